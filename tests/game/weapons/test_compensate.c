/* Lag compensation, on a range that can be computed: one shooter at the origin, targets on known paths. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "game/core/weapons.h"
#include "support/near.h"

#define HZ 60000
#define BODIES 2
#define RADIUS 0.6

typedef ll_point way(double t);

/* Across the line of fire at 6 m/s, 40 m away; at y = 0 at 2 s. */
static ll_point crossing(double t)
{
    return (ll_point){40, 6 * (t - 2)};
}

/* The same, but it turns at step 130. */
static ll_point turning(double t)
{
    double turn = ll_to_s(ll_tick_time(130, HZ));
    return (ll_point){40, 6 * ((t < turn ? t : 2 * turn - t) - 2)};
}

typedef struct range {
    ll_arena arena;
    ll_compensation rules;
    ll_policy_params params;
    ll_history *history;
    ll_world *world;
    ll_past past;
    ll_weapon_state arms;
    ll_point before[BODIES], after[BODIES];
    way *target;
    int64_t step; /* made last */
    ll_hit_result results[16];
    ll_shot shots[16];
    int count;
} range;

static void witness(void *context, const ll_hit_result *j)
{
    range *r = context;
    assert_true(r->count < 16);
    if (j->shot)
        r->shots[r->count] = *j->shot;
    r->results[r->count++] = *j;
}

static void place(range *r)
{
    ll_point p = r->target(ll_to_s(ll_tick_time(r->step, HZ)));
    r->world->entity[1] = (ll_entity){.x = p.x, .y = p.y};
    ll_history_add(r->history, ll_tick_time(r->step, HZ), r->world);
    ll_bodies_now(&r->arena, r->world, r->after);
}

static range *new_range(way *target, int hitscan, int projectile)
{
    range *r = calloc(1, sizeof *r);
    r->arena = (ll_arena){.players = 1,
                          .bodies = BODIES,
                          .teams = 2,
                          .player_radius = 0.5,
                          .target_radius = RADIUS,
                          .projectile_speed = 35,
                          .gravity = 9.81,
                          .interval_s = {0.1, 0.5},
                          .bounds = {-10, 100, -50, 50}};
    r->rules = (ll_compensation){.max_rewind_ms = 1000,
                                 .rewind_tolerance_ms = 200,
                                 .projectile_forward_ms = 100,
                                 .hitscan = hitscan,
                                 .projectile = projectile};
    r->world = calloc(1, ll_extent_size((ll_extent){BODIES, 0}));
    r->world->players = 1;
    r->world->entities = BODIES;
    r->history = malloc(ll_history_size(BODIES));
    ll_history_init(r->history, BODIES);
    r->past = (ll_past){.history = r->history,
                        .rules = &r->rules,
                        .params = &r->params,
                        .buffer = 30 * LL_MS,
                        .witness = witness,
                        .context = r};
    r->target = target;
    place(r);
    return r;
}

static void free_range(range *r)
{
    free(r->history);
    free(r->world);
    free(r);
}

/* Steps to step `k`, with the presses of `fire` in the last one. */
static void step_to(range *r, int64_t k, const ll_action *fire, ll_aim aim)
{
    while (r->step < k) {
        memcpy(r->before, r->after, sizeof r->before);
        const ll_action actions[BODIES] = {{.view_age_ns = 0}, {.view_age_ns = 0}};
        const ll_field field = {&r->arena, r->before, &r->past, actions};
        ll_time before = ll_tick_time(r->step, HZ), now = ll_tick_time(r->step + 1, HZ);
        if (fire && r->step + 1 == k)
            ll_weapons_fire(&r->arms, &field, 0, fire, aim, before, now);
        r->step++;
        place(r); /* as in a netgame, after the step; projectiles meet the bodies at their new positions */
        ll_weapons_fly(&r->arms, &field, 0, r->after, before, now);
    }
}

static ll_aim level(void)
{
    return (ll_aim){{0, 0}, {1, 0}};
}

static ll_aim raised(double radians)
{
    return (ll_aim){{0, 0}, {cos(radians), sin(radians)}};
}

