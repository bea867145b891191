#include "rigid/laglab.h"

#include <stdio.h>
#include <stdlib.h>

#include "rigid/body/rigid.h"
#include "threads/team.h"

typedef struct lab {
    ll_rigid *world;
    ll_team *team; /* of the setting `threads`; NULL: one thread */
    ll_body_id *ids;
    int made;
} lab;

static void check(ll_status status)
{
    if (ll_failed(&status)) {
        fprintf(stderr, "rigid: %s\n", status.text);
        exit(1);
    }
}

static void *open_lab(const bench_world *of, double (*set)(const char *name, double standard))
{
    ll_rigid_limits limits = {.bodies = of->bodies,
                              .shapes = of->shapes,
                              .hulls = of->shapes,
                              .contacts = of->contacts,
                              .joints = of->joints,
                              .broad = (int32_t)set("broad_phase", LL_BROAD_GRID)};
    ll_rigid_params p;
    ll_param_defaults(&ll_rigid_table, &p);
    p.gravity_x = of->gravity_x;
    p.gravity_y = of->gravity_y;
    p.sleep = set("sleep", 0) != 0;
    p.continuous = of->continuous ? LL_CONTINUOUS_SWEPT : LL_CONTINUOUS_OFF;
    p.solver = (int32_t)set("solver", p.solver);
    p.substeps = (int64_t)set("substeps", (double)p.substeps);
    p.iterations = (int64_t)set("iterations", (double)p.iterations);
    p.contact_hertz = set("hertz", p.contact_hertz);
    p.simd = (int32_t)set("simd", p.simd);
    lab *l = calloc(1, sizeof *l);
    if (set("threads", 1) > 1)
        check(ll_team_make((int)set("threads", 1), &l->team));
    check(ll_rigid_check(&limits));
    l->ids = calloc((size_t)of->made + 1, sizeof *l->ids);
    l->world = ll_rigid_init(aligned_alloc(64, (ll_rigid_size(&limits) + 63) & ~(size_t)63), &limits, &p);
    return l;
}

static void add_shape(lab *l, ll_body_id body, const bench_shape *s)
{
    ll_material material = {.density = s->density,
                            .friction = s->friction,
                            .restitution = s->restitution,
                            .category = s->category,
                            .mask = s->mask,
                            .group = s->group};
    ll_vec2 *v = malloc((size_t)s->count * sizeof *v);
    ll_geometry g = {0};
    for (int i = 0; i < s->count; i++)
        v[i] = ll_vec(s->vertex[i][0], s->vertex[i][1]);
    if (s->kind == SHAPE_CIRCLE)
        check(ll_shape_circle(v[0], s->radius, &g));
    else if (s->kind == SHAPE_CAPSULE)
        check(ll_shape_capsule(v[0], v[1], s->radius, &g));
    else if (s->kind == SHAPE_POLYGON)
        check(ll_shape_polygon(v, s->count, &g));
    check(s->kind == SHAPE_CHAIN ? ll_rigid_add_chain(l->world, body, v, s->count, true, &material)
                                 : ll_rigid_add_shape(l->world, body, &g, &material));
    free(v);
}

static void add_body(void *state, const bench_body *b)
{
    lab *l = state;
    ll_body_def def = ll_body_defaults((ll_body_type)b->type);
    ll_body_id *id = &l->ids[l->made++];
    def.position = ll_vec(b->x, b->y);
    def.angle = b->angle;
    def.velocity = ll_vec(b->vx, b->vy);
    def.angular_velocity = b->angular_velocity;
    check(ll_rigid_add_body(l->world, &def, id));
    for (int i = 0; i < b->shape_count; i++)
        add_shape(l, *id, &b->shapes[i]);
}

static void add_joint(void *state, const bench_joint *j)
{
    lab *l = state;
    ll_joint_def def = {.type = LL_JOINT_REVOLUTE,
                        .a = l->ids[j->a],
                        .b = l->ids[j->b],
                        .anchor_a = {j->ax, j->ay},
                        .anchor_b = {j->bx, j->by},
                        .axis = {1, 0},
                        .angle = j->angle,
                        .limited = j->limited,
                        .lower = j->lower,
                        .upper = j->upper,
                        .motored = j->motored,
                        .motor_speed = j->speed,
                        .max_torque = j->torque};
    ll_joint_id id;
    check(ll_rigid_add_joint(l->world, &def, &id));
}

static void remove_body(void *state, int body)
{
    lab *l = state;
    check(ll_rigid_remove_body(l->world, l->ids[body]));
}

static void step(void *state, double dt)
{
    lab *l = state;
    check(ll_rigid_step_by_team(l->world, dt, NULL, l->team));
}

static void get(void *state, int body, double pose[3])
{
    lab *l = state;
    ll_body_state s;
    check(ll_rigid_get_body(l->world, l->ids[body], &s));
    pose[0] = s.centre.x;
    pose[1] = s.centre.y;
    pose[2] = s.angle;
}

const engine laglab_engine = {"laglab", open_lab, add_body, add_joint, remove_body, step, get};
