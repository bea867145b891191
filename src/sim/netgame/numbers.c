/* Numbers of the metrics: null where nothing was counted. */
#include <cjson/cJSON.h>
#include <math.h>

#include "sim/netgame/netgame.h"

void ll_netgame_number(cJSON *object, const char *name, double value)
{
    if (value - value == 0)
        cJSON_AddNumberToObject(object, name, value);
    else
        cJSON_AddNullToObject(object, name);
}

double ll_netgame_ratio(double part, double whole)
{
    return whole != 0 ? part / whole : NAN;
}

void ll_netgame_distribution(cJSON *object, const char *name, ll_summary s)
{
    cJSON *o = cJSON_AddObjectToObject(object, name);
    ll_netgame_number(o, "mean", s.mean);
    ll_netgame_number(o, "rms", s.rms);
    ll_netgame_number(o, "p50", s.p50);
    ll_netgame_number(o, "p95", s.p95);
    ll_netgame_number(o, "p99", s.p99);
    ll_netgame_number(o, "max", s.max);
    ll_netgame_number(o, "count", (double)s.count);
}
