/* Every stage draws for every packet from a stream of its own: switching one on does not change the others'
 * draws, for every pair. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "link/harness.h"

#define COUNT 100000

typedef struct fates {
    ll_sending of[COUNT];
} fates;

static fates *run(const ll_link_params *params, uint64_t seed, uint64_t stream)
{
    fates *f = malloc(sizeof *f);
    ll_link *link = link_open(200, 20000, seed, stream);
    ll_time sent, due;
    for (int64_t i = 0; i < COUNT; i++) {
        f->of[i] = packet_send(link, params, 100, i * STEP, i);
        while (packet_receive(link, LL_NEVER - 1, &sent, &due) >= 0)
            ;
    }
    free(link);
    return f;
}

static const ll_link_params jitter = {.jitter_ms = 40};
static const ll_link_params with_loss = {.jitter_ms = 40, .loss_pct = 10};
static const ll_link_params with_all = {.jitter_ms = 40, .loss_pct = 10, .duplicate_pct = 30};
static const ll_link_params only_loss = {.loss_pct = 10};
static const ll_link_params more_loss = {.loss_pct = 20};

static void loss_leaves_the_delays_of_the_others(void **state)
{
    (void)state;
    fates *plain = run(&jitter, 1, 2), *lossy = run(&with_loss, 1, 2), *all = run(&with_all, 1, 2);
    for (int i = 0; i < COUNT; i++) {
        if (lossy->of[i].fate == LL_FATE_DELIVERED)
            assert_int_equal(lossy->of[i].due, plain->of[i].due);
        bool taken = all->of[i].fate == LL_FATE_LOST || all->of[i].rescued; /* a duplicate keeps one */
        assert_int_equal(taken, lossy->of[i].fate == LL_FATE_LOST);
        if (all->of[i].fate == LL_FATE_DELIVERED)
            assert_int_equal(all->of[i].due, plain->of[i].due);
        if (all->of[i].duplicated && all->of[i].copy_fate == LL_FATE_DELIVERED)
            assert_true(all->of[i].copy_due != all->of[i].due);
    }
    free(plain);
    free(lossy);
    free(all);
}

static void jitter_leaves_the_losses(void **state)
{
    (void)state;
    fates *a = run(&only_loss, 1, 2), *b = run(&with_loss, 1, 2), *more = run(&more_loss, 1, 2);
    for (int i = 0; i < COUNT; i++) {
        assert_int_equal(a->of[i].fate, b->of[i].fate);
        if (a->of[i].fate == LL_FATE_LOST) /* a higher rate loses these and others */
            assert_int_equal(more->of[i].fate, LL_FATE_LOST);
    }
    free(a);
    free(b);
    free(more);
}

/* Also a packet that the queue had no room for had its draws. */
static void an_overflow_leaves_the_draws_of_the_others(void **state)
{
    (void)state;
    ll_link *wide = link_open(100, 100000, 1, 2), *narrow = link_open(3, 100000, 1, 2);
    ll_time sent, due;
    int refused = 0;
    for (int64_t i = 0; i < 5000; i++) {
        ll_sending a = packet_send(wide, &with_loss, 100, i * STEP, i);
        ll_sending b = packet_send(narrow, &with_loss, 100, i * STEP, i);
        refused += b.fate == LL_FATE_OVERFLOW;
        assert_int_equal(a.fate == LL_FATE_LOST, b.fate == LL_FATE_LOST);
        if (b.fate == LL_FATE_DELIVERED)
            assert_int_equal(a.due, b.due);
        while (packet_receive(wide, i * STEP, &sent, &due) >= 0)
            ;
        while (packet_receive(narrow, i * STEP, &sent, &due) >= 0)
            ;
    }
    assert_true(refused > 1000);
    free(wide);
    free(narrow);
}

/* Correlation of two sequences of delays; its standard error is 1 / sqrt(COUNT). */
static double correlation(const fates *a, const fates *b, int shift)
{
    double ab = 0, aa = 0, bb = 0;
    for (int i = 0; i + shift < COUNT; i++) {
        double x = ll_to_ms(a->of[i].due - i * STEP) - 100;
        double y = ll_to_ms(b->of[i + shift].due - (i + shift) * STEP) - 100;
        ab += x * y;
        aa += x * x;
        bb += y * y;
    }
    return ab / sqrt(aa * bb);
}

