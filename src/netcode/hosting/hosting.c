#include "netcode/hosting/hosting.h"

#include <string.h>

#include "base/assert.h"

void ll_hosting_init(ll_hosting *h, const ll_hosting_params *params, int players)
{
    LL_ASSERT(params->host >= 0 && params->host < players && players <= LL_PEERS_MAX);
    memset(h, 0, sizeof *h);
    h->params = *params;
    h->players = players;
    h->host = params->host;
    h->since = LL_LONG_AGO;
    h->leaves = params->leaves_s > 0 ? (ll_time)(params->leaves_s * 1e9) : LL_NEVER;
    h->farewell = -1;
    for (int i = 0; i < players; i++) {
        h->lease[i] = LL_NEVER;
        h->view[i].target = params->host;
        h->view[i].lost = h->view[i].announced = -1;
        h->view[i].bound = LL_LONG_AGO;
        h->view[i].asked = h->view[i].without = h->view[i].host_from = LL_NEVER;
    }
    h->view[h->host].host_from = 0;
}

void ll_hosting_lose(ll_hosting *h, int player, const ll_candidacy *own, ll_time now)
{
    ll_host_view *v = &h->view[player];
    v->lost = v->target;
    v->since = now;
    v->asked = LL_NEVER;
    v->tried = v->again = 0;
    v->heard |= UINT64_C(1) << player; /* others may have noticed before */
    v->of[player] = *own;
}

static uint64_t bit(int64_t player)
{
    return player < 0 ? 0 : UINT64_C(1) << player;
}

/* Who can host as far as the player knows. */
static uint64_t eligible(const ll_hosting *h, const ll_host_view *v)
{
    return ((UINT64_C(1) << h->players) - 1) & ~v->departed & ~bit(v->lost);
}

bool ll_hosting_heard_all(const ll_hosting *h, int player)
{
    const ll_host_view *v = &h->view[player];
    return (eligible(h, v) & ~v->heard) == 0;
}

/* The best of `among`; -1: there is none. */
static int best_of(const ll_hosting *h, const ll_host_view *v, uint64_t among)
{
    const ll_election *election = ll_hosting_election(h);
    int best = -1;
    for (int p = 0; p < h->players; p++)
        if (among >> p & 1 &&
            (best < 0 || (election->compare && election->compare(&v->of[p], &v->of[best]) < 0)))
            best = p;
    return best;
}

int ll_hosting_choose(ll_hosting *h, int player)
{
    ll_host_view *v = &h->view[player];
    const uint64_t all = (UINT64_C(1) << h->players) - 1;
    const uint64_t known = ll_hosting_election(h)->asks ? v->heard | bit(v->lost) : all;
    int best = best_of(h, v, known & ~v->tried & (v->again ? all : eligible(h, v)));
    if (best < 0) {
        v->again = 1;
        v->tried = 0;
        best = best_of(h, v, known);
    }
    LL_ASSERT(best >= 0); /* its own has always come */
    v->tried |= bit(best);
    return best;
}

void ll_hosting_join(ll_hosting *h, int player, ll_time now)
{
    ll_host_view *v = &h->view[player];
    if (v->lost >= 0)
        v->departed |= bit(v->lost);
    ll_hosting_hear_of(h, player, v->target);
    v->lost = -1;
    v->asked = LL_NEVER;
    v->tried = v->heard = v->again = 0;
    if (v->promises) /* which it has kept; a promise to another than this host still binds it */
        v->bound = LL_LONG_AGO;
    v->promises = 0;
    if (v->without == LL_NEVER)
        return;
    ll_time without = now - v->without;
    v->without_sum += without;
    v->without_max = without > v->without_max ? without : v->without_max;
    v->without = LL_NEVER;
}

bool ll_hosting_elected(const ll_hosting *h, int candidate, ll_time at)
{
    const ll_host_vote *votes = h->votes[candidate];
    int count = 0;
    for (int p = 0; p < h->players; p++)
        count += votes[p].until > at;
    return votes[candidate].until > at && 2 * count > h->players;
}

void ll_hosting_begin(ll_hosting *h, int host, ll_time now, ll_time timeout)
{
    LL_ASSERT(h->host < 0); /* never a second one */
    h->host = host;
    h->since = now;
    h->changes++;
    h->without += now - h->stopped;
    h->leaves = h->params.every_s > 0 ? now + (ll_time)(h->params.every_s * 1e9) : LL_NEVER;
    h->view[host].host_from = now;
    for (int p = 0; p < h->players; p++) {
        h->lease[p] = ll_hosting_lease(h->votes[host][p].until, now, timeout);
        h->votes[host][p].until = 0;
    }
}

void ll_hosting_stop(ll_hosting *h, ll_time now)
{
    ll_host_view *last = &h->view[h->host];
    last->hosted += now - (h->since > 0 ? h->since : 0);
    h->host = -1;
    h->stopped = now;
    for (int p = 0; p < h->players; p++)
        if (h->view[p].without == LL_NEVER && !(h->gone >> p & 1))
            h->view[p].without = now;
}

void ll_hosting_renew(ll_hosting *h, int player, ll_time until)
{
    if (h->lease[player] == LL_NEVER || until > h->lease[player])
        h->lease[player] = until;
}

void ll_hosting_shorten(ll_hosting *h, ll_time less)
{
    for (int p = 0; p < h->players; p++)
        if (h->lease[p] != LL_NEVER)
            h->lease[p] -= less;
}

bool ll_hosting_holds(const ll_hosting *h, ll_time at)
{
    int held = 1; /* its own */
    for (int p = 0; p < h->players; p++)
        held += p != h->host && h->lease[p] > at;
    return 2 * held > h->players;
}
