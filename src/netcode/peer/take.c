/* What a peer takes from packets: inputs of others, and how far it is ahead of them. */
#include <string.h>

#include "base/assert.h"
#include "netcode/state/peer.h"

/* An input that is too far ahead to be kept is not acknowledged, so it is sent again. */
void ll_peer_take_input(ll_peer *peer, int player, int64_t tick, const ll_controls *input)
{
    ll_peer_player *from = &peer->player[player];
    if (tick != from->known + 1 || tick >= peer->confirmed + LL_PEER_RING - LL_SYNC_TEST_MAX)
        return;
    ll_controls *slot = ll_peer_input(peer, player, tick);
    if (tick <= peer->tick && tick < peer->wrong && memcmp(slot, input, sizeof *slot) != 0)
        peer->wrong = tick;
    LL_ASSERT(tick > peer->confirmed); /* a confirmed tick never changes */
    *slot = *input;
    from->known = tick;
}

void ll_peer_take_lead(ll_client *c, const ll_client_setup *s, const ll_relay_part *part, ll_time now)
{
    ll_peer *peer = ll_client_peer(c);
    ll_peer_player *from = &peer->player[part->player];
    if (part->at <= from->at)
        return;
    if (ll_peer_paced(s)) {
        ll_pacing_take(c, s, part, now);
        return;
    }
    double ahead = (double)(peer->tick - part->at), behind = part->ahead;
    from->samples = from->at < 0 ? 1 : from->samples + (from->samples < LL_LEAD_SAMPLES);
    double share = 1.0 / from->samples;
    from->ahead += share * (ahead - from->ahead);
    from->behind += share * (behind - from->behind);
    from->at = part->at;
}