/* An input of step `k` whose client saw the world of time `seen`, and whose newest snapshot was that old. */
static ll_action press(range *r, ll_weapon weapon, int64_t k, ll_time seen)
{
    ll_time age = ll_tick_time(k, HZ) - seen;
    r->past.measured[0] = age;
    ll_action a = {.buttons = UINT32_C(1) << weapon, .view_age_ns = (uint32_t)age};
    return a;
}

/* ---- hitscan ---- */

static int hitscan_at(int policy, double view_time_s, int claim)
{
    range *r = new_range(crossing, policy, 0);
    ll_action a = press(r, LL_HITSCAN, 140, (ll_time)(view_time_s * 1e9));
    ll_set_claim(&a, LL_HITSCAN, claim);
    step_to(r, 140, &a, level());
    int body = r->results[0].body;
    assert_int_equal(r->count, 1);
    assert_int_equal(r->arms.shots[LL_HITSCAN], 1);
    assert_int_equal(r->arms.hits[LL_HITSCAN], body != LL_NOBODY);
    free_range(r);
    return body;
}

/* The target crosses the line of fire at 2 s, and is on it for 0.1 s before and after; the shot is taken at
 * step 140, 2.33 s. */
static void hitscan_hits_what_the_shooter_saw(void **state)
{
    (void)state;
    for (int ms = 1840; ms <= 2160; ms += 10) {
        int seen = ms > 1900 && ms < 2100 ? 1 : LL_NOBODY;
        if (ms == 1900 || ms == 2100)
            continue; /* the very edge */
        assert_int_equal(hitscan_at(1, ms / 1000.0, LL_NOBODY), seen);
        assert_int_equal(hitscan_at(0, ms / 1000.0, LL_NOBODY), LL_NOBODY); /* it is 2 m away by then */
    }
}

static void trust_accepts_a_lie_and_rewind_does_not(void **state)
{
    (void)state;
    assert_int_equal(hitscan_at(2, 2.3, 1), 1);
    assert_int_equal(hitscan_at(1, 2.3, 1), LL_NOBODY);
    assert_int_equal(hitscan_at(0, 2.3, 1), LL_NOBODY);
    assert_int_equal(hitscan_at(2, 2.0, LL_NOBODY), LL_NOBODY); /* the claim counts, not the shot */
    assert_int_equal(hitscan_at(2, 2.3, 0), LL_NOBODY);         /* no player hits itself, */
    assert_int_equal(hitscan_at(2, 2.3, 77), LL_NOBODY);        /* nor a body that does not exist */
}

static void view_is_clamped_and_cross_checked(void **state)
{
    (void)state;
    const struct {
        double stated_ms, measured_ms, looked_back_ms;
        bool clamped, view_time_rejected;
    } cases[] = {
        {120, 100, 120, false, false},
        {240, 60, 240, false, false},
        {300, 250, 250, true, false}, /* the limit counts from the server's present */
        {260, 250, 260, false, false},
        {266, 250, 266, false, false}, /* 249.3 ms before it */
        {267, 250, 250, true, false},
        {240, 10, 240, false, false}, /* 200 more than the oldest of 10 to 40 ms */
        {241, 10, 40, false, true},   /* the measured age counts */
        {20, 400, 20, false, false},
        /* younger than any snapshot: others were predicted */ {900, 300, 250, true, true},
        {0, 0, 0, false, false},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        range *r = new_range(crossing, 1, 0);
        r->rules.max_rewind_ms = 250;
        ll_time now = ll_tick_time(140, HZ);
        ll_action a = press(r, LL_HITSCAN, 140, now - ll_ms(cases[i].stated_ms));
        r->past.measured[0] = ll_ms(cases[i].measured_ms);
        step_to(r, 140, &a, level());
        ll_time present = ll_tick_time(139, HZ);
        ll_time want = (cases[i].clamped ? present : now) - ll_ms(cases[i].looked_back_ms);
        assert_int_equal(r->shots[0].now, present);
        assert_int_equal(r->shots[0].seen, want < present ? want : present);
        assert_int_equal(r->shots[0].clamped, cases[i].clamped);
        assert_int_equal(r->shots[0].view_time_rejected, cases[i].view_time_rejected);
        free_range(r);
    }
}

