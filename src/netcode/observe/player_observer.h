/* The observer: it sees both sides and compares a client's view with the truth and with the views of the
 * other clients. */
#pragma once

#include "netcode/state/client.h"

/* Errors of entities near and far: nearer than a quarter of the radius of the area of interest, and
 * others. */
typedef struct ll_nearness {
    double near_m;
    double sum[2]; /* m; of near ones, of far ones */
    int64_t count[2];
} ll_nearness;

/* At a display of `client`: compares what it draws with the truth. */
typedef struct ll_truth {
    const ll_world *world;
    const ll_history *history;
    ll_time device; /* display latency: added to the time of each display */
    uint32_t acked; /* newest input of the client's player that the server has applied; only where it applies
                       inputs on arrival */
    ll_nearness *nearness; /* NULL where snapshots contain every entity */
    const uint64_t *known; /* a bit per entity that the client draws; NULL: flags of its world say it */
    bool applies_on_arrival, peers; /* inputs are applied on arrival; clients have worlds of their own */
} ll_truth;

/* The tick of a drawn time. Most entities of a display are drawn at one time. */
typedef struct ll_drawn_tick {
    ll_time time; /* LL_NEVER: none yet */
    int64_t tick; /* that of `time` is near it, if it is none yet */
} ll_drawn_tick;

void ll_client_metrics_frame(ll_client_metrics *in, const ll_client *client, const ll_truth *truth,
                             ll_time now);

/* At the same display: what it shows of `self`, the player that these metrics belong to. `last`: the tick
 * looked up last in this display. */
void ll_client_metrics_seen(ll_client_metrics *in, int self, const ll_client *by, const ll_truth *truth,
                            ll_drawn_tick *last, ll_time now);

/* After the last frame of an instant: inconsistency between the clients' views. The distance of an entity in
 * one view is that to the farthest of the other views. `elapsed`: time since the last such instant. */
void ll_client_metrics_between(ll_client_metrics *const *in, const ll_client *const *clients, int count,
                               ll_time now, ll_time elapsed);

/* The same where clients have only some entities: `known` is a bit per entity, of each client. A view without
 * an entity does not count for it. */
void ll_client_metrics_between_some(ll_client_metrics *const *in, const ll_client *const *clients,
                                    const uint64_t *const *known, int count, ll_time now, ll_time elapsed);
