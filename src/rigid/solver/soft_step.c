/* Soft step: substeps with soft contacts, each followed by a relax pass that removes the velocity which the
 * correction of overlap added (Catto, "Solver2D", 2024, there TGS Soft; the default of Box2D 3). Contacts of
 * one colour are solved four at a time.
 *
 * Passes over contacts with n substeps: 1 warm start + 2 n; friction in every second. Without joints the
 * later substeps need no warm start. The Jacobian is constant in a step, so the impulse that holds a body is
 * the difference of its velocity from that after gravity; it is applied when velocities are integrated.
 *
 * The working set stays in the cache: all substeps of one group of islands are done before the next group is
 * prepared in the same memory. */
#include "rigid/solver/soft.h"

#include <string.h>

#include "base/assert.h"

typedef struct batch { /* contacts of one colour */
    ll_wide_contact *at;
    int32_t count;
    bool fixed; /* with an immovable body: stiffer */
    bool alone; /* overflow: bodies may be shared, one lane after the other */
} batch;

typedef struct batches {
    batch at[LL_COLOUR_SLOTS];
    int32_t count;
    ll_wide_contact *all;
    int32_t contacts; /* number of wide contacts */
} batches;

/* What is solved together, by one thread or by a team: the contacts of one colour share no movable body, so
 * that its parts can be solved at the same time and in any order with the same bits. */
typedef struct soft_group {
    ll_rigid *w;
    ll_team *team;
    const ll_soft_loops *loops;
    ll_group members;
    batches all;
    ll_joint_set joints;
    double h;             /* of a substep, as are the following */
    ll_softness stiff;    /* of joints */
    ll_soft_pass push[2]; /* the second with an immovable body */
    ll_soft_pass rest[2];
    int32_t sinks, pad; /* as a workshop's */
} soft_group;

/* What one thread solves groups with: its part of the solver's memory, and sinks of its own. */
typedef struct workshop {
    char *memory;
    size_t bytes;
    ll_contact_counts counts; /* of its groups */
    int32_t sinks;            /* of the parts of its passes, from here on; LL_NONE: no other thread solves at
                                 the same time */
    int32_t idle;             /* the body of empty lanes, which all passes write */
} workshop;

/* Fewest elements that are worth a team. A wide contact takes about 50 ns in a pass, a body 10 ns in an
 * integration. */
enum { team_contacts = 32, team_bodies = 256 };

static size_t size(const ll_rigid_limits *limits)
{
    return ((size_t)limits->contacts / LL_LANES + LL_COLOUR_SLOTS + 1) * sizeof(ll_wide_contact);
}

static const ll_soft_loops *loops_of(const ll_rigid *w)
{
#if defined(__x86_64__)
    bool avx2 = __builtin_cpu_supports("avx2");
#else
    bool avx2 = false;
#endif
    switch ((ll_simd)w->params.simd) {
    case LL_SIMD_SCALAR:
        return &ll_soft_scalar;
    case LL_SIMD_SSE2:
        return &ll_soft_sse2;
    default:
        return avx2 ? &ll_soft_avx2 : &ll_soft_sse2;
    }
}

/* ---- contacts into lanes and back ---- */

/* Of a lane that is cleared. */
static void leave_empty(ll_wide_contact *c, int lane, int32_t idle)
{
    c->a[lane] = c->b[lane] = idle;
    c->contact[lane] = LL_NONE;
}

static void clear_points(ll_wide_contact *c, int lane)
{
    for (int k = 0; k < 2; k++) {
        double *p = (double *)&c->at[k];
        for (size_t i = 0; i < sizeof c->at[k] / sizeof(double) / LL_LANES; i++)
            p[i * LL_LANES + (size_t)lane] = 0;
    }
}

static void fill_point(const ll_rigid *w, ll_wide_contact *c, int lane, int k, const ll_contact_point *from,
                       const ll_relative_motion *since)
{
    ll_wide_point *p = &c->at[k];
    ll_vec2 n = {c->nx[lane], c->ny[lane]};
    double cross_a = ll_cross(from->a, n), cross_b = ll_cross(from->b, n);
    double dot_a = ll_dot(from->a, n), dot_b = ll_dot(from->b, n);
    double m = c->ma[lane] + c->mb[lane], ia = c->ia[lane], ib = c->ib[lane];
    double kn = m + ia * cross_a * cross_a + ib * cross_b * cross_b;
    double kt = m + ia * dot_a * dot_a + ib * dot_b * dot_b;
    p->cross_a[lane] = cross_a;
    p->dot_a[lane] = dot_a;
    p->cross_b[lane] = cross_b;
    p->dot_b[lane] = dot_b;
    p->adjust[lane] = from->separation + ll_dot(ll_point_gap(from, since), n) - (dot_b - dot_a);
    LL_VALIDATE(!(kn < 0) && !(kt < 0)); /* effective masses */
    p->normal_mass[lane] = kn > 0 ? 1 / kn : 0;
    p->tangent_mass[lane] = kt > 0 ? 1 / kt : 0;
    p->normal_impulse[lane] = w->params.warm_start ? from->normal_impulse : 0;
    p->tangent_impulse[lane] = w->params.warm_start ? from->tangent_impulse : 0;
}

