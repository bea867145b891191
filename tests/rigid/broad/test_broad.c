/* Every broad phase finds the same pairs as brute force: boxes of one size and of many, moved, removed,
 * inserted again, and piled up. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "base/rng.h"
#include "rigid/broad/broad.h"
#include "threads/team.h"

#define CAPACITY 1500

typedef struct bench {
    ll_aabb boxes[CAPACITY];
    uint8_t moved[CAPACITY], live[CAPACITY];
    int32_t list[CAPACITY];
    int32_t moves;
    bool scratch; /* the grid sweeps strips with it and makes queries without it */
    void *state[LL_BROADS];
} bench;

static ll_aabb random_box(uint64_t stream, uint64_t n, double width, double spread)
{
    double x = ll_rng_unit(1, stream, 4 * n) * width - 0.5 * width;
    double y = ll_rng_unit(1, stream, 4 * n + 1) * width - 0.5 * width;
    double u = ll_rng_unit(1, stream, 4 * n + 2), w = 0.5 + spread * u * u * u * u;
    double h = 0.5 + spread * ll_rng_unit(1, stream, 4 * n + 3) * u;
    return (ll_aabb){{x, y}, {x + w, y + h}};
}

static void touch(bench *b, int32_t i)
{
    if (!b->moved[i]) {
        b->moved[i] = 1;
        b->list[b->moves++] = i;
    }
}

/* The same pairs by three threads, also when a part of them has too little room for its pairs. */
static void compare_by_team(const bench *b, int kind, const ll_proxy_pair *expected, int32_t count)
{
    static ll_proxy_pair pairs[400000];
    static char scratch[CAPACITY * 400];
    ll_team *team;
    ll_status made = ll_team_make(3, &team);
    assert_false(ll_failed(&made));
    for (int tight = 0; tight < 2; tight++) {
        ll_pair_list out = {.at = pairs,
                            .capacity = tight ? count : 400000,
                            .team = team,
                            .scratch = scratch,
                            .scratch_size = b->scratch ? sizeof scratch : 0};
        ll_broad_pairs(ll_broad_phases[kind], b->state[kind], b->boxes, b->moved, b->list, b->moves, &out);
        assert_false(out.overflowed);
        assert_int_equal(out.count, count);
        assert_memory_equal(pairs, expected, (size_t)count * sizeof *pairs);
    }
    ll_team_free(team);
}

static void compare(bench *b)
{
    static ll_proxy_pair pairs[LL_BROADS][400000];
    static char scratch[CAPACITY * 400];
    int32_t counts[LL_BROADS];
    for (int k = 0; k < LL_BROADS; k++) {
        ll_pair_list out = {.at = pairs[k],
                            .capacity = 400000,
                            .scratch = scratch,
                            .scratch_size = b->scratch ? sizeof scratch : 0};
        ll_broad_pairs(ll_broad_phases[k], b->state[k], b->boxes, b->moved, b->list, b->moves, &out);
        assert_false(out.overflowed);
        counts[k] = out.count;
        assert_int_equal(counts[k], counts[0]);
        assert_memory_equal(pairs[k], pairs[0], (size_t)counts[0] * sizeof(ll_proxy_pair));
        compare_by_team(b, k, pairs[0], counts[0]);
    }
    assert_true(counts[0] > 0);
    memset(b->moved, 0, sizeof b->moved);
    b->moves = 0;
}

static void run(double width, double spread, double step)
{
    bench *b = calloc(1, sizeof *b);
    for (int k = 0; k < LL_BROADS; k++) {
        b->state[k] = malloc(ll_broad_phases[k]->size(CAPACITY));
        ll_broad_phases[k]->init(b->state[k], CAPACITY);
    }
    for (int32_t i = 0; i < CAPACITY; i++) {
        b->boxes[i] = random_box(1, (uint64_t)i, width, spread);
        b->live[i] = 1;
        for (int k = 0; k < LL_BROADS; k++)
            ll_broad_phases[k]->insert(b->state[k], b->boxes, i);
        touch(b, i);
    }
    compare(b);
    for (uint64_t round = 0; round < 40; round++) {
        b->scratch = round % 2 == 0;
        for (int32_t i = 0; i < CAPACITY; i++) {
            double chance = ll_rng_unit(2, round, (uint64_t)i);
            if (chance < 0.02) {
                for (int k = 0; k < LL_BROADS; k++) {
                    if (b->live[i])
                        ll_broad_phases[k]->remove(b->state[k], i);
                    else
                        ll_broad_phases[k]->insert(b->state[k], b->boxes, i);
                }
                b->live[i] = !b->live[i];
                if (b->live[i])
                    touch(b, i);
            } else if (chance < 0.4 && b->live[i]) {
                ll_aabb *box = &b->boxes[i];
                double dx = step * (ll_rng_unit(3, round, (uint64_t)i) - 0.5), dy = step * (chance - 0.2);
                *box =
                    (ll_aabb){{box->lower.x + dx, box->lower.y + dy}, {box->upper.x + dx, box->upper.y + dy}};
                for (int k = 0; k < LL_BROADS; k++)
                    ll_broad_phases[k]->move(b->state[k], b->boxes, i);
                touch(b, i);
            }
        }
        compare(b);
    }
    for (int k = 0; k < LL_BROADS; k++)
        free(b->state[k]);
    free(b);
}

static void equal_sizes(void **state)
{
    (void)state;
    run(40, 0, 1);
}

static void many_sizes(void **state)
{
    (void)state;
    run(200, 60, 5);
}

static void piled_up(void **state)
{
    (void)state;
    run(3, 0.1, 0.3);
}

static void far_apart(void **state)
{
    (void)state;
    run(1e8, 2e6, 1e6);
}

static void too_many_pairs_are_told(void **state)
{
    (void)state;
    ll_aabb boxes[3] = {{{0, 0}, {1, 1}}, {{0, 0}, {1, 1}}, {{0, 0}, {1, 1}}};
    uint8_t moved[3] = {1, 1, 1};
    int32_t list[3] = {0, 1, 2};
    for (int k = 0; k < LL_BROADS; k++) {
        void *s = malloc(ll_broad_phases[k]->size(3));
        ll_proxy_pair room[2];
        ll_pair_list out = {.at = room, .capacity = 2};
        ll_broad_phases[k]->init(s, 3);
        for (int32_t i = 0; i < 3; i++)
            ll_broad_phases[k]->insert(s, boxes, i);
        ll_broad_pairs(ll_broad_phases[k], s, boxes, moved, list, 3, &out);
        assert_true(out.overflowed);
        free(s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_sizes),
        cmocka_unit_test(many_sizes),
        cmocka_unit_test(piled_up),
        cmocka_unit_test(far_apart),
        cmocka_unit_test(too_many_pairs_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
