#include <stdio.h>
#include <string.h>

#include "sim/core/scenario_rows.h"
#include "sim/rigid/rigid.h"

#define ROW(struct_type, field, ...)                                                                         \
    {                                                                                                        \
        .name = #field, .offset = offsetof(struct_type, field), __VA_ARGS__                                  \
    }

/* ---- bodies ---- */

static const char *const form_names[LL_FORMS + 1] = {"box",     "circle", "capsule", "polygon",
                                                     "segment", "chain",  NULL};

#define REAL(field, low, high, value, of, text)                                                              \
    ROW(ll_rigid_body, field, .type = LL_PARAM_REAL, .min = low, .max = high, .default_value = value,        \
        .unit = of, .help = text)
#define PAIR(field, low, high, x, y, of, text)                                                               \
    ROW(ll_rigid_body, field, .type = LL_PARAM_VECTOR, .min = low, .max = high, .vector = {x, y},            \
        .unit = of, .help = text)

static const ll_param body_rows[] = {
    ROW(ll_rigid_body, type, .type = LL_PARAM_CHOICE, .choices = ll_body_type_names,
        .default_value = LL_BODY_DYNAMIC,
        .help = "dynamic: moved by forces. kinematic: moved by its velocity alone. static: not moved."),
    {LL_PARAM_ROW("shape", CHOICE, ll_rigid_body, form), .choices = form_names,
     .help = "Shape: box and capsule have a size, a circle a radius, the others points."},
    PAIR(size, 0, 1e6, 1, 1, "m", "Width and height of a box, length and thickness of a capsule."),
    REAL(radius, 0, 1e6, 0.5, "m", "Radius of a circle."),
    ROW(ll_rigid_body, points, .type = LL_PARAM_POINTS, .max = LL_RIGID_POINTS_MAX, .default_value = 1e6,
        .count_offset = offsetof(ll_rigid_body, point_count), .unit = "m",
        .help = "Points in the body's frame: 3 to 8 corners of a convex polygon, 2 ends of a segment, 4 or "
                "more points of a chain. A chain stops bodies that come from the right of its direction."),
    ROW(ll_rigid_body, loop, .type = LL_PARAM_BOOL,
        .help = "Joins a chain's last point to its first; otherwise its outermost segments collide with "
                "nothing."),
    PAIR(position, -LL_WORLD_MAX, LL_WORLD_MAX, 0, 0, "m", "Initial position of its frame."),
    REAL(angle, -1e6, 1e6, 0, "rad", "Initial rotation of its frame, counter-clockwise."),
    PAIR(velocity, -1e6, 1e6, 0, 0, "m/s", "Initial value; a kinematic body keeps it."),
    REAL(angular_velocity, -1e6, 1e6, 0, "rad/s", "Initial value; a kinematic body keeps it."),
    REAL(density, 1e-6, 1e9, 1, "kg/m^2", "Mass of a dynamic body per area."),
    REAL(friction, 0, 1000, 0.6, NULL,
         "Coefficient of friction; the geometric mean of two bodies' coefficients counts."),
    REAL(restitution, 0, 1, 0, NULL,
         "Ratio of normal speeds after and before an impact; the larger value of two bodies counts."),
    REAL(gravity_scale, -1000, 1000, 1, NULL, "Factor of gravity."),
    REAL(damping, 0, 1e6, 0, "1/s", "Damping of its velocity."),
    REAL(angular_damping, 0, 1e6, 0, "1/s", "Damping of its angular velocity."),
    ROW(ll_rigid_body, fixed_rotation, .type = LL_PARAM_BOOL, .help = "It does not rotate."),
    ROW(ll_rigid_body, bullet, .type = LL_PARAM_BOOL,
        .help = "With `continuous` swept: a fast dynamic body with CCD against all bodies, not only against "
                "static, kinematic and four times heavier ones."),
};
#undef REAL
#undef PAIR

static const ll_param_table body_table = {
    .name = "rigid_body", .help = "A body of one shape.", LL_PARAM_ROWS(body_rows, ll_rigid_body)};

/* ---- joints ---- */

#define REAL(field, low, high, value, of, text)                                                              \
    ROW(ll_rigid_joint, field, .type = LL_PARAM_REAL, .min = low, .max = high, .default_value = value,       \
        .unit = of, .help = text)
