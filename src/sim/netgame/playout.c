/* The players' de-jitter buffers, between link and client. Only snapshots are played out; packets that the
 * link's receiver holds back stay in the link's store. */
#include <string.h>

#include "sim/netgame/netgame.h"

bool ll_netgame_hold(ll_netgame *g, int player, const void *packet, int bytes)
{
    ll_dejitter *buffer = ll_netgame_dejitter(g, player);
    const ll_player_config *config = &g->config.players[player];
    ll_snapshot_message m;
    memcpy(&m, packet, sizeof m.head);
    if (m.head.type != LL_MESSAGE_SNAPSHOT ||
        (config->dejitter == LL_DEJITTER_NONE && ll_dejitter_depth(buffer) == 0))
        return false;
    memcpy(&m, packet, sizeof m);
    const ll_dejitter_params params = {.delay_ms = config->dejitter_ms,
                                       .interval_ms = 1000 / (double)m.update_hz,
                                       .policy = config->dejitter};
    if (ll_dejitter_push(buffer, &params, m.tick, m.time, g->now))
        ll_link_hold(ll_netgame_down(g, player), (uint32_t)m.tick, packet, bytes);
    return true; /* held, or dropped by a full buffer */
}

int ll_netgame_play_out(ll_netgame *g, int player, void *packet, int capacity)
{
    ll_dejitter_packet next;
    if (!ll_dejitter_pop(ll_netgame_dejitter(g, player), g->now, &next))
        return 0;
    return ll_link_take_held(ll_netgame_down(g, player), (uint32_t)next.id, packet, capacity);
}
