/* Chipmunk 7: its default iterations and bias; the slop, which it counts in the user's unit, is laglab's and
 * Box2D's 5 mm. Chains are segments, and nothing is swept: it has no word for that. */
#include <stdlib.h>

#include <chipmunk/chipmunk.h>

#include "rigid/engine.h"

typedef struct peer {
    cpSpace *space;
    cpBody **bodies;
    int made;
} peer;

static void *open_world(const bench_world *of, double (*set)(const char *name, double standard))
{
    peer *p = calloc(1, sizeof *p);
    p->space = cpSpaceNew();
    p->bodies = calloc((size_t)of->made + 1, sizeof *p->bodies);
    cpSpaceSetGravity(p->space, cpv(of->gravity_x, of->gravity_y));
    cpSpaceSetIterations(p->space, (int)set("iterations", 10));
    cpSpaceSetCollisionSlop(p->space, 0.005);
    return p;
}

static void finish_shape(peer *p, cpShape *shape, const bench_shape *s)
{
    cpShapeSetDensity(shape, s->density);
    cpShapeSetFriction(shape, s->friction);
    cpShapeSetElasticity(shape, s->restitution);
    cpShapeSetFilter(shape, cpShapeFilterNew((cpGroup)-s->group, s->category, s->mask));
    cpSpaceAddShape(p->space, shape);
}

static cpVect point(const double v[2])
{
    return cpv(v[0], v[1]);
}

static void add_shape(peer *p, cpBody *body, const bench_shape *s)
{
    if (s->kind == SHAPE_CIRCLE)
        finish_shape(p, cpCircleShapeNew(body, s->radius, point(s->vertex[0])), s);
    else if (s->kind == SHAPE_CAPSULE)
        finish_shape(p, cpSegmentShapeNew(body, point(s->vertex[0]), point(s->vertex[1]), s->radius), s);
    else if (s->kind == SHAPE_POLYGON) {
        cpVect points[SHAPE_VERTICES_MAX];
        for (int i = 0; i < s->count; i++)
            points[i] = point(s->vertex[i]);
        finish_shape(p, cpPolyShapeNewRaw(body, s->count, points, 0), s);
    } else
        for (int i = 0; i < s->count; i++) {
            cpShape *segment =
                cpSegmentShapeNew(body, point(s->vertex[i]), point(s->vertex[(i + 1) % s->count]), 0);
            cpSegmentShapeSetNeighbors(segment, point(s->vertex[(i + s->count - 1) % s->count]),
                                       point(s->vertex[(i + 2) % s->count]));
            finish_shape(p, segment, s);
        }
}

static void add_body(void *state, const bench_body *b)
{
    peer *p = state;
    cpBody *body = b->type == 0 ? cpBodyNewStatic() : b->type == 1 ? cpBodyNewKinematic() : cpBodyNew(0, 0);
    cpBodySetPosition(body, cpv(b->x, b->y));
    cpBodySetAngle(body, b->angle);
    cpSpaceAddBody(p->space, body);
    for (int i = 0; i < b->shape_count; i++)
        add_shape(p, body, &b->shapes[i]);
    if (b->type != 0) {
        cpBodySetVelocity(body, cpv(b->vx, b->vy));
        cpBodySetAngularVelocity(body, b->angular_velocity);
    } else
        cpSpaceReindexShapesForBody(p->space, body);
    p->bodies[p->made++] = body;
}

static void add_joint(void *state, const bench_joint *j)
{
    peer *p = state;
    cpBody *a = p->bodies[j->a], *b = p->bodies[j->b];
    cpConstraint *pivot = cpPivotJointNew2(a, b, cpv(j->ax, j->ay), cpv(j->bx, j->by));
    cpConstraintSetCollideBodies(pivot, cpFalse);
    cpSpaceAddConstraint(p->space, pivot);
    if (j->limited)
        cpSpaceAddConstraint(p->space, cpRotaryLimitJointNew(a, b, j->angle + j->lower, j->angle + j->upper));
    if (j->motored) {
        cpConstraint *motor = cpSimpleMotorNew(a, b, -j->speed);
        cpConstraintSetMaxForce(motor, j->torque);
        cpSpaceAddConstraint(p->space, motor);
    }
}

static void drop_shape(cpBody *body, cpShape *shape, void *space)
{
    (void)body;
    cpSpaceRemoveShape(space, shape);
    cpShapeFree(shape);
}

static void drop_constraint(cpBody *body, cpConstraint *constraint, void *space)
{
    (void)body;
    cpSpaceRemoveConstraint(space, constraint);
    cpConstraintFree(constraint);
}

static void remove_body(void *state, int body)
{
    peer *p = state;
    cpBody *b = p->bodies[body];
    cpBodyEachConstraint(b, drop_constraint, p->space);
    cpBodyEachShape(b, drop_shape, p->space);
    cpSpaceRemoveBody(p->space, b);
    cpBodyFree(b);
}

static void step(void *state, double dt)
{
    cpSpaceStep(((peer *)state)->space, dt);
}

static void get(void *state, int body, double pose[3])
{
    peer *p = state;
    cpVect at = cpBodyGetPosition(p->bodies[body]);
    pose[0] = at.x;
    pose[1] = at.y;
    pose[2] = cpBodyGetAngle(p->bodies[body]);
}

int main(int argc, char **argv)
{
    const engine e = {"Chipmunk", open_world, add_body, add_joint, remove_body, step, get};
    return run_engine(&e, argc, argv);
}
