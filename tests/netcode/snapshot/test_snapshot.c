/* Codecs: encodings written by hand, round trips, and errors. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "netcode/snapshot/replica.h"
#include "netcode/snapshot/snapshot.h"
#include "support/near.h"

#define ENTITIES 40
#define TAIL 24
#define BYTES 8192

static const ll_quantization usual = {0.002f, 0.02f, 0.005f, 0.05f};

static ll_world *empty(int players, int entities, int tail)
{
    ll_world *p = calloc(1, ll_extent_size((ll_extent){entities, tail}));
    assert_non_null(p);
    p->players = players;
    p->entities = entities;
    p->tail = tail;
    return p;
}

static void cells_of(const ll_world *p, const ll_quantization *grid, ll_cell *cells)
{
    for (int i = 0; i < p->entities; i++)
        cells[i] = ll_cell_of(&p->entity[i], grid);
}

/* Encodes `now` for `self`, against `before` if given. Returns the bits. */
static int64_t encode(const ll_codec *codec, const ll_world *now, const ll_world *before,
                      const ll_quantization *grid, int self, uint8_t *bytes, ll_snapshot_cost *cost)
{
    static ll_cell cells[ENTITIES], baseline[ENTITIES];
    ll_bit_writer w = {.bytes = bytes, .capacity = 8 * BYTES};
    cells_of(now, grid, cells);
    if (before)
        cells_of(before, grid, baseline);
    ll_outgoing out = {.world = now, .self = self, .grid = grid, .cells = cells};
    out.baseline = before ? baseline : NULL;
    out.same_tail =
        before && memcmp(ll_world_tail_const(now), ll_world_tail_const(before), (size_t)now->tail) == 0;
    if (codec->selects) { /* to a client that holds nothing */
        out.replicas = calloc(1, ll_replicas_size(1 + self, now->entities));
        ll_replicas_init(out.replicas, 1 + self, now->entities);
        out.replica = ll_replicas_of(out.replicas, self);
        out.tick = 1;
    }
    memset(bytes, 0xa5, BYTES);
    *cost = (ll_snapshot_cost){0};
    codec->encode(&w, &out, cost);
    free(out.replicas);
    return w.count;
}

static ll_status decode(const ll_codec *codec, const uint8_t *bytes, int64_t size, const ll_world *before,
                        ll_quantization grid, int self, ll_world *to)
{
    ll_bit_reader r = {.bytes = bytes, .size = 8 * size};
    ll_incoming in = {.world = to, .self = self, .grid = &grid, .baseline = before ? before : NULL};
    return codec->decode(&r, &in);
}

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

static void tables_agree(void **state)
{
    (void)state;
    int n = 0;
    for (; ll_codecs[n]; n++) {
        assert_int_equal(ll_codec_index(ll_codecs[n]), n);
        assert_ptr_equal(ll_codec_at(n), ll_codecs[n]);
        assert_true(ll_codecs[n]->gridded || !ll_codecs[n]->compares);
    }
    assert_null(ll_codec_at(n));
    assert_null(ll_codec_at(-1));
}

/* ---- by hand ---- */

#define WORD_0 "0"
#define NUMBER_0 "0000"
#define EXACT_1_5                                                                                            \
    "1" /* x is not 0: 1.5 = 0x3ff8000000000000, lowest bit first */                                         \
    "000000000000000000000000000000000000000000000000000"                                                    \
    "1"                                                                                                      \
    "1111111111"                                                                                             \
    "00"                                                                                                     \
    "0"                                                                                                      \
    "0"                                                                                                      \
    "0"                                                                                                      \
    "0"                                                                                                      \
    "0"                                                                                                      \
    "0000" /* y, vx, vy, angle, spin, flags */

/* Three entities, the first the receiver's own; one at rest, one in motion. */
static ll_world *by_hand(void)
{
    ll_world *p = empty(1, 3, 8);
    p->entity[0] = (ll_entity){.x = 1.5};
    p->entity[1] = (ll_entity){.x = 1.4, .y = -0.6}; /* 3 and -1 steps of 0.5 m */
    p->entity[2] = (ll_entity){
        .x = 100, .vx = 0.25, .vy = -0.5, .angle = 1.2, .angular_velocity = 2, .flags = LL_ENTITY_ACTIVE};
    *(uint64_t *)ll_world_tail(p) = 7;
    return p;
}

static const ll_quantization coarse = {0.5f, 0.25f, 1, 2};

