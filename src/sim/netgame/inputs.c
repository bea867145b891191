/* Reports of inputs: how they were predicted, acknowledged and decided, and the last ones as they are
 * streamed. */
#include <cjson/cJSON.h>
#include <math.h>

#include "sim/netgame/netgame.h"

static double per_second(int64_t count, double seconds)
{
    return ll_netgame_ratio((double)count, seconds > 0 ? seconds : 0);
}

/* ---- results of inputs ---- */

#define RESULTS(X)                                                                                           \
    X(count, made, NULL, ll_input_history_made_count(input_history), "inputs that the client made", NULL)    \
    X(count, open, NULL, input_history->count[LL_INPUT_IS_OPEN], "inputs without a result yet", NULL)        \
    X(count, applied, NULL, input_history->count[LL_INPUT_WAS_APPLIED],                                      \
      "inputs that the server applied in the step that they were for", NULL)                                 \
    X(count, refused, NULL, input_history->count[LL_INPUT_WAS_REFUSED],                                      \
      "inputs that broke a rule of the server", NULL)                                                        \
    X(count, late, NULL, input_history->count[LL_INPUT_CAME_LATE], "inputs that arrived after their step",   \
      NULL)                                                                                                  \
    X(count, lost, NULL, input_history->count[LL_INPUT_WAS_LOST],                                            \
      "inputs whose step is over and that have not arrived", NULL)

#define TIMED(X)                                                                                             \
    X(rate, late_per_s, "1/s", per_second(input_history->late, seconds),                                     \
      "inputs per second that arrived after their step", "The run has not reached warmup_s.")                \
    X(rate, starved_per_s, "1/s",                                                                            \
      per_second(client_slot->counts.starved - input_history->starved_before, seconds),                      \
      "steps of the server per second without an input of the player", "The run has not reached warmup_s.")  \
    X(count, extra_inputs, NULL, input_history->doubled, "inputs that the client made beyond one per frame", \
      NULL)                                                                                                  \
    X(count, skipped_inputs, NULL, input_history->left_out, "frames in which the client made no input",      \
      NULL)                                                                                                  \
    X(gauge, slack, "ticks", ll_netgame_gauge(&input_history->slack, 1),                                     \
      "input slack: ticks from the arrival of an input to its step (only with sync free)",                   \
      "No input has arrived.")                                                                               \
    X(gauge, scale, NULL, ll_netgame_gauge(&input_history->scale, 1),                                        \
      "time dilation: rate of the client's frames relative to their own rate; above 1: faster",              \
      "No frame was drawn.")

#define CAUSES(X)                                                                                            \
    X(count, count, NULL, input_history->corrections[i].count,                                               \
      "corrections of the own entity by this cause", NULL)                                                   \
    X(rate, per_s, "1/s", per_second(input_history->corrections[i].count, seconds),                          \
      "corrections of the own entity by this cause, per second", "The run has not reached warmup_s.")        \
    X(number, mean_m, "m",                                                                                   \
      ll_netgame_ratio(input_history->corrections[i].sum, (double)input_history->corrections[i].count),      \
      "mean size of the corrections by this cause", "There was no correction by this cause.")                \
    X(number, max_m, "m", input_history->corrections[i].count > 0 ? input_history->corrections[i].max : NAN, \
      "size of the largest correction by this cause", "There was no correction by this cause.")

#define REPLAY(X)                                                                                            \
    X(rate, replays_per_s, "1/s", per_second(input_history->replays, seconds),                               \
      "snapshots per second after which the client replayed inputs", "The run has not reached warmup_s.")    \
    X(rate, inputs_per_s, "1/s", per_second(input_history->replayed, seconds),                               \
      "inputs per second that the client replayed", "The run has not reached warmup_s.")

#define VALIDATION(X)                                                                                        \
    X(events, false_refusals, NULL, in->false_refusals, "refused inputs of a client that does not cheat",    \
      NULL)                                                                                                  \
    X(number, budget_used, NULL, ll_netgame_server(g)->client_slots[player].limits.budget_used,              \
      "largest share of the time budget in use; above 1 only without validation", NULL)                      \
    X(number, gain_m, "m", has_farthest ? in->gain.most : NAN,                                               \
      "distance that a cheat gained beyond the farthest that the game permits",                              \
      "The game does not define the farthest permitted distance.")                                           \
    X(number, gain_over_honest_m, "m", has_farthest ? in->honest.most : NAN,                                 \
      "distance that a cheat gained beyond the honest reference",                                            \
      "The game does not define the farthest permitted distance.")

