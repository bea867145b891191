/* Dead reckoning against closed forms, and against a naive second implementation on random motion. One
 * entity, number 1, is reckoned by the client of player 0. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "netcode/reckoning/reckoning.h"
#include "support/near.h"

typedef struct pair {
    ll_reckoning *sender, *receiver; /* of their own: they share nothing but messages */
    ll_world *world, *seen;
} pair;

static pair open_pair(ll_reckoning_params params)
{
    size_t size = ll_reckoning_size(1, 2), world = sizeof(ll_world) + 2 * sizeof(ll_entity);
    pair p = {calloc(1, size), calloc(1, size), calloc(1, world), calloc(1, world)};
    ll_reckoning_init(p.sender, &params, 1, 2, 0);
    ll_reckoning_init(p.receiver, &params, 1, 2, 0);
    p.world->players = 1;
    p.world->entities = 2;
    *p.seen = *p.world;
    return p;
}

static void close_pair(pair *p)
{
    free(p->sender);
    free(p->receiver);
    free(p->world);
    free(p->seen);
}

typedef struct message {
    uint8_t bytes[256];
    int64_t bits;
    ll_time time;
    bool updates; /* it has entity 1 */
} message;

static int64_t updates_of(const pair *p)
{
    const ll_reckoning_counts *c = ll_reckoning_counted(p->sender, 0);
    return c->first + c->by_threshold + c->by_heartbeat;
}

static message send(pair *p, ll_time now, bool whole)
{
    message m = {.time = now};
    ll_snapshot_cost cost = {0};
    int64_t before = updates_of(p);
    ll_bit_writer w = {.bytes = m.bytes, .capacity = 8 * (int64_t)sizeof m.bytes};
    ll_reckoning_encode(p->sender, 0, p->world, now, whole, &w, &cost);
    assert_true(w.count <= w.capacity);
    assert_true(w.count <= 8 * (int64_t)(2 * sizeof(ll_entity)) + ll_reckoning_extra_bits(2));
    m.bits = w.count;
    m.updates = updates_of(p) > before;
    return m;
}

static void arrive(pair *p, const message *m, ll_time now)
{
    ll_bit_reader r = {.bytes = m->bytes, .size = (m->bits + 7) / 8 * 8};
    ll_status status = ll_reckoning_decode(p->receiver, 0, &r, p->seen, m->time, now);
    assert_string_equal(status.text, "");
}

static ll_entity drawn(pair *p, ll_time now)
{
    ll_reckoning_draw(p->receiver, 0, now, p->seen);
    return p->seen->entity[1];
}

static int model_index(const char *name)
{
    int i = 0;
    while (strcmp(ll_reckoning_names[i], name) != 0)
        i++;
    return i;
}

typedef ll_entity motion(double t);

/* Steps of 1 ms for `seconds`; messages take `delay_ms`. Of the time after the first second: the worst error,
 * the fastest that is drawn, and the mean time between two updates. */
typedef struct result {
    double worst_m, fastest_mps, interval_s, largest_jump_m, largest_kick_mps;
    int64_t updates, heartbeats;
} result;

static result watch(motion *of, ll_reckoning_params params, int delay_ms, int seconds)
{
    enum { LATEST = 512 };
    pair p = open_pair(params);
    static message queue[LATEST];
    result all = {0};
    ll_time first = -1, last = -1;
    ll_entity before = {0}, velocity = {0};
    for (int ms = 0; ms <= 1000 * seconds; ms++) {
        ll_time now = ms * LL_MS;
        p.world->entity[1] = of(ms / 1000.0);
        queue[ms % LATEST] = send(&p, now, ms == 0);
        if (queue[ms % LATEST].updates && ms > 0) {
            all.updates++;
            first = first < 0 ? now : first;
            last = now;
        }
        if (ms < delay_ms)
            continue;
        arrive(&p, &queue[(ms - delay_ms) % LATEST], now);
        ll_entity e = drawn(&p, now), truth = of(ms / 1000.0);
        if (ms > 1000) {
            double jump = hypot(e.x - before.x, e.y - before.y), vx = (e.x - before.x) * 1000,
                   vy = (e.y - before.y) * 1000;
            all.worst_m = larger(all.worst_m, hypot(e.x - truth.x, e.y - truth.y));
            all.largest_jump_m = larger(all.largest_jump_m, jump);
            all.fastest_mps = larger(all.fastest_mps, jump * 1000);
            if (ms > 1002)
                all.largest_kick_mps =
                    larger(all.largest_kick_mps, hypot(vx - velocity.vx, vy - velocity.vy));
            velocity.vx = vx;
            velocity.vy = vy;
        }
        before = e;
    }
    all.heartbeats = ll_reckoning_counted(p.sender, 0)->by_heartbeat;
    all.interval_s = all.updates > 1 ? ll_to_s(last - first) / (double)(all.updates - 1) : 0;
    close_pair(&p);
    return all;
}

