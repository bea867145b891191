/* Joints for velocity solvers: one by one, as rows. */
#include "rigid/solver/solver.h"

#include <string.h>

typedef struct pair {
    ll_solver_body *a, *b;
    double ma, ia, mb, ib;
} pair;

static pair pair_of(ll_rigid *w, const ll_joint *j)
{
    const ll_body *a = &ll_bodies(w)[j->body[0]], *b = &ll_bodies(w)[j->body[1]];
    return (pair){&ll_solver_bodies(w)[j->body[0]],
                  &ll_solver_bodies(w)[j->body[1]],
                  a->inv_mass,
                  a->inv_inertia,
                  b->inv_mass,
                  b->inv_inertia};
}

static void apply_row_impulse(const pair *p, const ll_constraint_row *row, double impulse)
{
    p->a->v = ll_madd(p->a->v, -p->ma * impulse, row->n);
    p->a->w -= p->ia * row->ja * impulse;
    p->b->v = ll_madd(p->b->v, p->mb * impulse, row->n);
    p->b->w += p->ib * row->jb * impulse;
}

static double row_speed(const pair *p, const ll_constraint_row *row)
{
    return ll_dot(row->n, ll_sub(p->b->v, p->a->v)) + row->jb * p->b->w - row->ja * p->a->w;
}

static double row_cross(const pair *p, const ll_constraint_row *x, const ll_constraint_row *y)
{
    return (p->ma + p->mb) * ll_dot(x->n, y->n) + p->ia * x->ja * y->ja + p->ib * x->jb * y->jb;
}

static void rows_of(const ll_rigid *w, const ll_joint *j, ll_constraint_row rows[LL_ROWS])
{
    memset(rows, 0, LL_ROWS * sizeof(ll_constraint_row));
    ll_joint_row_types[j->def.type].rows(j, ll_pose_now(w, j->body[0]), ll_pose_now(w, j->body[1]),
                                         ll_angle_now(w, j), rows);
}

/* ---- revolute joints: the most common, so their rows are written out; a friction joint yields ---- */

struct ll_revolute_sim {
    int32_t joint, a, b;
    int32_t revolute_limits; /* LL_NONE: neither limits nor a motor */
    double ma, ia, mb, ib;
    ll_vec2 ra, rb, gap; /* anchors and their gap at the beginning of the step */
    double most; /* N, of friction; infinite for a revolute joint, which also corrects its anchors' gap */
    ll_vec2 impulse;
};

struct ll_revolute_limits { /* impulses of rows 3 to 5 */
    double angle;           /* at the beginning of the step */
    double lower, upper, speed, torque;
    double lower_impulse, upper_impulse, motor_impulse;
    int32_t limited, motored;
};

size_t ll_revolute_sim_size(void)
{
    return sizeof(ll_revolute_sim);
}

size_t ll_revolute_limits_size(void)
{
    return sizeof(ll_revolute_limits);
}

static ll_revolute_limits revolute_limits_of(const ll_rigid *w, const ll_joint *j)
{
    const ll_joint_def *d = &j->def;
    if (d->type == LL_JOINT_FRICTION)
        return (ll_revolute_limits){.torque = d->max_torque, .motor_impulse = j->impulse[5], .motored = 1};
    return (ll_revolute_limits){.angle = (ll_bodies(w)[j->body[1]].angle - ll_bodies(w)[j->body[0]].angle) -
                                         d->angle,
                                .lower = d->lower,
                                .upper = d->upper,
                                .speed = d->motor_speed,
                                .torque = d->max_torque,
                                .lower_impulse = j->impulse[3],
                                .upper_impulse = j->impulse[4],
                                .motor_impulse = j->impulse[5],
                                .limited = d->limited,
                                .motored = d->motored};
}

