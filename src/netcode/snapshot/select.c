#include "netcode/snapshot/select.h"

#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"
#include "netcode/snapshot/priority.h"

double ll_select_priority(const ll_selection *selection, double distance_m)
{
    double near_m = selection->radius_m / 4;
    return near_m == 0 || distance_m <= near_m ? 1 : near_m / distance_m;
}

static int index_bits(int entities)
{
    int bits = 1;
    while (entities > 1 << bits)
        bits++;
    return bits;
}

/* ---- which ---- */

static bool same_cell(const ll_cell *a, const ll_cell *b)
{
    return ll_cell_fits(a) && memcmp(a, b, sizeof *a) == 0;
}

/* Whether the client lacks the present state, unless something in flight is lost. */
static bool lacks(const ll_replica_entity *e, const ll_cell *now, bool gone)
{
    if (e->has_sent)
        return gone != e->sent_gone || (!gone && !same_cell(now, &e->sent));
    if (e->has_acked)
        return gone != e->acked_gone || (!gone && !same_cell(now, &e->acked));
    return true;
}

static double priority_of(const ll_outgoing *out, int entity)
{
    const ll_entity *own = &out->world->entity[out->self], *e = &out->world->entity[entity];
    double dx = e->x - own->x, dy = e->y - own->y;
    return ll_select_priority(&out->replicas->selection, ll_sqrt(dx * dx + dy * dy));
}

/* Adds the priorities of all that must be sent, and lists these. */
static int accumulate(const ll_outgoing *out, ll_candidate *list)
{
    ll_replica *r = out->replica;
    ll_entity_bits either;
    ll_entity_list all;
    int count = 0;
    for (int word = 0; word < LL_ENTITY_WORDS; word++)
        either[word] = r->scope[word] | r->known[word];
    ll_entity_list_of(&all, either);
    for (int k = 0; k < all.count; k++) {
        const int i = all.entity[k];
        ll_replica_entity *e = &r->entity[i];
        const bool gone = !ll_entity_bits_have(r->scope, i);
        ll_fetch(&r->entity[all.entity[k + LL_FETCH_AHEAD]], sizeof *e);
        if (i == out->self || !lacks(e, &out->cells[i], gone)) {
            e->accumulated = 0;
            continue;
        }
        e->accumulated += priority_of(out, i);
        list[count++] =
            (ll_candidate){e->accumulated, i, ll_candidate_turn(i, r->first, out->world->entities)};
    }
    return count;
}

/* ---- one entity ---- */

/* Writes entity `i`. `age`: of the state that the entity before it was compared with; 0: of none yet. */
static void put_entity(ll_bit_writer *w, const ll_outgoing *out, int i, bool deltas, int64_t *age)
{
    const ll_replica_entity *e = &out->replica->entity[i];
    const ll_cell *c = &out->cells[i], zero = {0};
    const bool gone = !(out->replica->scope[i >> 6] >> (i & 63) & 1);
    ll_bits_put(w, 1, 1);
    ll_bits_put(w, (uint64_t)i, index_bits(out->world->entities));
    ll_bits_put(w, gone, 1);
    if (gone)
        return;
    ll_bits_put(w, !ll_cell_fits(c), 1);
    if (!ll_cell_fits(c)) {
        ll_put_exact(w, &out->world->entity[i]);
        return;
    }
    const bool compares = deltas && e->has_acked && !e->acked_gone && ll_cell_fits(&e->acked) &&
                          out->replicas->update - e->acked_update <= LL_DELTA_UPDATES;
    ll_bits_put(w, compares, 1);
    if (compares) {
        const bool same = *age == out->tick - e->acked_tick;
        ll_bits_put(w, same, 1);
        *age = out->tick - e->acked_tick;
        if (!same)
            ll_bits_put_number(w, (uint64_t)*age);
    }
    ll_put_cell(w, c, compares ? &e->acked : &zero);
}

static void note_sent(const ll_outgoing *out, int i, ll_sent_snapshot *record)
{
    ll_replica *r = out->replica;
    ll_replica_entity *e = &r->entity[i];
    const bool gone = !(r->scope[i >> 6] >> (i & 63) & 1);
    record->entity[record->count] = (uint16_t)i;
    record->gone[record->count] = gone;
    record->accumulated[record->count++] = e->accumulated;
    if (r->counts_now && e->sent_tick > 0 && !gone && !e->sent_gone) {
        double ticks = (double)(out->tick - e->sent_tick);
        r->counts.intervals++;
        r->counts.interval_ticks += ticks;
        if (ticks > r->counts.interval_ticks_max)
            r->counts.interval_ticks_max = ticks;
    }
    e->accumulated = 0;
    e->sent = out->cells[i];
    e->sent_gone = gone;
    e->has_sent = 1;
    e->sent_tick = out->tick;
    if (!gone)
        r->known[i >> 6] |= UINT64_C(1) << (i & 63);
}

