/* Interpolation between snapshots, rules for its delay, and how render time follows its target. */
#include "netcode/view/view.h"

#define NAME(name) #name,

/* ---- between two snapshots ---- */

/* Linear: the paper's formula ("Interpolation"). Between snapshots dt apart the error is at most a dt^2 / 8
 * where the acceleration is at most a, and speed jumps at every snapshot. Cost: six multiplications per
 * entity. */
static void linear(const ll_entity *a, const ll_entity *b, double alpha, double span_s, ll_entity *out)
{
    (void)span_s;
    out->x = a->x + alpha * (b->x - a->x);
    out->y = a->y + alpha * (b->y - a->y);
    out->vx = a->vx + alpha * (b->vx - a->vx);
    out->vy = a->vy + alpha * (b->vy - a->vy);
    out->angle = a->angle + alpha * (b->angle - a->angle);
    out->angular_velocity = a->angular_velocity + alpha * (b->angular_velocity - a->angular_velocity);
}

static void all_linear(const ll_stretch *stretch)
{
    ll_interpolate_all(stretch, linear);
}

/* Hermite: the cubic with the positions and the velocities of both snapshots (Fiedler, "Snapshot
 * Interpolation"). It is exact for motion under constant acceleration and for any cubic; otherwise the error
 * is at most j' dt^4 / 384 where the fourth derivative is at most j'. Speed is continuous at a snapshot. It
 * depends on the velocities: where one is not that of the path, as across a contact, it overshoots. Cost:
 * about 20 multiplications per coordinate. */

/* Position and velocity of one coordinate; `s`: fraction of the way, `t`: its length in seconds. */
static void cubic(double p, double v, double q, double w, double s, double t, double *place, double *speed)
{
    double c2 = 3 * (q - p) - t * (2 * v + w), c3 = t * (v + w) - 2 * (q - p);
    *place = p + s * (t * v + s * (c2 + s * c3));
    *speed = v + s * (2 * c2 + s * 3 * c3) / t;
}

static void hermite(const ll_entity *a, const ll_entity *b, double alpha, double span_s, ll_entity *out)
{
    cubic(a->x, a->vx, b->x, b->vx, alpha, span_s, &out->x, &out->vx);
    cubic(a->y, a->vy, b->y, b->vy, alpha, span_s, &out->y, &out->vy);
    cubic(a->angle, a->angular_velocity, b->angle, b->angular_velocity, alpha, span_s, &out->angle,
          &out->angular_velocity);
}

static void all_hermite(const ll_stretch *stretch)
{
    ll_interpolate_all(stretch, hermite);
}

const ll_interpolation ll_interpolation_linear = {.settles = true, .between = linear, .all = all_linear};
const ll_interpolation ll_interpolation_hermite = {.between = hermite, .all = all_hermite};

#define INTERPOLATIONS(X) X(linear) X(hermite)
#define INTERPOLATION(name) &ll_interpolation_##name,

const ll_interpolation *const ll_interpolations[] = {INTERPOLATIONS(INTERPOLATION) NULL};
const char *const ll_interpolation_names[] = {INTERPOLATIONS(NAME) NULL};

/* ---- the delay ---- */

static ll_time interval(const ll_client *c)
{
    return (ll_time)(1e9 / c->latest.update_hz);
}

static ll_time ratio(const ll_client *c, const ll_player_config *config)
{
    return (ll_time)(config->interpolation_ratio / c->latest.update_hz * 1e9) +
           ll_ms(config->jitter_margin_ms);
}

#define INTERVALS_MAX 6
#define STEPS_PER_FRAME 10 /* largest change, as a part of a frame */

/* After Netcode for Entities: average gap between snapshots + 1.25 x its mean deviation, at most six
 * intervals, changed by at most a tenth of a frame per frame. Chosen over Mirror's rule (1 + a tolerance of 1
 * + deviation / interval, in intervals), which is never below two intervals, even on a perfect link. There,
 * gaps are of send times, which show only loss, and time counts from the average snapshot. Here they are of
 * arrivals, which also show jitter, and time counts from the fastest snapshot, so the average lateness
 * relative to it is added. */
static ll_time adaptive(const ll_client *c, const ll_player_config *config)
{
    ll_time want = (ll_time)(c->arrivals.gap + 1.25 * c->arrivals.gap_deviation + c->arrivals.late),
            most = INTERVALS_MAX * interval(c), step = c->displays.elapsed / STEPS_PER_FRAME;
    want = (want < most ? want : most) + ll_ms(config->jitter_margin_ms);
    if (!c->view.has_render)
        return ratio(c, config); /* no gap is known yet */
    return want > c->view.delay + step   ? c->view.delay + step
           : want < c->view.delay - step ? c->view.delay - step
                                         : want;
}

#define DELAYS(X) X(ratio) X(adaptive)
#define DELAY(name) &(const ll_interpolation_delay){name},

const ll_interpolation_delay *const ll_interpolation_delays[] = {DELAYS(DELAY) NULL};
const char *const ll_interpolation_delay_names[] = {DELAYS(NAME) NULL};

/* ---- render time ---- */

/* Faster or slower by what the error needs, at most a tenth. */
static ll_time proportional(ll_client *c, ll_time error)
{
    ll_time most = c->displays.elapsed / 10;
    return error > most ? most : error < -most ? -most : error;
}

static ll_time proportional_limit(const ll_client *c)
{
    (void)c;
    return 250 * LL_MS;
}

#define DRIFT_S 1.0 /* over which the error is averaged */

/* Mirror's rule: real time while the averaged error is within one update interval, otherwise 2 % faster or 4
 * % slower; slower by more, so that the buffer does not run empty. */
static ll_time catch_up(ll_client *c, ll_time error)
{
    double share = ll_to_s(c->displays.elapsed) / DRIFT_S, interval = 1e9 / c->latest.update_hz;
    c->view.drift += ((double)error - c->view.drift) * (share < 1 ? share : 1);
    double extra = c->view.drift > interval ? 0.02 : c->view.drift < -interval ? -0.04 : 0;
    return (ll_time)(extra * (double)c->displays.elapsed);
}

static ll_time catch_up_limit(const ll_client *c)
{
    ll_time interval = (ll_time)(1e9 / c->latest.update_hz);
    return c->view.delay > interval ? c->view.delay : interval;
}

#define SCALES(X) X(proportional) X(catch_up)
#define SCALE(name) &(const ll_time_scale){name, name##_limit},

const ll_time_scale *const ll_time_scales[] = {SCALES(SCALE) NULL};
const char *const ll_time_scale_names[] = {SCALES(NAME) NULL};
