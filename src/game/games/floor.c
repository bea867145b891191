#include "game/games/floor.h"

#include "base/assert.h"
#include "base/detmath.h"
#include "game/games/games.h"
#include "rigid/body/rigid.h"

#define ITERATIONS 16             /* a push propagates through at least this many bodies */
#define POSITION_ITERATIONS 4     /* of the correction of overlap */
#define NEAR (4 * LL_LINEAR_SLOP) /* m: resting bodies nearer than this have a contact in src/rigid */
#define REST 1e-3                 /* m/s: slower bodies that the floor holds come to rest */
#define STILL 1e-6                /* m, rad: a resting body that moves less per step stays where it is */
#define ALL_PAIRS 32              /* shapes up to which brute force is the fastest broad phase */
/* of a world: the floor, and a target for each body with a wanted velocity */
#define BODIES_MAX (2 * LL_TOUCHING_MAX + 1)
#define BLOCK_MAX (3 << 19) /* bytes of a world with all bodies */

typedef struct work {
    const ll_game_env *env;
    const ll_floor *floor;
    ll_floor_body *body;
    int count, reached, lonely, walls;
    int alone[LL_TOUCHING_MAX];     /* moving bodies without possible contacts */
    int order[LL_TOUCHING_MAX];     /* bodies with possible contacts */
    ll_body_id id[LL_TOUCHING_MAX]; /* of body order[k] */
    int16_t of[BODIES_MAX];         /* body of a slot of the world; -1: none */
} work;

double ll_floor_bound(const ll_floor_body *b)
{
    return b->round ? b->half : b->half * 1.4142135623730951;
}

int ll_floor_substeps(double dt, double top_speed, double half_min)
{
    double n = dt * top_speed / (0.5 * half_min);
    return 1 + (int)n;
}

/* Both move at top speed up to the last substep, and speculative contacts reach as far as both move and
 * rotate in it. */
double ll_floor_margin(const ll_game_env *env, const ll_floor *floor)
{
    return 2 * floor->top_speed * env->dt * (1 + 1.0 / floor->substeps) + NEAR;
}

/* ---- participants ---- */

static bool moves(const ll_floor_body *b)
{
    return b->inverse_mass > 0 && !b->absent &&
           (b->vx != 0 || b->vy != 0 || b->angular_velocity != 0 || b->wanted_vx != 0 || b->wanted_vy != 0 ||
            b->unsettled);
}

/* Walls that a body may reach within the step: bits in the order of add_floor. */
static int walls_near(const work *w, const ll_floor_body *b)
{
    double reach = ll_floor_bound(b) + ll_floor_margin(w->env, w->floor);
    return (b->x < reach) | (b->x > w->floor->width - reach) << 1 | (b->y < reach) << 2 |
           (b->y > w->floor->depth - reach) << 3;
}

/* Moving bodies, those that they may reach within the step, and so on; obstacles pass nothing on. A body that
 * reaches nothing is alone. */
static void find_reached(work *w)
{
    bool known[LL_TOUCHING_MAX] = {false}, meets[LL_TOUCHING_MAX] = {false};
    double margin = ll_floor_margin(w->env, w->floor);
    int queue[LL_TOUCHING_MAX], count = 0;
    for (int i = 0; i < w->count; i++)
        if (moves(&w->body[i])) {
            known[i] = true;
            queue[count++] = i;
        }
    for (int k = 0; k < count; k++) {
        const ll_floor_body *a = &w->body[queue[k]];
        double reach = ll_floor_bound(a) + margin;
        for (int i = 0; i < w->count && a->inverse_mass > 0; i++) {
            const ll_floor_body *b = &w->body[i];
            double dx = b->x - a->x, dy = b->y - a->y, far = reach + ll_floor_bound(b);
            if (i == queue[k] || b->absent || dx * dx + dy * dy > far * far)
                continue;
            meets[queue[k]] = meets[i] = true;
            if (!known[i])
                queue[count++] = i;
            known[i] = true;
        }
    }
    for (int i = 0; i < w->count; i++) {
        int walls = known[i] ? walls_near(w, &w->body[i]) : 0;
        w->walls |= walls;
        if (known[i] && (meets[i] || walls))
            w->order[w->reached++] = i;
        else if (known[i])
            w->alone[w->lonely++] = i;
    }
}

/* ---- the world of a step ---- */

static void must(ll_status status)
{
    LL_ASSERT(!ll_failed(&status));
}

/* Small, since it is cleared in each step: few bodies cannot have more contacts than pairs. */
static ll_rigid_limits limits_of(int bodies)
{
    int pairs = bodies * (bodies - 1) / 2 + 4 * bodies, enough = 6 * bodies + 32;
    return (ll_rigid_limits){.bodies = 2 * bodies + 1,
                             .shapes = bodies + 4,
                             .hulls = bodies + 4,
                             .contacts = pairs < enough ? pairs : enough,
                             .joints = bodies,
                             .broad = bodies < ALL_PAIRS ? LL_BROAD_BRUTE : LL_BROAD_SAP};
}