static void fill_lane(const ll_rigid *w, ll_wide_contact *c, int lane, int32_t contact)
{
    const ll_contact *from = &ll_contacts(w)[contact];
    const ll_body_sim *a = &ll_body_sims(w)[from->body[0]], *b = &ll_body_sims(w)[from->body[1]];
    ll_vec2 n = from->normal;
    if (from->count < 2)
        clear_points(c, lane);
    c->a[lane] = from->body[0];
    c->b[lane] = from->body[1];
    c->contact[lane] = contact;
    c->points[lane] = from->count;
    c->ma[lane] = a->inv_mass;
    c->ia[lane] = a->inv_inertia;
    c->mb[lane] = b->inv_mass;
    c->ib[lane] = b->inv_inertia;
    c->nx[lane] = n.x;
    c->ny[lane] = n.y;
    c->friction[lane] = from->friction;
    ll_relative_motion since = ll_relative_motion_of(w, from);
    for (int k = 0; k < from->count; k++)
        fill_point(w, c, lane, k, &from->at[k], &since);
    c->coupling[lane] = a->inv_mass + b->inv_mass +
                        (a->inv_inertia * c->at[0].cross_a[lane] * c->at[1].cross_a[lane] +
                         b->inv_inertia * c->at[0].cross_b[lane] * c->at[1].cross_b[lane]);
}

typedef struct filling {
    const ll_rigid *w;
    const batch *batch;
    const int32_t *contacts; /* of the colour */
    int32_t count, idle;
} filling;

static void fill(void *context, int part, int parts)
{
    const filling *f = context;
    const ll_rigid *w = f->w;
    ll_share of = ll_share_of(f->batch->count, part, parts);
    for (int32_t i = of.begin * LL_LANES; i < of.end * LL_LANES; i++) {
        if (i + 8 < f->count)
            ll_prefetch_contact(&ll_contacts(w)[f->contacts[i + 8]]);
        ll_wide_contact *c = &f->batch->at[i / LL_LANES];
        int lane = i % LL_LANES;
        if (lane == 0 && f->count - i < LL_LANES)
            memset(c, 0, sizeof *c);
        if (i < f->count)
            fill_lane(w, c, lane, f->contacts[i]);
        else
            leave_empty(c, lane, f->idle);
    }
}

static void add_batch(batches *all, const ll_rigid *w, ll_team *team, const int32_t *orders,
                      const ll_colour_spans *spans, int c, int32_t idle)
{
    int32_t count = spans->end[c] - spans->begin[c];
    batch *b = &all->at[all->count++];
    *b = (batch){.at = all->all + all->contacts,
                 .count = (count + LL_LANES - 1) / LL_LANES,
                 .fixed = c == LL_OVERFLOW_STATIC || (c >= LL_COLOURS_DYNAMIC && c < LL_COLOURS),
                 .alone = c >= LL_COLOURS};
    filling f = {w, b, orders + spans->begin[c], count, idle};
    ll_team_run(team, b->count, team_contacts, fill, &f);
    all->contacts += b->count;
}

#define COLOURS(from, to) ((UINT64_C(1) << (to)) - (UINT64_C(1) << (from)))

