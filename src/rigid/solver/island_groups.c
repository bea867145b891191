/* Groups of islands: islands do not affect each other within a step, so a solver may finish some before it
 * starts the next. A kinematic body connects all that it touches, since it moves from substep to substep; a
 * static body separates islands. */
#include "rigid/solver/solver.h"

#include <string.h>

#include "base/assert.h"

/* A heap has up to three contacts per body; with contacts and constraints, `enough_bodies` of it take about
 * half of a second-level cache of 1 MiB. Smaller worlds gain less from groups than they cost. So do worlds
 * in which one island has most of the bodies: these are solved as a whole, and checked again after some
 * steps. */
enum { enough_bodies = 400, least_world = 2000, whole_steps = 16 };

static size_t most_groups(const ll_rigid_limits *l)
{
    return (size_t)l->bodies / enough_bodies + 1;
}

size_t ll_groups_size(const ll_rigid_limits *l)
{
    return (3 * (size_t)l->bodies + (size_t)l->contacts + (size_t)l->joints + 3 * most_groups(l)) *
           sizeof(int32_t);
}

static int32_t *take(int32_t **at, size_t count)
{
    int32_t *taken = *at;
    *at += count;
    return taken;
}

static ll_groups memory_of(const ll_rigid *w)
{
    const ll_rigid_limits *l = &w->limits;
    int32_t *at = ll_group_memory(w);
    ll_groups g = {0};
    g.parent = take(&at, (size_t)l->bodies);
    g.of = take(&at, (size_t)l->bodies);
    g.bodies = take(&at, (size_t)l->bodies);
    g.contacts = take(&at, (size_t)l->contacts);
    g.joints = take(&at, (size_t)l->joints);
    g.body_end = take(&at, most_groups(l));
    g.contact_end = take(&at, most_groups(l));
    g.joint_end = take(&at, most_groups(l));
    return g;
}

ll_group ll_whole(const ll_rigid *w)
{
    int32_t *joints = memory_of(w).joints;
    for (int32_t i = 0; i < w->joint_end; i++)
        joints[i] = i;
    return (ll_group){.bodies = {.at = ll_awake_bodies(w), .count = w->awake},
                      .contacts = {.at = ll_awake_contacts(w), .count = w->awake_contacts},
                      .joints = {.at = joints, .count = w->joint_end}};
}

/* Turns counts into the start of each group; placing then advances that to its end. */
static void begin_each(int32_t *at, int32_t groups)
{
    int32_t total = 0;
    for (int32_t i = 0; i < groups; i++) {
        int32_t count = at[i];
        at[i] = total;
        total += count;
    }
}

/* Islands in the order of the awake list. Returns the size of the largest. */
static int32_t group_islands(const ll_rigid *w, ll_groups *g)
{
    const int32_t *awake = ll_awake_bodies(w);
    int32_t filled = enough_bodies, largest = 0;
    g->count = 0;
    for (int32_t i = 0; i < w->awake; i++) {
        int32_t root = ll_root_of(g->parent, awake[i]), size = -g->parent[root];
        if (g->of[root] == LL_NONE) {
            if (filled >= enough_bodies) {
                g->body_end[g->count++] = 0;
                filled = 0;
            }
            g->of[root] = g->count - 1;
            filled += size;
            largest = size > largest ? size : largest;
        }
        g->of[awake[i]] = g->of[root];
        g->body_end[g->of[root]]++;
    }
    return largest;
}

static void place_bodies(const ll_rigid *w, const ll_groups *g)
{
    const int32_t *awake = ll_awake_bodies(w);
    begin_each(g->body_end, g->count);
    for (int32_t i = 0; i < w->awake; i++)
        g->bodies[g->body_end[g->of[awake[i]]]++] = awake[i];
}

static int32_t group_of(const ll_groups *g, const ll_island_edge *link)
{
    LL_VALIDATE(g->parent[link->body[0]] != LL_APART || g->parent[link->body[1]] != LL_APART);
    return g->of[link->body[g->parent[link->body[0]] == LL_APART]];
}

static void place_edges(const ll_groups *g, const ll_island_edge *links, int32_t count, int32_t *end,
                        int32_t *out)
{
    memset(end, 0, (size_t)g->count * sizeof *end);
    for (int32_t i = 0; i < count; i++)
        end[group_of(g, &links[i])]++;
    begin_each(end, g->count);
    for (int32_t i = 0; i < count; i++)
        out[end[group_of(g, &links[i])]++] = links[i].number;
}

ll_groups ll_group_islands(ll_rigid *w, ll_team *team)
{
    ll_groups g = memory_of(w), whole = {.count = 1};
    if (w->awake < least_world || w->stats.step < w->whole_until)
        return whole;
    for (int32_t i = 0; i < w->body_end; i++)
        g.parent[i] = LL_APART;
    for (int32_t i = 0; i < w->awake; i++) {
        g.parent[ll_awake_bodies(w)[i]] = LL_ALONE;
        g.of[ll_awake_bodies(w)[i]] = LL_NONE;
    }
    ll_island_edge *links = ll_island_edges(w);
    int32_t touching = ll_touching_edges(w, team, links), joints = ll_joint_edges(w, links + touching);
    ll_join(g.parent, links, touching + joints);
    if (2 * group_islands(w, &g) > w->awake) {
        w->whole_until = w->stats.step + whole_steps;
        return whole;
    }
    place_bodies(w, &g);
    place_edges(&g, links, touching, g.contact_end, g.contacts);
    place_edges(&g, links + touching, joints, g.joint_end, g.joints);
    return g;
}

static ll_index_list part(const int32_t *all, const int32_t *end, int32_t i)
{
    int32_t begin = i > 0 ? end[i - 1] : 0;
    LL_ASSERT(begin >= 0 && begin <= end[i]); /* groups follow each other */
    return (ll_index_list){.at = all + begin, .count = end[i] - begin, .first = begin};
}

ll_group ll_group_at(const ll_rigid *w, const ll_groups *g, int32_t i)
{
    if (g->count == 1)
        return ll_whole(w);
    return (ll_group){.bodies = part(g->bodies, g->body_end, i),
                      .contacts = part(g->contacts, g->contact_end, i),
                      .joints = part(g->joints, g->joint_end, i)};
}
