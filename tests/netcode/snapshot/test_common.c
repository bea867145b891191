/* Snapshots that share what they have in common are those that are encoded whole, bit by bit. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "netcode/snapshot/common.h"

/* Draws in turn. */
typedef struct draws {
    uint64_t seed, count;
} draws;

static double unit(draws *r)
{
    return ll_rng_unit(r->seed, 0, r->count++);
}
static uint32_t below(draws *r, uint32_t n)
{
    return (uint32_t)(unit(r) * n);
}

enum { BASELINES = 20, MOST = 1000, TAIL = 24, BYTES = 1 << 17 };

static const ll_quantization grid = {0.002f, 0.02f, 0.005f, 0.05f};

typedef struct scene {
    ll_world *world;
    ll_cell cells[MOST];
    ll_cell baseline[BASELINES][MOST];
    ll_snapshot_common common;
} scene;

static double some(draws *r, double most)
{
    return most * (2 * unit(r) - 1);
}

/* Some rest, and some are too far away for the grid. */
static ll_entity entity(draws *r, double far)
{
    ll_entity e = {.x = some(r, 20), .y = some(r, 20), .angle = some(r, 3)};
    if (unit(r) < 0.6) {
        e.vx = some(r, 5);
        e.angular_velocity = some(r, 2);
    }
    if (unit(r) < far)
        e.y = 1e9 + some(r, 1e6);
    e.flags = unit(r) < 0.2;
    return e;
}

static scene *new_scene(draws *r, int entities, double far, double moved)
{
    scene *s = calloc(1, sizeof *s);
    assert_non_null(s);
    s->world = calloc(1, ll_extent_size((ll_extent){entities, TAIL}));
    assert_non_null(s->world);
    s->world->entities = entities;
    s->world->tail = TAIL;
    for (int i = 0; i < entities; i++) {
        s->world->entity[i] = entity(r, far);
        s->cells[i] = ll_cell_of(&s->world->entity[i], &grid);
    }
    for (int b = 0; b < BASELINES; b++)
        for (int i = 0; i < entities; i++) {
            ll_entity other = unit(r) < moved ? entity(r, far) : s->world->entity[i];
            s->baseline[b][i] = ll_cell_of(&other, &grid);
        }
    memset(ll_world_tail(s->world), 7, TAIL);
    return s;
}

static void destroy(scene *s)
{
    free(s->world);
    free(s);
}

static int64_t encode(const ll_codec *codec, ll_outgoing *out, ll_snapshot_common *common, int64_t capacity,
                      uint8_t *bytes, ll_snapshot_cost *cost)
{
    ll_bit_writer w = {.bytes = bytes, .capacity = capacity};
    memset(bytes, 0xa5, BYTES);
    *cost = (ll_snapshot_cost){0};
    out->common = common;
    codec->encode(&w, out, cost);
    return w.count;
}

/* Encodes `n` messages to receivers and for baselines in a random order, in both ways. */
static void compare(draws *r, scene *s, const ll_codec *codec, int receivers, int baselines, int n,
                    int64_t capacity)
{
    static uint8_t whole[BYTES], shared[BYTES];
    ll_snapshot_common_clear(&s->common);
    while (n-- > 0) {
        int b = (int)below(r, (uint32_t)baselines);
        ll_snapshot_cost cost[2];
        ll_outgoing out = {.world = s->world,
                           .self = (int)below(r, (uint32_t)receivers),
                           .receivers = receivers,
                           .grid = &grid,
                           .cells = s->cells,
                           .baseline = codec->compares ? s->baseline[b] : NULL,
                           .same_tail = codec->compares && b % 2 == 0};
        int64_t bits = encode(codec, &out, NULL, capacity, whole, &cost[0]);
        assert_int_equal(encode(codec, &out, &s->common, capacity, shared, &cost[1]), bits);
        if (bits <= capacity) /* otherwise it is not used */
            assert_memory_equal(whole, shared, (size_t)(bits + 7) / 8);
        assert_memory_equal(&cost[0], &cost[1], sizeof cost[0]);
    }
}

static void test_shared_is_whole(void **state)
{
    (void)state;
    draws r = {.seed = 18};
    const ll_codec *codecs[] = {&ll_codec_delta, &ll_codec_quantised};
    for (int round = 0; round < 200; round++) {
        int receivers = 1 + (int)below(&r, 9), entities = receivers + (int)below(&r, 60);
        const double moved[] = {0, 0.02, 0.5, 1};
        scene *s = new_scene(&r, entities, round % 3 == 0 ? 0.1 : 0, moved[round % 4]);
        int64_t capacity = round % 5 == 0 ? 8 * (int64_t)below(&r, 4096) : 8 * (int64_t)BYTES;
        for (int c = 0; c < 2; c++) {
            int baselines = codecs[c]->compares ? 1 + round % 5 : 1;
            compare(&r, s, codecs[c], receivers, baselines, 40, capacity);
            assert_in_range(s->common.count, 1, baselines); /* once for each baseline */
        }
        destroy(s);
    }
}

/* More baselines than parts, and parts that do not fit: those are encoded for each receiver. */
static void test_without_room(void **state)
{
    (void)state;
    draws r = {.seed = 19};
    scene *many = new_scene(&r, 50, 0, 0.5), *large = new_scene(&r, MOST, 1, 1);
    compare(&r, many, &ll_codec_delta, 4, BASELINES, 200, 8 * (int64_t)BYTES);
    assert_int_equal(many->common.count, LL_COMMON_PARTS);
    compare(&r, large, &ll_codec_delta, 4, 5, 40, 8 * (int64_t)BYTES);
    assert_in_range(large->common.count, 1, 4);
    destroy(many);
    destroy(large);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_shared_is_whole),
        cmocka_unit_test(test_without_room),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
