/* Sleeping: touching bodies fall asleep together and wake together. */
#include "rigid/contact/contact.h"

#include <string.h>

#include "base/assert.h"

void ll_wake(ll_rigid *w, int32_t body)
{
    ll_body *first = &ll_bodies(w)[body];
    first->sleep_time = 0;
    if (first->awake != LL_NONE || first->type == LL_BODY_STATIC)
        return;
    int32_t i = body;
    do {
        ll_body *b = &ll_bodies(w)[i];
        LL_ASSERT(b->awake == LL_NONE && b->type != LL_BODY_STATIC); /* the whole island sleeps */
        ll_put_in_awake_list(w, i);
        b->sleep_time = 0;
        for (int32_t e = b->contact; e != LL_NONE; e = ll_contacts(w)[e >> 1].next[e & 1])
            ll_awake_contact(w, e >> 1);
        int32_t next = b->island;
        b->island = i;
        i = next;
    } while (i != body);
}

/* ---- edges of islands ---- */

typedef struct touching {
    const ll_rigid *w;
    ll_island_edge *out;
    ll_share wrote[LL_TEAM_PARTS_MAX]; /* for ll_team_join */
} touching;

static void list_touching(void *context, int part, int parts)
{
    touching *t = context;
    const ll_rigid *w = t->w;
    ll_share of = ll_share_of(w->awake_contacts, part, parts);
    int32_t end = of.begin;
    for (int32_t i = of.begin; i < of.end; i++) {
        int32_t number = ll_awake_contacts(w)[i];
        const ll_contact *c = &ll_contacts(w)[number];
        if (i + 16 < of.end)
            __builtin_prefetch(&ll_contacts(w)[ll_awake_contacts(w)[i + 16]]);
        if (c->count > 0)
            t->out[end++] = (ll_island_edge){number, {c->body[0], c->body[1]}};
    }
    t->wrote[part] = (ll_share){of.begin, end};
}

int32_t ll_touching_edges(const ll_rigid *w, ll_team *team, ll_island_edge *out)
{
    enum { least = 512 }; /* a contact takes about 10 ns */
    touching t = {.w = w, .out = out};
    ll_team_run(team, w->awake_contacts, least, list_touching, &t);
    return ll_team_join(t.wrote, out, sizeof *out);
}

bool ll_joint_awake(const ll_rigid *w, int32_t joint)
{
    const int32_t *body = ll_joints(w)[joint].body;
    return body[0] != LL_NONE &&
           (ll_bodies(w)[body[0]].awake != LL_NONE || ll_bodies(w)[body[1]].awake != LL_NONE);
}

int32_t ll_joint_edges(const ll_rigid *w, ll_island_edge *out)
{
    int32_t count = 0;
    for (int32_t i = 0; i < w->joint_end; i++) {
        const ll_joint *j = &ll_joints(w)[i];
        if (ll_joint_awake(w, i))
            out[count++] = (ll_island_edge){i, {j->body[0], j->body[1]}};
    }
    return count;
}

int32_t ll_root_of(int32_t *parent, int32_t body)
{
    while (parent[body] >= 0) {
        int32_t above = parent[body];
        if (parent[above] >= 0)
            parent[body] = parent[above];
        body = above;
    }
    return body;
}

void ll_join(int32_t *parent, const ll_island_edge *links, int32_t count)
{
    for (int32_t i = 0; i < count; i++) {
        int32_t a = links[i].body[0], b = links[i].body[1];
        if (parent[a] == LL_APART || parent[b] == LL_APART)
            continue;
        a = ll_root_of(parent, a);
        b = ll_root_of(parent, b);
        if (a == b)
            continue;
        LL_VALIDATE(parent[a] < 0 && parent[b] < 0); /* roots have minus their size */
        int32_t root = a < b ? a : b;
        parent[root] = parent[a] + parent[b];
        parent[a + b - root] = root;
    }
}

