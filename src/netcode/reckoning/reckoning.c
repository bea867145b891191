#include "netcode/reckoning/reckoning.h"

#include <string.h>

#include "base/detmath.h"

#define DEGREE 0.017453292519943295 /* rad */

/* ---- models ---- */

/* Static: an entity stays where it was sent. Every motion is sent, in steps of the threshold. */
static void at_static(const ll_reckoned *sent, double s, ll_entity *out)
{
    (void)s;
    *out = sent->entity;
    out->vx = out->vy = out->angular_velocity = 0;
}

/* Velocity (DIS: FPW): an entity goes on at its velocity, without turning. */
static void at_velocity(const ll_reckoned *sent, double s, ll_entity *out)
{
    *out = sent->entity;
    out->x += sent->entity.vx * s;
    out->y += sent->entity.vy * s;
    out->angular_velocity = 0;
}

/* Velocity and spin (DIS: RPW): an entity goes on at its velocity and angular velocity. */
static void at_spin(const ll_reckoned *sent, double s, ll_entity *out)
{
    *out = sent->entity;
    out->x += sent->entity.vx * s;
    out->y += sent->entity.vy * s;
    out->angle += sent->entity.angular_velocity * s;
}

/* Acceleration (DIS: RVW): as velocity and spin, with the acceleration that the entity had when it was sent.
 * The server takes it from the velocities of two updates. It is sent too, and it errs where forces change. */
static void at_acceleration(const ll_reckoned *sent, double s, ll_entity *out)
{
    *out = sent->entity;
    out->x += (sent->entity.vx + sent->ax * s / 2) * s;
    out->y += (sent->entity.vy + sent->ay * s / 2) * s;
    out->vx += sent->ax * s;
    out->vy += sent->ay * s;
    out->angle += sent->entity.angular_velocity * s;
}

#define MODELS(X)                                                                                            \
    X(static, .at = at_static)                                                                               \
    X(velocity, .at = at_velocity)                                                                           \
    X(velocity_spin, .at = at_spin)                                                                          \
    X(acceleration, .at = at_acceleration, .accelerates = true)

#define MODEL(name, ...) &(const ll_reckoning_model){__VA_ARGS__},
#define NAME(name, ...) #name,

const ll_reckoning_model *const ll_reckoning_models[] = {NULL, MODELS(MODEL) NULL};
const char *const ll_reckoning_names[] = {"none", MODELS(NAME) NULL};

/* ---- convergence ---- */

/* Snap: the new model at once. */
static double left_by_snap(double e, double u, double tau, double t, double *rate)
{
    (void)e, (void)u, (void)tau, (void)t;
    *rate = 0;
    return 0;
}

/* Linear: the deviation shrinks evenly. The drawn speed is at most that of the model + deviation / tau, and
 * jumps at both ends. */
static double left_by_linear(double e, double u, double tau, double t, double *rate)
{
    (void)u;
    *rate = -e / tau;
    return e * (1 - t / tau);
}

/* Cubic: a cubic of the deviation that begins with its value and rate and ends with neither: the drawn
 * velocity has no jump. It may swing out further than the deviation where the rate is large. */
static double left_by_cubic(double e, double u, double tau, double t, double *rate)
{
    double s = t / tau, r = 1 - s;
    *rate = e * 6 * s * (s - 1) / tau + u * r * (1 - 3 * s);
    return e * r * r * (1 + 2 * s) + u * tau * s * r * r;
}

/* Projective velocity blending (Murphy, "Believable Dead Reckoning for Networked Games", Game Engine Gems 2,
 * 2011): the drawn entity goes on at a velocity that is blended from its old to the new one, and its place is
 * blended with the model's. In terms of the deviation: (1 - s) (e + (1 - s) u t), s = t / tau. */
static double left_by_projective(double e, double u, double tau, double t, double *rate)
{
    double s = t / tau, r = 1 - s;
    *rate = -e / tau + u * r * (1 - 3 * s);
    return r * (e + r * u * t);
}

#define CONVERGENCES(X)                                                                                      \
    X(snap, left_by_snap) X(linear, left_by_linear) X(cubic, left_by_cubic) X(projective, left_by_projective)
#define CONVERGENCE(name, left) &(const ll_convergence){left},

const ll_convergence *const ll_convergences[] = {CONVERGENCES(CONVERGENCE) NULL};
const char *const ll_convergence_names[] = {CONVERGENCES(NAME) NULL};

/* ---- places ---- */