static void streams_seeds_and_neighbours_are_uncorrelated(void **state)
{
    (void)state;
    fates *a = run(&jitter, 1, 2), *other_stream = run(&jitter, 1, 3), *other_seed = run(&jitter, 2, 2);
    assert_near(correlation(a, other_stream, 0), 0, 4 / sqrt(COUNT));
    assert_near(correlation(a, other_seed, 0), 0, 4 / sqrt(COUNT));
    assert_near(correlation(a, a, 1), 0, 4 / sqrt(COUNT));
    free(a);
    free(other_stream);
    free(other_seed);
}

/* The delay of a copy says nothing about that of its original. */
static void copies_draw_for_themselves(void **state)
{
    (void)state;
    ll_link_params params = {.jitter_ms = 40, .duplicate_pct = 100};
    fates *a = run(&params, 1, 2), *copies = malloc(sizeof *copies);
    for (int i = 0; i < COUNT; i++) {
        assert_true(a->of[i].duplicated);
        copies->of[i].due = a->of[i].copy_due;
    }
    assert_near(correlation(a, copies, 0), 0, 4 / sqrt(COUNT));
    free(a);
    free(copies);
}

/* ---- every pair ---- */

/* The impairments one by one, correlated where possible, so that their memory counts as well. */
typedef struct impairment {
    const char *name;
    void (*set)(ll_link_params *params);
    /* Its decision about a packet, comparable only where `seen`. The delay is that without the queue. */
    bool (*seen)(const ll_sending *s);
    int64_t (*decided)(const ll_sending *s, ll_time now);
} impairment;

static void set_random(ll_link_params *p)
{
    p->loss_pct = 20;
    p->loss_corr_pct = 50;
}

static void set_gemodel(ll_link_params *p)
{
    p->loss_model = LL_LOSS_GEMODEL;
    p->ge_p_pct = 10;
    p->ge_r_pct = 30;
    p->ge_1h_pct = 80;
    p->ge_1k_pct = 5;
}

static void set_state(ll_link_params *p)
{
    p->loss_model = LL_LOSS_STATE;
    p->p13_pct = 10;
    p->p31_pct = 40;
    p->p32_pct = 30;
    p->p23_pct = 50;
    p->p14_pct = 3;
}

static void set_blackout(ll_link_params *p)
{
    p->blackout_every_ms = 1000;
    p->blackout_length_ms = 300;
}

static void set_duplicate(ll_link_params *p)
{
    p->duplicate_pct = 30;
    p->duplicate_corr_pct = 50;
}

static void set_jitter(ll_link_params *p)
{
    p->jitter_ms = 30;
    p->distribution = LL_DISTRIBUTION_PARETONORMAL;
    p->delay_corr_pct = 60;
}

static void set_spike(ll_link_params *p)
{
    p->spike_every_ms = 700;
    p->spike_length_ms = 200;
    p->spike_add_ms = 90;
}

static void set_rate(ll_link_params *p)
{
    p->rate_kbps = 30;
    p->limit_ms = 300;
}

static void set_reorder(ll_link_params *p)
{
    p->reorder_pct = 30;
    p->reorder_corr_pct = 40;
    p->reorder_gap = 3;
}

static void set_corrupt(ll_link_params *p)
{
    p->corrupt_pct = 20;
    p->corrupt_corr_pct = 50;
}

static bool always(const ll_sending *s)
{
    (void)s;
    return true;
}

static bool travelled(const ll_sending *s)
{
    return s->fate == LL_FATE_DELIVERED || s->fate == LL_FATE_CORRUPTED;
}

static bool travelled_in_turn(const ll_sending *s)
{
    return travelled(s) && !s->reordered;
}

static int64_t lost(const ll_sending *s, ll_time now)
{
    (void)now;
    return s->fate == LL_FATE_LOST || s->rescued;
}

static int64_t duplicated(const ll_sending *s, ll_time now)
{
    (void)now;
    return s->duplicated;
}

static int64_t delay(const ll_sending *s, ll_time now)
{
    return s->due - s->queued - now;
}