static ll_revolute_sim revolute_of(const ll_rigid *w, int32_t joint)
{
    const ll_joint *j = &ll_joints(w)[joint];
    const ll_body *a = &ll_bodies(w)[j->body[0]], *b = &ll_bodies(w)[j->body[1]];
    ll_pose pa = ll_poses(w)[j->body[0]], pb = ll_poses(w)[j->body[1]];
    return (ll_revolute_sim){.joint = joint,
                             .a = j->body[0],
                             .b = j->body[1],
                             .revolute_limits = LL_NONE,
                             .ma = a->inv_mass,
                             .ia = a->inv_inertia,
                             .mb = b->inv_mass,
                             .ib = b->inv_inertia,
                             .ra = ll_rotate(pa.q, j->def.anchor_a),
                             .rb = ll_rotate(pb.q, j->def.anchor_b),
                             .gap = ll_sub(pb.p, pa.p),
                             .most = j->def.type == LL_JOINT_FRICTION ? j->def.max_force : INFINITY,
                             .impulse = {j->impulse[0], j->impulse[1]}};
}

ll_joint_set ll_prepare_joints(ll_rigid *w, ll_index_list joints)
{
    ll_joint_set set = {.revolutes = ll_revolute_sims(w),
                        .revolute_limits = ll_revolute_limit_sets(w),
                        .others = ll_scratch(w)};
    for (int32_t i = 0; i < joints.count; i++) {
        ll_joint *j = &ll_joints(w)[joints.at[i]];
        if (!ll_joint_awake(w, joints.at[i]))
            continue;
        if (!w->params.warm_start)
            memset(j->impulse, 0, sizeof j->impulse);
        bool friction = j->def.type == LL_JOINT_FRICTION;
        if (j->def.type != LL_JOINT_REVOLUTE && !friction) {
            set.others[set.other_count++] = joints.at[i];
            continue;
        }
        set.revolutes[set.revolute_count] = revolute_of(w, joints.at[i]);
        if (j->def.limited || j->def.motored || friction) {
            set.revolutes[set.revolute_count].revolute_limits = set.revolute_limits_count;
            set.revolute_limits[set.revolute_limits_count++] = revolute_limits_of(w, j);
        }
        set.revolute_count++;
    }
    return set;
}

void ll_store_joints(ll_rigid *w, const ll_joint_set *set)
{
    for (int32_t i = 0; i < set->revolute_count; i++) {
        ll_joint *j = &ll_joints(w)[set->revolutes[i].joint];
        j->impulse[0] = set->revolutes[i].impulse.x;
        j->impulse[1] = set->revolutes[i].impulse.y;
        if (set->revolutes[i].revolute_limits == LL_NONE)
            continue;
        const ll_revolute_limits *t = &set->revolute_limits[set->revolutes[i].revolute_limits];
        j->impulse[3] = t->lower_impulse;
        j->impulse[4] = t->upper_impulse;
        j->impulse[5] = t->motor_impulse;
    }
}

static void apply_revolute_impulse(const ll_revolute_sim *h, ll_solver_body *a, ll_solver_body *b, ll_vec2 ra,
                                   ll_vec2 rb, ll_vec2 impulse)
{
    a->v = ll_madd(a->v, -h->ma, impulse);
    a->w -= h->ia * ll_cross(ra, impulse);
    b->v = ll_madd(b->v, h->mb, impulse);
    b->w += h->ib * ll_cross(rb, impulse);
}

static void turn(const ll_revolute_sim *h, ll_solver_body *a, ll_solver_body *b, double impulse)
{
    a->w -= h->ia * impulse;
    b->w += h->ib * impulse;
}

/* `room`: distance of the angle to the limit, `speed`: rate at which it grows. */
static double limit_impulse(double room, double speed, double mass, double h, ll_softness soft, double old)
{
    ll_softness s = room > 0 ? (ll_softness){1 / h, 1, 0} : soft;
    return ll_max(old - s.mass_scale * mass * (speed + s.bias_rate * room) - s.impulse_scale * old, 0);
}