static void check_bits(const uint8_t *bytes, int64_t count, const char *expected)
{
    assert_int_equal(count, strlen(expected));
    for (int64_t i = 0; i < count; i++)
        if ((bytes[i >> 3] >> (i & 7) & 1) != expected[i] - '0')
            fail_msg("bit %lld is not %c", (long long)i, expected[i]);
    for (int64_t i = count; i & 7; i++)
        assert_int_equal(bytes[i >> 3] >> (i & 7) & 1, 0);
}

static void quantised_by_hand(void **state)
{
    (void)state;
    uint8_t bytes[BYTES];
    ll_snapshot_cost cost;
    ll_world *p = by_hand();
    int64_t count = encode(&ll_codec_quantised, p, NULL, &coarse, 0, bytes, &cost);
    check_bits(bytes, count,
               "00000000000000000000000011111100" /* 0.5f = 0x3f000000 */
               "00000000000000000000000101111100" /* 0.25f = 0x3e800000 */
               "00000000000000000000000111111100" /* 1.0f = 0x3f800000 */
               "00000000000000000000000000000010" /* 2.0f = 0x40000000 */
               EXACT_1_5                          /* own */
               "0"                                /* on the grid */
               "0110"
               "1000"
               "0000"
               "1"
               "0" /* x 3 -> 6, y -1 -> 1, angle 0, at rest, no flags */
               "0"
               "0001"
               "0101"
               "0110"
               "0000"
               "0100" /* x 200 -> 400 = 6 2 0 in octal, y, angle 1 -> 2 */
               "0"
               "0100"
               "1100"
               "0100" /* vx 1 -> 2, vy -2 -> 3, spin 1 -> 2 */
               "1"
               "0001"
               "0100" /* flags 16 = 2 0 in octal */
               "1"
               "1110000000000000"
               "0000000000000000"
               "0000000000000000"
               "0000000000000000");
    assert_int_equal(cost.entities, 3);
    assert_int_equal(cost.entity_bits, 74 + 15 + 43);
    assert_int_equal(cost.tail_bits, 65);
    assert_int_equal(cost.resting, 1);
    assert_int_equal(cost.unchanged, 0);
    free(p);
}

static void delta_by_hand(void **state)
{
    (void)state;
    uint8_t bytes[BYTES];
    ll_snapshot_cost cost;
    ll_world *before = by_hand(), *now = by_hand();
    before->entity[2].x = 99.5;
    now->entity[1].x = 1.3; /* the same step */
    int64_t count = encode(&ll_codec_delta, now, before, &coarse, 0, bytes, &cost);
    check_bits(bytes, count,
               EXACT_1_5 "0100" /* two are skipped: entity 2 */
                         "0"    /* on the grid */
                         "0100"
                         "0000"
                         "0000" /* one step in x */
                         "0"    /* not at rest */
                         "0000"
                         "0000"
                         "0000"
                         "0"    /* its velocities and flags are unchanged */
                         "0000" /* none is left to skip: the end */
                         "1");  /* the tail is unchanged */
    assert_int_equal(cost.unchanged, 1);
    assert_int_equal(cost.tail_bits, 1);
    *(uint64_t *)ll_world_tail(now) = 8;
    assert_int_equal(encode(&ll_codec_delta, now, before, &coarse, 0, bytes, &cost), count + 65);
    assert_int_equal(cost.tail_bits, 66);
    free(before);
    free(now);
}

/* "At rest, everything": a world in which nothing happens is sent as the own entity and a few bits. */
static void nothing_new_is_nearly_nothing(void **state)
{
    (void)state;
    uint8_t bytes[BYTES];
    ll_snapshot_cost cost;
    ll_world *p = empty(1, ENTITIES, TAIL);
    for (int i = 0; i < ENTITIES; i++)
        p->entity[i] = (ll_entity){.x = i, .y = -i, .angle = 0.1 * i};
    /* own: six words that are 0 but x (entity 39), y and angle; flags; 39 to skip; the tail */
    assert_int_equal(encode(&ll_codec_delta, p, p, &usual, ENTITIES - 1, bytes, &cost),
                     6 + 3 * 64 + 4 + 8 + 1);
    assert_int_equal(cost.unchanged, ENTITIES - 1);
    assert_int_equal(cost.resting, ENTITIES - 1);
    free(p);
}

/* ---- round trips ---- */

static double unit(uint64_t stream, uint64_t counter)
{
    return 2 * ll_rng_unit(99, stream, counter) - 1;
}

