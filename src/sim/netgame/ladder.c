/* The reconciliation ladder: the last inputs of each player who reconciles, where its client thought that
 * they put the own entity, and where the server had it. Section 7 of session/frame.h. */
#include <cjson/cJSON.h>

#include "sim/netgame/netgame.h"

enum { SECTION_LADDER = 7 };
enum { RUNGS_MAX = 32 }; /* of a player */

enum { RUNG_OPEN, RUNG_ACKNOWLEDGED, RUNG_REFUSED, RUNG_LATE, RUNG_LOST };
enum { RUNG_PREDICTED = 1, RUNG_CONFIRMED = 2 }; /* which of the places are known */

typedef struct rung {
    uint8_t player, state, known, reserved;
    uint32_t seq;
    float made_ms, predicted_x, server_x, correction_m;
} rung;

_Static_assert(sizeof(rung) == 24, "the layout of session/frame.h");

/* The client's word for what is open; of what is closed the observer knows more than it. */
static uint8_t state_of(const ll_netgame *g, int player, uint32_t seq)
{
    ll_client *c = ll_netgame_client(g, player);
    uint8_t fate = ll_ledger_marks(&ll_netgame_instruments(g, player)->ledger, seq);
    if (seq > c->acked && ll_client_is_open(c, seq))
        return RUNG_OPEN;
    if (fate & LL_LEDGER_REFUSED)
        return RUNG_REFUSED;
    if (fate & LL_LEDGER_IN_TIME)
        return RUNG_ACKNOWLEDGED;
    return fate & (LL_LEDGER_LATE | LL_LEDGER_WENT) ? RUNG_LATE : RUNG_LOST;
}

/* The states that the client still has tell where the server had it after the inputs that they acknowledge.
 */
static void confirm(ll_client *c, rung *rungs, int count)
{
    int64_t oldest = c->newest > LL_STATE_RING ? c->newest - LL_STATE_RING : 0;
    for (int64_t i = oldest; count > 0 && i < c->newest; i++) {
        ll_received *state = ll_client_state(c, i);
        uint32_t at = state->acked - rungs[0].seq;
        if (state->acked < rungs[0].seq || at >= (uint32_t)count || rungs[at].state == RUNG_OPEN)
            continue;
        rungs[at].server_x = (float)ll_received_world(state)->entity[c->self].x;
        rungs[at].known |= RUNG_CONFIRMED;
        if (rungs[at].known & RUNG_PREDICTED)
            rungs[at].correction_m =
                (float)(ll_received_world(state)->entity[c->self].x - ll_client_pending(c, state->acked)->x);
    }
}

/* Returns how many were written. */
static int list(const ll_netgame *g, int player, rung *rungs)
{
    ll_client *c = ll_netgame_client(g, player);
    int count = c->seq < RUNGS_MAX ? (int)c->seq : RUNGS_MAX;
    if (c->predicting == 0 || !g->config.players[player].reconciliation)
        return 0;
    for (int i = 0; i < count; i++) {
        uint32_t seq = c->seq - (uint32_t)(count - 1 - i);
        const ll_pending *p = ll_client_pending(c, seq);
        bool played = seq <= c->played;
        rungs[i] = (rung){.player = (uint8_t)player,
                          .state = state_of(g, player, seq),
                          .known = played ? RUNG_PREDICTED : 0,
                          .seq = seq,
                          .made_ms = (float)ll_to_ms(p->made - g->now),
                          .predicted_x = played ? (float)p->x : 0};
    }
    confirm(c, rungs, count);
    return count;
}

static int list_all(const ll_netgame *g, rung *rungs)
{
    int n = 0;
    for (int i = 0; i < g->config.player_count; i++)
        n += list(g, i, rungs + n);
    return n;
}

void ll_netgame_ladder_section(const ll_netgame *g,
                               void (*section)(void *context, int type, int count, const void *bytes,
                                               size_t size),
                               void *context)
{
    rung rungs[LL_PLAYERS_MAX * RUNGS_MAX];
    int n = list_all(g, rungs);
    section(context, SECTION_LADDER, n, rungs, (size_t)n * sizeof rungs[0]);
}

static void number(cJSON *object, const char *name, double value)
{
    cJSON_AddNumberToObject(object, name, value);
}

void ll_netgame_ladder_section_json(const ll_netgame *g, cJSON *frame)
{
    rung rungs[LL_PLAYERS_MAX * RUNGS_MAX];
    cJSON *ladder = cJSON_AddArrayToObject(frame, "ladder");
    int n = list_all(g, rungs);
    for (int i = 0; i < n; i++) {
        const rung *r = &rungs[i];
        cJSON *o = cJSON_CreateObject();
        number(o, "player", r->player);
        number(o, "state", r->state);
        number(o, "known", r->known);
        number(o, "seq", r->seq);
        number(o, "made_ms", (double)r->made_ms);
        number(o, "predicted_x", (double)r->predicted_x);
        number(o, "server_x", (double)r->server_x);
        number(o, "correction_m", (double)r->correction_m);
        cJSON_AddItemToArray(ladder, o);
    }
}
