/* Who gets a place in a class, who gives way, and who stays out. */
#include <string.h>

#include "daemon/class/class.h"

int ll_class_count(const ll_class *c)
{
    int count = 0;
    for (int i = 0; i < c->capacity; i++)
        count += c->members[i].used;
    return count;
}

int ll_class_at(const ll_class *c, uint64_t client)
{
    int count = 0;
    for (int i = 0; i < c->capacity; i++)
        count += c->members[i].used && c->members[i].client == client;
    return count;
}

/* ---- who gives way ---- */

/* Who has been away for longest, and holds no seat. A device that never had a connection, as a program that
 * only joins, is away sooner. */
static int find_absent(const ll_class *c, ll_time now)
{
    int oldest = -1;
    for (int i = 0; i < c->capacity; i++) {
        const ll_class_member *m = &c->members[i];
        bool away = m->connections == 0 && now - m->heard > (m->seen ? LL_CLASS_EVICT_NS : LL_CLASS_SHOW_NS);
        if (away && (m->player < 0 || c->board.script[m->player]) &&
            (oldest < 0 || m->heard < c->members[oldest].heard))
            oldest = i;
    }
    return oldest;
}

/* The newest member of the address with the most: when it has at least two more than the newcomer's address,
 * so that no two can drive each other out. The address at which the class was opened keeps half of the
 * places, since a school may be behind it, while others may have a device behind each of many addresses. */
static int find_crowded(const ll_class *c, uint64_t client)
{
    int own = ll_class_at(c, client), half = c->capacity / 2, most = 0, found = -1;
    for (int i = 0; i < c->capacity; i++) {
        const ll_class_member *m = &c->members[i];
        int count = ll_class_at(c, m->client);
        if (m->client == client || (m->client == c->home && count <= half))
            continue;
        if (count > most || (count == most && m->number > c->members[found].number)) {
            most = count;
            found = i;
        }
    }
    return most > own + 1 || (client == c->home && own < half) ? found : -1;
}

/* The first of the newcomer's own address that never had a connection. */
static int find_unseen(const ll_class *c, uint64_t client)
{
    int first = -1;
    for (int i = 0; i < c->capacity; i++) {
        const ll_class_member *m = &c->members[i];
        if (m->client == client && !m->seen && (first < 0 || m->number < c->members[first].number))
            first = i;
    }
    return first;
}

static int find_free(const ll_class *c)
{
    for (int i = 0; i < c->capacity; i++)
        if (!c->members[i].used)
            return i;
    return -1;
}

static int find_place(const ll_class *c, uint64_t client, ll_time now)
{
    int found = find_free(c);
    found = found >= 0 ? found : find_absent(c, now);
    found = found >= 0 ? found : find_crowded(c, client);
    return found >= 0 ? found : find_unseen(c, client);
}

/* ---- joining ---- */

/* The letter of the address: that of its members, or the first that no address has. */
static int choose_group(const ll_class *c, uint64_t client)
{
    int group = 0;
    for (int i = 0; i < c->capacity; i++) {
        const ll_class_member *m = &c->members[i];
        if (m->used && m->client == client)
            return m->group;
    }
    for (int i = 0; i < c->capacity; i++) {
        if (c->members[i].used && c->members[i].group == group) {
            group++;
            i = -1;
        }
    }
    return group;
}

static bool is_barred(const ll_class *c, uint64_t client)
{
    for (uint32_t i = 0; i < c->bars && i < LL_CLASS_REMOVED; i++)
        if (c->barred[i] == client)
            return true;
    return false;
}

ll_status ll_class_admits(const ll_class *c, uint64_t client, ll_time now)
{
    if (is_barred(c, client))
        return ll_field_error(LL_FORBIDDEN, "address",
                              "address: the teacher has removed its devices from the class.");
    if (c->now.door == LL_CLASS_CLOSED)
        return ll_field_error(LL_FORBIDDEN, "door", "door: closed; the teacher can open it.");
    return find_place(c, client, now) >= 0
               ? ll_ok()
               : ll_error(LL_LIMIT, "The class is full: it has %d members (--max-class-members).",
                          c->capacity);
}

int ll_class_join(ll_class *c, const ll_class_arrival *a, char copy[LL_ID_LENGTH + 1])
{
    int found = find_place(c, a->client, a->now);
    copy[0] = '\0';
    if (found >= 0 && c->members[found].used) {
        memcpy(copy, c->members[found].copy.session, LL_ID_LENGTH + 1);
        ll_class_leave(c, found);
    }
    if (found < 0)
        return found;
    c->members[found] = (ll_class_member){.used = true,
                                          .number = ++c->numbers,
                                          .token = a->token,
                                          .client = a->client,
                                          .group = choose_group(c, a->client),
                                          .joined_s = a->unix_s,
                                          .role = LL_CLASS_WATCH,
                                          .player = -1,
                                          .choice = -1,
                                          .heard = a->now,
                                          .round_trip_ns = -1};
    c->stirred = true;
    return found;
}

/* ---- removing ---- */

bool ll_class_has_removed(const ll_class *c, const char *token, size_t length)
{
    bool removed = false;
    for (uint32_t i = 0; i < c->removals && i < LL_CLASS_REMOVED; i++)
        removed = ll_key_matches(&c->removed[i].token, token, length) || removed;
    return removed;
}

bool ll_class_has_removed_number(const ll_class *c, uint32_t number)
{
    for (uint32_t i = 0; i < c->removals && i < LL_CLASS_REMOVED; i++)
        if (c->removed[i].number == number)
            return true;
    return false;
}

ll_status ll_class_remove(ll_class *c, uint32_t number, ll_class_reach reach,
                          void (*removed)(void *context, const char *copy), void *context)
{
    int first = 0;
    while (first < c->capacity && !(c->members[first].used && c->members[first].number == number))
        first++;
    if (first == c->capacity)
        return ll_error(LL_NOT_FOUND, "The class has no member %u.", (unsigned)number);
    uint64_t client = c->members[first].client;
    if (reach == LL_CLASS_ADDRESS && client == c->home)
        return ll_field_error(LL_CONFLICT, "and",
                              "and: the class was opened at this address; remove its devices alone, or "
                              "with those that came later.");
    if (reach == LL_CLASS_ADDRESS && !is_barred(c, client))
        c->barred[c->bars++ % LL_CLASS_REMOVED] = client;
    for (int i = 0; i < c->capacity; i++) {
        const ll_class_member *m = &c->members[i];
        if (!m->used || !(m->number == number || (reach == LL_CLASS_LATER && m->number > number) ||
                          (reach == LL_CLASS_ADDRESS && m->client == client)))
            continue;
        uint32_t at = c->removals++ % LL_CLASS_REMOVED;
        c->removed[at].token = m->token;
        c->removed[at].number = m->number;
        if (m->copy.session[0])
            removed(context, m->copy.session);
        ll_class_leave(c, i);
    }
    c->changed = true;
    return ll_ok();
}
