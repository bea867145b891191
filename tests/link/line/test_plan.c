/* A link under a plan does what it does under its parameters: the same fates, and the same bytes of the whole
 * link after every call. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "base/rng.h"
#include "link/harness.h"

enum { SLOTS = 40, ARENA = 3000, LONGEST = 400 };

static uint64_t draw(uint64_t seed, int i, int what, uint64_t below)
{
    return ll_rng_u64(seed, (uint64_t)what, (uint64_t)i) % below;
}

static ll_link_params random_params(uint64_t seed)
{
    ll_link_params p = {.delay_ms = (double)draw(seed, 0, 90, 30)};
    p.order = (int32_t)draw(seed, 0, 91, 2);
    if (draw(seed, 0, 92, 2))
        p.mtu_bytes = 64 + (int64_t)draw(seed, 0, 93, 100);
    if (seed % 3 == 0)
        return p; /* without impairments */
    p.jitter_ms = (double)draw(seed, 0, 94, 20);
    p.loss_pct = (double)draw(seed, 0, 95, 30);
    p.reorder_pct = (double)draw(seed, 0, 89, 30);
    p.reorder_gap = 1 + (int64_t)draw(seed, 0, 87, 3);
    p.corrupt_pct = (double)draw(seed, 0, 88, 10);
    p.duplicate_pct = seed % 2 == 0 ? (double)draw(seed, 0, 96, 30) : 0;
    p.rate_kbps = draw(seed, 0, 97, 2) ? 100 : 0;
    return p;
}

static void same_links(const ll_link *a, const ll_link *b)
{
    assert_memory_equal(a, b, ll_link_size(SLOTS, ARENA));
}

static void same_fates(const ll_sending *a, const ll_sending *b)
{
    assert_int_equal(a->fate, b->fate);
    assert_int_equal(a->due, b->due);
    assert_int_equal(a->fragments, b->fragments);
    assert_int_equal(a->duplicated, b->duplicated);
    if (a->duplicated)
        assert_int_equal(a->copy_due, b->copy_due);
}

/* Takes all that is due from both: copied out of one, where it lies from the other. */
static int take_both(ll_link *a, ll_link *b, ll_time now)
{
    char bytes[LONGEST];
    ll_time sent, due;
    int taken = 0, size, lying;
    while ((size = ll_link_receive(a, now, bytes, (int)sizeof bytes, &sent, &due)) >= 0) {
        const void *there = ll_link_next(b, now, &lying);
        assert_non_null(there);
        assert_int_equal(lying, size);
        assert_int_equal((uintptr_t)there % 4, 0);
        if (size > 0)
            assert_memory_equal(there, bytes, (size_t)size);
        same_links(a, b);
        taken++;
    }
    assert_null(ll_link_next(b, now, &lying));
    return taken;
}

static void a_plan_changes_nothing(void **state)
{
    (void)state;
    int taken = 0, usual = 0, other = 0, single = 0;
    ll_time sent, due;
    for (uint64_t seed = 1; seed <= 60; seed++) {
        ll_link *a = link_open(SLOTS, ARENA, seed, 3), *b = link_open(SLOTS, ARENA, seed, 3),
                *c = link_open(SLOTS, ARENA, seed, 3);
        const ll_link_params params = random_params(seed);
        const double lag_ms = (double)draw(seed, 0, 98, 100);
        const ll_link_plan plan = ll_link_plan_of(&params, lag_ms);
        char bytes[LONGEST];
        ll_time now = 0;
        for (int i = 0; i < 600; i++) {
            int size = (int)draw(seed, i, 1, LONGEST);
            now += (ll_time)draw(seed, i, 2, 12) * LL_MS;
            for (int k = 0; k < size; k++)
                bytes[k] = (char)(k * 7 + i);
            ll_sending s = link_send(a, &params, lag_ms, now, bytes, size);
            ll_sending t = {.fate = LL_FATE_DELIVERED, .fragments = 1};
            bool plain = ll_link_send_plain(b, &plan, now, bytes, size, &t.due);
            if (!plain)
                t = ll_link_send_by(b, &plan, now, bytes, size);
            plain ? usual++ : other++;
            same_fates(&s, &t);
            same_links(a, b);
            if (ll_link_send_single(c, &plan, now, bytes, size))
                single++;
            else
                ll_link_send_by(c, &plan, now, bytes, size);
            same_links(a, c);
            taken += take_both(a, b, now);
            while (ll_link_receive(c, now, bytes, (int)sizeof bytes, &sent, &due) >= 0)
                ;
        }
        free(a);
        free(b);
        free(c);
    }
    assert_true(taken > 10000 && usual > 3000 && other > 10000 && single > 5000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_plan_changes_nothing)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
