// Box2D 2.4: its default settings, sleeping off. It has no capsules: they are polygons of eight vertices.
#include <cmath>
#include <vector>

#include <box2d/box2d.h>

#include "rigid/engine.h"

namespace {

struct peer {
    b2World world;
    std::vector<b2Body *> bodies;
    int velocity, position;
};

void *open_world(const bench_world *of, double (*set)(const char *name, double standard))
{
    peer *p = new peer{b2World(b2Vec2(float(of->gravity_x), float(of->gravity_y))), {},
                       int(set("velocity", 8)), int(set("position", 3))};
    p->world.SetAllowSleeping(set("sleep", 0) != 0);
    p->world.SetContinuousPhysics(of->continuous);
    return p;
}

b2Vec2 point(const double v[2]) { return b2Vec2(float(v[0]), float(v[1])); }

void set_capsule(b2PolygonShape *polygon, const bench_shape *s)
{
    b2Vec2 a = point(s->vertex[0]), b = point(s->vertex[1]), along = b - a, points[8];
    along.Normalize();
    const b2Vec2 across(-along.y, along.x);
    const float angles[4] = {-67.5f, -22.5f, 22.5f, 67.5f}, out = float(s->radius) / std::cos(b2_pi / 8);
    for (int i = 0; i < 4; i++) {
        b2Vec2 turned = std::cos(angles[i] * b2_pi / 180) * along + std::sin(angles[i] * b2_pi / 180) * across;
        points[i] = b + out * turned;
        points[4 + i] = a - out * turned;
    }
    polygon->Set(points, 8);
}

void add_shape(b2Body *body, const bench_shape *s)
{
    b2CircleShape circle;
    b2PolygonShape polygon;
    b2ChainShape chain;
    b2FixtureDef def;
    std::vector<b2Vec2> points;
    for (int i = 0; i < s->count; i++)
        points.push_back(point(s->vertex[i]));
    if (s->kind == SHAPE_CIRCLE) {
        circle.m_p = points[0];
        circle.m_radius = float(s->radius);
        def.shape = &circle;
    } else if (s->kind == SHAPE_CAPSULE) {
        set_capsule(&polygon, s);
        def.shape = &polygon;
    } else if (s->kind == SHAPE_POLYGON) {
        polygon.Set(points.data(), s->count);
        def.shape = &polygon;
    } else {
        chain.CreateLoop(points.data(), s->count);
        def.shape = &chain;
    }
    def.density = float(s->density);
    def.friction = float(s->friction);
    def.restitution = float(s->restitution);
    def.filter.categoryBits = uint16(s->category);
    def.filter.maskBits = uint16(s->mask);
    def.filter.groupIndex = int16(s->group);
    body->CreateFixture(&def);
}

void add_body(void *state, const bench_body *b)
{
    static const b2BodyType types[] = {b2_staticBody, b2_kinematicBody, b2_dynamicBody};
    peer *p = static_cast<peer *>(state);
    b2BodyDef def;
    def.type = types[b->type];
    def.position.Set(float(b->x), float(b->y));
    def.angle = float(b->angle);
    def.linearVelocity.Set(float(b->vx), float(b->vy));
    def.angularVelocity = float(b->angular_velocity);
    b2Body *body = p->world.CreateBody(&def);
    for (int i = 0; i < b->shape_count; i++)
        add_shape(body, &b->shapes[i]);
    p->bodies.push_back(body);
}

void add_joint(void *state, const bench_joint *j)
{
    peer *p = static_cast<peer *>(state);
    b2RevoluteJointDef def;
    def.bodyA = p->bodies[size_t(j->a)];
    def.bodyB = p->bodies[size_t(j->b)];
    def.localAnchorA.Set(float(j->ax), float(j->ay));
    def.localAnchorB.Set(float(j->bx), float(j->by));
    def.referenceAngle = float(j->angle);
    def.enableLimit = j->limited;
    def.lowerAngle = float(j->lower);
    def.upperAngle = float(j->upper);
    def.enableMotor = j->motored;
    def.motorSpeed = float(j->speed);
    def.maxMotorTorque = float(j->torque);
    p->world.CreateJoint(&def);
}

void remove_body(void *state, int body)
{
    peer *p = static_cast<peer *>(state);
    p->world.DestroyBody(p->bodies[size_t(body)]);
}

void step(void *state, double dt)
{
    peer *p = static_cast<peer *>(state);
    p->world.Step(float(dt), p->velocity, p->position);
}

void get(void *state, int body, double pose[3])
{
    const b2Body *b = static_cast<peer *>(state)->bodies[size_t(body)];
    pose[0] = b->GetWorldCenter().x;
    pose[1] = b->GetWorldCenter().y;
    pose[2] = b->GetAngle();
}

} // namespace

int main(int argc, char **argv)
{
    const engine e = {"Box2D 2.4", open_world, add_body, add_joint, remove_body, step, get};
    return run_engine(&e, argc, argv);
}