/* Hybrid: all of the rewind for young views, a share that falls linearly, none from its end on; without a
 * range between, it ends at once. */
static void hybrid_fades_with_the_age_of_the_view(void **state)
{
    (void)state;
    const struct {
        double full_ms, none_ms, age_ms, share;
    } cases[] = {{150, 350, 20, 1},    {150, 350, 150, 1}, {150, 350, 200, 0.75}, {150, 350, 250, 0.5},
                 {150, 350, 300, .25}, {150, 350, 350, 0}, {150, 350, 900, 0},    {0, 0, 30, 0},
                 {200, 100, 199, 1},   {200, 100, 201, 0}, {0, 1000, 400, 0.6}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        range *r = new_range(crossing, 3, 0);
        r->params.hybrid_full_ms = cases[i].full_ms;
        r->params.hybrid_none_ms = cases[i].none_ms;
        ll_time now = ll_tick_time(140, HZ), present = ll_tick_time(139, HZ);
        ll_action a = press(r, LL_HITSCAN, 140, now - ll_ms(cases[i].age_ms));
        step_to(r, 140, &a, level());
        double whole = (double)(present - (now - ll_ms(cases[i].age_ms)));
        assert_near((double)(present - r->shots[0].seen), cases[i].share * whole, 1);
        assert_int_equal(r->shots[0].clamped, cases[i].share < 1);
        assert_int_equal(r->results[0].rewound_to, r->shots[0].seen);
        free_range(r);
    }
}

/* A player 40 m away hides at 2 s behind a box, and the shooter, at rest, hits it where it was before. The
 * veto lets the hit count until `grace` after it hid in its own view. */
static void veto_spares_who_hid_longer_ago_than_the_grace(void **state)
{
    (void)state;
    for (int grace = 0; grace <= 300; grace += 100) {
        for (int64_t k = 118; k <= 160; k++) {
            range *r = new_range(crossing, 4, 0);
            r->arena.players = 2;
            r->arena.player_radius = RADIUS;
            r->arena.covers = 1;
            r->arena.cover[0] = (ll_box){20, 21, 0, 10}; /* from y = 0 of the target on, at 2 s */
            r->params.veto_grace_ms = grace;
            ll_time now = ll_tick_time(k, HZ), hid = ll_tick_time(120, HZ);
            ll_action a = press(r, LL_HITSCAN, k, ll_tick_time(115, HZ));
            step_to(r, k, &a, (ll_aim){{0, 0}, {cos(-0.0125), sin(-0.0125)}});
            bool counts = ll_tick_time(k - 1, HZ) - ll_ms(grace) < hid;
            assert_int_equal(r->shots[0].seen, ll_tick_time(115, HZ) < now ? ll_tick_time(115, HZ) : now);
            assert_int_equal(r->results[0].body, counts ? 1 : LL_NOBODY);
            assert_int_equal(r->results[0].vetoed, !counts);
            free_range(r);
        }
    }
}

/* ---- projectiles ---- */

/* Position and time of the impact of a projectile that is fired in step `k` for a view of the end of step
 * `seen`. */
typedef struct impact {
    int body;
    double at_s, x, y, start_s, trace_error_m;
} impact;

static impact projectile(way *target, int family, int trace, ll_aim aim, int64_t seen, int64_t k)
{
    range *r = new_range(target, 0, family);
    r->rules.projectile_trace = trace;
    ll_action a = press(r, LL_PROJECTILE, k, ll_tick_time(seen, HZ));
    step_to(r, k, &a, aim);
    step_to(r, k + 400, NULL, aim);
    assert_int_equal(r->count, 2);
    assert_int_equal(r->results[0].kind, LL_HIT_RESULT_LAUNCH);
    assert_int_equal(r->results[1].kind, LL_HIT_RESULT_IMPACT);
    assert_int_equal(r->arms.shots[LL_PROJECTILE], 1);
    assert_int_equal(r->arms.hits[LL_PROJECTILE], r->results[1].body != LL_NOBODY);
    impact i = {r->results[1].body, ll_to_s(r->results[1].end),   r->results[1].at.x,
                r->results[1].at.y, ll_to_s(r->results[0].start), r->results[0].trace_error_m};
    free_range(r);
    return i;
}