static ll_rigid_params params_of(void)
{
    ll_rigid_params p;
    ll_param_defaults(&ll_rigid_table, &p);
    p.gravity_y = 0;
    p.solver = LL_SOLVER_PGS_NGS;
    p.iterations = ITERATIONS;
    p.position_iterations = POSITION_ITERATIONS;
    p.continuous = LL_CONTINUOUS_SPECULATIVE;
    p.recycle = p.sleep = false;
    return p;
}

static ll_material smooth(void)
{
    ll_material m = ll_material_defaults();
    m.friction = 0;
    return m;
}

/* Adds body 0: the floor, with the walls that some body may reach. */
static ll_body_id add_floor(work *w, ll_rigid *world)
{
    ll_body_def def = ll_body_defaults(LL_BODY_STATIC);
    ll_material material = smooth();
    ll_body_id floor;
    double width = w->floor->width, depth = w->floor->depth, thick = width + depth;
    const ll_vec2 centre[4] = {{-thick / 2, depth / 2},
                               {width + thick / 2, depth / 2},
                               {width / 2, -thick / 2},
                               {width / 2, depth + thick / 2}};
    w->of[0] = -1;
    must(ll_rigid_add_body(world, &def, &floor));
    for (int k = 0; k < 4; k++) {
        ll_geometry wall;
        if (!(w->walls >> k & 1))
            continue;
        must(ll_shape_box(k < 2 ? thick : width + thick, k < 2 ? depth + thick : thick, centre[k], 0, &wall));
        must(ll_rigid_add_shape(world, floor, &wall, &material));
    }
    return floor;
}

static void add_body(work *w, ll_rigid *world, int k)
{
    const ll_floor_body *b = &w->body[w->order[k]];
    bool fixed = b->inverse_mass == 0;
    ll_body_def def = ll_body_defaults(fixed ? LL_BODY_STATIC : LL_BODY_DYNAMIC);
    ll_material material = smooth();
    ll_geometry outline;
    def.position = (ll_vec2){b->x, b->y};
    def.angle = b->angle;
    def.velocity = (ll_vec2){b->vx, b->vy};
    def.angular_velocity = b->angular_velocity;
    def.fixed_rotation = b->inverse_inertia == 0;
    must(b->round ? ll_shape_circle((ll_vec2){0, 0}, b->half, &outline)
                  : ll_shape_box(2 * b->half, 2 * b->half, (ll_vec2){0, 0}, 0, &outline));
    must(ll_rigid_add_body(world, &def, &w->id[k]));
    must(ll_rigid_add_shape(world, w->id[k], &outline, &material));
    if (!fixed)
        must(ll_rigid_set_mass(world, w->id[k], 1 / b->inverse_mass,
                               def.fixed_rotation ? 1 : 1 / b->inverse_inertia));
    w->of[w->id[k].index - 1] = (int16_t)w->order[k];
}

/* Grip of the floor: friction towards the wanted velocity, or towards rest against the floor itself. */
static void add_grip(work *w, ll_rigid *world, ll_body_id floor, int k)
{
    const ll_floor_body *b = &w->body[w->order[k]];
    ll_body_id under = floor;
    if (b->inverse_mass == 0 || b->grip == 0)
        return;
    if (b->wanted_vx != 0 || b->wanted_vy != 0) {
        ll_body_def def = ll_body_defaults(LL_BODY_KINEMATIC);
        def.velocity = (ll_vec2){b->wanted_vx, b->wanted_vy};
        must(ll_rigid_add_body(world, &def, &under));
        w->of[under.index - 1] = -1;
    }
    ll_joint_def joint = ll_joint_defaults(world, LL_JOINT_FRICTION, under, w->id[k], (ll_vec2){b->x, b->y});
    ll_joint_id id;
    joint.collide = 1; /* with the walls */
    joint.max_force = b->grip / b->inverse_mass;
    joint.max_torque = b->inverse_inertia > 0 ? b->grip_spin / b->inverse_inertia : 0;
    must(ll_rigid_add_joint(world, &joint, &id));
}

static ll_rigid *make_world(work *w, void *block)
{
    ll_rigid_limits limits = limits_of(w->reached);
    ll_rigid_params params = params_of();
    LL_ASSERT(ll_rigid_size(&limits) <= BLOCK_MAX);
    ll_rigid *world = ll_rigid_init(block, &limits, &params);
    ll_body_id floor = add_floor(w, world);
    for (int k = 0; k < w->reached; k++)
        add_body(w, world, k);
    for (int k = 0; k < w->reached; k++)
        add_grip(w, world, floor, k);
    return world;
}

/* ---- results ---- */

