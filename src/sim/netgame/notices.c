/* Reasons why metrics of a netgame are null or meaningless, where the numbers do not show it. */
#include <cjson/cJSON.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "sim/netgame/netgame.h"

enum { NAMED = 3 /* players; of more it gives the number */ };

static void add_notice(cJSON *notices, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void add_notice(cJSON *notices, const char *format, ...)
{
    char text[400];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    cJSON_AddItemToArray(notices, cJSON_CreateString(text));
}

cJSON *ll_netgame_notices(const void *config)
{
    const ll_netgame_config *c = config;
    cJSON *notices = cJSON_CreateArray();
    if (c->head.duration_s <= c->warmup_s)
        add_notice(
            notices,
            "duration_s, %g s, is not longer than warmup_s, %g s, from which on metrics count: those that "
            "count from there are null.",
            c->head.duration_s, c->warmup_s);
    return notices;
}

/* ---- players ---- */

static int64_t count_of(const ll_netgame *g, int player, ll_metric metric)
{
    return ll_histogram_summary(&ll_netgame_client_metrics(g, player)->histogram[metric]).count;
}

static bool never_joined(const ll_netgame *g, int player)
{
    return ll_netgame_client(g, player)->connection.joins == 0;
}

static bool touched_nothing(const ll_netgame *g, int player)
{
    return !never_joined(g, player) && ll_netgame_client_metrics(g, player)->changes.made == 0 &&
           count_of(g, player, LL_METRIC_INPUT_LATENCY) == 0;
}

static bool is_alone(const ll_netgame *g, int player)
{
    return !never_joined(g, player) && count_of(g, player, LL_METRIC_REMOTE_ERROR) == 0;
}

static const struct reason {
    bool (*holds)(const ll_netgame *g, int player);
    const char *what; /* after the players' names */
} reasons[] = {
    {never_joined, "never joined: what is drawn there stands still, and errors against its own time "
                   "(own_timeline_error_m, timeline_error_m) mean nothing."},
    {touched_nothing, "did not change the controls from warmup_s on: latencies of such changes "
                      "(input_latency_ms, confirmed_latency_ms, seen_latency_ms) are null."},
    {is_alone, "had no other player in view from warmup_s on: metrics of the others (remote_error_m, "
               "timeline_error_m, view_age_ms) are null."},
};

/* `A`, `A and B`, `A, B and 5 others`; returns their number. */
static int name_players(const ll_netgame *g, const struct reason *reason, char *out, size_t size)
{
    int count = 0, named = 0;
    size_t used = 0;
    for (int i = 0; i < g->config.player_count; i++)
        count += reason->holds(g, i);
    int most = count > NAMED ? NAMED - 1 : count;
    out[0] = '\0';
    for (int i = 0; i < g->config.player_count && named < most; i++) {
        if (!reason->holds(g, i))
            continue;
        const char *between = named == 0 ? "" : named + 1 == count ? " and " : ", ";
        int length = snprintf(out + used, size - used, "%s%s", between, g->config.players[i].name);
        used += (size_t)length < size - used ? (size_t)length : size - used - 1;
        named++;
    }
    if (named < count)
        snprintf(out + used, size - used, " and %d others", count - named);
    return count;
}

void ll_netgame_add_notices(const ll_netgame *g, cJSON *metrics)
{
    cJSON *notices = ll_netgame_notices(&g->config);
    bool begun = ll_to_s(g->now) > g->config.warmup_s;
    char names[160];
    if (!begun && g->config.warmup_s > 0 && cJSON_GetArraySize(notices) == 0)
        add_notice(notices, "Metrics count from warmup_s, %g s, on; it is %g s.", g->config.warmup_s,
                   ll_to_s(g->now));
    for (size_t i = 0; begun && i < sizeof reasons / sizeof reasons[0]; i++)
        if (name_players(g, &reasons[i], names, sizeof names) > 0)
            add_notice(notices, "%s %s", names, reasons[i].what);
    cJSON_AddItemToObject(metrics, "notices", notices);
}