#define PAIR(field, x, y, of, text)                                                                          \
    ROW(ll_rigid_joint, field, .type = LL_PARAM_VECTOR, .min = -1e6, .max = 1e6, .vector = {x, y},           \
        .unit = of, .help = text)
#define SWITCH(field, text) ROW(ll_rigid_joint, field, .type = LL_PARAM_BOOL, .help = text)
#define INDEX(field, text)                                                                                   \
    ROW(ll_rigid_joint, field, .type = LL_PARAM_INT, .max = LL_RIGID_BODIES_MAX - 1, .required = true,       \
        .help = text)

static const ll_param joint_rows[] = {
    ROW(ll_rigid_joint, type, .type = LL_PARAM_CHOICE, .choices = ll_joint_type_names,
        .default_value = LL_JOINT_REVOLUTE, .help = "Type, which determines the free directions."),
    INDEX(a, "Index of the first body."),
    INDEX(b, "Index of the second body: the one that a motor drives or a mouse joint drags."),
    PAIR(anchor_a, 0, 0, "m", "Anchor on the first body, in that body's frame."),
    PAIR(anchor_b, 0, 0, "m", "Anchor on the second body, in that body's frame."),
    PAIR(axis, 1, 0, NULL, "Direction of a prismatic joint in the first body's frame."),
    PAIR(target, 0, 0, "m", "Point to which a mouse joint drags the second body's anchor."),
    REAL(length, 0, 1e6, 0, "m", "Length of a distance joint; 0: the initial distance of the anchors."),
    REAL(lower, -1e6, 1e6, 0, NULL, "Lower limit, in m or rad."),
    REAL(upper, -1e6, 1e6, 0, NULL, "Upper limit, in m or rad."),
    REAL(hertz, 0, 1000, 0, "Hz", "Stiffness of a spring; 0: that of joint_hertz."),
    REAL(damping, 0, 100, 1, NULL, "Damping ratio of a spring."),
    REAL(motor_speed, -1e6, 1e6, 0, NULL, "Speed of a motor, in m/s or rad/s."),
    REAL(max_force, 0, 1e12, 1000, "N", "Maximum force of a motor, mouse or friction joint."),
    REAL(max_torque, 0, 1e12, 1000, "N m", "Maximum torque of a motor or friction joint."),
    SWITCH(limited, "Limits are on."),
    SWITCH(motored, "The motor is on."),
    SWITCH(rope, "A distance joint allows shorter distances."),
    SWITCH(collide, "The two bodies collide with each other."),
};
#undef REAL
#undef PAIR

static const ll_param_table joint_table = {
    .name = "rigid_joint", .help = "A joint of two bodies.", LL_PARAM_ROWS(joint_rows, ll_rigid_joint)};

/* ---- the scenario ---- */

/* A scene sets its own gravity, and some scenes a solver. */
static void scene_chosen(void *object, int choice)
{
    ll_rigid_setup *setup = &((ll_rigid_config *)object)->setup;
    const ll_scene *scene = ll_rigid_sim_scene(setup);
    (void)choice;
    if (scene == NULL || scene->params == NULL)
        return;
    ll_scene_args none = {0}, args = ll_scene_args_of(scene, &none);
    ll_rigid_params p = ll_rigid_sim_params(setup, 0);
    scene->params(&args, &p);
    setup->gravity[0] = p.gravity_x;
    setup->gravity[1] = p.gravity_y;
    p.gravity_x = p.gravity_y = 0;
    setup->solver = p;
}

static const ll_param side_by_side_rows[] = {
    ROW(ll_rigid_side_by_side, solver, .type = LL_PARAM_OBJECT, .child = &ll_rigid_solver_table, .live = true,
        .help = "Time stepping."),
};

static const ll_param_table side_by_side_table = {
    .name = "rigid_side_by_side",
    .help = "A copy of the same bodies next to the first; parameters that are not given are the first one's.",
    LL_PARAM_ROWS(side_by_side_rows, ll_rigid_side_by_side)};

static void as_the_first(const void *object, void *element)
{
    ((ll_rigid_side_by_side *)element)->solver = ((const ll_rigid_config *)object)->setup.solver;
}