/* This and the next return whether an impulse changed. */
static bool solve_revolute_limits(ll_solver_body *states, const ll_revolute_sim *revolute,
                                  ll_revolute_limits *t, double h, ll_softness soft)
{
    ll_solver_body *a = &states[revolute->a], *b = &states[revolute->b];
    double k = revolute->ia + revolute->ib, mass = k > 0 ? 1 / k : 0;
    bool changed = false;
    if (t->motored) {
        double old = t->motor_impulse, most = t->torque * h;
        t->motor_impulse = ll_max(ll_min(old - mass * (b->w - a->w - t->speed), most), -most);
        turn(revolute, a, b, t->motor_impulse - old);
        changed = t->motor_impulse != old;
    }
    if (!t->limited)
        return changed;
    double angle = t->angle + (b->turn - a->turn), old = t->upper_impulse;
    t->upper_impulse = limit_impulse(t->upper - angle, a->w - b->w, mass, h, soft, old);
    turn(revolute, a, b, old - t->upper_impulse);
    changed |= t->upper_impulse != old;
    old = t->lower_impulse;
    t->lower_impulse = limit_impulse(angle - t->lower, b->w - a->w, mass, h, soft, old);
    turn(revolute, a, b, t->lower_impulse - old);
    return changed | (t->lower_impulse != old);
}

/* The part of `impulse` that keeps the sum within the friction limit. */
static ll_vec2 held(const ll_revolute_sim *revolute, ll_vec2 impulse, double most)
{
    ll_vec2 sum = ll_add(revolute->impulse, impulse);
    double size = ll_length(sum);
    return size > most ? ll_sub(ll_scale(most / size, sum), revolute->impulse) : impulse;
}

static bool solve_revolute(ll_solver_body *states, ll_revolute_sim *h, double dt, ll_softness soft)
{
    ll_solver_body *a = &states[h->a], *b = &states[h->b];
    ll_vec2 ra = ll_rotate(a->q, h->ra), rb = ll_rotate(b->q, h->rb);
    bool slides = h->most < INFINITY;
    if (slides)
        soft = (ll_softness){0, 1, 0};
    double mass = h->ma + h->mb;
    double k11 = mass + h->ia * ra.y * ra.y + h->ib * rb.y * rb.y;
    double k22 = mass + h->ia * ra.x * ra.x + h->ib * rb.x * rb.x;
    double k12 = -h->ia * ra.x * ra.y - h->ib * rb.x * rb.y, det = k11 * k22 - k12 * k12;
    if (det <= 0)
        return false;
    ll_vec2 gap = ll_add(ll_add(h->gap, ll_sub(b->d, a->d)), ll_sub(rb, ra));
    ll_vec2 e = ll_sub(ll_add(b->v, ll_cross_sv(b->w, rb)), ll_add(a->v, ll_cross_sv(a->w, ra)));
    e = ll_madd(e, soft.bias_rate, gap);
    double scale = soft.mass_scale / det;
    ll_vec2 impulse = {-scale * (k22 * e.x - k12 * e.y) - soft.impulse_scale * h->impulse.x,
                       -scale * (k11 * e.y - k12 * e.x) - soft.impulse_scale * h->impulse.y};
    if (slides)
        impulse = held(h, impulse, h->most * dt);
    h->impulse = ll_add(h->impulse, impulse);
    apply_revolute_impulse(h, a, b, ra, rb, impulse);
    return impulse.x != 0 || impulse.y != 0;
}

/* ---- passes ---- */

void ll_warm_start_joints(ll_rigid *w, const ll_joint_set *set)
{
    ll_solver_body *states = ll_solver_bodies(w);
    for (int32_t i = 0; i < set->revolute_count; i++) {
        const ll_revolute_sim *h = &set->revolutes[i];
        ll_solver_body *a = &states[h->a], *b = &states[h->b];
        apply_revolute_impulse(h, a, b, ll_rotate(a->q, h->ra), ll_rotate(b->q, h->rb), h->impulse);
        if (h->revolute_limits == LL_NONE)
            continue;
        const ll_revolute_limits *t = &set->revolute_limits[h->revolute_limits];
        turn(h, a, b, t->lower_impulse - t->upper_impulse + t->motor_impulse);
    }
    for (int32_t i = 0; i < set->other_count; i++) {
        const ll_joint *j = &ll_joints(w)[set->others[i]];
        ll_constraint_row rows[LL_ROWS];
        rows_of(w, j, rows);
        pair p = pair_of(w, j);
        for (int k = 0; k < LL_ROWS; k++)
            if (rows[k].kind != LL_ROW_NONE)
                apply_row_impulse(&p, &rows[k], j->impulse[k]);
    }
}