/* Not inlined: within the substeps its loop runs out of registers, which costs 2 % of a step. */
__attribute__((noinline)) static void prepare(batches *all, const ll_rigid *w, ll_team *team,
                                              ll_index_list contacts, workshop *shop)
{
    /* Contacts with the ground are solved last. */
    static const uint64_t order[] = {
        COLOURS(LL_OVERFLOW_DYNAMIC, LL_OVERFLOW_DYNAMIC + 1), COLOURS(0, LL_COLOURS_DYNAMIC),
        COLOURS(LL_OVERFLOW_STATIC, LL_OVERFLOW_STATIC + 1), COLOURS(LL_COLOURS_DYNAMIC, LL_COLOURS)};
    ll_colour_spans spans;
    ll_contact_counts counts = ll_order_contacts(w, team, contacts, &spans);
    shop->counts.colours |= counts.colours;
    shop->counts.points += counts.points;
    shop->counts.touching += counts.touching;
    shop->counts.overflow += counts.overflow;
    all->all = (ll_wide_contact *)(void *)shop->memory;
    all->count = all->contacts = 0;
    for (size_t i = 0; i < sizeof order / sizeof order[0]; i++)
        for (uint64_t left = spans.used & order[i]; left != 0; left &= left - 1)
            add_batch(all, w, team, ll_orders(w) + contacts.first, &spans, __builtin_ctzll(left), shop->idle);
    LL_ASSERT((size_t)all->contacts * sizeof(ll_wide_contact) <= shop->bytes);
}

static void store_lane(ll_contact *to, const ll_wide_contact *c, int lane)
{
    for (int k = 0; k < c->points[lane]; k++) {
        to->at[k].normal_impulse = c->at[k].normal_impulse[lane];
        to->at[k].tangent_impulse = c->at[k].tangent_impulse[lane];
    }
}

static void store(void *context, int part, int parts)
{
    const soft_group *g = context;
    ll_contact *contacts = ll_contacts(g->w);
    ll_share of = ll_share_of(g->all.contacts, part, parts);
    for (int32_t i = of.begin; i < of.end; i++) {
        const ll_wide_contact *c = &g->all.all[i], *ahead = &g->all.all[i + 3 < of.end ? i + 3 : i];
        for (int lane = 0; lane < LL_LANES; lane++) {
            for (int k = 0; k < ahead->points[lane]; k++)
                __builtin_prefetch(&contacts[ahead->contact[lane]].at[k].normal_impulse, 1);
            if (c->contact[lane] != LL_NONE)
                store_lane(&contacts[c->contact[lane]], c, lane);
        }
    }
}

/* ---- substeps ---- */

/* After gravity: applies the impulses that held the body in the last substep. */
static void integrate_velocities(ll_rigid *w, ll_index_list bodies, double h, bool held)
{
    for (int32_t i = 0; i < bodies.count; i++) {
        int32_t k = bodies.at[i];
        ll_body_step *d = &ll_body_steps(w)[k];
        ll_solver_body *m = &ll_solver_bodies(w)[k];
        ll_vec2 v = ll_scale(d->keep, ll_madd(m->v, h, d->a));
        double spin = d->keep_angular * (m->w + h * d->angular_acceleration);
        m->v = held ? ll_add(v, d->held) : v;
        m->w = held ? spin + d->held_angular : spin;
        d->held = v;
        d->held_angular = spin;
    }
}

static void note_held(ll_rigid *w, ll_index_list bodies)
{
    for (int32_t i = 0; i < bodies.count; i++) {
        int32_t k = bodies.at[i];
        ll_body_step *d = &ll_body_steps(w)[k];
        d->held = ll_sub(ll_solver_bodies(w)[k].v, d->held);
        d->held_angular = ll_solver_bodies(w)[k].w - d->held_angular;
    }
}

typedef struct contact_pass {
    const batch *batch;
    ll_solver_body *states;
    ll_soft_loop *loop;
    const ll_soft_pass *pass;
    int32_t sinks;
} contact_pass;

/* Contacts with immovable bodies share these, which are therefore written to a place of each part. */
static void pass_part(void *context, int part, int parts)
{
    const contact_pass *p = context;
    ll_share of = ll_share_of(p->batch->count, part, parts);
    ll_soft_pass pass = *p->pass;
    pass.sink = p->sinks != LL_NONE && p->batch->fixed ? p->sinks + part : LL_NONE;
    p->loop(p->batch->at + of.begin, of.end - of.begin, p->states, &pass);
}

/* Contacts beyond the colours share movable bodies: one thread solves them. `alone`: the scalar loop. */
static void pass_all(const soft_group *g, ll_soft_loop *wide, ll_soft_loop *alone, const ll_soft_pass pass[2])
{
    ll_solver_body *states = ll_solver_bodies(g->w);
    for (int32_t i = 0; i < g->all.count; i++) {
        const batch *b = &g->all.at[i];
        ll_team *team = b->alone ? NULL : g->team;
        if (g->sinks == LL_NONE && ll_team_parts_of(team, b->count, team_contacts) == 1) {
            (b->alone ? alone : wide)(b->at, b->count, states, &pass[b->fixed]);
            continue;
        }
        contact_pass p = {.batch = b,
                          .states = states,
                          .loop = b->alone ? alone : wide,
                          .pass = &pass[b->fixed],
                          .sinks = g->sinks};
        ll_team_run(team, b->count, team_contacts, pass_part, &p);
    }
}

