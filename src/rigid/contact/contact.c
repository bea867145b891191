#include <string.h>

#include "base/assert.h"
#include "base/mix.h"
#include "rigid/contact/contact.h"

/* ---- pair set: a hash table with linear probing, without tombstones ---- */

static inline uint32_t slot_of(const ll_rigid *w, int32_t a, int32_t b)
{
    uint64_t key = (uint64_t)(uint32_t)a << 32 | (uint32_t)b;
    key *= LL_MIX_STEP;
    return (uint32_t)((key ^ key >> 32) & (uint64_t)w->pair_set_mask);
}

bool ll_pair_exists(const ll_rigid *w, int32_t a, int32_t b)
{
    const ll_pair_entry *table = ll_pair_entries(w);
    for (uint32_t i = slot_of(w, a, b);; i = (i + 1) & (uint32_t)w->pair_set_mask) {
        if (table[i].a == LL_NONE)
            return false;
        if (table[i].a == a && table[i].b == b)
            return true;
    }
}

static void pair_set_put(ll_rigid *w, int32_t contact)
{
    const ll_contact *c = &ll_contacts(w)[contact];
    uint32_t i = slot_of(w, c->shape[0], c->shape[1]);
    LL_ASSERT(w->contacts < w->pair_set_mask); /* a free slot ends every search */
    while (ll_pair_entries(w)[i].a != LL_NONE)
        i = (i + 1) & (uint32_t)w->pair_set_mask;
    ll_pair_entries(w)[i] = (ll_pair_entry){c->shape[0], c->shape[1]};
}

/* Entries behind the hole move up unless their home slot is between it and them (Knuth 6.4, algorithm R). */
static void pair_set_remove(ll_rigid *w, int32_t contact)
{
    ll_pair_entry *table = ll_pair_entries(w);
    uint32_t mask = (uint32_t)w->pair_set_mask;
    const ll_contact *c = &ll_contacts(w)[contact];
    uint32_t hole = slot_of(w, c->shape[0], c->shape[1]);
    LL_VALIDATE(ll_pair_exists(w, c->shape[0], c->shape[1]));
    while (table[hole].a != c->shape[0] || table[hole].b != c->shape[1])
        hole = (hole + 1) & mask;
    for (uint32_t i = (hole + 1) & mask; table[i].a != LL_NONE; i = (i + 1) & mask) {
        uint32_t home = slot_of(w, table[i].a, table[i].b);
        if (((i - home) & mask) >= ((i - hole) & mask)) {
            table[hole] = table[i];
            hole = i;
        }
    }
    table[hole] = (ll_pair_entry){LL_NONE, LL_NONE};
}

/* ---- lists ---- */

void ll_awake_contact(ll_rigid *w, int32_t contact)
{
    ll_contact *c = &ll_contacts(w)[contact];
    if (c->awake != LL_NONE)
        return;
    c->awake = w->awake_contacts;
    ll_awake_contacts(w)[w->awake_contacts++] = contact;
}

void ll_sleep_contact(ll_rigid *w, int32_t contact)
{
    ll_contact *c = &ll_contacts(w)[contact];
    LL_ASSERT(c->awake >= 0 && c->awake < w->awake_contacts);
    int32_t *list = ll_awake_contacts(w), last = list[--w->awake_contacts];
    list[c->awake] = last;
    ll_contacts(w)[last].awake = c->awake;
    c->awake = LL_NONE;
}

static void link_side(ll_rigid *w, int32_t contact, int side)
{
    ll_contact *c = &ll_contacts(w)[contact];
    ll_body *b = &ll_bodies(w)[c->body[side]];
    c->previous[side] = LL_NONE;
    c->next[side] = b->contact;
    if (b->contact != LL_NONE)
        ll_contacts(w)[b->contact >> 1].previous[b->contact & 1] = 2 * contact + side;
    b->contact = 2 * contact + side;
}

static void unlink_side(ll_rigid *w, int32_t contact, int side)
{
    ll_contact *c = &ll_contacts(w)[contact];
    int32_t next = c->next[side], previous = c->previous[side];
    LL_VALIDATE(previous != LL_NONE || ll_bodies(w)[c->body[side]].contact == 2 * contact + side);
    if (previous == LL_NONE)
        ll_bodies(w)[c->body[side]].contact = next;
    else
        ll_contacts(w)[previous >> 1].next[previous & 1] = next;
    if (next != LL_NONE)
        ll_contacts(w)[next >> 1].previous[next & 1] = previous;
}

/* ---- colours ---- */

static const uint64_t dynamic_colours = (UINT64_C(1) << LL_COLOURS_DYNAMIC) - 1;
static const uint64_t static_colours =
    ((UINT64_C(1) << LL_COLOURS) - 1) & ~((UINT64_C(1) << LL_COLOURS_DYNAMIC) - 1);

void ll_take_colour(ll_rigid *w, ll_contact *c)
{
    ll_body *a = &ll_bodies(w)[c->body[0]], *b = &ll_bodies(w)[c->body[1]];
    bool both = a->type == LL_BODY_DYNAMIC && b->type == LL_BODY_DYNAMIC;
    uint64_t taken =
        (a->type == LL_BODY_DYNAMIC ? a->colours : 0) | (b->type == LL_BODY_DYNAMIC ? b->colours : 0);
    uint64_t open = ~taken & (both ? dynamic_colours : static_colours);
    if (open == 0) {
        c->colour = both ? LL_OVERFLOW_DYNAMIC : LL_OVERFLOW_STATIC;
        return;
    }
    uint64_t bit = open & (~open + 1);
    LL_VALIDATE((taken & bit) == 0); /* no two contacts of a dynamic body have one colour */
    c->colour = __builtin_ctzll(open);
    if (a->type == LL_BODY_DYNAMIC)
        a->colours |= bit;
    if (b->type == LL_BODY_DYNAMIC)
        b->colours |= bit;
}

