/* Augmented vertex block descent (Giles, Diaz, Yuksel, "Augmented Vertex Block Descent", ACM TOG 44(4),
 * 2025). The step minimises inertia plus the constraints' energy. Each body in turn takes a Newton step of
 * its own three unknowns; then forces and penalties of violated constraints grow. Both are kept for the next
 * step. Errors present at the beginning of the step are left until velocities are known. A last descent then
 * removes them, so that their correction adds no velocity (the authors' post-stabilisation). Passes over
 * contacts: 3 per iteration (each contact is seen from both its bodies, and once to grow), and 2.
 *
 * Forces are in N (lambda of the paper). Errors C have the sign for which a positive force pushes b along
 * n. */
#include "rigid/solver/solver.h"

#include <string.h>

static const double gamma_kept = 0.99; /* decay of penalties per step */
static const double growth = 1e5;      /* of penalties, N/m per m of error */
static const double least_penalty = 1, most_penalty = 1e9;

typedef struct cp { /* contact point */
    ll_vec2 ra, rb;
    double c0[2]; /* normal and tangential error at the beginning of the step */
    double force[2], penalty;
    double pad;
} cp;

typedef struct touch {
    int32_t contact, a, b, count;
    ll_vec2 n;
    double friction;
    cp at[2];
} touch;

typedef struct goal { /* where inertia alone would move a body */
    ll_vec2 d;
    double turn;
    double pad;
} goal;

typedef struct memory {
    touch *touches;
    int32_t *place; /* index of a contact in `touches` */
    goal *goals;
    double (*joint_c0)[LL_ROWS];
    int32_t count, pad;
    double h;
    double settle; /* fraction of the initial errors to remove: 0, and 1 in the last descent */
} memory;

static size_t round_up(size_t bytes)
{
    return (bytes + 63) & ~(size_t)63;
}

static size_t size(const ll_rigid_limits *l)
{
    return round_up((size_t)l->contacts * sizeof(touch)) + round_up((size_t)l->contacts * sizeof(int32_t)) +
           round_up((size_t)l->bodies * sizeof(goal)) +
           round_up((size_t)l->joints * LL_ROWS * sizeof(double));
}

static memory memory_of(ll_rigid *w)
{
    char *at = ll_solver_memory(w);
    const ll_rigid_limits *l = &w->limits;
    memory m = {.touches = (touch *)at, .h = w->dt};
    at += round_up((size_t)l->contacts * sizeof(touch));
    m.place = (int32_t *)at;
    at += round_up((size_t)l->contacts * sizeof(int32_t));
    m.goals = (goal *)at;
    at += round_up((size_t)l->bodies * sizeof(goal));
    m.joint_c0 = (double(*)[LL_ROWS])at;
    return m;
}