static ll_reckoning_params by(const char *model, double threshold_m, int convergence)
{
    return (ll_reckoning_params){.threshold_m = threshold_m,
                                 .threshold_deg = 3,
                                 .heartbeat_s = 5,
                                 .tau_s = 0.3,
                                 .model = model_index(model),
                                 .convergence = convergence};
}

enum { SNAP, LINEAR, CUBIC, PROJECTIVE };

/* ---- closed forms ---- */

static double acceleration; /* of `accelerating` */

static ll_entity accelerating(double t)
{
    return (ll_entity){.x = acceleration * t * t / 2, .vx = acceleration * t};
}

/* Constant acceleration a, by velocity: sent every t = sqrt(2 th / a), and when the next state arrives after
 * d the receiver is off by a (t + d)^2 / 2 = th (1 + d / t)^2. */
static void constant_acceleration_is_sent_at_its_period(void **state)
{
    (void)state;
    static const struct {
        double threshold, a;
        int delay_ms;
    } cases[] = {{1, 2, 100}, {1, 2, 0}, {1, 2, 400}, {0.5, 4, 100}, {2, 1, 250}, {0.1, 5, 50}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        acceleration = cases[i].a;
        double t = sqrt(2 * cases[i].threshold / cases[i].a), d = cases[i].delay_ms / 1000.0;
        double worst = cases[i].threshold * (1 + d / t) * (1 + d / t);
        result r = watch(accelerating, by("velocity", cases[i].threshold, SNAP), cases[i].delay_ms, 20);
        /* a step of 1 ms late at most */
        assert_true(r.interval_s >= t - 1e-9 && r.interval_s <= t + 0.001);
        assert_true(r.worst_m <= cases[i].a * (t + d + 0.001) * (t + d + 0.001) / 2 + 1e-9);
        assert_true(r.worst_m > worst - cases[i].a * (t + d) * 0.001);
        if (i == 0)
            assert_near(r.worst_m, 1.21, 0.005);
        assert_int_equal(r.heartbeats, 0);
    }
}

static void the_model_of_the_motion_sends_heartbeats_only(void **state)
{
    (void)state;
    acceleration = 0.7;
    result r = watch(accelerating, by("acceleration", 0.01, SNAP), 100, 41);
    assert_int_equal(r.heartbeats, 8);
    assert_in_range(r.updates, 8, 9); /* the first state is sent before an acceleration is known */
}

static ll_entity circling(double t)
{
    const double v = 10, r = 20, w = v / r;
    return (ll_entity){.x = r * cos(w * t),
                       .y = r * sin(w * t),
                       .vx = -v * sin(w * t),
                       .vy = v * cos(w * t),
                       .angle = w * t,
                       .angular_velocity = w};
}

/* On a circle a tangent of length v t is off by sqrt(r^2 + (v t)^2 + ...): 1 m after 0.633 s, at 10 m/s and
 * 20 m. Without spin the angle is 3 degrees off long before. */
static void a_circle_is_sent_at_its_period(void **state)
{
    (void)state;
    double t = 0;
    for (double step = 0.1; step > 1e-7; step /= 10)
        for (;; t += step) {
            double x = 20 - 20 * cos(0.5 * (t + step)), y = 10 * (t + step) - 20 * sin(0.5 * (t + step));
            if (x * x + y * y > 1)
                break;
        }
    assert_near(t, 0.633, 0.001);
    result spin = watch(circling, by("velocity_spin", 1, SNAP), 50, 30);
    result velocity = watch(circling, by("velocity", 1, SNAP), 50, 30);
    double turned = 3 * M_PI / 180 / 0.5;
    assert_true(spin.interval_s >= t && spin.interval_s <= t + 0.001);
    assert_true(velocity.interval_s >= turned && velocity.interval_s <= turned + 0.001);
}

static ll_entity straight(double t)
{
    return (ll_entity){.x = 12 * t, .y = -5 * t, .vx = 12, .vy = -5};
}