static void warm_start(const soft_group *g)
{
    const ll_soft_pass none[2] = {{.sink = LL_NONE}, {.sink = LL_NONE}};
    pass_all(g, g->loops->warm_start, ll_soft_scalar.warm_start, none);
}

static ll_index_list bodies_of(const soft_group *g, int part, int parts)
{
    ll_share of = ll_share_of(g->members.bodies.count, part, parts);
    return (ll_index_list){.at = g->members.bodies.at + of.begin, .count = of.end - of.begin};
}

static void prepare_bodies(void *context, int part, int parts)
{
    const soft_group *g = context;
    ll_prepare_body_steps(g->w, bodies_of(g, part, parts), g->h);
}

static void begin_substep(void *context, int part, int parts)
{
    const soft_group *g = context;
    integrate_velocities(g->w, bodies_of(g, part, parts), g->h, false);
}

static void begin_held_substep(void *context, int part, int parts)
{
    const soft_group *g = context;
    integrate_velocities(g->w, bodies_of(g, part, parts), g->h, true);
}

static void move(void *context, int part, int parts)
{
    const soft_group *g = context;
    ll_integrate_positions(g->w, bodies_of(g, part, parts), g->h);
}

static void end_held_substep(void *context, int part, int parts)
{
    const soft_group *g = context;
    note_held(g->w, bodies_of(g, part, parts));
}

static void on_bodies(soft_group *g, ll_team_job *job)
{
    ll_team_run(g->team, g->members.bodies.count, team_bodies, job, g);
}

static void set_softness(soft_group *g, const ll_rigid_params *p)
{
    double h = g->h, hertz = ll_min(p->contact_hertz, 0.125 / h);
    g->stiff = ll_soft(ll_min(p->joint_hertz, 0.25 / h), p->joint_damping_ratio, h);
    for (int fixed = 0; fixed < 2; fixed++) {
        ll_softness soft = ll_soft(fixed ? 2 * hertz : hertz, p->contact_damping_ratio, h);
        g->push[fixed] = (ll_soft_pass){soft, 1 / h, p->contact_push_speed, LL_NONE, 0};
        g->rest[fixed] = (ll_soft_pass){{0, 1, 0}, 1 / h, p->contact_push_speed, LL_NONE, 0};
    }
}

static void substep(soft_group *g, bool first)
{
    ll_rigid *w = g->w;
    bool joints = w->joints > 0;
    on_bodies(g, !first && !joints ? begin_held_substep : begin_substep);
    if (joints)
        ll_warm_start_joints(w, &g->joints);
    if (first || joints)
        warm_start(g);
    if (joints)
        ll_solve_joints(w, &g->joints, g->h, g->stiff, true);
    pass_all(g, g->loops->solve, ll_soft_scalar.solve, g->push);
    on_bodies(g, move);
    if (joints)
        ll_solve_joints(w, &g->joints, g->h, g->stiff, false);
    pass_all(g, g->loops->relax, ll_soft_scalar.relax, g->rest);
    if (!joints)
        on_bodies(g, end_held_substep);
}

static double substep_of(const ll_rigid *w)
{
    return w->dt / (double)w->params.substeps;
}

static void solve_group(ll_rigid *w, ll_team *team, const ll_group *members, bool crowded, workshop *shop)
{
    soft_group g; /* few of its batches are used, and none is cleared */
    g.w = w;
    g.team = team;
    g.loops = loops_of(w);
    g.members = *members;
    g.h = substep_of(w);
    g.sinks = shop->sinks;
    set_softness(&g, &w->params);
    prepare(&g.all, w, team, members->contacts, shop);
    on_bodies(&g, prepare_bodies);
    size_t used = ((size_t)g.all.contacts * sizeof(ll_wide_contact) + 63) & ~(size_t)63;
    ll_bounces bounces =
        ll_begin_bounces(w, team, members->contacts, shop->memory + used, shop->bytes - used);
    bounces.crowded |= crowded;
    g.joints = ll_prepare_joints(w, members->joints);
    for (int64_t i = 0; i < w->params.substeps; i++) {
        ll_bounce(w, &bounces, g.h, 2 * g.h);
        substep(&g, i == 0);
    }
    ll_end_bounces(w, &bounces);
    ll_team_run(team, g.all.contacts, team_contacts, store, &g);
    ll_store_joints(w, &g.joints);
}

