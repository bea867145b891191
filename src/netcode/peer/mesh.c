/* A peer of a mesh: it sends its inputs to each other player itself, to each those that this player has not
 * acknowledged, and takes theirs from their packets. The server only keeps the session. */
#include "netcode/state/peer.h"

/* More than a player in the game can lack: two clients wait for each other within twice the prediction window
 * and the input delay of each. */
#define OPEN_MAX (2 * LL_PEER_RING)

_Static_assert(2 * (LL_ROLLBACK_MAX + LL_INPUT_DELAY_MAX) + 2 < OPEN_MAX && OPEN_MAX <= LL_PENDING_RING,
               "a copy reaches back to all inputs that its receiver lacks");

void ll_mesh_start(ll_client *c, const ll_client_setup *s)
{
    for (int p = 0; p < LL_PEERS_MAX; p++)
        s->choices->way[p] = (ll_peer_way){.acked = ll_client_peer(c)->first};
}

/* The report of a later packet counts, even if it is less: a player who joins again has no earlier inputs. */
int ll_mesh_receive(ll_client *c, const ll_client_setup *s, const ll_peer_message *m, ll_time now)
{
    ll_peer *peer = ll_client_peer(c);
    const int from = m->other - 1;
    const ll_peer_ack *acks = (const ll_peer_ack *)(m + 1);
    const ll_input_run *runs = (const ll_input_run *)(acks + ll_client_rendered(c)->players);
    int64_t tick = m->tick, known = peer->player[from].known;
    const ll_relay_part report = {.at = m->at, .ahead = acks[c->self].ahead, .player = (uint16_t)from};
    if (m->at > peer->began) /* not from before the game continued after a barrier */
        ll_peer_take_lead(c, s, &report, now);
    for (int r = 0; r < m->runs; r++)
        for (uint32_t i = 0; i < runs[r].count; i++)
            ll_peer_take_input(peer, from, tick++, &runs[r].input);
    if (ll_peer_paced(s) && peer->player[from].known > known)
        ll_pacing_inputs_came(c, s, from, known + 1, now);
    s->choices->way[from].acked = acks[c->self].known;
    s->choices->way[from].away = 0;
    return LL_OUTCOME_APPLIED;
}

void ll_mesh_note_away(const ll_client_setup *s, int player)
{
    s->choices->way[player].away = 1;
}

int64_t ll_mesh_first(const ll_client *c, const ll_client_setup *s, int other)
{
    const ll_peer_way *way = &s->choices->way[other];
    const int64_t begins = ll_client_peer(c)->first + 1, oldest = c->inputs.tick - OPEN_MAX + 1;
    int64_t first = way->away ? begins + c->inputs.acked : way->acked + 1;
    first = first > begins ? first : begins;
    return first > oldest ? first : oldest;
}