static void a_straight_line_sends_heartbeats_only(void **state)
{
    (void)state;
    static const char *const models[] = {"velocity", "velocity_spin", "acceleration"};
    for (int i = 0; i < 3; i++) {
        result r = watch(straight, by(models[i], 1, LINEAR), 200, 31);
        assert_int_equal(r.updates, 6);
        assert_int_equal(r.heartbeats, 6);
        assert_true(r.worst_m < 1e-9);
        assert_near(r.fastest_mps, 13, 1e-6);
    }
    ll_reckoning_params never = by("velocity", 1, LINEAR);
    never.heartbeat_s = 0;
    assert_int_equal(watch(straight, never, 200, 31).updates, 0);
    result still = watch(straight, by("static", 1, SNAP), 0, 20);
    assert_near(still.interval_s, 1 / 13.0, 0.002);
}

/* ---- convergence ---- */

/* The drawn speed is at most that of the model + error / tau (linear). The error when a state arrives is that
 * of the receiver at its worst; the model is as fast as the entity at its end. */
static void linear_convergence_bounds_the_drawn_speed(void **state)
{
    (void)state;
    acceleration = 2;
    for (int tau = 1; tau <= 4; tau++) {
        ll_reckoning_params p = by("velocity", 1, LINEAR);
        p.tau_s = 0.2 * tau;
        result r = watch(accelerating, p, 100, 10);
        double fastest = 2 * 10;
        assert_true(r.fastest_mps <= fastest + r.worst_m / p.tau_s + 1e-6);
    }
}

/* Every convergence begins at the deviation and ends without it; cubic and projective begin with its rate,
 * and end without one. The rate is the derivative. */
static void convergences_end_where_they_should(void **state)
{
    (void)state;
    const double e = 0.8, u = -1.7, tau = 0.4, h = 1e-6;
    for (int i = 0; ll_convergences[i]; i++) {
        const ll_convergence *c = ll_convergences[i];
        double rate, ignored;
        double begin = c->left(e, u, tau, 0, &rate);
        assert_near(begin, (i == SNAP ? 0 : e), 1e-12);
        assert_true(i < CUBIC || fabs(rate - (i == CUBIC ? u : u - e / tau)) < 1e-12);
        assert_near(c->left(e, u, tau, tau, &rate), 0, 1e-12);
        assert_true(i != CUBIC || fabs(rate) < 1e-12);
        for (double t = 0.05; t < tau; t += 0.05) {
            c->left(e, u, tau, t, &rate);
            double slope =
                (c->left(e, u, tau, t + h, &ignored) - c->left(e, u, tau, t - h, &ignored)) / (2 * h);
            assert_near(slope, rate, 1e-6);
        }
    }
}

/* Only snap jumps; of the others cubic alone has no kick of the velocity. */
static void only_snap_jumps_and_cubic_does_not_kick(void **state)
{
    (void)state;
    result r[4];
    for (int i = 0; i < 4; i++)
        r[i] = watch(circling, by("velocity_spin", 1, i), 150, 20);
    assert_true(r[SNAP].largest_jump_m > 1);
    for (int i = LINEAR; i <= PROJECTIVE; i++)
        assert_true(r[i].largest_jump_m < 0.03 && r[i].updates == r[SNAP].updates);
    assert_true(r[LINEAR].largest_kick_mps > 3);
    assert_true(r[CUBIC].largest_kick_mps < 0.2);
}

/* ---- time stamps, loss, rubbish ---- */

/* The model goes on from the sender's time stamp: a message that was late changes nothing after its arrival.
 */
static void jitter_leaves_no_trace(void **state)
{
    (void)state;
    pair on_time = open_pair(by("velocity_spin", 1, SNAP)), late = open_pair(by("velocity_spin", 1, SNAP));
    for (int ms = 0; ms <= 3000; ms += 50) {
        on_time.world->entity[1] = late.world->entity[1] = circling(ms / 1000.0);
        message m = send(&on_time, ms * LL_MS, ms == 0), n = send(&late, ms * LL_MS, ms == 0);
        ll_time end = (ms + 49) * LL_MS;
        arrive(&on_time, &m, ms * LL_MS + LL_MS);
        arrive(&late, &n, ms * LL_MS + (1 + ms * 37 % 45) * LL_MS);
        ll_entity a = drawn(&on_time, end), b = drawn(&late, end);
        assert_memory_equal(&a, &b, sizeof a);
    }
    close_pair(&on_time);
    close_pair(&late);
}

