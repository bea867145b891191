/* Box2D 3: its default settings, sleeping off. */
#include <stdlib.h>

#include "box2d/box2d.h"
#include "rigid/engine.h"

typedef struct peer {
    b2WorldId world;
    b2BodyId *bodies;
    int made, substeps;
} peer;

static void *open_world(const bench_world *of, double (*set)(const char *name, double standard))
{
    peer *p = calloc(1, sizeof *p);
    b2WorldDef def = b2DefaultWorldDef();
    def.gravity = (b2Vec2){(float)of->gravity_x, (float)of->gravity_y};
    def.enableSleep = set("sleep", 0) != 0;
    def.enableContinuous = of->continuous;
    def.contactHertz = (float)set("hertz", def.contactHertz);
    def.workerCount = (int)set("threads", 1); /* by its own scheduler */
    p->world = b2CreateWorld(&def);
    p->bodies = calloc((size_t)of->made + 1, sizeof *p->bodies);
    p->substeps = (int)set("substeps", 4);
    return p;
}

static b2Vec2 point(const double v[2])
{
    return (b2Vec2){(float)v[0], (float)v[1]};
}

static void add_chain(b2BodyId body, const bench_shape *s, const b2SurfaceMaterial *material, b2Filter filter)
{
    b2Vec2 *points = malloc((size_t)s->count * sizeof *points);
    for (int i = 0; i < s->count; i++)
        points[i] = point(s->vertex[i]);
    b2ChainDef def = b2DefaultChainDef();
    def.points = points;
    def.count = s->count;
    def.materials = material;
    def.materialCount = 1;
    def.filter = filter;
    def.isLoop = true;
    b2CreateChain(body, &def);
    free(points);
}

static void add_shape(b2BodyId body, const bench_shape *s)
{
    b2ShapeDef def = b2DefaultShapeDef();
    def.density = (float)s->density;
    def.material.friction = (float)s->friction;
    def.material.restitution = (float)s->restitution;
    def.filter.categoryBits = s->category;
    def.filter.maskBits = s->mask;
    def.filter.groupIndex = s->group;
    def.enableSensorEvents = false;
    def.enableContactEvents = false;
    if (s->kind == SHAPE_CIRCLE)
        b2CreateCircleShape(body, &def, &(b2Circle){point(s->vertex[0]), (float)s->radius});
    else if (s->kind == SHAPE_CAPSULE)
        b2CreateCapsuleShape(body, &def,
                             &(b2Capsule){point(s->vertex[0]), point(s->vertex[1]), (float)s->radius});
    else if (s->kind == SHAPE_POLYGON) {
        b2Vec2 points[SHAPE_VERTICES_MAX];
        for (int i = 0; i < s->count; i++)
            points[i] = point(s->vertex[i]);
        b2Hull hull = b2ComputeHull(points, s->count);
        b2Polygon polygon = b2MakePolygon(&hull, 0);
        b2CreatePolygonShape(body, &def, &polygon);
    } else
        add_chain(body, s, &def.material, def.filter);
}

static void add_body(void *state, const bench_body *b)
{
    static const b2BodyType types[] = {b2_staticBody, b2_kinematicBody, b2_dynamicBody};
    peer *p = state;
    b2BodyDef def = b2DefaultBodyDef();
    def.type = types[b->type];
    def.position.x = (float)b->x;
    def.position.y = (float)b->y;
    def.rotation = b2MakeRot((float)b->angle);
    def.linearVelocity = (b2Vec2){(float)b->vx, (float)b->vy};
    def.angularVelocity = (float)b->angular_velocity;
    b2BodyId body = p->bodies[p->made++] = b2CreateBody(p->world, &def);
    for (int i = 0; i < b->shape_count; i++)
        add_shape(body, &b->shapes[i]);
}

static void add_joint(void *state, const bench_joint *j)
{
    peer *p = state;
    b2RevoluteJointDef def = b2DefaultRevoluteJointDef();
    def.base.bodyIdA = p->bodies[j->a];
    def.base.bodyIdB = p->bodies[j->b];
    def.base.localFrameA.p = (b2Vec2){(float)j->ax, (float)j->ay};
    def.base.localFrameB.p = (b2Vec2){(float)j->bx, (float)j->by};
    def.base.localFrameA.q = b2MakeRot((float)j->angle);
    def.enableLimit = j->limited;
    def.lowerAngle = (float)j->lower;
    def.upperAngle = (float)j->upper;
    def.enableMotor = j->motored;
    def.motorSpeed = (float)j->speed;
    def.maxMotorTorque = (float)j->torque;
    b2CreateRevoluteJoint(p->world, &def);
}

static void remove_body(void *state, int body)
{
    b2DestroyBody(((peer *)state)->bodies[body]);
}

static void step(void *state, double dt)
{
    peer *p = state;
    b2World_Step(p->world, (float)dt, p->substeps);
}

static void get(void *state, int body, double pose[3])
{
    peer *p = state;
    b2Pos at = b2Body_GetPosition(p->bodies[body]);
    pose[0] = at.x;
    pose[1] = at.y;
    pose[2] = b2Rot_GetAngle(b2Body_GetRotation(p->bodies[body]));
}

int main(int argc, char **argv)
{
    const engine e = {"Box2D 3", open_world, add_body, add_joint, remove_body, step, get};
    return run_engine(&e, argc, argv);
}