/* ---- a snapshot ---- */

static int set_bits(const uint64_t *words)
{
    int count = 0;
    for (int i = 0; i < LL_ENTITY_WORDS; i++)
        count += __builtin_popcountll(words[i]);
    return count;
}

/* Where entities end. The limit is for a world without the game's tail, of which `tail` bits are written. */
static int64_t limit_of(const ll_bit_writer *w, const ll_outgoing *out, int64_t tail)
{
    const int64_t bytes = out->replicas->selection.bytes, room = w->capacity - 1; /* without the last bit */
    const int64_t limit = bytes * 8 - 1 + tail;
    return bytes == 0 || limit > room ? room : limit;
}

static void put_selected(ll_bit_writer *w, const ll_outgoing *out, ll_selection_rule rule, int64_t tail,
                         ll_snapshot_cost *cost)
{
    ll_candidate list[LL_ENTITIES_MAX];
    ll_replica_counts *counts = &out->replica->counts;
    ll_sent_snapshot *record = ll_replica_record(out->replica, out->replicas);
    if (!record) {
        ll_bits_put(w, 0, 1);
        return;
    }
    int count = accumulate(out, list);
    int64_t limit = limit_of(w, out, tail), age = 0;
    ll_candidates_order(list, count);
    while (count > 0 && record->count < LL_SENT_ENTITIES) {
        const int64_t start = w->count, before = age;
        ll_candidate next = ll_candidates_take(list, &count);
        put_entity(w, out, next.entity, rule.deltas, &age);
        if (w->count > limit) {
            w->count = start;
            age = before;
            count++;
            break;
        }
        note_sent(out, next.entity, record);
        out->replica->first = (uint16_t)(next.entity + 1);
        cost->resting += ll_cell_fits(&out->cells[next.entity]) && ll_cell_rests(&out->cells[next.entity]);
    }
    ll_bits_put(w, 0, 1);
    cost->entities += record->count + 1;
    if (!out->counts)
        return;
    counts->snapshots++;
    counts->choked += count > 0;
    counts->in_scope += set_bits(out->replica->scope);
}

void ll_select_encode(ll_bit_writer *w, const ll_outgoing *out, ll_selection_rule rule,
                      ll_snapshot_cost *cost)
{
    LL_ASSERT(out->replica && out->replicas);
    out->replica->counts_now = out->counts;
    ll_replicas_begin(out->replicas, out->world, out->tick);
    ll_replicas_find_scope(out->replicas, out->replica, out->world, out->self, rule.interest);
    int64_t start = w->count;
    ll_put_exact(w, &out->world->entity[out->self]);
    cost->entity_bits += w->count - start;
    ll_bits_put(w, !out->baseline, 1);
    if (!out->baseline)
        ll_put_grid(w, out->grid);
    start = w->count;
    ll_bits_put(w, out->same_tail, 1);
    if (!out->same_tail)
        ll_put_tail(w, out->world);
    cost->tail_bits += w->count - start;
    const int64_t tail = w->count - start - 1;
    start = w->count;
    put_selected(w, out, rule, tail, cost);
    cost->entity_bits += w->count - start;
}

/* ---- at the client ---- */

/* The state that the entity before was compared with. */
typedef struct compared {
    int64_t age;           /* 0: of none yet */
    const ll_world *world; /* NULL: not looked up yet */
} compared;

/* Where the new state of an entity goes. `keeps`: only some of its members will be set. */
static ll_entity *place_of(const ll_incoming *in, int i, bool keeps)
{
    ll_changed *changed = in->changed;
    const uint64_t bit = UINT64_C(1) << (i & 63);
    if (changed && !(changed->has[i >> 6] & bit)) {
        changed->has[i >> 6] |= bit;
        changed->entity[changed->count++] = (uint16_t)i;
        if (keeps)
            in->world->entity[i] = in->previous->entity[i];
    }
    return &in->world->entity[i];
}