void ll_give_colour(ll_rigid *w, ll_contact *c)
{
    if (c->colour >= 0 && c->colour < LL_COLOURS) {
        uint64_t bit = UINT64_C(1) << c->colour;
        for (int side = 0; side < 2; side++) {
            ll_body *b = &ll_bodies(w)[c->body[side]];
            if (b->type == LL_BODY_DYNAMIC)
                b->colours &= ~bit;
        }
    }
    c->colour = LL_NONE;
}

/* ---- making and removing ---- */

static void make_contact(ll_rigid *w, ll_proxy_pair pair)
{
    const ll_shape *a = &ll_shapes(w)[pair.a], *b = &ll_shapes(w)[pair.b];
    int32_t i = w->free_contact;
    if (i == LL_NONE)
        i = w->contact_end++;
    else
        w->free_contact = ll_contacts(w)[i].awake;
    LL_ASSERT(i < w->limits.contacts && a->body != b->body);
    ll_contacts(w)[i] = (ll_contact){.shape = {pair.a, pair.b},
                                     .body = {a->body, b->body},
                                     .awake = LL_NONE,
                                     .colour = LL_NONE,
                                     .friction = sqrt(a->friction * b->friction),
                                     .restitution = ll_max(a->restitution, b->restitution)};
    if (ll_contacts(w)[i].restitution > 0)
        w->bouncing++;
    link_side(w, i, 0);
    link_side(w, i, 1);
    pair_set_put(w, i);
    w->contacts++;
    if (ll_bodies(w)[a->body].awake != LL_NONE || ll_bodies(w)[b->body].awake != LL_NONE)
        ll_awake_contact(w, i);
}

void ll_remove_contact(ll_rigid *w, int32_t contact)
{
    ll_contact *c = &ll_contacts(w)[contact];
    LL_ASSERT(w->contacts > 0 && c->shape[0] != LL_NONE); /* not removed yet */
    ll_give_colour(w, c);
    pair_set_remove(w, contact);
    unlink_side(w, contact, 0);
    unlink_side(w, contact, 1);
    if (c->awake != LL_NONE)
        ll_sleep_contact(w, contact);
    if (c->restitution > 0)
        w->bouncing--;
    memset(c, 0, sizeof *c);
    c->shape[0] = c->colour = LL_NONE;
    c->awake = w->free_contact;
    w->free_contact = contact;
    w->contacts--;
}

static void announce(const void *context, int32_t a, int32_t b)
{
    const ll_rigid *w = context;
    __builtin_prefetch(&ll_pair_entries(w)[slot_of(w, a, b)]);
}

static bool wanted(const void *context, int32_t a, int32_t b)
{
    const ll_rigid *w = context;
    if (ll_pair_exists(w, a, b)) /* most pairs have a contact; those without are not in the cache */
        return false;
    const ll_shape *sa = &ll_shapes(w)[a], *sb = &ll_shapes(w)[b];
    if (sa->body == sb->body)
        return false;
    const ll_body *ba = &ll_bodies(w)[sa->body], *bb = &ll_bodies(w)[sb->body];
    if (ba->type != LL_BODY_DYNAMIC && bb->type != LL_BODY_DYNAMIC)
        return false;
    if ((sa->category & sb->mask) == 0 || (sb->category & sa->mask) == 0 ||
        (sa->group != 0 && sa->group == sb->group))
        return false;
    return !ll_joint_blocks_collision(w, sa->body, sb->body);
}

void ll_find_pairs(ll_rigid *w, ll_team *team, bool *overflowed)
{
    size_t taken = ((size_t)w->limits.contacts * sizeof(ll_proxy_pair) + 63) & ~(size_t)63;
    ll_pair_list list = {.at = ll_pairs(w),
                         .capacity = w->limits.contacts,
                         .accept = wanted,
                         .announce = announce,
                         .context = w,
                         .team = team,
                         .scratch = (char *)ll_pairs(w) + taken,
                         .scratch_size = w->at.end - w->at.pair - taken};
    ll_broad_pairs(ll_broad_of(w), ll_broad_state(w), ll_boxes(w), ll_moved_flags(w), ll_moved_lists(w),
                   w->moved, &list);
    *overflowed = list.overflowed;
    for (int32_t i = 0; i < list.count; i++) {
        if (w->contacts == w->limits.contacts) {
            *overflowed = true;
            break;
        }
        make_contact(w, list.at[i]);
    }
}

/* ---- joints ---- */

bool ll_joint_blocks_collision(const ll_rigid *w, int32_t a, int32_t b)
{
    for (int32_t e = ll_bodies(w)[a].joint; e != LL_NONE; e = ll_joints(w)[e >> 1].next[e & 1]) {
        const ll_joint *j = &ll_joints(w)[e >> 1];
        if (j->body[1 - (e & 1)] == b && !j->def.collide)
            return true;
    }
    return false;
}