static size_t player_size(int entities)
{
    return sizeof(ll_reckoning_counts) + (size_t)entities * (2 * sizeof(ll_reckoned) + sizeof(ll_deviation));
}

size_t ll_reckoning_size(int players, int entities)
{
    return sizeof(ll_reckoning) + (size_t)entities * sizeof(ll_reckoned) +
           (size_t)players * player_size(entities);
}

static ll_reckoned *motion_of(const ll_reckoning *r)
{
    return (ll_reckoned *)(r + 1);
}

static ll_reckoning_counts *counts_of(const ll_reckoning *r, int player)
{
    return (ll_reckoning_counts *)((char *)(motion_of(r) + r->entities) +
                                   (size_t)player * player_size(r->entities));
}

static ll_reckoned *sent_of(const ll_reckoning *r, int player)
{
    return (ll_reckoned *)(counts_of(r, player) + 1);
}

static ll_reckoned *received_of(const ll_reckoning *r, int player)
{
    return sent_of(r, player) + r->entities;
}

static ll_deviation *deviations_of(const ll_reckoning *r, int player)
{
    return (ll_deviation *)(received_of(r, player) + r->entities);
}

const ll_reckoning_counts *ll_reckoning_counted(const ll_reckoning *r, int player)
{
    return counts_of(r, player);
}

void ll_reckoning_init(ll_reckoning *r, const ll_reckoning_params *params, int players, int entities,
                       ll_time from)
{
    memset(r, 0, ll_reckoning_size(players, entities));
    *r = (ll_reckoning){
        .params = *params, .from = from, .moved = -1, .players = players, .entities = entities};
    for (int p = 0; p < players; p++) {
        ll_histogram_init(&counts_of(r, p)->model_error, 0.001);
        for (int i = 0; i < entities; i++)
            sent_of(r, p)[i].time = received_of(r, p)[i].time = -1;
    }
}

int64_t ll_reckoning_extra_bits(int entities)
{
    return (int64_t)entities * (1 + 7 + 2 * 64);
}

/* ---- the sender ---- */

static const ll_reckoning_model *model_of(const ll_reckoning *r)
{
    return ll_reckoning_models[r->params.model];
}

/* Once for each update: accelerations, by the velocities of two updates. */
static void follow_motion(ll_reckoning *r, const ll_world *world, ll_time now)
{
    ll_reckoned *motion = motion_of(r);
    double s = ll_to_s(now - r->moved);
    if (r->moved == now)
        return;
    for (int i = 0; i < r->entities; i++) {
        const ll_entity *e = &world->entity[i], *before = &motion[i].entity;
        bool known = r->moved >= 0 && model_of(r)->accelerates;
        motion[i].ax = known ? (e->vx - before->vx) / s : 0;
        motion[i].ay = known ? (e->vy - before->vy) / s : 0;
        motion[i].entity = *e;
        motion[i].time = now;
    }
    r->moved = now;
}

/* Decides whether an entity is sent, and counts why. */
static bool is_due(const ll_reckoning *r, ll_reckoning_counts *counts, const ll_reckoned *sent,
                   const ll_entity *e, ll_time now)
{
    const ll_reckoning_params *p = &r->params;
    bool counted = now >= r->from;
    ll_entity model;
    if (sent->time < 0 || sent->entity.flags != e->flags) {
        counts->first += counted;
        return true;
    }
    model_of(r)->at(sent, ll_to_s(now - sent->time), &model);
    double dx = e->x - model.x, dy = e->y - model.y, off = ll_sqrt(dx * dx + dy * dy);
    bool far = off > p->threshold_m || ll_abs(e->angle - model.angle) > p->threshold_deg * DEGREE;
    bool old = p->heartbeat_s > 0 && ll_to_s(now - sent->time) >= p->heartbeat_s;
    if (counted) {
        ll_histogram_add(&counts->model_error, off);
        counts->by_threshold += far;
        counts->by_heartbeat += old && !far;
        counts->suppressed += !far && !old;
    }
    return far || old;
}

static void put_double(ll_bit_writer *w, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    ll_bits_put(w, bits, 64);
}

