/* The input history: the last inputs of each player with reconciliation, where its client predicted the own
 * entity after them, and where the server had it. */
#include <math.h>

#include "sim/netgame/netgame.h"

enum { INPUTS_MAX = 32 }; /* of a player */

enum { STATE_OPEN, STATE_ACKNOWLEDGED, STATE_REFUSED, STATE_LATE, STATE_LOST };

typedef struct input_row {
    uint8_t player, state;
    uint32_t seq;
    double made_s;
    float predicted_x, server_x, correction_m;
} input_row;

static const char *const state_names[] = {"open", "acknowledged", "refused", "late", "lost", NULL};

static const ll_record_field input_fields[] = {
    LL_INT(input_row, player, NULL, "index of the player"),
    LL_INT(input_row, seq, NULL, "its sequence number"),
    LL_ENUM(input_row, state, state_names, "its result"),
    LL_STEP(input_row, made_s, LL_BITS_S, "s", "when it was made"),
    LL_STEP(input_row, predicted_x, LL_BITS_M, "m", "own entity after it, as last predicted; null: not yet"),
    LL_STEP(input_row, server_x, LL_BITS_M, "m",
            "own entity in the snapshot that acknowledged it; null: unknown"),
    LL_STEP(input_row, correction_m, LL_BITS_M, "m", "difference of both; null: one is unknown"),
};

const ll_record ll_netgame_input_history_record = {
    .id = 9,
    .name = "input_history",
    .channel = LL_CHANNEL_INPUT_HISTORY,
    .help = "The input history of reconciliation: the last 32 inputs of each player with reconciliation, "
            "oldest first.",
    .form = LL_FORM_KEYED,
    .keys = 2,
    LL_ROWS_OF(input_row, input_fields)};

/* The client's state for open inputs; of closed inputs the observer knows more. */
static uint8_t state_of(const ll_netgame *g, int player, uint32_t seq)
{
    ll_client *c = ll_netgame_client(g, player);
    uint8_t fate = ll_input_history_flags(&ll_netgame_client_metrics(g, player)->input_history, seq);
    if (seq > c->inputs.acked && ll_client_is_open(c, seq))
        return STATE_OPEN;
    if (fate & LL_INPUT_HISTORY_REFUSED)
        return STATE_REFUSED;
    if (fate & LL_INPUT_HISTORY_IN_TIME)
        return STATE_ACKNOWLEDGED;
    return fate & (LL_INPUT_HISTORY_LATE | LL_INPUT_HISTORY_SENT) ? STATE_LATE : STATE_LOST;
}

/* The snapshots that the client still holds show where the server had the entity after the inputs that they
 * acknowledge. */
static void confirm(ll_client *c, input_row *inputs, int count)
{
    int64_t oldest = c->snapshots.received > LL_STATE_RING ? c->snapshots.received - LL_STATE_RING : 0;
    for (int64_t i = oldest; count > 0 && i < c->snapshots.received; i++) {
        ll_snapshot_entry *state = ll_client_state(c, i);
        uint32_t at = state->acked - inputs[0].seq;
        if (state->acked < inputs[0].seq || at >= (uint32_t)count || inputs[at].state == STATE_OPEN)
            continue;
        inputs[at].server_x = (float)ll_snapshot_entry_world(state)->entity[c->self].x;
        if (inputs[at].predicted_x == inputs[at].predicted_x)
            inputs[at].correction_m = (float)(ll_snapshot_entry_world(state)->entity[c->self].x -
                                              ll_client_pending(c, state->acked)->x);
    }
}

/* Returns the number of rows. */
static int list(const ll_netgame *g, int player, input_row *inputs)
{
    ll_client *c = ll_netgame_client(g, player);
    int count = c->inputs.seq < INPUTS_MAX ? (int)c->inputs.seq : INPUTS_MAX;
    if (c->predicting == 0 || !g->config.players[player].reconciliation)
        return 0;
    for (int i = 0; i < count; i++) {
        uint32_t seq = c->inputs.seq - (uint32_t)(count - 1 - i);
        const ll_pending_input *p = ll_client_pending(c, seq);
        bool played = seq <= c->prediction.played;
        inputs[i] = (input_row){.player = (uint8_t)player,
                                .state = state_of(g, player, seq),
                                .seq = seq,
                                .made_s = ll_to_s(p->made),
                                .predicted_x = played ? (float)p->x : NAN,
                                .server_x = NAN,
                                .correction_m = NAN};
    }
    confirm(c, inputs, count);
    return count;
}

void ll_netgame_fill_input_history(const ll_netgame *g, ll_row_set *rows)
{
    input_row inputs[INPUTS_MAX];
    for (int i = 0; i < g->config.player_count; i++)
        ll_row_set_put(rows, &ll_netgame_input_history_record, inputs, list(g, i, inputs));
}