/* ---- groups ---- */

static workshop workshop_of(const ll_rigid *w, int part, int parts)
{
    size_t bytes = (w->at.end - w->at.solver) / (size_t)parts & ~(size_t)63;
    return (workshop){.memory = (char *)ll_solver_memory(w) + (size_t)part * bytes,
                      .bytes = bytes,
                      .sinks = parts > 1 ? ll_first_sink(w) + part : LL_NONE,
                      .idle = parts > 1 ? ll_first_sink(w) + part : w->limits.bodies};
}

/* Groups of which each thread solves some by itself, without waiting for the others. */
typedef struct shared_groups {
    ll_rigid *w;
    const ll_groups *groups;
    workshop shop[LL_TEAM_PARTS_MAX];
} shared_groups;

/* Groups follow each other by their first body. */
static ll_share groups_of_part(const ll_rigid *w, const ll_groups *g, int part, int parts)
{
    ll_share of = ll_share_of(w->awake, part, parts), groups = {0, 0};
    while (groups.begin < g->count && (groups.begin > 0 ? g->body_end[groups.begin - 1] : 0) < of.begin)
        groups.begin++;
    for (groups.end = groups.begin; groups.end < g->count; groups.end++)
        if ((groups.end > 0 ? g->body_end[groups.end - 1] : 0) >= of.end)
            break;
    return groups;
}

static void solve_share(void *context, int part, int parts)
{
    shared_groups *s = context;
    ll_share of = groups_of_part(s->w, s->groups, part, parts);
    for (int32_t i = of.begin; i < of.end; i++) {
        ll_group group = ll_group_at(s->w, s->groups, i);
        solve_group(s->w, NULL, &group, false, &s->shop[part]);
    }
}

static bool is_even(const ll_rigid *w, const ll_groups *g, int parts)
{
    for (int part = 0; part < parts; part++) {
        ll_share of = groups_of_part(w, g, part, parts);
        int32_t bodies = 0;
        for (int32_t i = of.begin; i < of.end; i++) {
            ll_group group = ll_group_at(w, g, i);
            size_t most = (size_t)group.contacts.count / LL_LANES + LL_COLOUR_SLOTS + 1;
            if (most * sizeof(ll_wide_contact) > workshop_of(w, part, parts).bytes)
                return false;
            bodies += group.bodies.count;
        }
        if (8 * (int64_t)parts * bodies > 9 * (int64_t)w->awake)
            return false;
    }
    return true;
}

/* Whether the threads of a team share the groups; only if these fit its parts of the memory, and are about as
 * many bodies for each. Joints and impacts have no memory of their own for each thread. */
static bool solve_apart(ll_rigid *w, ll_team *team)
{
    int parts = ll_team_parts(team);
    if (w->joints > 0 || w->bouncing > 0)
        return false;
    ll_groups groups = ll_group_islands(w, team);
    if (groups.count < parts || !is_even(w, &groups, parts))
        return false;
    shared_groups s; /* not all of it is used, nor cleared */
    s.w = w;
    s.groups = &groups;
    for (int k = 0; k < parts; k++)
        s.shop[k] = workshop_of(w, k, parts);
    team->run(team, solve_share, &s);
    for (int k = 0; k < parts; k++)
        ll_count_contacts(w, &s.shop[k].counts);
    return true;
}

/* A team shares the groups, or solves the awake world at once: in groups that fit one cache its threads would
 * meet too often. */
static void solve(ll_rigid *w, ll_team *team)
{
    ll_groups groups = {.count = 1};
    workshop shop = workshop_of(w, 0, 1);
    if (ll_team_parts(team) > 1) {
        if (solve_apart(w, team))
            return;
        shop.sinks = ll_first_sink(w);
    } else {
        groups = ll_group_islands(w, NULL);
    }
    bool crowded = groups.count > 1 && ll_bounces_crowded(w, substep_of(w));
    for (int32_t i = 0; i < groups.count; i++) {
        ll_group group = ll_group_at(w, &groups, i);
        solve_group(w, team, &group, crowded, &shop);
    }
    ll_count_contacts(w, &shop.counts);
}

const ll_solver ll_solver_soft_step = {
    .name = "soft_step",
    .help = "Substeps with soft contacts and a relax pass each (TGS soft, as Box2D 3): 2 passes per substep.",
    .passes = {[LL_PER_SUBSTEP] = 2},
    .size = size,
    .solve = solve};
