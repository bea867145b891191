/* What is told of the players' views: M7 to M9. */
#include <cjson/cJSON.h>

#include "base/detmath.h"
#include "sim/netgame.h"

static void number(cJSON *object, const char *name, double value)
{
    cJSON_AddNumberToObject(object, name, value);
}

static double ratio(double a, double b)
{
    return b > 0 ? a / b : 0;
}

/* Over all entities of others together. */
static void smoothness(cJSON *player, const ll_instruments *in)
{
    ll_smoothness sum = {0};
    for (int i = 0; i < in->entities; i++) {
        const ll_smoothness *s = &in->track[i].smooth;
        sum.acceleration += s->acceleration;
        sum.jerk += s->jerk;
        sum.frames += s->frames;
        sum.seconds += s->seconds;
        sum.moving += s->moving;
        sum.frozen += s->frozen;
        sum.reversals += s->reversals;
        sum.step_max = s->step_max > sum.step_max ? s->step_max : sum.step_max;
        sum.truth_step_sum += s->truth_step_sum;
    }
    double frames = (double)sum.frames, moving = (double)sum.moving;
    cJSON *o = cJSON_AddObjectToObject(player, "smoothness");
    number(o, "acceleration_rms_mps2", ll_sqrt(ratio(sum.acceleration, frames)));
    number(o, "jerk_rms_mps3", ll_sqrt(ratio(sum.jerk, frames)));
    number(o, "freeze_ratio", ratio((double)sum.frozen, moving));
    number(o, "reversals_per_s", ratio((double)sum.reversals, sum.seconds));
    number(o, "step_max_m", sum.step_max);
    number(o, "step_max_over_mean", ratio(sum.step_max, ratio(sum.truth_step_sum, moving)));
}

static void gauge(cJSON *object, const char *name, const ll_gauge *g)
{
    cJSON *o = cJSON_AddObjectToObject(object, name);
    number(o, "mean", ratio(g->sum, (double)g->count));
    number(o, "min", g->min);
    number(o, "max", g->max);
}

static void buffer(cJSON *player, const ll_instruments *in, const ll_client *client)
{
    cJSON *o = cJSON_AddObjectToObject(player, "buffer");
    number(o, "underruns", (double)in->underruns);
    number(o, "overruns", (double)in->overruns);
    number(o, "held_ratio", ratio((double)in->held_frames, (double)in->frames));
    number(o, "extrapolated_ratio", ratio((double)in->extrapolated_frames, (double)in->frames));
    number(o, "stale_states", (double)client->stale);
    gauge(o, "depth_states", &in->depth);
    gauge(o, "delay_ms", &in->delay_ms);
    gauge(o, "time_scale", &in->time_scale);
}

/* The mean of all entities. */
static void excursions(cJSON *object, const char *name, const ll_inconsistency *total, double entities,
                       double seconds)
{
    cJSON *o = cJSON_AddObjectToObject(object, name);
    number(o, "sum_m_s_per_min", ratio(total->sum / entities, seconds / 60));
    number(o, "time_ratio", ratio(ll_to_s(total->time) / entities, seconds));
    number(o, "excursions", (double)total->excursions);
}

void ll_netgame_view_metrics(const ll_netgame *g, int player, cJSON *object)
{
    const ll_instruments *in = ll_netgame_instruments(g, player);
    double seconds = ll_to_s(g->now - in->from);
    smoothness(object, in);
    buffer(object, in, ll_netgame_client(g, player));
    cJSON *o = cJSON_AddObjectToObject(object, "inconsistency");
    excursions(o, "server", &in->server, in->entities, seconds);
    excursions(o, "clients", &in->clients, in->entities, seconds);
}
