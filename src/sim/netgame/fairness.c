/* Fairness: how evenly the players are served. Per metric: the gap between the best and the worst served
 * player, the Jain index (1: all alike, 1/n: one has everything), and the cost of one millisecond of a
 * player's own round trip (least squares). The round trip is the measured mean delay of the player's link up
 * plus that of its link down. */
#include <cjson/cJSON.h>
#include <math.h>

#include "sim/netgame/netgame.h"

/* Paths in a player's metrics. */
static const struct {
    const char *name;
    const char *path;
    bool armed; /* in games with weapons */
} measures[] = {
    {"input_latency_ms", "input_latency_ms.mean", false},
    {"view_age_ms", "view_age_ms.mean", false},
    {"age_of_information_ms", "age_of_information_ms.mean", false},
    {"own_timeline_error_m", "own_timeline_error_m.rms", false},
    {"remote_error_m", "remote_error_m.rms", false},
    {"inconsistency_m_s_per_min", "inconsistency.server.sum_m_s_per_min", false},
    {"hit_ratio", "shots.hit_ratio", true},
};

static double mean_delay_ms(const ll_link *link)
{
    const ll_link_stats *s = ll_link_get_stats(link);
    return ll_netgame_ratio(s->delay.sum_ms, (double)ll_link_put_on_way(s));
}

static double round_trip_ms(const ll_netgame *g, int i)
{
    return mean_delay_ms(ll_netgame_up(g, i)) + mean_delay_ms(ll_netgame_down(g, i));
}

typedef struct sums {
    double n, x, x2, y2; /* x: the measure, y: the round trip */
    double min, max;
    double from_x, from_y;     /* the first player's */
    double dx, dy, dy2, dx_dy; /* minus these, so that close round trips do not cancel */
} sums;

static void add(sums *s, double x, double y)
{
    if (s->n == 0) {
        s->min = s->max = s->from_x = x;
        s->from_y = y;
    }
    double dx = x - s->from_x, dy = y - s->from_y;
    s->min = x < s->min ? x : s->min;
    s->max = x > s->max ? x : s->max;
    s->n++;
    s->x += x;
    s->x2 += x * x;
    s->y2 += y * y;
    s->dx += dx;
    s->dy += dy;
    s->dy2 += dy * dy;
    s->dx_dy += dx * dy;
}

#define FAIRNESS(X)                                                                                          \
    X(number, spread, NULL, several ? s->max - s->min : NAN,                                                 \
      "largest less smallest value of the measure among the players, in the unit of the measure",            \
      "Fewer than two players have the measure.")                                                            \
    X(number, jain, NULL, several ? jain : NAN,                                                              \
      "Jain index of the measure: 1 when all players have the same value, or all have 0; 1/n when one of n " \
      "players has everything",                                                                              \
      "Fewer than two players have the measure.")                                                            \
    X(number, per_ms_of_round_trip, "1/ms",                                                                  \
      several &&spread > least ? (s->n * s->dx_dy - s->dx * s->dy) / spread : NAN,                           \
      "change of the measure per millisecond of a player's own round-trip time, by least squares; the "      \
      "round-trip time is the mean delay of link_up plus that of link_down",                                 \
      "Fewer than two players have the measure, or all round-trip times are equal.")

const ll_metric_table ll_netgame_fairness_table = {
    LL_OF_RUN("server.fairness.*"),
    .help = "How evenly a measure is distributed among the players; hit_ratio only in games with weapons.",
    LL_METRICS_FROM(FAIRNESS)};

static cJSON *fairness_json(const sums *s)
{
    cJSON *o = cJSON_CreateObject();
    bool several = s->n > 1;
    double spread = s->n * s->dy2 - s->dy * s->dy, least = 1e-9 * s->n * s->y2; /* rounding error */
    double jain = s->x2 > 0 ? s->x * s->x / (s->n * s->x2) : 1;
    LL_METRICS_PUT(o, &ll_netgame_fairness_table, FAIRNESS);
    return o;
}

void ll_netgame_add_fairness(const ll_netgame *g, cJSON *server, const cJSON *players)
{
    cJSON *fairness = cJSON_AddObjectToObject(server, "fairness");
    for (size_t m = 0; m < sizeof measures / sizeof measures[0]; m++) {
        sums s = {0};
        if (measures[m].armed && !ll_netgame_shots(g))
            continue;
        for (int i = 0; i < g->config.player_count; i++) {
            const cJSON *value = ll_param_number_at(cJSON_GetArrayItem(players, i), measures[m].path);
            double x = value ? value->valuedouble : NAN, y = round_trip_ms(g, i);
            if (!(x - x == 0 && y - y == 0))
                continue; /* no value was counted, or no packet has arrived */
            add(&s, x, y);
        }
        cJSON_AddItemToObject(fairness, measures[m].name, fairness_json(&s));
    }
}
