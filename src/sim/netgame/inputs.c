/* Reports of inputs: how they were predicted, acknowledged and decided. */
#include <cjson/cJSON.h>
#include <math.h>

#include "sim/netgame/netgame.h"

static double per_second(int64_t count, double seconds)
{
    return ll_netgame_ratio((double)count, seconds > 0 ? seconds : 0);
}

/* ---- what became of inputs ---- */

#define VERDICTS(X)                                                                                          \
    X(count, made, NULL, input_history->made, "by the client", NULL)                                         \
    X(count, open, NULL, input_history->count[LL_INPUT_IS_OPEN], "without a result yet", NULL)               \
    X(count, applied, NULL, input_history->count[LL_INPUT_WAS_APPLIED],                                      \
      "the server made the step that it was for, with it", NULL)                                             \
    X(count, refused, NULL, input_history->count[LL_INPUT_WAS_REFUSED], "it broke a rule", NULL)             \
    X(count, late, NULL, input_history->count[LL_INPUT_CAME_LATE], "it came after its step", NULL)           \
    X(count, lost, NULL, input_history->count[LL_INPUT_WAS_LOST], "its step is over and it has not come",    \
      NULL)

#define TIMED(X)                                                                                             \
    X(number, late_per_s, "1/s", per_second(input_history->late, seconds),                                   \
      "inputs that came after their step", "It is before warmup_s.")                                         \
    X(number, starved_per_s, "1/s",                                                                          \
      per_second(client_slot->starved - input_history->starved_before, seconds), "steps without an input",   \
      "It is before warmup_s.")                                                                              \
    X(count, extra_inputs, NULL, input_history->doubled, "inputs made beyond one a frame", NULL)             \
    X(count, skipped_inputs, NULL, input_history->left_out, "frames without an input", NULL)                 \
    X(gauge, slack, "ticks", ll_netgame_gauge(&input_history->slack, 1),                                     \
      "that each input came early (under free)", "No input came.")                                           \
    X(gauge, scale, NULL, ll_netgame_gauge(&input_history->scale, 1),                                        \
      "how much faster than its own rate the client's frames came", "No frame.")

#define CAUSES(X)                                                                                            \
    X(count, count, NULL, input_history->corrections[i].count, "corrections", NULL)                          \
    X(number, per_s, "1/s", per_second(input_history->corrections[i].count, seconds), "corrections",         \
      "It is before warmup_s.")                                                                              \
    X(number, mean_m, "m",                                                                                   \
      ll_netgame_ratio(input_history->corrections[i].sum, (double)input_history->corrections[i].count),      \
      "their size", "There was none.")                                                                       \
    X(number, max_m, "m", input_history->corrections[i].count > 0 ? input_history->corrections[i].max : NAN, \
      "the largest", "There was none.")

#define REPLAY(X)                                                                                            \
    X(number, replays_per_s, "1/s", per_second(input_history->replays, seconds),                             \
      "states after which inputs were applied again", "It is before warmup_s.")                              \
    X(number, inputs_per_s, "1/s", per_second(input_history->replayed, seconds), "inputs that were",         \
      "It is before warmup_s.")

#define VALIDATION(X)                                                                                        \
    X(events, false_refusals, NULL, in->false_refusals, "refusals of a client that does not cheat", NULL)    \
    X(number, budget_used, NULL, ll_netgame_server(g)->client_slots[player].budget_used,                     \
      "the most of the time budget that was in use, as a share; above 1 only without validation", NULL)      \
    X(number, gain_m, "m", told ? in->gain.most : NAN, "what a cheat brought beyond what one may come",      \
      "The game does not define the farthest one may come.")                                                 \
    X(number, twin_gain_m, "m", told ? in->twin.most : NAN, "what it brought beyond its honest twin",        \
      "The game does not define the farthest one may come.")

#define ACKS(X)                                                                                              \
    X(number, applied_per_s, "1/s", per_second(input_history->applied, seconds), "inputs taken as applied",  \
      "It is before warmup_s.")                                                                              \
    X(number, skipped_per_s, "1/s", per_second(input_history->skipped, seconds), "inputs taken as skipped",  \
      "It is before warmup_s.")                                                                              \
    X(number, wrong_per_s, "1/s", per_second(input_history->wrong, seconds),                                 \
      "taken as applied, though the state is without it", "It is before warmup_s.")

const ll_metric_table ll_netgame_verdict_table = {
    LL_OF_PLAYERS(".inputs.verdicts"),
    .help = "what became of each input, from 0 on; `made` is the sum of the others.",
    LL_METRICS_FROM(VERDICTS)};

const ll_metric_table ll_netgame_timed_table = {LL_OF_PLAYERS(".inputs"), .help = "inputs, from warmup_s on.",
                                                LL_METRICS_FROM(TIMED)};

const ll_metric_table ll_netgame_cause_table = {
    LL_OF_PLAYERS(".corrections_by_cause.*"),
    .help = "corrections by what went wrong since the state before, the first of: refused, late, loss, "
            "contact, other.",
    LL_METRICS_FROM(CAUSES)};

const ll_metric_table ll_netgame_replay_table = {
    LL_OF_PLAYERS(".replay"), .help = "reconciliation, from warmup_s on.", LL_METRICS_FROM(REPLAY)};

const ll_metric_table ll_netgame_validation_table = {
    LL_OF_PLAYERS(".validation"), .help = "what the server refuses, and what cheats bring.",
    LL_METRICS_FROM(VALIDATION)};

const ll_metric_table ll_netgame_ack_table = {
    LL_OF_PLAYERS(".acks"), .help = "what the client believes, from warmup_s on.", LL_METRICS_FROM(ACKS)};

void ll_netgame_inputs_metrics(const ll_netgame *g, int player, cJSON *o)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(g, player);
    const ll_input_history *input_history = &in->input_history;
    const ll_client_slot *client_slot = &ll_netgame_server(g)->client_slots[player];
    double seconds = ll_to_s(g->now - in->from);
    bool told = ll_netgame_game(g)->farthest != NULL;
    cJSON *causes = cJSON_AddObjectToObject(o, "corrections_by_cause");
    for (int i = 0; i < LL_CAUSES; i++) {
        LL_METRICS_PUT(cJSON_AddObjectToObject(causes, ll_cause_names[i]), &ll_netgame_cause_table, CAUSES);
    }
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "replay"), &ll_netgame_replay_table, REPLAY);
    cJSON *inputs = cJSON_GetObjectItem(o, "inputs");
    LL_METRICS_PUT(cJSON_AddObjectToObject(inputs, "verdicts"), &ll_netgame_verdict_table, VERDICTS);
    LL_METRICS_PUT(inputs, &ll_netgame_timed_table, TIMED);
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "validation"), &ll_netgame_validation_table, VALIDATION);
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "acks"), &ll_netgame_ack_table, ACKS);
}
