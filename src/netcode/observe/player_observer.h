/* What one sees who sees both sides: a client's picture beside the truth, and beside those of the others. */
#pragma once

#include "netcode/state/client.h"

/* At a display of `client`: compares what it draws with the truth. */
typedef struct ll_truth {
    const ll_world *world;
    const ll_history *history;
    ll_time device; /* from the picture to the light of the screen: changes are seen so much later */
    uint32_t acked; /* the newest input of the client's player that the server has applied; where it drains */
    bool applies_on_arrival, peers; /* inputs are applied as they come; clients have worlds of their own */
} ll_truth;

void ll_client_metrics_frame(ll_client_metrics *in, const ll_client *client, const ll_truth *truth,
                             ll_time now);

/* At the same display: what it shows of the player whose instruments these are, `self`. */
void ll_client_metrics_seen(ll_client_metrics *in, int self, const ll_client *by, const ll_truth *truth,
                            ll_time now);

/* After the last frame of an instant: compares what the clients draw with each other (M7). The distance of an
 * entity in one picture is that from the farthest of the others. `elapsed` since the last such instant. */
void ll_client_metrics_between(ll_client_metrics *const *in, const ll_client *const *clients, int count,
                               ll_time now, ll_time elapsed);