static int64_t reordered(const ll_sending *s, ll_time now)
{
    (void)now;
    return s->reordered;
}

static int64_t corrupted(const ll_sending *s, ll_time now)
{
    (void)now;
    return s->fate == LL_FATE_CORRUPTED;
}

static const impairment impairments[] = {
    {"random", set_random, always, lost},
    {"gemodel", set_gemodel, always, lost},
    {"state", set_state, always, lost},
    {"blackout", set_blackout, NULL, NULL}, /* draws nothing, as spikes and the rate */
    {"duplicate", set_duplicate, always, duplicated},
    {"jitter", set_jitter, travelled_in_turn, delay},
    {"spike", set_spike, NULL, NULL},
    {"rate", set_rate, NULL, NULL},
    {"reorder", set_reorder, travelled, reordered},
    {"corrupt", set_corrupt, travelled, corrupted},
};
enum { IMPAIRMENTS = sizeof impairments / sizeof impairments[0], LOSSES = 3 };

static bool excluded(int a, int b)
{
    bool two_models = a < LOSSES && b < LOSSES;
    bool two_causes = a < LOSSES && impairments[b].set == set_blackout; /* both show as lost */
    bool two_delays = impairments[a].set == set_jitter && impairments[b].set == set_spike;
    return a == b || two_models || two_causes || two_delays;
}

static fates *run_with(int a, int b)
{
    ll_link_params params = link_params();
    params.delay_ms = 500;
    impairments[a].set(&params);
    if (b >= 0)
        impairments[b].set(&params);
    return run(&params, 5, 2);
}

static void every_impairment_leaves_the_draws_of_every_other(void **state)
{
    (void)state;
    for (int a = 0; a < IMPAIRMENTS; a++) {
        if (!impairments[a].decided)
            continue;
        fates *alone = run_with(a, -1);
        for (int b = 0; b < IMPAIRMENTS; b++) {
            if (excluded(a, b))
                continue;
            fates *with = run_with(a, b);
            int compared = 0, different = 0;
            for (int i = 0; i < COUNT; i++) {
                const ll_sending *x = &alone->of[i], *y = &with->of[i];
                if (!impairments[a].seen(x) || !impairments[a].seen(y))
                    continue;
                different += impairments[a].decided(x, i * STEP) != impairments[a].decided(y, i * STEP);
                compared++;
            }
            if (different != 0 || compared < COUNT / 4)
                fail_msg("%s changes %d of %d draws of %s", impairments[b].name, different, compared,
                         impairments[a].name);
            free(with);
        }
        free(alone);
    }
}

/* Copies too: with all impairments on, one more does not change when or whether the copies arrive. */
static void copies_keep_their_draws(void **state)
{
    (void)state;
    for (int b = 0; b < IMPAIRMENTS; b++) {
        bool delays = impairments[b].set == set_spike || impairments[b].set == set_rate;
        if (impairments[b].set == set_jitter || delays || impairments[b].set == set_reorder)
            continue;
        ll_link_params params = link_params();
        params.delay_ms = 500;
        set_duplicate(&params);
        set_jitter(&params);
        set_reorder(&params);
        fates *without = run(&params, 5, 2);
        impairments[b].set(&params);
        fates *with = run(&params, 5, 2);
        int compared = 0;
        for (int i = 0; i < COUNT; i++) {
            const ll_sending *x = &without->of[i], *y = &with->of[i];
            if (!x->duplicated || !y->duplicated || y->copy_fate != LL_FATE_DELIVERED)
                continue;
            assert_int_equal(x->copy_due, y->copy_due);
            compared++;
        }
        assert_true(compared > COUNT / 20);
        free(without);
        free(with);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loss_leaves_the_delays_of_the_others),
        cmocka_unit_test(jitter_leaves_the_losses),
        cmocka_unit_test(an_overflow_leaves_the_draws_of_the_others),
        cmocka_unit_test(streams_seeds_and_neighbours_are_uncorrelated),
        cmocka_unit_test(copies_draw_for_themselves),
        cmocka_unit_test(every_impairment_leaves_the_draws_of_every_other),
        cmocka_unit_test(copies_keep_their_draws),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
