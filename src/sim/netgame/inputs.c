/* Reports of inputs: how they were predicted, acknowledged and decided. */
#include <cjson/cJSON.h>
#include <math.h>

#include "sim/netgame/netgame.h"

static void number(cJSON *object, const char *name, double value)
{
    ll_netgame_number(object, name, value);
}

static double per_second(int64_t count, double seconds)
{
    return ll_netgame_ratio((double)count, seconds > 0 ? seconds : 0);
}

/* Metrics of the inputs, in addition to those that the report counts from the start. */
static void inputs(cJSON *o, const ll_input_history *input_history, const ll_client_slot *client_slot,
                   double seconds)
{
    cJSON *results = cJSON_AddObjectToObject(o, "verdicts");
    number(results, "made", (double)input_history->made);
    for (int i = 0; i < LL_INPUT_RESULT_KINDS; i++)
        number(results, ll_input_result_names[i], (double)input_history->count[i]);
    number(o, "late_per_s", per_second(input_history->late, seconds));
    number(o, "starved_per_s", per_second(client_slot->starved - input_history->starved_before, seconds));
    number(o, "extra_inputs", (double)input_history->doubled);
    number(o, "skipped_inputs", (double)input_history->left_out);
    ll_netgame_running_stats(o, "slack", &input_history->slack, 1);
    ll_netgame_running_stats(o, "scale", &input_history->scale, 1);
}

void ll_netgame_inputs_metrics(const ll_netgame *g, int player, cJSON *o)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(g, player);
    const ll_input_history *input_history = &in->input_history;
    double seconds = ll_to_s(g->now - in->from);
    cJSON *causes = cJSON_AddObjectToObject(o, "corrections_by_cause");
    for (int i = 0; i < LL_CAUSES; i++) {
        double count = (double)input_history->corrections[i].count;
        cJSON *cause = cJSON_AddObjectToObject(causes, ll_cause_names[i]);
        number(cause, "count", count);
        number(cause, "per_s", per_second(input_history->corrections[i].count, seconds));
        number(cause, "mean_m", ll_netgame_ratio(input_history->corrections[i].sum, count));
        number(cause, "max_m", count > 0 ? input_history->corrections[i].max : NAN);
    }
    cJSON *replay = cJSON_AddObjectToObject(o, "replay");
    number(replay, "replays_per_s", per_second(input_history->replays, seconds));
    number(replay, "inputs_per_s", per_second(input_history->replayed, seconds));
    inputs(cJSON_GetObjectItem(o, "inputs"), input_history, &ll_netgame_server(g)->client_slots[player],
           seconds);
    cJSON *validation = cJSON_AddObjectToObject(o, "validation");
    number(validation, "false_refusals", (double)in->false_refusals);
    number(validation, "budget_used", ll_netgame_server(g)->client_slots[player].budget_used);
    if (ll_netgame_game(g)->farthest) {
        number(validation, "gain_m", in->gain.most);
        number(validation, "twin_gain_m", in->twin.most);
    } else {
        cJSON_AddNullToObject(validation, "gain_m");
        cJSON_AddNullToObject(validation, "twin_gain_m");
    }
    cJSON *acks = cJSON_AddObjectToObject(o, "acks");
    number(acks, "applied_per_s", per_second(input_history->applied, seconds));
    number(acks, "skipped_per_s", per_second(input_history->skipped, seconds));
    number(acks, "wrong_per_s", per_second(input_history->wrong, seconds));
}