/* A lost state is made up for by the next, at the latest by the heartbeat. */
static void a_heartbeat_makes_up_for_a_loss(void **state)
{
    (void)state;
    ll_reckoning_params params = by("velocity", 1, SNAP);
    params.heartbeat_s = 2;
    pair p = open_pair(params);
    double right_since = -1;
    for (int ms = 0; ms < 6000; ms += 20) {
        double t = ms / 1000.0, turn = t < 1 ? t : 1; /* it stops at 1 s */
        p.world->entity[1] = (ll_entity){.x = 10 * turn, .vx = t < 1 ? 10 : 0};
        message m = send(&p, ms * LL_MS, ms == 0);
        if (m.updates && t >= 1 && t < 2)
            continue; /* lost */
        arrive(&p, &m, ms * LL_MS);
        bool right = fabs(drawn(&p, ms * LL_MS).x - 10 * turn) < 1e-9;
        right_since = !right ? -1 : right_since < 0 ? t : right_since;
    }
    assert_true(right_since > 3 && right_since < 3.2); /* 1.12 s, when it was sent in vain, + 2 s */
    close_pair(&p);
}

static void what_cannot_be_decoded_changes_nothing(void **state)
{
    (void)state;
    pair p = open_pair(by("acceleration", 1, LINEAR));
    p.world->entity[1] = circling(1);
    message first = send(&p, LL_SECOND, true), second = send(&p, LL_SECOND + LL_MS, false);
    ll_bit_reader r = {.bytes = second.bytes, .size = (second.bits + 7) / 8 * 8};
    ll_status status = ll_reckoning_decode(p.receiver, 0, &r, p.seen, second.time, second.time);
    assert_int_equal(status.code, LL_NOT_FOUND); /* nothing has come yet */
    arrive(&p, &first, LL_SECOND);
    size_t size = ll_reckoning_size(1, 2);
    void *before = malloc(size);
    memcpy(before, p.receiver, size);
    for (int i = 0; i < 2000; i++) {
        message m = {.bits = 8 * (1 + i % 150), .time = 2 * LL_SECOND};
        for (int k = 0; k < 150; k++)
            m.bytes[k] = (uint8_t)(255 * ll_rng_unit(7, (uint64_t)i, (uint64_t)k));
        r = (ll_bit_reader){.bytes = m.bytes, .size = m.bits};
        status = ll_reckoning_decode(p.receiver, 0, &r, p.seen, m.time, m.time);
        if (ll_failed(&status))
            assert_memory_equal(before, p.receiver, size);
        else
            memcpy(before, p.receiver, size);
        assert_true(isfinite(drawn(&p, m.time).x));
    }
    free(before);
    close_pair(&p);
}

/* ---- a naive second implementation ---- */

/* It keeps every state that was ever sent, and finds what is drawn from the whole history of arrivals. */
typedef struct naive {
    ll_reckoning_params params;
    struct {
        double at, x, y, vx, vy, ax, ay, came; /* came: -1, lost */
    } sent[2000];
    int count;
    double vx, vy, moved;
} naive;

static void naive_model(const naive *n, int k, double t, double out[4])
{
    double s = t - n->sent[k].at;
    const char *model = ll_reckoning_names[n->params.model];
    bool moves = strcmp(model, "static") != 0, accelerates = strcmp(model, "acceleration") == 0;
    out[0] = n->sent[k].x + (moves ? n->sent[k].vx * s : 0);
    out[1] = n->sent[k].y + (moves ? n->sent[k].vy * s : 0);
    out[2] = moves ? n->sent[k].vx : 0;
    out[3] = moves ? n->sent[k].vy : 0;
    if (accelerates) {
        out[0] += n->sent[k].ax * s * s / 2;
        out[1] += n->sent[k].ay * s * s / 2;
        out[2] += n->sent[k].ax * s;
        out[3] += n->sent[k].ay * s;
    }
}

static bool naive_sends(naive *n, const ll_entity *e, double t)
{
    double model[4], ax = (e->vx - n->vx) / (t - n->moved), ay = (e->vy - n->vy) / (t - n->moved);
    bool first = n->count == 0, due = first;
    if (!first) {
        naive_model(n, n->count - 1, t, model);
        due = hypot(e->x - model[0], e->y - model[1]) > n->params.threshold_m ||
              t - n->sent[n->count - 1].at >= n->params.heartbeat_s;
    }
    if (due) {
        n->sent[n->count].at = t;
        n->sent[n->count].x = e->x;
        n->sent[n->count].y = e->y;
        n->sent[n->count].vx = e->vx;
        n->sent[n->count].vy = e->vy;
        n->sent[n->count].ax = first ? 0 : ax;
        n->sent[n->count].ay = first ? 0 : ay;
        n->sent[n->count++].came = -1;
    }
    n->vx = e->vx;
    n->vy = e->vy;
    n->moved = t;
    return due;
}