/* A world of all kinds: at rest, far, off the grid, with odd bits. */
static ll_world *random_world(uint64_t seed)
{
    ll_world *p = empty(4, ENTITIES, TAIL);
    for (int i = 0; i < ENTITIES; i++) {
        ll_entity *e = &p->entity[i];
        uint64_t k = seed * 64 + (uint64_t)i;
        double reach = i % 5 == 4 ? 1e6 : 50;
        *e = (ll_entity){.x = reach * unit(1, k), .y = reach * unit(2, k), .angle = 9 * unit(3, k)};
        e->flags = i % 3 ? 0 : ll_rng_u64(99, 4, k) >> (i * 3 % 64);
        if (i % 4 != 0) {
            e->vx = 30 * unit(5, k);
            e->vy = i % 7 ? 3 * unit(6, k) : -0.0;
            e->angular_velocity = 10 * unit(7, k);
        }
        if (i == 9)
            e->y = -1e9; /* off the grid */
    }
    for (int i = 0; i < TAIL / 8; i++)
        ((uint64_t *)ll_world_tail(p))[i] = seed % 3 ? 0 : ll_rng_u64(99, 8, seed);
    return p;
}

/* Moves some of a world's entities. */
static ll_world *moved(const ll_world *from, uint64_t seed)
{
    ll_world *p = empty(4, ENTITIES, TAIL);
    memcpy(p, from, ll_world_size(from));
    for (int i = 0; i < ENTITIES; i++)
        if (unit(9, seed * 64 + (uint64_t)i) < 0) {
            p->entity[i].x += 0.1 * unit(10, seed);
            p->entity[i].vy += 0.01;
        }
    if (seed % 2)
        ((uint64_t *)ll_world_tail(p))[1]++;
    return p;
}

static void check_member(double got, double true_value, float step)
{
    /* half a step, and the rounding of a product and a quotient */
    assert_near(got, true_value, 0.5 * (double)step + 4e-16 * fabs(true_value));
}

static void check_world(const ll_world *got, const ll_world *real, const ll_quantization *grid, int self)
{
    assert_memory_equal(got, real, sizeof(ll_world));
    for (int i = 0; i < real->entities; i++) {
        const ll_entity *e = &got->entity[i], *t = &real->entity[i];
        ll_cell cell = ll_cell_of(t, grid);
        if (i == self || !ll_cell_fits(&cell)) {
            assert_memory_equal(e, t, sizeof *e);
            continue;
        }
        check_member(e->x, t->x, grid->m);
        check_member(e->y, t->y, grid->m);
        check_member(e->vx, t->vx, grid->mps);
        check_member(e->vy, t->vy, grid->mps);
        check_member(e->angle, t->angle, grid->rad);
        check_member(e->angular_velocity, t->angular_velocity, grid->radps);
        assert_true(e->flags == t->flags);
        ll_entity same = ll_cell_entity(&cell, grid);
        assert_memory_equal(e, &same, sizeof same); /* the value that the server reports as sent */
    }
    assert_memory_equal(ll_world_tail_const(got), ll_world_tail_const(real), TAIL);
}

static void full_round_trip_is_exact(void **state)
{
    (void)state;
    uint8_t bytes[BYTES];
    ll_snapshot_cost cost;
    for (uint64_t seed = 1; seed <= 20; seed++) {
        ll_world *p = random_world(seed), *got = empty(4, ENTITIES, TAIL);
        int64_t count = encode(&ll_codec_full, p, NULL, &usual, 1, bytes, &cost);
        assert_int_equal(count, 8 * ll_world_size(p));
        assert_memory_equal(bytes, p, count / 8);
        must(decode(&ll_codec_full, bytes, count / 8, NULL, usual, 1, got));
        assert_memory_equal(got, p, ll_world_size(p));
        assert_int_equal(cost.entity_bits, 448 * ENTITIES);
        free(p);
        free(got);
    }
}

static const ll_quantization grids[] = {{0.002f, 0.02f, 0.005f, 0.05f},
                                        {1, 1, 1, 1},
                                        {10, 10, 1, 10},
                                        {0.001f, 0.0001f, 0.0001f, 0.0001f},
                                        {0.0625f, 3, 0.3f, 7}};

static void quantised_round_trip_is_within_half_a_step(void **state)
{
    (void)state;
    uint8_t bytes[BYTES];
    ll_snapshot_cost cost;
    for (size_t g = 0; g < sizeof grids / sizeof grids[0]; g++)
        for (uint64_t seed = 1; seed <= 20; seed++) {
            ll_world *p = random_world(seed), *got = empty(4, ENTITIES, TAIL);
            int self = (int)(seed % 4);
            int64_t count = encode(&ll_codec_quantised, p, NULL, &grids[g], self, bytes, &cost);
            assert_true(count < 8 * (int64_t)ll_world_size(p));
            must(decode(&ll_codec_quantised, bytes, (count + 7) / 8, NULL, (ll_quantization){0}, self, got));
            check_world(got, p, &grids[g], self);
            free(p);
            free(got);
        }
}

