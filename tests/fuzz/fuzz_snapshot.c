/* Any snapshot: refused with a message, or a world of finite numbers, whose own snapshot decodes to the same
 * bits. The first bytes select codec, receiver and number of entities. */
#include "check.h"

#include "netcode/snapshot/snapshot.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { HEAD = 3, ENTITIES = 16, TAIL = 16, BYTES = 4096 };

static ll_world *new_world(int entities)
{
    ll_world *world = calloc(1, ll_extent_size((ll_extent){entities, TAIL}));
    FUZZ_CHECK(world != NULL);
    world->players = 1;
    world->entities = entities;
    world->tail = TAIL;
    return world;
}

/* The baseline that the client has. */
static ll_world *new_baseline(int entities)
{
    ll_world *world = new_world(entities);
    for (int i = 0; i < entities; i++)
        world->entity[i] = (ll_entity){.x = i == 3 ? 1e15 : 2 * i, .vy = i % 2, .flags = (uint64_t)i};
    return world;
}

static size_t encode(const ll_codec *codec, const ll_world *world, const ll_world *baseline, int self,
                     const ll_quantization *grid, uint8_t *bytes)
{
    ll_cell cells[ENTITIES], before[ENTITIES];
    for (int i = 0; i < world->entities; i++) {
        cells[i] = ll_cell_of(&world->entity[i], grid);
        before[i] = ll_cell_of(&baseline->entity[i], grid);
    }
    ll_bit_writer w = {.bytes = bytes, .capacity = 8 * BYTES};
    ll_outgoing out = {.world = world, .self = self, .grid = grid, .cells = cells, .baseline = before};
    ll_snapshot_cost cost = {0};
    codec->encode(&w, &out, &cost);
    FUZZ_CHECK(w.count <= w.capacity);
    return (size_t)(w.count + 7) / 8;
}

static const ll_world *world_at(const void *context, int64_t tick)
{
    return tick > 5 ? context : NULL;
}

static bool decode(const ll_codec *codec, const uint8_t *bytes, size_t size, const ll_world *baseline,
                   int self, ll_quantization *grid, ll_world *world)
{
    ll_bit_reader r = {.bytes = bytes, .size = 8 * (int64_t)size};
    ll_incoming in = {
        .world = world, .self = self, .grid = grid, .baseline = codec->compares ? baseline : NULL};
    if (codec->selects) {
        in.previous = in.baseline = in.context = baseline;
        in.world_at = world_at;
        in.tick = 10;
    }
    ll_status status = codec->decode(&r, &in);
    return !fuzz_failed(&status);
}

static void is_a_world(const ll_world *world, int entities)
{
    FUZZ_CHECK(world->players == 1 && world->entities == entities && world->tail == TAIL);
    for (int i = 0; i < entities; i++) {
        const ll_entity *e = &world->entity[i];
        double sum = e->x + e->y + e->vx + e->vy + e->angle + e->angular_velocity;
        FUZZ_CHECK(sum - sum == 0);
    }
}

/* The snapshot of a decoded world decodes to the same bits. */
static void repeats_itself(const ll_codec *codec, const ll_world *first, ll_world *second,
                           const ll_world *baseline, int self, ll_quantization *grid)
{
    uint8_t once[BYTES], twice[BYTES];
    size_t length = encode(codec, first, baseline, self, grid, once);
    FUZZ_CHECK(decode(codec, once, length, baseline, self, grid, second));
    is_a_world(second, first->entities);
    FUZZ_CHECK(memcmp(&first->entity[self], &second->entity[self], sizeof(ll_entity)) == 0);
    FUZZ_CHECK(memcmp(ll_world_tail_const(first), ll_world_tail_const(second), TAIL) == 0);
    FUZZ_CHECK(encode(codec, second, baseline, self, grid, twice) == length);
    FUZZ_CHECK(memcmp(once, twice, length) == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < HEAD)
        return 0;
    const ll_codec *codec = ll_codec_at(data[0] % 6);
    int entities = 1 + data[1] % ENTITIES, self = data[2] % entities;
    ll_quantization grid = {0.002f, 0.02f, 0.005f, 0.05f};
    ll_world *baseline = new_baseline(entities), *first = new_world(entities), *second = new_world(entities);
    if (decode(codec, data + HEAD, size - HEAD, baseline, self, &grid, first)) {
        is_a_world(first, entities);
        if (!codec->selects) /* what those send depends on what was sent before */
            repeats_itself(codec, first, second, baseline, self, &grid);
    }
    free(baseline);
    free(first);
    free(second);
    return 0;
}
