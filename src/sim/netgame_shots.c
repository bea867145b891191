/* What is told of shots: M10. */
#include <cjson/cJSON.h>

#include "sim/netgame.h"

static void number(cJSON *object, const char *name, double value)
{
    cJSON_AddNumberToObject(object, name, value);
}

static void share(cJSON *object, const char *name, int64_t part, int64_t whole)
{
    number(object, name, whole > 0 ? (double)part / (double)whole : 0);
}

static void tally(cJSON *parent, const char *name, const ll_shot_tally *t)
{
    static const char *const hits[LL_JUDGES] = {[LL_JUDGE_VIEW] = "client_view_hits",
                                                [LL_JUDGE_NOW] = "server_now_hits",
                                                [LL_JUDGE_SERVER] = "compensated_hits",
                                                [LL_JUDGE_PERFECT] = "perfect_hits"};
    cJSON *o = cJSON_AddObjectToObject(parent, name);
    number(o, "shots", (double)t->shots);
    number(o, "lost", (double)t->lost);
    for (int j = 0; j < LL_JUDGES; j++)
        number(o, hits[j], (double)t->hits[j]);
    share(o, "agreement", t->agreed, t->shots);
    number(o, "shots_within_max_rewind", (double)t->within);
    share(o, "agreement_within_max_rewind", t->within_agreed, t->within);
    number(o, "false_hits", (double)t->false_hits);
    number(o, "false_misses", (double)t->false_misses);
    share(o, "favour_the_shooter", t->kept, t->hits[LL_JUDGE_VIEW]);
    number(o, "hits_on_players", (double)t->on_players);
    number(o, "shot_behind_cover", (double)t->behind_cover);
    number(o, "clamped", (double)t->clamped);
    number(o, "distrusted", (double)t->distrusted);
}

void ll_netgame_shots_metrics(const ll_netgame *g, int player, cJSON *metrics)
{
    if (!ll_netgame_shots(g))
        return;
    const ll_marksman *m = &ll_netgame_shots(g)->marksman[player];
    cJSON *o = cJSON_AddObjectToObject(metrics, "shots");
    tally(o, "rifle", &m->tally[LL_RIFLE]);
    tally(o, "shell", &m->tally[LL_CANNON]);
    ll_netgame_distribution(o, "rollback_distance_m", ll_histogram_summary(&m->rollback));
    ll_netgame_distribution(o, "rewind_ms", ll_histogram_summary(&m->rewind));
    ll_netgame_distribution(o, "trace_error_m", ll_histogram_summary(&m->trace_error));
    ll_netgame_distribution(o, "peeker_advantage_ms", ll_histogram_summary(&m->peek));
}