static double get_double(ll_bit_reader *r)
{
    uint64_t bits = ll_bits_get(r, 64);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void put_state(ll_bit_writer *w, const ll_reckoned *state, bool accelerates)
{
    ll_put_exact(w, &state->entity);
    if (accelerates) {
        put_double(w, state->ax);
        put_double(w, state->ay);
    }
}

void ll_reckoning_encode(ll_reckoning *r, int player, const ll_world *world, ll_time now, bool whole,
                         ll_bit_writer *w, ll_snapshot_cost *cost)
{
    ll_reckoned *sent = sent_of(r, player);
    int64_t start = w->count;
    follow_motion(r, world, now);
    ll_put_exact(w, &world->entity[player]);
    for (int i = 0; i < r->entities; i++) {
        if (i == player)
            continue;
        if (whole)
            sent[i].time = -1;
        bool due = is_due(r, counts_of(r, player), &sent[i], &world->entity[i], now);
        ll_bits_put(w, due, 1);
        cost->unchanged += !due;
        if (!due)
            continue;
        sent[i] = motion_of(r)[i];
        put_state(w, &sent[i], model_of(r)->accelerates);
    }
    cost->entities += r->entities;
    cost->entity_bits += w->count - start;
    start = w->count;
    ll_put_tail(w, world);
    cost->tail_bits += w->count - start;
}

/* ---- a receiver ---- */

/* The drawn state and its velocities: the model, and what is left of the deviation. */
static void draw(const ll_reckoning *r, const ll_reckoned *base, const ll_deviation *d, ll_time now,
                 ll_entity *out)
{
    const ll_convergence *convergence = ll_convergences[r->params.convergence];
    double tau = r->params.tau_s, t = ll_to_s(now - d->since), rate;
    model_of(r)->at(base, ll_to_s(now - base->time), out);
    if (t < 0 || t >= tau)
        return;
    out->x += convergence->left(d->x, d->vx, tau, t, &rate);
    out->vx += rate;
    out->y += convergence->left(d->y, d->vy, tau, t, &rate);
    out->vy += rate;
    out->angle += convergence->left(d->angle, d->angular_velocity, tau, t, &rate);
    out->angular_velocity += rate;
}

/* A new state: the deviation begins as what was drawn less the new model. */
static void replace(const ll_reckoning *r, ll_reckoned *base, ll_deviation *d, const ll_reckoned *next,
                    ll_time now)
{
    ll_entity drawn, model;
    bool same = base->time >= 0 && base->entity.flags == next->entity.flags;
    if (same) {
        draw(r, base, d, now, &drawn);
        model_of(r)->at(next, ll_to_s(now - next->time), &model);
    }
    *base = *next;
    *d = (ll_deviation){.since = now};
    if (!same)
        return; /* nothing was drawn, or another object */
    d->x = drawn.x - model.x;
    d->y = drawn.y - model.y;
    d->angle = drawn.angle - model.angle;
    d->vx = drawn.vx - model.vx;
    d->vy = drawn.vy - model.vy;
    d->angular_velocity = drawn.angular_velocity - model.angular_velocity;
}

ll_status ll_reckoning_decode(ll_reckoning *r, int player, ll_bit_reader *bits, ll_world *world, ll_time time,
                              ll_time now)
{
    ll_reckoned next[LL_ENTITIES_MAX], *received = received_of(r, player);
    ll_get_exact(bits, &world->entity[player]);
    for (int i = 0; i < r->entities; i++) {
        if (i == player)
            continue;
        next[i].time = -1;
        if (ll_bits_get(bits, 1)) {
            next[i] = (ll_reckoned){.time = time};
            ll_get_exact(bits, &next[i].entity);
            if (model_of(r)->accelerates) {
                next[i].ax = get_double(bits);
                next[i].ay = get_double(bits);
            }
        } else if (received[i].time < 0) {
            return ll_error(LL_NOT_FOUND, "no state of entity %d has come yet", i);
        }
        const ll_reckoned *base = next[i].time >= 0 ? &next[i] : &received[i];
        model_of(r)->at(base, ll_to_s(time - base->time), &world->entity[i]);
        if (!(base->ax - base->ax == 0 && base->ay - base->ay == 0))
            return ll_error(LL_BAD_INPUT, "the acceleration of entity %d is not finite", i);
    }
    ll_get_tail(bits, world);
    LL_TRY(ll_decoded(bits, world));
    for (int i = 0; i < r->entities; i++)
        if (i != player && next[i].time >= 0)
            replace(r, &received[i], &deviations_of(r, player)[i], &next[i], now);
    return ll_ok();
}

void ll_reckoning_draw(const ll_reckoning *r, int player, ll_time now, ll_world *shown)
{
    const ll_reckoned *received = received_of(r, player);
    for (int i = 0; i < r->entities; i++)
        if (i != player && received[i].time >= 0)
            draw(r, &received[i], &deviations_of(r, player)[i], now, &shown->entity[i]);
}
