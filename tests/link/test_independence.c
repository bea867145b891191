/* Every stage draws for every packet from a stream of its own: switching one on leaves the others' draws as
 * they were. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "link/harness.h"

#define COUNT 100000
#define STEP (LL_SECOND / 60)

typedef struct fates {
    ll_sending of[COUNT];
} fates;

static fates *run(const ll_link_params *params, uint64_t seed, uint64_t stream)
{
    fates *f = malloc(sizeof *f);
    ll_link *link = link_open(60, 4000, seed, stream);
    ll_time sent, due;
    for (int64_t i = 0; i < COUNT; i++) {
        f->of[i] = packet_send(link, params, 100, i * STEP, i);
        while (packet_receive(link, i * STEP, &sent, &due) >= 0)
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
        assert_int_equal(all->of[i].fate, lossy->of[i].fate);
        assert_int_equal(all->of[i].due, lossy->of[i].due);
        if (all->of[i].duplicated)
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
    assert_true(fabs(correlation(a, other_stream, 0)) < 4 / sqrt(COUNT));
    assert_true(fabs(correlation(a, other_seed, 0)) < 4 / sqrt(COUNT));
    assert_true(fabs(correlation(a, a, 1)) < 4 / sqrt(COUNT));
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
    assert_true(fabs(correlation(a, copies, 0)) < 4 / sqrt(COUNT));
    free(a);
    free(copies);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loss_leaves_the_delays_of_the_others),
        cmocka_unit_test(jitter_leaves_the_losses),
        cmocka_unit_test(an_overflow_leaves_the_draws_of_the_others),
        cmocka_unit_test(streams_seeds_and_neighbours_are_uncorrelated),
        cmocka_unit_test(copies_draw_for_themselves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
