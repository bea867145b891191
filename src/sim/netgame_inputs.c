/* What is told of inputs: how they were predicted, acknowledged and judged. */
#include <cjson/cJSON.h>

#include "sim/netgame.h"

static void number(cJSON *object, const char *name, double value)
{
    cJSON_AddNumberToObject(object, name, value);
}

static double per_second(int64_t count, double seconds)
{
    return seconds > 0 ? (double)count / seconds : 0;
}

void ll_netgame_inputs_metrics(const ll_netgame *g, int player, cJSON *o)
{
    const ll_instruments *in = ll_netgame_instruments(g, player);
    double seconds = ll_to_s(g->now - in->from);
    cJSON *replay = cJSON_AddObjectToObject(o, "replay");
    number(replay, "replays_per_s", per_second(in->replays, seconds));
    number(replay, "inputs_per_s", per_second(in->replayed, seconds));
}