#define SETUP(field, ...)                                                                                    \
    {                                                                                                        \
        .name = #field, .offset = offsetof(ll_rigid_config, setup.field), __VA_ARGS__                        \
    }

static const ll_param rows[] = {
    LL_SCENARIO_ROWS,
    SETUP(scene, .type = LL_PARAM_CHOICE, .choices = ll_scene_names, .chosen = scene_chosen,
          .help = "A predefined scene; none: the listed bodies and joints."),
    SETUP(params, .type = LL_PARAM_OBJECT, .child = &ll_scene_args_table, .help = "Parameters of the scene."),
    SETUP(hz, .type = LL_PARAM_REAL, .min = 1, .max = 1000, .default_value = 60, .unit = "Hz",
          .help = "Steps per second."),
    SETUP(gravity, .type = LL_PARAM_VECTOR, .min = -1000, .max = 1000, .vector = {0, -10}, .unit = "m/s^2",
          .live = true, .help = "To the right and upwards."),
    SETUP(solver, .type = LL_PARAM_OBJECT, .child = &ll_rigid_solver_table, .live = true,
          .help = "Time stepping of the world."),
    SETUP(side_by_side, .type = LL_PARAM_ARRAY, .max = LL_SIDE_BY_SIDE_MAX - 1, .child = &side_by_side_table,
          .count_offset = offsetof(ll_rigid_config, setup.side_by_side_count), .live = true,
          .begin = as_the_first,
          .help =
              "The same bodies side by side from the same start; each gives its differences from the first."),
    SETUP(broad_phase, .type = LL_PARAM_CHOICE, .choices = ll_broad_names, .default_value = LL_BROAD_GRID,
          .live = true,
          .help = "Broad phase: finds the pairs whose boxes overlap; every one finds the same pairs."),
    SETUP(compare_volumes, .type = LL_PARAM_BOOL, .live = true,
          .help = "Each step every bounding volume tests all pairs of the first 256 shapes; counts false and "
                  "missed hits."),
    SETUP(tunnel_x, .type = LL_PARAM_REAL, .min = -LL_WORLD_MAX, .max = LL_WORLD_MAX,
          .default_value = LL_WORLD_MAX, .unit = "m", .live = true,
          .help = "Dynamic bodies whose centre is to the right of this count as tunnelled."),
    ROW(ll_rigid_config, bodies, .type = LL_PARAM_ARRAY, .max = LL_RIGID_BODIES_MAX, .child = &body_table,
        .count_offset = offsetof(ll_rigid_config, body_count), .help = "The bodies, if no scene is named."),
    ROW(ll_rigid_config, joints, .type = LL_PARAM_ARRAY, .max = LL_RIGID_JOINTS_MAX, .child = &joint_table,
        .count_offset = offsetof(ll_rigid_config, joint_count), .help = "The joints of these bodies."),
};

/* ---- limits and checks ---- */

ll_rigid_params ll_rigid_sim_params(const ll_rigid_setup *setup, int world)
{
    ll_rigid_params p = world == 0 ? setup->solver : setup->side_by_side[world - 1].solver;
    p.gravity_x = setup->gravity[0];
    p.gravity_y = setup->gravity[1];
    return p;
}

static void list_limits(const ll_rigid_config *c, ll_rigid_limits *l)
{
    l->bodies = c->body_count;
    for (int i = 0; i < c->body_count; i++)
        l->shapes += c->bodies[i].form == LL_FORM_CHAIN ? c->bodies[i].point_count : 1;
    l->hulls = l->shapes;
    int32_t few = c->body_count < 128 ? c->body_count : 128; /* each of few bodies may touch all others */
    l->contacts = 48 * few + 16 * c->body_count + 8 * l->shapes + 64;
    l->joints = c->joint_count;
}

ll_rigid_limits ll_rigid_sim_limits(const ll_rigid_config *c)
{
    const ll_scene *scene = ll_rigid_sim_scene(&c->setup);
    ll_rigid_limits l = {0};
    if (scene != NULL) {
        ll_scene_args args = ll_scene_args_of(scene, &c->setup.params);
        scene->limits(&args, &l);
    } else {
        list_limits(c, &l);
    }
    l.bodies += l.bodies < INT32_MAX; /* the fixed body of a mouse joint, */
    l.joints += l.joints < INT32_MAX; /* and the mouse joint */
    l.shapes += l.shapes == 0;
    l.broad = c->setup.broad_phase;
    l.volumes = l.broads = 1;
    return l;
}