static ll_status get_state(ll_bit_reader *r, const ll_incoming *in, int i, compared *last)
{
    const ll_cell zero = {0};
    ll_cell from = zero, cell;
    if (ll_bits_get(r, 1)) {
        ll_get_exact(r, place_of(in, i, false));
        return ll_ok();
    }
    if (ll_bits_get(r, 1)) {
        if (!ll_bits_get(r, 1))
            *last = (compared){.age = (int64_t)(ll_bits_get_number(r) & INT32_MAX)};
        if (!last->world && in->world_at)
            last->world = in->world_at(in->context, in->tick - last->age);
        if (!last->world)
            return ll_error(LL_NOT_FOUND, "entity %d: its state of tick %lld is missing", i,
                            (long long)(in->tick - last->age));
        from = ll_cell_of(&last->world->entity[i], in->grid);
        if (!ll_cell_fits(&from))
            return ll_off_grid(i);
    }
    if (!ll_get_cell(r, &from, &cell))
        return ll_off_grid(i);
    *place_of(in, i, false) = ll_cell_entity(&cell, in->grid);
    return ll_ok();
}

static ll_status get_selected(ll_bit_reader *r, const ll_incoming *in)
{
    const int bits = index_bits(in->world->entities);
    compared last = {0, NULL};
    while (ll_bits_get(r, 1)) {
        const int i = (int)ll_bits_get(r, bits);
        if (i >= in->world->entities || i == in->self)
            return ll_error(LL_BAD_INPUT, "an entity of a snapshot must be 0 to %d and not %d; got %d",
                            in->world->entities - 1, in->self, i);
        if (ll_bits_get(r, 1))
            place_of(in, i, true)->flags = LL_ENTITY_UNKNOWN;
        else
            LL_TRY(get_state(r, in, i, &last));
    }
    return ll_ok();
}

/* The world before the snapshot: nothing is known yet, or what was known last. */
static void begin_world(const ll_incoming *in)
{
    if (in->changed) {
        LL_ASSERT(in->previous);
        in->changed->count = 0;
        memset(in->changed->has, 0, sizeof in->changed->has);
        return;
    }
    if (in->previous) {
        memcpy(in->world->entity, in->previous->entity, (size_t)in->world->entities * sizeof(ll_entity));
        return;
    }
    memset(in->world->entity, 0, (size_t)in->world->entities * sizeof(ll_entity));
    for (int i = 0; i < in->world->entities; i++)
        in->world->entity[i].flags = LL_ENTITY_UNKNOWN;
}

ll_status ll_select_decode(ll_bit_reader *r, const ll_incoming *in)
{
    begin_world(in);
    ll_get_exact(r, place_of(in, in->self, false));
    if (ll_bits_get(r, 1))
        LL_TRY(ll_get_grid(r, in->grid));
    if (!ll_bits_get(r, 1))
        ll_get_tail(r, in->world);
    else if (in->baseline)
        memcpy(ll_world_tail(in->world), ll_world_tail_const(in->baseline), (size_t)in->world->tail);
    else
        return ll_error(LL_NOT_FOUND, "the baseline of the game's own state is missing");
    LL_TRY(get_selected(r, in));
    return in->changed ? ll_decoded_some(r, in->world, in->changed) : ll_decoded(r, in->world);
}

/* ---- codecs ---- */

/* Partial: on the grid, and of the changed entities those of the largest accumulated priority that fit
 * snapshot_bytes, each whole (Fiedler, "State Synchronization"). */
static void encode_partial(ll_bit_writer *w, const ll_outgoing *out, ll_snapshot_cost *cost)
{
    ll_select_encode(w, out, (ll_selection_rule){.deltas = false}, cost);
}

/* Partial delta: as partial, and of each entity only the differences from the newest state of it that the
 * client has acknowledged (Tribes; Unreal). Snapshots of different entities need no common baseline. */
static void encode_partial_delta(ll_bit_writer *w, const ll_outgoing *out, ll_snapshot_cost *cost)
{
    ll_select_encode(w, out, (ll_selection_rule){.deltas = true}, cost);
}

/* Interest: as partial_delta, of the entities in the receiver's area of interest alone. An entity that leaves
 * the area is sent once more, as gone. At equal density the bytes of a client do not depend on the number of
 * entities. */
static void encode_interest(ll_bit_writer *w, const ll_outgoing *out, ll_snapshot_cost *cost)
{
    ll_select_encode(w, out, (ll_selection_rule){.deltas = true, .interest = true}, cost);
}

#define ROW(name_)                                                                                           \
    const ll_codec ll_codec_##name_ = {.name = #name_,                                                       \
                                       .gridded = true,                                                      \
                                       .selects = true,                                                      \
                                       .encode = encode_##name_,                                             \
                                       .decode = ll_select_decode};
ROW(partial)
ROW(partial_delta)
ROW(interest)
