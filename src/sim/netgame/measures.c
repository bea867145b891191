/* What is counted of each player's view: section 10 of session/frame.h.
 *
 * Sums and counts, not means: who looks takes the difference over as long as it wants, and where nothing was
 * counted there is no mean. */
#include <cjson/cJSON.h>
#include <stddef.h>

#include "sim/netgame/netgame.h"

enum { SECTION_MEASURES = 10 };

typedef struct measures_record {
    uint8_t player, reserved[3];
    float age_of_information_ms;
    double own_timeline_error_sum_m, input_latency_sum_ms;
    uint32_t own_timeline_errors, input_latencies, input_changes, input_changes_lost;
    uint32_t visible_corrections, reserved_2;
} measures_record;

_Static_assert(sizeof(measures_record) == 48, "the layout of session/frame.h");

static measures_record record_of(const ll_netgame *g, int i)
{
    const ll_instruments *in = ll_netgame_instruments(g, i);
    const ll_histogram *error = &in->histogram[LL_METRIC_OWN_TIMELINE_ERROR],
                       *latency = &in->histogram[LL_METRIC_INPUT_LATENCY];
    return (measures_record){.player = (uint8_t)i,
                             .age_of_information_ms = (float)in->age_of_information,
                             .own_timeline_error_sum_m = error->sum,
                             .input_latency_sum_ms = latency->sum,
                             .own_timeline_errors = (uint32_t)error->count,
                             .input_latencies = (uint32_t)latency->count,
                             .input_changes = (uint32_t)(latency->count + latency->never),
                             .input_changes_lost = (uint32_t)in->changes.lost[LL_LATENCY_FELT],
                             .visible_corrections = (uint32_t)in->visible_m_all.count};
}

void ll_netgame_measures_section(const ll_netgame *g,
                                 void (*section)(void *context, int type, int count, const void *bytes,
                                                 size_t size),
                                 void *context)
{
    measures_record records[LL_PLAYERS_MAX];
    int n = g->config.player_count;
    for (int i = 0; i < n; i++)
        records[i] = record_of(g, i);
    section(context, SECTION_MEASURES, n, records, (size_t)n * sizeof records[0]);
}

void ll_netgame_measures_section_json(const ll_netgame *g, cJSON *frame)
{
    cJSON *measures = cJSON_AddArrayToObject(frame, "measures");
    for (int i = 0; i < g->config.player_count; i++) {
        measures_record r = record_of(g, i);
        cJSON *o = cJSON_CreateObject();
        cJSON_AddItemToArray(measures, o);
        ll_netgame_number(o, "player", r.player);
        ll_netgame_number(o, "age_of_information_ms", (double)r.age_of_information_ms);
        ll_netgame_number(o, "own_timeline_error_sum_m", r.own_timeline_error_sum_m);
        ll_netgame_number(o, "input_latency_sum_ms", r.input_latency_sum_ms);
        ll_netgame_number(o, "own_timeline_errors", r.own_timeline_errors);
        ll_netgame_number(o, "input_latencies", r.input_latencies);
        ll_netgame_number(o, "input_changes", r.input_changes);
        ll_netgame_number(o, "input_changes_lost", r.input_changes_lost);
        ll_netgame_number(o, "visible_corrections", r.visible_corrections);
    }
}