void ll_clear_joint_impulses(ll_rigid *w)
{
    for (int32_t i = 0; i < w->joint_end; i++)
        memset(ll_joints(w)[i].impulse, 0, sizeof ll_joints(w)[i].impulse);
}

/* How this pass solves a row. A spring is soft in every pass. */
static ll_softness row_softness(const ll_constraint_row *row, double h, ll_softness stiff, bool bias)
{
    if (row->kind == LL_ROW_MOTOR)
        return (ll_softness){0, 1, 0};
    if (row->hertz > 0)
        return ll_soft(row->hertz, row->damping, h);
    if (row->kind == LL_ROW_LIMIT && row->c > 0)
        return (ll_softness){1 / h, 1, 0};
    return bias ? stiff : (ll_softness){0, 1, 0};
}

static bool solve_row(const pair *p, const ll_constraint_row *row, double h, ll_softness soft, double *total)
{
    double k = row_cross(p, row, row);
    if (k <= 0)
        return false;
    double speed = row_speed(p, row) - (row->kind == LL_ROW_MOTOR ? row->speed : 0);
    double sum =
        *total - soft.mass_scale / k * (speed + soft.bias_rate * row->c) - soft.impulse_scale * *total;
    double most = row->most * h;
    sum = ll_min(sum, most);
    sum = ll_max(sum, row->kind == LL_ROW_LIMIT ? 0 : -most);
    double impulse = sum - *total;
    apply_row_impulse(p, row, impulse);
    *total = sum;
    return impulse != 0;
}

/* Two rows at once: a loaded joint does not yield in one direction while the other is solved. */
static bool solve_block(const pair *p, const ll_constraint_row *rows, ll_softness soft, double total[2])
{
    double k11 = row_cross(p, &rows[0], &rows[0]), k12 = row_cross(p, &rows[0], &rows[1]);
    double k22 = row_cross(p, &rows[1], &rows[1]), det = k11 * k22 - k12 * k12;
    if (det <= 0)
        return false;
    double e0 = row_speed(p, &rows[0]) + soft.bias_rate * rows[0].c;
    double e1 = row_speed(p, &rows[1]) + soft.bias_rate * rows[1].c;
    double impulse[2] = {-soft.mass_scale * (k22 * e0 - k12 * e1) / det - soft.impulse_scale * total[0],
                         -soft.mass_scale * (k11 * e1 - k12 * e0) / det - soft.impulse_scale * total[1]};
    for (int i = 0; i < 2; i++) {
        total[i] += impulse[i];
        apply_row_impulse(p, &rows[i], impulse[i]);
    }
    return impulse[0] != 0 || impulse[1] != 0;
}

bool ll_solve_joints(ll_rigid *w, const ll_joint_set *set, double h, ll_softness stiff, bool bias)
{
    ll_softness soft = bias ? stiff : (ll_softness){0, 1, 0};
    bool changed = false;
    for (int32_t i = 0; i < set->revolute_count; i++) {
        ll_revolute_sim *revolute = &set->revolutes[i];
        if (revolute->revolute_limits != LL_NONE)
            changed |= solve_revolute_limits(ll_solver_bodies(w), revolute,
                                             &set->revolute_limits[revolute->revolute_limits], h, soft);
        changed |= solve_revolute(ll_solver_bodies(w), revolute, h, soft);
    }
    for (int32_t i = 0; i < set->other_count; i++) {
        ll_joint *j = &ll_joints(w)[set->others[i]];
        ll_constraint_row rows[LL_ROWS];
        pair p = pair_of(w, j);
        rows_of(w, j, rows);
        bool block = ll_joint_row_types[j->def.type].block;
        for (int k = LL_ROWS; k-- > (block ? 2 : 0);)
            if (rows[k].kind != LL_ROW_NONE)
                changed |= solve_row(&p, &rows[k], h, row_softness(&rows[k], h, stiff, bias), &j->impulse[k]);
        if (block)
            changed |= solve_block(&p, rows, row_softness(&rows[0], h, stiff, bias), j->impulse);
    }
    return changed;
}