#define REPORTS(X)                                                                                           \
    X(count, accepted, NULL, r->accepted, "states of its entity that the server took", NULL)                 \
    X(events, refused, NULL, r->refused,                                                                     \
      "states that the server refused by the rule movement: the entity could not have got there", NULL)      \
    X(count, missing, NULL, r->missing, "steps of the server for which no state had come", NULL)             \
    X(count, late, NULL, r->late, "states that came after their step", NULL)                                 \
    X(number, allowance_used_m, "m", r->used_m,                                                              \
      "distance beyond what the game permits that the server has taken, of reports.allowance_m", NULL)

#define ACKS(X)                                                                                              \
    X(rate, applied_per_s, "1/s", per_second(input_history->applied, seconds),                               \
      "inputs per second that the client takes as applied", "The run has not reached warmup_s.")             \
    X(rate, skipped_per_s, "1/s", per_second(input_history->skipped, seconds),                               \
      "inputs per second that the client takes as skipped", "The run has not reached warmup_s.")             \
    X(rate, wrong_per_s, "1/s", per_second(input_history->wrong, seconds),                                   \
      "inputs per second that the client takes as applied, although the snapshot does not include them",     \
      "The run has not reached warmup_s.")

const ll_metric_table ll_netgame_input_result_table = {
    LL_OF_PLAYERS(".inputs.results"),
    .help = "Results of the player's inputs, from time 0 on; `made` is the sum of the others.",
    LL_METRICS_FROM(RESULTS)};

const ll_metric_table ll_netgame_timed_table = {
    LL_OF_PLAYERS(".inputs"), .help = "The player's inputs, from warmup_s on.", LL_METRICS_FROM(TIMED)};

const ll_metric_table ll_netgame_cause_table = {
    LL_OF_PLAYERS(".corrections_by_cause.*"),
    .help = "Corrections of the own entity, by the first of these causes since the previous snapshot. "
            "refused: the server refused an input. late: an input arrived after its step, or is still in "
            "flight. loss: every packet with an input was lost. contact: another entity could act on the own "
            "one. other: none of these.",
    LL_METRICS_FROM(CAUSES)};

const ll_metric_table ll_netgame_replay_table = {
    LL_OF_PLAYERS(".replay"), .help = "Server reconciliation, from warmup_s on.", LL_METRICS_FROM(REPLAY)};

const ll_metric_table ll_netgame_validation_table = {
    LL_OF_PLAYERS(".validation"), .help = "Validation of inputs by the server, and the gain of cheats.",
    LL_METRICS_FROM(VALIDATION)};

const ll_metric_table ll_netgame_report_table = {
    LL_OF_PLAYERS(".reports"), .when = "Only with authority position.",
    .help = "The states of its own entity that the client reports, from time 0 on.",
    LL_METRICS_FROM(REPORTS)};

const ll_metric_table ll_netgame_ack_table = {
    LL_OF_PLAYERS(".acks"), .help = "Acknowledgement of inputs as the client believes, from warmup_s on.",
    LL_METRICS_FROM(ACKS)};

static void reports(cJSON *o, const ll_netgame *g, int player)
{
    if (!ll_netgame_reporter(g, player))
        return;
    const ll_report_slot *r = &ll_netgame_reports(g)->slot[player];
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "reports"), &ll_netgame_report_table, REPORTS);
}

void ll_netgame_inputs_metrics(const ll_netgame *g, int player, cJSON *o)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(g, player);
    const ll_input_history *input_history = &in->input_history;
    const ll_client_slot *client_slot = &ll_netgame_server(g)->client_slots[player];
    double seconds = ll_to_s(g->now - in->from);
    bool has_farthest = ll_netgame_game(g)->farthest != NULL;
    cJSON *causes = cJSON_AddObjectToObject(o, "corrections_by_cause");
    for (int i = 0; i < LL_CAUSES; i++)
        LL_METRICS_PUT(cJSON_AddObjectToObject(causes, ll_cause_names[i]), &ll_netgame_cause_table, CAUSES);
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "replay"), &ll_netgame_replay_table, REPLAY);
    cJSON *inputs = cJSON_GetObjectItem(o, "inputs");
    LL_METRICS_PUT(cJSON_AddObjectToObject(inputs, "results"), &ll_netgame_input_result_table, RESULTS);
    LL_METRICS_PUT(inputs, &ll_netgame_timed_table, TIMED);
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "validation"), &ll_netgame_validation_table, VALIDATION);
    reports(o, g, player);
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "acks"), &ll_netgame_ack_table, ACKS);
}

/* ---- detection of cheats ---- */

static double alarm_s(ll_time first)
{
    return first == LL_NEVER ? NAN : ll_to_s(first);
}