static void note_pressed(work *w, const ll_rigid *world)
{
    ll_contact_view c;
    for (int32_t i = 0; i < ll_rigid_contact_end(world); i++) {
        if (!ll_rigid_contact_at(world, i, &c) ||
            (c.at[0].impulse == 0 && (c.count < 2 || c.at[1].impulse == 0)))
            continue;
        int a = w->of[c.a.index - 1], b = w->of[c.b.index - 1];
        if (a < 0 || b < 0)
            continue;
        if (a < 32)
            w->body[b].pressed_by |= UINT32_C(1) << a;
        if (b < 32)
            w->body[a].pressed_by |= UINT32_C(1) << b;
    }
}

/* The floor's own rules: bodies that it holds come to rest, and nothing exceeds the top speed, also when
 * pushed out of overlap. */
static void take(const work *w, ll_floor_body *b, const ll_body_state *s)
{
    double dt = w->env->dt, top = w->floor->top_speed, top_spin = top / ll_floor_bound(b);
    double speed = ll_sqrt(s->velocity.x * s->velocity.x + s->velocity.y * s->velocity.y);
    double dx = s->position.x - b->x, dy = s->position.y - b->y, turn = s->angle - b->angle;
    double share = speed > top ? top / speed : 1, mean = ll_sqrt(dx * dx + dy * dy) / dt;
    bool held = b->grip > 0 && b->wanted_vx == 0 && b->wanted_vy == 0 &&
                speed + ll_abs(s->angular_velocity) * ll_floor_bound(b) < REST;
    b->vx = held ? 0 : share * s->velocity.x;
    b->vy = held ? 0 : share * s->velocity.y;
    b->angular_velocity = held ? 0 : ll_clamp(s->angular_velocity, -top_spin, top_spin);
    b->unsettled = false;
    if (b->vx == 0 && b->vy == 0 && b->angular_velocity == 0) {
        if (ll_abs(dx) < STILL && ll_abs(dy) < STILL && ll_abs(turn) < STILL)
            return;
        b->unsettled = true;
    }
    share = mean > top ? top / mean : 1;
    b->x = ll_mul_add(w->env, share * dx / dt, dt, b->x);
    b->y = ll_mul_add(w->env, share * dy / dt, dt, b->y);
    b->angle = ll_mul_add(w->env, ll_clamp(turn / dt, -top_spin, top_spin), dt, b->angle);
}

/* The same result as the world's step, for a body without contacts. */
static ll_body_state slide(const work *w, const ll_floor_body *b)
{
    double h = w->env->dt / w->floor->substeps, most = b->grip * h, most_spin = b->grip_spin * h;
    ll_body_state s = {.position = {b->x, b->y},
                       .angle = b->angle,
                       .velocity = {b->vx, b->vy},
                       .angular_velocity = b->angular_velocity};
    for (int k = 0; k < w->floor->substeps; k++) {
        double dx = b->wanted_vx - s.velocity.x, dy = b->wanted_vy - s.velocity.y,
               size = ll_sqrt(dx * dx + dy * dy);
        if (size <= most)
            s.velocity = (ll_vec2){b->wanted_vx, b->wanted_vy};
        else
            s.velocity = (ll_vec2){ll_mul_add(w->env, most / size, dx, s.velocity.x),
                                   ll_mul_add(w->env, most / size, dy, s.velocity.y)};
        s.angular_velocity -= ll_clamp(s.angular_velocity, -most_spin, most_spin);
        s.position = (ll_vec2){ll_mul_add(w->env, s.velocity.x, h, s.position.x),
                               ll_mul_add(w->env, s.velocity.y, h, s.position.y)};
        s.angle = ll_mul_add(w->env, s.angular_velocity, h, s.angle);
    }
    return s;
}

static void step_world(work *w)
{
    _Alignas(64) char block[BLOCK_MAX];
    ll_rigid *world = make_world(w, block);
    for (int k = 0; k < w->floor->substeps; k++) {
        must(ll_rigid_step(world, w->env->dt / w->floor->substeps, NULL));
        note_pressed(w, world);
    }
    for (int k = 0; k < w->reached; k++) {
        ll_floor_body *b = &w->body[w->order[k]];
        ll_body_state state;
        must(ll_rigid_get_body(world, w->id[k], &state));
        if (b->inverse_mass > 0)
            take(w, b, &state);
    }
}

void ll_floor_step(const ll_game_env *env, const ll_floor *floor, ll_floor_body *bodies, int count)
{
    work w;
    LL_ASSERT(count >= 0 && count <= LL_TOUCHING_MAX);
    w.env = env;
    w.floor = floor;
    w.body = bodies;
    w.count = count;
    w.reached = w.lonely = w.walls = 0;
    for (int i = 0; i < count; i++)
        bodies[i].pressed_by = 0;
    find_reached(&w);
    for (int k = 0; k < w.lonely; k++) {
        ll_body_state state = slide(&w, &bodies[w.alone[k]]);
        take(&w, &bodies[w.alone[k]], &state);
    }
    if (w.reached > 0)
        step_world(&w);
}