static ll_status check_bodies(const ll_rigid_config *c)
{
    for (int i = 0; i < c->body_count; i++) {
        const ll_rigid_body *b = &c->bodies[i];
        ll_geometry g;
        char field[32];
        ll_status status = ll_rigid_sim_shape(b, &g);
        snprintf(field, sizeof field, "bodies.%d", i);
        if (ll_failed(&status))
            return ll_field_error(LL_BAD_INPUT, field, "%s: %s", field, status.text);
        if (b->type == LL_BODY_DYNAMIC && !ll_shape_is_solid((ll_shape_kind)g.kind))
            return ll_field_error(LL_BAD_INPUT, field,
                                  "%s.type: must be static or kinematic: a %s has no mass; got dynamic",
                                  field, form_names[b->form]);
    }
    return ll_ok();
}

static ll_status check_joints(const ll_rigid_config *c)
{
    for (int i = 0; i < c->joint_count; i++) {
        const ll_rigid_joint *j = &c->joints[i];
        const int64_t ends[2] = {j->a, j->b};
        char field[32];
        for (int side = 0; side < 2; side++) {
            snprintf(field, sizeof field, "joints.%d.%c", i, "ab"[side]);
            if (ends[side] >= c->body_count)
                return ll_field_error(LL_BAD_INPUT, field,
                                      "%s: must be the index of one of the %d bodies; got %lld", field,
                                      c->body_count, (long long)ends[side]);
        }
        if (j->a == j->b)
            return ll_field_error(LL_BAD_INPUT, field, "%s: must be another body than a; got %lld", field,
                                  (long long)j->b);
        snprintf(field, sizeof field, "joints.%d.lower", i);
        if (j->limited && j->lower > j->upper)
            return ll_field_error(LL_BAD_INPUT, field, "%s: must be at most upper, which is %g; got %g",
                                  field, j->upper, j->lower);
    }
    return ll_ok();
}

/* The memory size is checked before anything is made. */
static ll_status check_size(const ll_rigid_config *c)
{
    ll_rigid_limits limits = ll_rigid_sim_limits(c);
    ll_status status = ll_rigid_check(&limits);
    size_t size = ll_failed(&status) ? 0 : (size_t)ll_rigid_sim_worlds(&c->setup) * ll_rigid_size(&limits);
    if (ll_failed(&status))
        return ll_field_error(LL_BAD_INPUT, "params.size", "params.size %lld is too large for %s: %s",
                              (long long)c->setup.params.size, ll_scene_names[c->setup.scene], status.text);
    if (size > LL_RIGID_BLOCK_MAX && c->setup.scene == 0)
        return ll_field_error(LL_BAD_INPUT, "bodies", "bodies: %d of them need %zu MB; at most %zu MB",
                              c->body_count, size >> 20, LL_RIGID_BLOCK_MAX >> 20);
    if (size > LL_RIGID_BLOCK_MAX)
        return ll_field_error(LL_BAD_INPUT, "params.size",
                              "params.size %lld of %s needs %zu MB for %d bodies; at most %zu MB",
                              (long long)c->setup.params.size, ll_scene_names[c->setup.scene], size >> 20,
                              limits.bodies, LL_RIGID_BLOCK_MAX >> 20);
    return ll_ok();
}

static ll_status check(const void *object, const char *path)
{
    const ll_rigid_config *c = object;
    (void)path;
    if (c->setup.scene > 0 && c->body_count + c->joint_count > 0)
        return ll_field_error(LL_BAD_INPUT, "bodies",
                              "bodies and joints must be empty where a scene is named; got %d and %d",
                              c->body_count, c->joint_count);
    ll_status status = check_bodies(c);
    LL_THEN(status, check_joints(c));
    return ll_failed(&status) ? status : check_size(c);
}

const ll_param_table ll_rigid_scenario_table = {
    .name = "rigid",
    .help = "Bodies that collide: bounding volumes, broad and narrow phases, contact solvers.",
    LL_PARAM_ROWS(rows, ll_rigid_config),
    .check = check};