#define RATE(X)                                                                                              \
    X(events, alarms, NULL, r->alarms.count, "alarms: more inputs have arrived than time allows", NULL)      \
    X(events, false_alarms, NULL, r->alarms.mistaken, "of them, those while the player did not cheat", NULL) \
    X(number, first_alarm_s, "s", alarm_s(r->alarms.first), "time of the first alarm",                       \
      "There was no alarm.")                                                                                 \
    X(signed_number, sum, NULL, r->sum,                                                                      \
      "inputs that have arrived beyond those that time allows, now; negative: credit", NULL)                 \
    X(number, most, NULL, r->most, "largest value of the sum; above 80 it is an alarm", NULL)

#define REACTION(X)                                                                                          \
    X(events, alarms, NULL, w->alarms.count, "alarms: too many reactions were too fast for a person", NULL)  \
    X(events, false_alarms, NULL, w->alarms.mistaken, "of them, those while the player did not cheat", NULL) \
    X(number, first_alarm_s, "s", alarm_s(w->alarms.first), "time of the first alarm",                       \
      "There was no alarm.")                                                                                 \
    X(count, shots, NULL, w->shots,                                                                          \
      "reactions: hitscan shots at a body within a second after it came in sight in the shooter's view",     \
      NULL)                                                                                                  \
    X(events, fast, NULL, w->fast, "reactions below 100 ms", NULL)                                           \
    X(count, cleared, NULL, w->cleared, "tests that found the player honest", NULL)                          \
    X(signed_number, sum, NULL, w->sum,                                                                      \
      "logarithm of the likelihood ratio of the present test: 4.605 more for a reaction below 100 ms, "      \
      "0.104 "                                                                                               \
      "less for any other; alarm at 9.200, honest at -4.605",                                                \
      NULL)

#define AIM(X)                                                                                               \
    X(events, alarms, NULL, a->alarms.count, "alarms: too many aims snapped onto their target", NULL)        \
    X(events, false_alarms, NULL, a->alarms.mistaken, "of them, those while the player did not cheat", NULL) \
    X(number, first_alarm_s, "s", alarm_s(a->alarms.first), "time of the first alarm",                       \
      "There was no alarm.")                                                                                 \
    X(count, shots, NULL, a->shots,                                                                          \
      "turns: hitscan shots at a body within a second after the aim came onto it from outside", NULL)        \
    X(events, snaps, NULL, a->snaps,                                                                         \
      "snaps: turns whose last input moved the aim by more than 40 radii of the target per second", NULL)    \
    X(count, cleared, NULL, a->cleared, "tests that found the player honest", NULL)                          \
    X(signed_number, sum, NULL, a->sum,                                                                      \
      "logarithm of the likelihood ratio of the present test: 3.401 more for a snap, 0.347 less for any "    \
      "other turn; alarm at 9.200, honest at -4.605",                                                        \
      NULL)

const ll_metric_table ll_netgame_rate_table = {
    LL_OF_PLAYERS(".detection.rate"), .when = "Only with server.detection.",
    .help = "Detection of cheats by the rate of inputs, from time 0 on.", LL_METRICS_FROM(RATE)};

const ll_metric_table ll_netgame_reaction_table = {
    LL_OF_PLAYERS(".detection.reaction"), .when = "Only with server.detection, in games with weapons.",
    .help = "Detection of aim bots by reaction times, from time 0 on.", LL_METRICS_FROM(REACTION)};

const ll_metric_table ll_netgame_aim_table = {
    LL_OF_PLAYERS(".detection.aim"), .when = "Only with server.detection, in games with weapons.",
    .help = "Detection of aim bots by how fast the aim arrives at its target, from time 0 on.",
    LL_METRICS_FROM(AIM)};

void ll_netgame_detection_metrics(const ll_netgame *g, int player, cJSON *metrics)
{
    if (!ll_netgame_detection(g))
        return;
    const ll_rate_watch *r = &ll_netgame_detection(g)[player].rate;
    const ll_reaction_watch *w = &ll_netgame_detection(g)[player].reaction;
    cJSON *o = cJSON_AddObjectToObject(metrics, "detection");
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "rate"), &ll_netgame_rate_table, RATE);
    const ll_aim_watch *a = ll_netgame_aim_watch(g) ? &ll_netgame_aim_watch(g)[player] : NULL;
    if (!a)
        return;
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "reaction"), &ll_netgame_reaction_table, REACTION);
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "aim"), &ll_netgame_aim_table, AIM);
}

/* ---- the input history: the last inputs of each player with reconciliation, where its client predicted the
 * own entity after them, and where the server had it ---- */

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
    int64_t oldest = ll_client_oldest(c);
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
