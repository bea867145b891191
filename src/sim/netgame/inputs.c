/* Reports of inputs: how they were predicted, acknowledged and decided. */
#include <cjson/cJSON.h>
#include <math.h>

#include "sim/netgame/netgame.h"

static double per_second(int64_t count, double seconds)
{
    return ll_netgame_ratio((double)count, seconds > 0 ? seconds : 0);
}

/* ---- results of inputs ---- */

#define RESULTS(X)                                                                                           \
    X(count, made, NULL, input_history->made, "inputs that the client made", NULL)                           \
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
    X(number, late_per_s, "1/s", per_second(input_history->late, seconds),                                   \
      "inputs per second that arrived after their step", "The run has not reached warmup_s.")                \
    X(number, starved_per_s, "1/s",                                                                          \
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
    X(number, per_s, "1/s", per_second(input_history->corrections[i].count, seconds),                        \
      "corrections of the own entity by this cause, per second", "The run has not reached warmup_s.")        \
    X(number, mean_m, "m",                                                                                   \
      ll_netgame_ratio(input_history->corrections[i].sum, (double)input_history->corrections[i].count),      \
      "mean size of the corrections by this cause", "There was no correction by this cause.")                \
    X(number, max_m, "m", input_history->corrections[i].count > 0 ? input_history->corrections[i].max : NAN, \
      "size of the largest correction by this cause", "There was no correction by this cause.")

#define REPLAY(X)                                                                                            \
    X(number, replays_per_s, "1/s", per_second(input_history->replays, seconds),                             \
      "snapshots per second after which the client replayed inputs", "The run has not reached warmup_s.")    \
    X(number, inputs_per_s, "1/s", per_second(input_history->replayed, seconds),                             \
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

#define ACKS(X)                                                                                              \
    X(number, applied_per_s, "1/s", per_second(input_history->applied, seconds),                             \
      "inputs per second that the client takes as applied", "The run has not reached warmup_s.")             \
    X(number, skipped_per_s, "1/s", per_second(input_history->skipped, seconds),                             \
      "inputs per second that the client takes as skipped", "The run has not reached warmup_s.")             \
    X(number, wrong_per_s, "1/s", per_second(input_history->wrong, seconds),                                 \
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

const ll_metric_table ll_netgame_ack_table = {
    LL_OF_PLAYERS(".acks"), .help = "Acknowledgement of inputs as the client believes, from warmup_s on.",
    LL_METRICS_FROM(ACKS)};

void ll_netgame_inputs_metrics(const ll_netgame *g, int player, cJSON *o)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(g, player);
    const ll_input_history *input_history = &in->input_history;
    const ll_client_slot *client_slot = &ll_netgame_server(g)->client_slots[player];
    double seconds = ll_to_s(g->now - in->from);
    bool has_farthest = ll_netgame_game(g)->farthest != NULL;
    cJSON *causes = cJSON_AddObjectToObject(o, "corrections_by_cause");
    for (int i = 0; i < LL_CAUSES; i++) {
        LL_METRICS_PUT(cJSON_AddObjectToObject(causes, ll_cause_names[i]), &ll_netgame_cause_table, CAUSES);
    }
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "replay"), &ll_netgame_replay_table, REPLAY);
    cJSON *inputs = cJSON_GetObjectItem(o, "inputs");
    LL_METRICS_PUT(cJSON_AddObjectToObject(inputs, "results"), &ll_netgame_input_result_table, RESULTS);
    LL_METRICS_PUT(inputs, &ll_netgame_timed_table, TIMED);
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "validation"), &ll_netgame_validation_table, VALIDATION);
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "acks"), &ll_netgame_ack_table, ACKS);
}