/* The client's baseline is the world that it decoded, not the server's: the result is bitwise equal. */
static void delta_against_the_decoded_world_equals_the_sent_one(void **state)
{
    (void)state;
    uint8_t bytes[BYTES];
    ll_snapshot_cost cost;
    for (size_t g = 0; g < sizeof grids / sizeof grids[0]; g++) {
        ll_world *sent = random_world(g), *held = empty(4, ENTITIES, TAIL);
        int self = (int)(g % 4);
        int64_t count = encode(&ll_codec_quantised, sent, NULL, &grids[g], self, bytes, &cost);
        must(decode(&ll_codec_quantised, bytes, (count + 7) / 8, NULL, (ll_quantization){0}, self, held));
        for (uint64_t k = 1; k <= 50; k++) {
            ll_world *next = k % 10 ? moved(sent, k) : random_world(k), *got = empty(4, ENTITIES, TAIL);
            count = encode(&ll_codec_delta, next, sent, &grids[g], self, bytes, &cost);
            must(decode(&ll_codec_delta, bytes, (count + 7) / 8, held, grids[g], self, got));
            check_world(got, next, &grids[g], self);
            free(sent);
            free(held);
            sent = next;
            held = got;
        }
        free(sent);
        free(held);
    }
}

/* A value on the grid is its own rounding, for any step and distance. */
static void rounding_twice_is_rounding_once(void **state)
{
    (void)state;
    for (size_t g = 0; g < sizeof grids / sizeof grids[0]; g++)
        for (uint64_t k = 0; k < 20000; k++) {
            int32_t n = (int32_t)(ll_rng_u64(5, g, k) >> (32 + k % 32)) * (k & 1 ? 1 : -1);
            if (n == INT32_MIN || n == INT32_MAX)
                continue;
            ll_cell cell = {
                .x = n, .y = -n, .vx = n, .vy = -n, .angle = n, .angular_velocity = -n, .flags = k};
            ll_entity e = ll_cell_entity(&cell, &grids[g]);
            ll_cell again = ll_cell_of(&e, &grids[g]);
            assert_memory_equal(&again, &cell, sizeof cell);
        }
}

static void off_grid_entities_are_reported(void **state)
{
    (void)state;
    const double bad[] = {INFINITY, -INFINITY, NAN, 2147483647.0 * 0.5, -2147483647.0 * 0.5, 1e300};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        ll_entity e = {.x = 1, .angular_velocity = bad[i]};
        ll_cell cell = ll_cell_of(&e, &(ll_quantization){0.5f, 0.5f, 0.5f, 0.5f});
        assert_false(ll_cell_fits(&cell));
    }
    ll_entity last = {.x = 2147483646.0 * 0.5};
    ll_cell cell = ll_cell_of(&last, &(ll_quantization){0.5f, 1, 1, 1});
    assert_int_equal(cell.x, INT32_MAX - 1);
}

/* ---- errors ---- */

static void refused(const ll_codec *codec, const uint8_t *bytes, int64_t size, const ll_world *before,
                    int self, const char *why)
{
    ll_world *to = empty(4, ENTITIES, TAIL);
    /* exact size, so that the address sanitizer sees a read past its end */
    uint8_t *copy = malloc((size_t)(size > 0 ? size : 1));
    memcpy(copy, bytes, (size_t)size);
    ll_status status = decode(codec, copy, size, before, usual, self, to);
    free(copy);
    free(to);
    assert_true(ll_failed(&status));
    if (!strstr(status.text, why))
        fail_msg("\"%s\" does not say \"%s\"", status.text, why);
}

static void truncated_or_too_long_snapshots_are_rejected(void **state)
{
    (void)state;
    uint8_t bytes[BYTES];
    ll_snapshot_cost cost;
    ll_world *before = random_world(3), *now = moved(before, 5);
    for (int k = 0; ll_codecs[k]; k++) {
        const ll_codec *codec = ll_codecs[k];
        const ll_world *from = codec->compares ? before : NULL;
        int64_t size = (encode(codec, now, from, &usual, 2, bytes, &cost) + 7) / 8;
        for (int64_t n = 0; n < size; n++)
            refused(codec, bytes, n, from, 2, codec->gridded ? "" : "must have");
        bytes[size] = 0;
        refused(codec, bytes, size + 1, from, 2, codec->gridded ? "must end where" : "must have");
    }
    free(before);
    free(now);
}