/* Bodies that touch a moving kinematic body, or that a mouse joint drags, do not rest. */
static void stir(ll_rigid *w)
{
    for (int32_t i = 0; i < w->awake; i++) {
        int32_t body = ll_awake_bodies(w)[i];
        if (ll_bodies(w)[body].type != LL_BODY_KINEMATIC)
            continue;
        for (int32_t e = ll_bodies(w)[body].contact; e != LL_NONE; e = ll_contacts(w)[e >> 1].next[e & 1])
            if (ll_contacts(w)[e >> 1].count > 0)
                ll_bodies(w)[ll_contacts(w)[e >> 1].body[1 - (e & 1)]].sleep_time = 0;
    }
    for (int32_t i = 0; i < w->joint_end; i++)
        if (ll_joints(w)[i].body[0] != LL_NONE && ll_joints(w)[i].def.type == LL_JOINT_MOUSE)
            ll_bodies(w)[ll_joints(w)[i].body[1]].sleep_time = 0;
}

static void lay_down(ll_rigid *w, int32_t body)
{
    ll_body *b = &ll_bodies(w)[body];
    ll_take_from_awake_list(w, body);
    ll_solver_bodies(w)[body] = (ll_solver_body){.q = {1, 0}};
    for (int32_t e = b->contact; e != LL_NONE; e = ll_contacts(w)[e >> 1].next[e & 1]) {
        const ll_contact *c = &ll_contacts(w)[e >> 1];
        if (c->awake != LL_NONE && ll_bodies(w)[c->body[1 - (e & 1)]].awake == LL_NONE)
            ll_sleep_contact(w, e >> 1);
    }
}

/* A kinematic body is an island by itself. */
static void join_dynamic(ll_rigid *w, int32_t *parent)
{
    for (int32_t i = 0; i < w->body_end; i++)
        parent[i] = LL_APART;
    for (int32_t i = 0; i < w->awake; i++)
        if (ll_bodies(w)[ll_awake_bodies(w)[i]].type == LL_BODY_DYNAMIC)
            parent[ll_awake_bodies(w)[i]] = LL_ALONE;
    ll_join(parent, ll_island_edges(w), ll_touching_edges(w, NULL, ll_island_edges(w)));
    ll_join(parent, ll_island_edges(w), ll_joint_edges(w, ll_island_edges(w)));
}

/* Checked every eighth step: an island may stay awake a little longer, and a moving scene pays little. */
void ll_put_to_sleep(ll_rigid *w)
{
    if (!w->params.sleep || w->stats.step % 8 != 0)
        return;
    bool any = false;
    for (int32_t i = 0; i < w->awake && !any; i++)
        any = ll_bodies(w)[ll_awake_bodies(w)[i]].sleep_time >= LL_SLEEP_TIME;
    if (!any)
        return;
    stir(w);
    int32_t *parent = ll_scratch(w), *wakeful = parent + w->limits.bodies, *list = wakeful + w->limits.bodies;
    int32_t count = w->awake;
    memcpy(list, ll_awake_bodies(w), (size_t)count * sizeof *list);
    join_dynamic(w, parent);
    for (int32_t i = 0; i < count; i++)
        wakeful[list[i]] = 0;
    for (int32_t i = 0; i < count; i++)
        if (ll_bodies(w)[list[i]].sleep_time < LL_SLEEP_TIME)
            wakeful[ll_root_of(parent, list[i])] = 1;
    w->stats.islands = 0;
    for (int32_t i = 0; i < count; i++) {
        int32_t root = ll_root_of(parent, list[i]);
        w->stats.islands += root == list[i];
        if (wakeful[root])
            continue;
        lay_down(w, list[i]);
        if (root != list[i]) { /* into the circular list after the root */
            ll_bodies(w)[list[i]].island = ll_bodies(w)[root].island;
            ll_bodies(w)[root].island = list[i];
        }
    }
}