/* The elevation at which a projectile from the origin passes through (40, y) after `s` seconds, and that
 * time. */
static double elevation(double y, double *s)
{
    double v = 35, g = 9.81, x = 40, v2 = v * v;
    double angle = atan((v2 - sqrt(v2 * v2 - g * (g * x * x + 2 * y * v2))) / (g * x));
    *s = x / (v * cos(angle));
    return angle;
}

/* Fired at the view of step 60, so as to meet the target: the middle is reached at 1 s + flight. */
static ll_aim at_target(way *target)
{
    double s = 1.2, angle = 0;
    for (int i = 0; i < 50; i++)
        angle = elevation(target(ll_to_s(ll_tick_time(60, HZ)) + s).y, &s);
    return raised(angle);
}

/* The first time that projectile and target touch, by bisection of the closed forms. */
static double touch(way *target, ll_aim aim, double start)
{
    long double low = 0.5L, high;
    for (high = low;; high += 1e-4L) {
        ll_point p = target(start + (double)high);
        long double x = 35 * (long double)aim.direction.x * high,
                    y = 35 * (long double)aim.direction.y * high - 9.81L / 2 * high * high;
        if (hypotl(x - p.x, y - p.y) <= RADIUS)
            break;
        low = high;
    }
    for (int i = 0; i < 60; i++) {
        long double s = (low + high) / 2;
        ll_point p = target(start + (double)s);
        long double x = 35 * (long double)aim.direction.x * s,
                    y = 35 * (long double)aim.direction.y * s - 9.81L / 2 * s * s;
        if (hypotl(x - p.x, y - p.y) > RADIUS)
            low = s;
        else
            high = s;
    }
    return (double)high;
}

/* Family C: at any lag the impact is that of a server without lag, and of the closed form. */
static void rewound_projectile_lands_where_it_would_without_lag(void **state)
{
    (void)state;
    way *const ways[] = {crossing, turning};
    for (int w = 0; w < 2; w++) {
        ll_aim aim = at_target(ways[w]);
        impact none = projectile(ways[w], 2, LL_TRACE_PARABOLA, aim, 60, 61);
        double start = ll_to_s(ll_tick_time(60, HZ)), s = touch(ways[w], aim, start);
        assert_int_equal(none.body, 1);
        assert_near(none.at_s, (start + s), 2e-9); /* whole ns */
        assert_near(none.x, 35 * aim.direction.x * s, 1e-9);
        assert_near(none.y, (35 * aim.direction.y - 9.81 / 2 * s) * s, 1e-9);
        for (int64_t k = 62; k <= 120; k++) { /* up to a second late */
            impact late = projectile(ways[w], 2, LL_TRACE_PARABOLA, aim, 60, k);
            assert_int_equal(late.body, 1);
            assert_near(late.x, none.x, 1e-9);
            assert_near(late.y, none.y, 1e-9);
            assert_near(late.at_s, none.at_s, 1e-9);
            assert_true(late.start_s == none.start_s && late.trace_error_m == 0);
        }
    }
}

/* Family A is late by the age of the view: the target has gone on. */
static void projectile_that_starts_at_the_server_is_late(void **state)
{
    (void)state;
    ll_aim aim = at_target(crossing);
    assert_int_equal(projectile(crossing, 0, LL_TRACE_PARABOLA, aim, 60, 61).body, 1);
    impact late = projectile(crossing, 0, LL_TRACE_PARABOLA, aim, 60, 79);
    assert_int_equal(late.body, LL_NOBODY);
    assert_true(late.start_s == ll_to_s(ll_tick_time(78, HZ)));
}

/* A target close by, at y = 0 at 1.2 s, 8 m away: the fast-forwarded part of the flight hits it. */
static ll_point close_by(double t)
{
    return (ll_point){8, 6 * (t - 1.2)};
}

