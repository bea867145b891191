/* M11: how evenly the players are served. Per metric: the gap between the best and the worst served, Jain's
 * index (1: all alike, 1/n: one has it all), and what a millisecond of one's own round trip costs (least
 * squares). */
#include <cjson/cJSON.h>

#include "sim/netgame.h"

/* Paths in a player's metrics. */
static const struct {
    const char *name;
    const char *path;
} measures[] = {
    {"input_latency_ms", "input_latency_ms.mean"},
    {"view_age_ms", "view_age_ms.mean"},
    {"own_error_m", "own_error_m.rms"},
    {"remote_error_m", "remote_error_m.rms"},
    {"inconsistency_m_s_per_min", "inconsistency.server.sum_m_s_per_min"},
    {"hit_ratio", "shots.hit_ratio"},
};

static double round_trip_ms(const ll_player_config *p)
{
    return 2 * p->lag_ms + p->link.up.delay_ms + p->link.down.delay_ms;
}

typedef struct sums {
    double n, x, x2, y, xy; /* x: the measure, y: the round trip */
    double y2, min, max;
} sums;

static void add_number(cJSON *o, const char *name, double value)
{
    cJSON_AddNumberToObject(o, name, value);
}

static cJSON *fairness_json(const sums *s)
{
    cJSON *o = cJSON_CreateObject();
    double spread = s->n * s->y2 - s->y * s->y;
    add_number(o, "spread", s->max - s->min);
    add_number(o, "jain", s->x2 > 0 ? s->x * s->x / (s->n * s->x2) : 1);
    add_number(o, "per_ms_of_round_trip", spread > 0 ? (s->n * s->xy - s->x * s->y) / spread : 0);
    return o;
}

void ll_netgame_add_fairness(const ll_netgame *g, cJSON *server, const cJSON *players)
{
    cJSON *fairness = cJSON_AddObjectToObject(server, "fairness");
    for (size_t m = 0; m < sizeof measures / sizeof measures[0]; m++) {
        sums s = {0};
        for (int i = 0; i < g->config.player_count; i++) {
            const cJSON *value = ll_param_number_at(cJSON_GetArrayItem(players, i), measures[m].path);
            if (!value)
                continue;
            double x = value->valuedouble, y = round_trip_ms(&g->config.players[i]);
            s.min = s.n == 0 || x < s.min ? x : s.min;
            s.max = s.n == 0 || x > s.max ? x : s.max;
            s.n++;
            s.x += x;
            s.x2 += x * x;
            s.y += y;
            s.y2 += y * y;
            s.xy += x * y;
        }
        if (s.n > 1)
            cJSON_AddItemToObject(fairness, measures[m].name, fairness_json(&s));
    }
}