static void another_world_is_refused(void **state)
{
    (void)state;
    uint8_t bytes[BYTES];
    ll_snapshot_cost cost;
    ll_world *p = random_world(1);
    for (int field = 0; field < 4; field++) {
        int64_t size = encode(&ll_codec_full, p, NULL, &usual, 0, bytes, &cost) / 8;
        bytes[4 * field]++;
        refused(&ll_codec_full, bytes, size, NULL, 0, "4 players, 40 entities and a tail of 24 bytes");
    }
    p->entity[7].vy = NAN;
    int64_t size = encode(&ll_codec_full, p, NULL, &usual, 0, bytes, &cost) / 8;
    refused(&ll_codec_full, bytes, size, NULL, 0, "entity 7 has one that is not");
    size = (encode(&ll_codec_quantised, p, NULL, &usual, 0, bytes, &cost) + 7) / 8;
    refused(&ll_codec_quantised, bytes, size, NULL, 0, "entity 7 has one that is not");
    free(p);
}

static void impossible_grids_are_refused(void **state)
{
    (void)state;
    uint8_t bytes[BYTES];
    ll_snapshot_cost cost;
    ll_world *p = random_world(1);
    const float steps[] = {0, -0.002f, 1e-7f, 1e7f, NAN, INFINITY};
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; i++)
        for (size_t k = 0; k < 4; k++) {
            int64_t size = (encode(&ll_codec_quantised, p, NULL, &usual, 0, bytes, &cost) + 7) / 8;
            memcpy(bytes + 4 * k, &steps[i], 4);
            refused(&ll_codec_quantised, bytes, size, NULL, 0, "a step of a grid must be 1e-06 to");
        }
    free(p);
}

static void impossible_differences_are_refused(void **state)
{
    (void)state;
    uint8_t bytes[64];
    ll_world *before = empty(4, ENTITIES, TAIL);
    before->entity[0].x = 2147483645.0 * (double)usual.m;
    const struct {
        int self, gap;
        int64_t difference;
        const char *why;
    } cases[] = {{5, 41, 0, "at most 40 entities can be skipped after 0 of 40; got 41"},
                 {5, 5, 0, "own entity, 5, is sent twice"},
                 {5, 0, 3, "less than 2^31 steps"},
                 {5, 0, INT64_MAX, "less than 2^31 steps"},
                 {5, 1, INT64_MIN, "less than 2^31 steps"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const ll_entity nothing = {0};
        ll_bit_writer w = {.bytes = bytes, .capacity = 8 * sizeof bytes};
        ll_put_exact(&w, &nothing);
        ll_bits_put_number(&w, (uint64_t)cases[i].gap);
        ll_bits_put(&w, 0, 1);
        ll_bits_put_signed(&w, cases[i].difference);
        for (int k = 0; k < 20; k++)
            ll_bits_put(&w, 0, 16);
        refused(&ll_codec_delta, bytes, w.count / 8, before, cases[i].self, cases[i].why);
    }
    /* Behind an entity fewer are left. */
    const ll_entity nothing = {0};
    ll_bit_writer w = {.bytes = bytes, .capacity = 8 * sizeof bytes};
    ll_put_exact(&w, &nothing);
    ll_bits_put_number(&w, 6);
    ll_bits_put(&w, 1, 1);
    ll_put_exact(&w, &nothing);
    ll_bits_put_number(&w, 34);
    refused(&ll_codec_delta, bytes, (w.count + 7) / 8, before, 5,
            "at most 33 entities can be skipped after 7 of 40; got 34");
    free(before);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_agree),
        cmocka_unit_test(quantised_by_hand),
        cmocka_unit_test(delta_by_hand),
        cmocka_unit_test(nothing_new_is_nearly_nothing),
        cmocka_unit_test(full_round_trip_is_exact),
        cmocka_unit_test(quantised_round_trip_is_within_half_a_step),
        cmocka_unit_test(delta_against_the_decoded_world_equals_the_sent_one),
        cmocka_unit_test(rounding_twice_is_rounding_once),
        cmocka_unit_test(off_grid_entities_are_reported),
        cmocka_unit_test(truncated_or_too_long_snapshots_are_rejected),
        cmocka_unit_test(another_world_is_refused),
        cmocka_unit_test(impossible_grids_are_refused),
        cmocka_unit_test(impossible_differences_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