/* Family B tests the fast-forwarded part against the present: a target that would have been hit has moved on,
 * and one that has arrived there since is hit although it was not there yet. */
static void fast_forward_leaves_the_first_part_uncompensated(void **state)
{
    (void)state;
    ll_aim flat = raised(0.0);
    /* seen at step 60 (1 s), at 8 m after 0.23 s: the target is 0.18 m beyond the line; taken at step 90,
     * 0.48 s after the view, it is 1.75 m beyond */
    assert_int_equal(projectile(close_by, 2, LL_TRACE_PARABOLA, flat, 60, 90).body, 1);
    assert_int_equal(projectile(close_by, 1, LL_TRACE_PARABOLA, flat, 60, 90).body, LL_NOBODY);
    /* seen at step 42 (0.7 s): then the target was 1.6 m below the line; taken at step 72 it is on it */
    assert_int_equal(projectile(close_by, 2, LL_TRACE_PARABOLA, flat, 42, 72).body, LL_NOBODY);
    assert_int_equal(projectile(close_by, 1, LL_TRACE_PARABOLA, flat, 42, 72).body, 1);
    /* a target beyond the first part is hit by both, at the same place */
    ll_aim aim = at_target(crossing);
    impact b = projectile(crossing, 1, LL_TRACE_PARABOLA, aim, 60, 90),
           c = projectile(crossing, 2, LL_TRACE_PARABOLA, aim, 60, 90);
    assert_true(b.body == 1);
    assert_true(c.body == 1);
    assert_near(b.x, c.x, 1e-9);
    assert_near(b.y, c.y, 1e-9);
}

static void partial_forwards_no_more_than_configured(void **state)
{
    (void)state;
    impact far = projectile(crossing, 3, LL_TRACE_PARABOLA, level(), 60, 91),
           close = projectile(crossing, 3, LL_TRACE_PARABOLA, level(), 60, 64);
    assert_near(far.start_s, (ll_to_s(ll_tick_time(90, HZ)) - 0.1), 1e-12);
    assert_true(close.start_s == ll_to_s(ll_tick_time(60, HZ)));
}

/* The straight line between the ends of the fast-forwarded part is off by g T^2 / 8 in its middle. */
static void straight_trace_is_off_by_its_closed_form(void **state)
{
    (void)state;
    for (int64_t k = 62; k <= 120; k++) {
        impact i = projectile(crossing, 2, LL_TRACE_STRAIGHT, raised(0.5), 60, k);
        double t = ll_to_s(ll_tick_time(k - 1, HZ) - ll_tick_time(60, HZ));
        assert_near(i.trace_error_m, 9.81 * t * t / 8, 1e-12);
    }
}

/* At rest near the top of the fast-forwarded part, within reach of the parabola and not of its chord. */
static ll_point above_the_chord(double t)
{
    (void)t;
    double s = 0.475; /* half of 57 steps */
    return (ll_point){35 * cos(0.5) * s, 35 * sin(0.5) * s - 9.81 / 2 * s * s + RADIUS - 0.02};
}

static void straight_trace_misses_what_the_parabola_meets(void **state)
{
    (void)state;
    assert_int_equal(projectile(above_the_chord, 2, LL_TRACE_PARABOLA, raised(0.5), 60, 118).body, 1);
    assert_int_equal(projectile(above_the_chord, 2, LL_TRACE_STRAIGHT, raised(0.5), 60, 118).body, LL_NOBODY);
    assert_int_equal(projectile(above_the_chord, 2, LL_TRACE_STRAIGHT, raised(0.5), 60, 62).body,
                     1); /* step by step */
}