static double naive_left(const naive *n, double e, double u, double t, double *rate)
{
    double tau = n->params.tau_s, s = t / tau;
    *rate = 0;
    if (s >= 1 || n->params.convergence == SNAP)
        return 0;
    if (n->params.convergence == LINEAR) {
        *rate = -e / tau;
        return e - e * s;
    }
    if (n->params.convergence == CUBIC) {
        *rate = e * (6 * s * s - 6 * s) / tau + u * (3 * s * s - 4 * s + 1);
        return e * (2 * s * s * s - 3 * s * s + 1) + u * tau * (s * s * s - 2 * s * s + s);
    }
    *rate = -e / tau + u * (1 - 4 * s + 3 * s * s);
    return e * (1 - s) + u * t * (1 - s) * (1 - s);
}

/* What is drawn at `t`: the first state that came, and for each later one its deviation from then on. */
static void naive_drawn(const naive *n, double t, double out[4])
{
    int base = -1;
    double e[4] = {0}, since = 0;
    for (int k = 0; k < n->count; k++) {
        if (n->sent[k].came < 0 || n->sent[k].came > t)
            continue;
        double old[4] = {0}, next[4], came = n->sent[k].came;
        naive_model(n, k, came, next);
        if (base >= 0) {
            naive_model(n, base, came, old);
            for (int c = 0; c < 2; c++) {
                double rate, left = naive_left(n, e[c], e[c + 2], came - since, &rate);
                e[c] = old[c] + left - next[c];
                e[c + 2] = old[c + 2] + rate - next[c + 2];
            }
        }
        base = k;
        since = came;
    }
    naive_model(n, base, t, out);
    for (int c = 0; c < 2; c++) {
        double rate;
        out[c] += naive_left(n, e[c], e[c + 2], t - since, &rate);
    }
}

/* Random turns and speeds, a tenth of all messages lost, delays of 20 to 44 ms at 50 ms between messages. */
static void both_implementations_draw_the_same(void **state)
{
    (void)state;
    int compared = 0;
    for (int run = 0; run < 16; run++) {
        ll_reckoning_params params = by(ll_reckoning_names[1 + run % 4], 0.4, run / 4);
        params.heartbeat_s = 1.02; /* no multiple of the time between messages */
        params.threshold_deg = 360;
        pair p = open_pair(params);
        naive *n = calloc(1, sizeof *n);
        n->params = params;
        ll_entity e = {0};
        for (int i = 0; i < 400; i++) {
            ll_time now = i * 50 * LL_MS,
                    came = now + (20 + (int)(24 * ll_rng_unit(1, (uint64_t)run, (uint64_t)i))) * LL_MS;
            if (ll_rng_unit(2, (uint64_t)run, (uint64_t)i) < 0.1) {
                e.vx = 20 * ll_rng_unit(3, (uint64_t)run, (uint64_t)i) - 10;
                e.vy = 20 * ll_rng_unit(4, (uint64_t)run, (uint64_t)i) - 10;
            }
            e.vx += 0.1 * (ll_rng_unit(5, (uint64_t)run, (uint64_t)i) - 0.5);
            e.x += e.vx * 0.05;
            e.y += e.vy * 0.05;
            p.world->entity[1] = e;
            message m = send(&p, now, i == 0);
            assert_int_equal(m.updates, naive_sends(n, &e, ll_to_s(now)));
            if (i > 0 && ll_rng_unit(6, (uint64_t)run, (uint64_t)i) < 0.1)
                continue;
            arrive(&p, &m, came);
            if (m.updates)
                n->sent[n->count - 1].came = ll_to_s(came);
            for (ll_time at = came; at < now + 50 * LL_MS; at += 2 * LL_MS) {
                double want[4];
                naive_drawn(n, ll_to_s(at), want);
                ll_entity got = drawn(&p, at);
                assert_near(got.x, want[0], 1e-9);
                assert_near(got.y, want[1], 1e-9);
                compared++;
            }
        }
        assert_true(n->count > 30);
        free(n);
        close_pair(&p);
    }
    assert_true(compared > 20000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(constant_acceleration_is_sent_at_its_period),
        cmocka_unit_test(the_model_of_the_motion_sends_heartbeats_only),
        cmocka_unit_test(a_circle_is_sent_at_its_period),
        cmocka_unit_test(a_straight_line_sends_heartbeats_only),
        cmocka_unit_test(linear_convergence_bounds_the_drawn_speed),
        cmocka_unit_test(convergences_end_where_they_should),
        cmocka_unit_test(only_snap_jumps_and_cubic_does_not_kick),
        cmocka_unit_test(jitter_leaves_no_trace),
        cmocka_unit_test(a_heartbeat_makes_up_for_a_loss),
        cmocka_unit_test(what_cannot_be_decoded_changes_nothing),
        cmocka_unit_test(both_implementations_draw_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