static double clamped(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

/* ---- beginning of the step ---- */

static void begin_touches(ll_rigid *w, memory *m)
{
    ll_colour_spans spans;
    bool warm = w->params.warm_start;
    ll_contact_counts counts = ll_order_contacts(w, NULL, ll_whole(w).contacts, &spans);
    m->count = counts.touching;
    ll_count_contacts(w, &counts);
    for (int32_t i = 0; i < m->count; i++) {
        int32_t index = ll_orders(w)[i];
        const ll_contact *c = &ll_contacts(w)[index];
        ll_relative_motion since = ll_relative_motion_of(w, c);
        touch *t = &m->touches[i];
        *t = (touch){.contact = index,
                     .a = c->body[0],
                     .b = c->body[1],
                     .count = c->count,
                     .n = c->normal,
                     .friction = c->friction};
        m->place[index] = i;
        for (int k = 0; k < c->count; k++) {
            const ll_contact_point *p = &c->at[k];
            ll_vec2 gap = ll_point_gap(p, &since);
            t->at[k] = (cp){
                .ra = p->a,
                .rb = p->b,
                .c0 = {ll_dot(gap, t->n) + p->separation, ll_dot(gap, ll_right(t->n))},
                .force = {warm ? p->normal_impulse / m->h : 0, warm ? p->tangent_impulse / m->h : 0},
                .penalty = clamped(warm ? gamma_kept * (double)p->penalty : 0, least_penalty, most_penalty)};
        }
    }
}

static void joint_rows(const ll_rigid *w, const ll_joint *j, ll_constraint_row rows[LL_ROWS])
{
    memset(rows, 0, LL_ROWS * sizeof(ll_constraint_row));
    ll_joint_row_types[j->def.type].rows(j, ll_pose_now(w, j->body[0]), ll_pose_now(w, j->body[1]),
                                         ll_angle_now(w, j), rows);
}

static void begin_joints(ll_rigid *w, memory *m)
{
    for (int32_t i = 0; i < w->joint_end; i++) {
        ll_joint *j = &ll_joints(w)[i];
        if (j->body[0] == LL_NONE)
            continue;
        ll_constraint_row rows[LL_ROWS];
        joint_rows(w, j, rows);
        for (int k = 0; k < LL_ROWS; k++) {
            bool moves = rows[k].kind == LL_ROW_MOTOR || rows[k].hertz > 0 ||
                         (rows[k].kind == LL_ROW_LIMIT && rows[k].c > 0);
            m->joint_c0[i][k] = moves ? 0 : rows[k].c;
            if (!w->params.warm_start)
                j->force[k] = 0;
            j->penalty[k] = clamped(gamma_kept * j->penalty[k], least_penalty, most_penalty);
        }
    }
}

/* Goal of inertia. The initial guess includes gravity as far as the body followed it in the last step, so
 * that resting bodies start at rest. */
static void begin_bodies(ll_rigid *w, memory *m)
{
    double h = m->h;
    for (int32_t i = 0; i < w->awake; i++) {
        int32_t k = ll_awake_bodies(w)[i];
        ll_solver_body *motion = &ll_solver_bodies(w)[k];
        const ll_body_step *d = &ll_body_steps(w)[k];
        ll_vec2 v = ll_scale(d->keep, ll_madd(motion->v, h, d->a));
        double spin = d->keep_angular * (motion->w + h * d->angular_acceleration);
        m->goals[k] = (goal){.d = ll_scale(h, v), .turn = h * spin};
        bool moved = ll_bodies(w)[k].inv_mass == 0;
        ll_vec2 guess = ll_scale(h, moved ? v : motion->v);
        motion->d = guess;
        motion->turn = h * (moved ? spin : motion->w);
        motion->q = ll_rot_small(motion->turn);
    }
}

/* ---- errors ---- */

/* Of a contact point, to first order in the rotations. */
static void point_errors(const ll_rigid *w, const memory *m, const touch *t, const cp *l, double c[2])
{
    const ll_solver_body *a = &ll_solver_bodies(w)[t->a], *b = &ll_solver_bodies(w)[t->b];
    ll_vec2 moved =
        ll_sub(ll_add(b->d, ll_cross_sv(b->turn, l->rb)), ll_add(a->d, ll_cross_sv(a->turn, l->ra)));
    c[0] = (l->c0[0] > 0 ? l->c0[0] : m->settle * l->c0[0]) + ll_dot(moved, t->n);
    c[1] = m->settle * l->c0[1] + ll_dot(moved, ll_right(t->n));
}

static void point_forces(const touch *t, const cp *l, const double c[2], double force[2])
{
    force[0] = ll_max(l->force[0] - l->penalty * c[0], 0);
    double most = t->friction * force[0];
    force[1] = clamped(l->force[1] - l->penalty * c[1], -most, most);
}

/* ---- Newton step of a body ---- */

typedef struct newton {
    double h[3][3]; /* Hessian of the energy; upper half */
    double g[3];    /* missing force (negative gradient) */
} newton;

static void add_row(newton *s, ll_vec2 n, double lever, double stiffness, double force, double curvature)
{
    double j[3] = {n.x, n.y, lever};
    for (int i = 0; i < 3; i++) {
        for (int k = i; k < 3; k++)
            s->h[i][k] += stiffness * j[i] * j[k];
        s->g[i] += force * j[i];
    }
    s->h[2][2] += fabs(curvature * force);
}

static void add_touches(const ll_rigid *w, const memory *m, int32_t body, newton *s)
{
    for (int32_t e = ll_bodies(w)[body].contact; e != LL_NONE; e = ll_contacts(w)[e >> 1].next[e & 1]) {
        if (ll_contacts(w)[e >> 1].count == 0)
            continue;
        const touch *t = &m->touches[m->place[e >> 1]];
        double side = e & 1 ? 1 : -1;
        for (int k = 0; k < t->count; k++) {
            const cp *l = &t->at[k];
            double c[2], force[2];
            point_errors(w, m, t, l, c);
            point_forces(t, l, c, force);
            /* A contact that has just separated still resists; otherwise it would separate and hit
             * alternately. */
            if (force[0] == 0 && c[0] > 0.1 * LL_LINEAR_SLOP)
                continue;
            ll_vec2 r = e & 1 ? l->rb : l->ra, tangent = ll_right(t->n);
            add_row(s, t->n, ll_cross(r, t->n), l->penalty, side * force[0], ll_dot(r, t->n));
            add_row(s, tangent, ll_cross(r, tangent), l->penalty, side * force[1], ll_dot(r, tangent));
        }
    }
}

/* Current error, force and stiffness of a joint's row. A spring has its own stiffness; the error of a motor
 * is its missing speed. A force at its limit has the stiffness of the secant to its error, so that a body is
 * not held where the row cannot hold it. */
static double row_force(const ll_rigid *w, const memory *m, const ll_joint *j, int32_t index, int k,
                        const ll_constraint_row *r, double *stiffness, double *error)
{
    const ll_body *a = &ll_bodies(w)[j->body[0]], *b = &ll_bodies(w)[j->body[1]];
    const ll_solver_body *ma = &ll_solver_bodies(w)[j->body[0]], *mb = &ll_solver_bodies(w)[j->body[1]];
    double inverse = (a->inv_mass + b->inv_mass) * ll_dot(r->n, r->n) + a->inv_inertia * r->ja * r->ja +
                     b->inv_inertia * r->jb * r->jb;
    double moved = ll_dot(r->n, ll_sub(mb->d, ma->d)) + r->jb * mb->turn - r->ja * ma->turn;
    double c = r->c - (1 - m->settle) * m->joint_c0[index][k], kept = j->force[k], damped = 0;
    *stiffness = j->penalty[k];
    if (r->kind == LL_ROW_MOTOR)
        c = moved - r->speed * m->h;
    if (r->hertz > 0 && inverse > 0) {
        double omega = 2 * 3.14159265358979323846 * r->hertz,
               drag = 2 * r->damping * omega / (inverse * m->h);
        *stiffness = omega * omega / inverse + drag;
        damped = drag * (moved - c);
        kept = 0;
    }
    *error = c;
    double wanted = kept - *stiffness * c - damped;
    double force = clamped(wanted, r->kind == LL_ROW_LIMIT ? 0 : -r->most, r->most);
    if (r->kind == LL_ROW_LIMIT && force == 0 && c > 0.1 * LL_LINEAR_SLOP)
        *stiffness = 0;
    else if (fabs(wanted) > r->most)
        *stiffness = ll_min(*stiffness, r->most / fabs(c));
    return force;
}

static void add_joints(const ll_rigid *w, const memory *m, int32_t body, newton *s)
{
    for (int32_t e = ll_bodies(w)[body].joint; e != LL_NONE; e = ll_joints(w)[e >> 1].next[e & 1]) {
        const ll_joint *j = &ll_joints(w)[e >> 1];
        ll_constraint_row rows[LL_ROWS];
        joint_rows(w, j, rows);
        for (int k = 0; k < LL_ROWS; k++) {
            if (rows[k].kind == LL_ROW_NONE)
                continue;
            double stiffness, error, force = row_force(w, m, j, e >> 1, k, &rows[k], &stiffness, &error);
            double lever = e & 1 ? rows[k].jb : rows[k].ja, side = e & 1 ? 1 : -1;
            add_row(s, rows[k].n, lever, stiffness, side * force,
                    ll_length(e & 1 ? j->def.anchor_b : j->def.anchor_a));
        }
    }
}

/* Solves the symmetric system of three by elimination; inertia makes it positive definite. */
static void solve_three(newton *s, double x[3])
{
    double(*h)[3] = s->h;
    double l10 = h[0][1] / h[0][0], l20 = h[0][2] / h[0][0];
    double d1 = h[1][1] - l10 * h[0][1], e12 = h[1][2] - l10 * h[0][2], l21 = e12 / d1;
    double d2 = h[2][2] - l20 * h[0][2] - l21 * e12;
    double y1 = s->g[1] - l10 * s->g[0], y2 = s->g[2] - l20 * s->g[0] - l21 * y1;
    x[2] = y2 / d2;
    x[1] = y1 / d1 - l21 * x[2];
    x[0] = s->g[0] / h[0][0] - l10 * x[1] - l20 * x[2];
}

static void descend(ll_rigid *w, const memory *m, int32_t body)
{
    const ll_body *b = &ll_bodies(w)[body];
    ll_solver_body *motion = &ll_solver_bodies(w)[body];
    if (b->inv_mass == 0)
        return;
    double mass = b->mass / (m->h * m->h), inertia = b->inertia / (m->h * m->h);
    if (b->inv_inertia == 0)
        inertia = 1e15; /* fixed rotation */
    ll_vec2 off = ll_sub(m->goals[body].d, motion->d);
    newton s = {.h = {{mass, 0, 0}, {0, mass, 0}, {0, 0, inertia}},
                .g = {mass * off.x, mass * off.y, inertia * (m->goals[body].turn - motion->turn)}};
    double x[3];
    add_touches(w, m, body, &s);
    add_joints(w, m, body, &s);
    solve_three(&s, x);
    motion->d = ll_add(motion->d, ll_vec(x[0], x[1]));
    motion->turn += x[2];
    motion->q = ll_rot_small(motion->turn);
}

/* ---- growth of forces and penalties ---- */

static void grow_touches(const ll_rigid *w, memory *m)
{
    for (int32_t i = 0; i < m->count; i++) {
        touch *t = &m->touches[i];
        for (int k = 0; k < t->count; k++) {
            cp *l = &t->at[k];
            double c[2], force[2];
            point_errors(w, m, t, l, c);
            point_forces(t, l, c, force);
            l->force[0] = force[0];
            l->force[1] = force[1];
            if (force[0] > 0)
                l->penalty = ll_min(l->penalty + growth * fabs(c[0]), most_penalty);
        }
    }
}

static void grow_joints(ll_rigid *w, const memory *m)
{
    for (int32_t i = 0; i < w->joint_end; i++) {
        ll_joint *j = &ll_joints(w)[i];
        if (j->body[0] == LL_NONE)
            continue;
        ll_constraint_row rows[LL_ROWS];
        joint_rows(w, j, rows);
        for (int k = 0; k < LL_ROWS; k++) {
            if (rows[k].kind == LL_ROW_NONE || rows[k].hertz > 0)
                continue;
            double stiffness, error;
            j->force[k] = row_force(w, m, j, i, k, &rows[k], &stiffness, &error);
            if (fabs(j->force[k]) < rows[k].most && (j->force[k] > 0 || rows[k].kind != LL_ROW_LIMIT))
                j->penalty[k] = ll_min(j->penalty[k] + growth * fabs(error), most_penalty);
        }
    }
}

static void end(ll_rigid *w, const memory *m)
{
    for (int32_t i = 0; i < w->awake; i++) {
        int32_t k = ll_awake_bodies(w)[i];
        ll_solver_body *motion = &ll_solver_bodies(w)[k];
        if (ll_bodies(w)[k].inv_mass == 0)
            continue;
        motion->v = ll_scale(1 / m->h, motion->d);
        motion->w = motion->turn / m->h;
    }
    for (int32_t i = 0; i < m->count; i++) {
        ll_contact *c = &ll_contacts(w)[m->touches[i].contact];
        for (int k = 0; k < c->count; k++) {
            c->at[k].normal_impulse = m->touches[i].at[k].force[0] * m->h;
            c->at[k].tangent_impulse = m->touches[i].at[k].force[1] * m->h;
            c->at[k].penalty = (float)m->touches[i].at[k].penalty;
        }
    }
}

/* The body made last first: a stack built upwards is solved downwards, and each body passes on the load
 * above. */
static void descend_all(ll_rigid *w, const memory *m)
{
    for (int32_t i = w->awake; i-- > 0;)
        descend(w, m, ll_awake_bodies(w)[i]);
}

static void solve(ll_rigid *w, ll_team *team)
{
    (void)team;
    memory m = memory_of(w);
    ll_group all = ll_whole(w);
    begin_touches(w, &m);
    ll_prepare_body_steps(w, all.bodies, m.h);
    ll_bounces bounces = ll_begin_bounces(w, NULL, all.contacts, NULL, 0);
    ll_bounce(w, &bounces, m.h, m.h);
    ll_end_bounces(w, &bounces);
    begin_joints(w, &m);
    begin_bodies(w, &m);
    for (int64_t n = 0; n < w->params.iterations; n++) {
        descend_all(w, &m);
        grow_touches(w, &m);
        grow_joints(w, &m);
    }
    end(w, &m);
    m.settle = 1;
    descend_all(w, &m);
}

const ll_solver ll_solver_avbd = {
    .name = "avbd",
    .help =
        "Augmented vertex block descent (Giles et al. 2025): bodies one by one against growing penalties; 3 "
        "passes per iteration. The paper has no restitution: impacts are resolved before the step.",
    .passes = {[LL_PER_ITERATION] = 3},
    .size = size,
    .solve = solve};