static void claimed_projectiles_hit_what_the_client_says(void **state)
{
    (void)state;
    range *r = new_range(crossing, 0, 4);
    ll_action fire = press(r, LL_PROJECTILE, 60, ll_tick_time(50, HZ)), claim = {0};
    step_to(r, 60, &fire, level());
    step_to(r, 100, NULL, level());
    assert_int_equal(r->count, 1);
    ll_set_claim(&claim, LL_PROJECTILE, 1);
    step_to(r, 101, &claim, level());
    assert_true(r->count == 2 && r->results[1].kind == LL_HIT_RESULT_IMPACT && r->results[1].body == 1);
    step_to(r, 102, &claim, level()); /* no projectile is left to claim for */
    assert_true(r->count == 2 && r->arms.hits[LL_PROJECTILE] == 1);
    fire = press(r, LL_PROJECTILE, 110, ll_tick_time(100, HZ));
    step_to(r, 110, &fire, raised(-1)); /* unclaimed: it passes the target and ends a second after it left */
    step_to(r, 400, NULL, level());
    assert_true(r->count == 4 && r->results[3].body == LL_NOBODY);
    double falls = (-35 * sin(1) + sqrt(35 * sin(1) * 35 * sin(1) + 2 * 9.81 * 50)) / 9.81;
    double end = ll_to_s(r->results[3].end - r->results[3].start);
    assert_true(end >= falls + 1 && end <= falls + 1 + 1.001 / 60);
    free_range(r);
}

static void a_press_beyond_the_ring_is_void(void **state)
{
    (void)state;
    range *r = new_range(crossing, 0, 0);
    for (int64_t k = 1; k <= LL_PROJECTILES + 2; k++) {
        ll_action a = press(r, LL_PROJECTILE, 30 * k, ll_tick_time(30 * k - 1, HZ));
        step_to(r, 30 * k, &a, raised(1));
    }
    assert_int_equal(r->arms.shots[LL_PROJECTILE], LL_PROJECTILES);
    assert_int_equal(r->count, LL_PROJECTILES);
    free_range(r);
}

static void a_press_before_the_weapon_is_ready_is_void(void **state)
{
    (void)state;
    range *r = new_range(crossing, 0, 0);
    for (int64_t k = 1; k <= 120; k++) { /* every step: a weapon of 0.1 s fires in every sixth */
        ll_action a = press(r, LL_HITSCAN, k, ll_tick_time(k - 1, HZ));
        step_to(r, k, &a, level());
        assert_int_equal(r->results[0].kind, k % 6 == 1 ? LL_HIT_RESULT_HITSCAN : LL_HIT_RESULT_VOID);
        assert_int_equal(r->arms.shots[LL_HITSCAN], (k + 5) / 6);
        r->count = 0;
    }
    free_range(r);
}

/* A client's world is stepped without a history: shots are judged against the present. */
static void nothing_is_compensated_without_a_past(void **state)
{
    (void)state;
    range *r = new_range(crossing, 1, 2);
    const ll_field field = {&r->arena, r->after, NULL, NULL};
    ll_action a = press(r, LL_PROJECTILE, 1, 0);
    a.buttons |= 1u << LL_HITSCAN;
    r->after[1].y = 0;
    ll_weapons_fire(&r->arms, &field, 0, &a, level(), 0, ll_tick_time(1, HZ));
    assert_true(r->arms.hits[LL_HITSCAN] == 1 && r->arms.projectiles[1].start == 0 && r->count == 0);
    free_range(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hitscan_hits_what_the_shooter_saw),
        cmocka_unit_test(trust_accepts_a_lie_and_rewind_does_not),
        cmocka_unit_test(view_is_clamped_and_cross_checked),
        cmocka_unit_test(hybrid_fades_with_the_age_of_the_view),
        cmocka_unit_test(veto_spares_who_hid_longer_ago_than_the_grace),
        cmocka_unit_test(rewound_projectile_lands_where_it_would_without_lag),
        cmocka_unit_test(projectile_that_starts_at_the_server_is_late),
        cmocka_unit_test(fast_forward_leaves_the_first_part_uncompensated),
        cmocka_unit_test(partial_forwards_no_more_than_configured),
        cmocka_unit_test(straight_trace_is_off_by_its_closed_form),
        cmocka_unit_test(straight_trace_misses_what_the_parabola_meets),
        cmocka_unit_test(claimed_projectiles_hit_what_the_client_says),
        cmocka_unit_test(a_press_beyond_the_ring_is_void),
        cmocka_unit_test(a_press_before_the_weapon_is_ready_is_void),
        cmocka_unit_test(nothing_is_compensated_without_a_past),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
