/* Streamed sums of each player's view.
 *
 * Sums and counts, not means: a viewer takes the difference over any period, and a period without counts has
 * no mean. */
#include "sim/netgame/netgame.h"

typedef struct measure {
    uint8_t player;
    float age_of_information_ms;
    double own_timeline_error_sum_m, input_latency_sum_ms;
    uint32_t own_timeline_errors, input_latencies, input_changes, input_changes_lost, visible_corrections;
} measure;

static const ll_record_field measure_fields[] = {
    LL_INT(measure, player, NULL, "index of the player"),
    LL_STEP(measure, age_of_information_ms, LL_BITS_MS, "ms", "present age of information"),
    LL_STEP(measure, own_timeline_error_sum_m, LL_BITS_M, "m", "sum of the own timeline error over displays"),
    LL_STEP(measure, input_latency_sum_ms, LL_BITS_MS, "ms", "sum of the input latencies"),
    LL_INT(measure, own_timeline_errors, NULL, "displays in that sum"),
    LL_INT(measure, input_latencies, NULL, "changes of controls in that sum"),
    LL_INT(measure, input_changes, NULL, "changes of controls"),
    LL_INT(measure, input_changes_lost, NULL, "those that were never applied"),
    LL_INT(measure, visible_corrections, NULL, "displays with a visible correction"),
};

const ll_record ll_netgame_measure_record = {
    .id = 7,
    .name = "measures",
    .channel = LL_CHANNEL_GAUGES,
    .help = "Sums over each player's view from the warm-up on; a mean is the difference of two sums divided "
            "by that of their counts.",
    .form = LL_FORM_BY_INDEX,
    LL_ROWS_OF(measure, measure_fields)};

static measure measure_of(const ll_netgame *g, int i)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(g, i);
    const ll_histogram *error = &in->histogram[LL_METRIC_OWN_TIMELINE_ERROR],
                       *latency = &in->histogram[LL_METRIC_INPUT_LATENCY];
    return (measure){.player = (uint8_t)i,
                     .age_of_information_ms = (float)in->age_of_information,
                     .own_timeline_error_sum_m = error->sum,
                     .input_latency_sum_ms = latency->sum,
                     .own_timeline_errors = (uint32_t)error->count,
                     .input_latencies = (uint32_t)latency->count,
                     .input_changes = (uint32_t)(latency->count + latency->never),
                     .input_changes_lost = (uint32_t)in->changes.lost[LL_LATENCY_FELT],
                     .visible_corrections = (uint32_t)in->visible_m_all.count};
}

void ll_netgame_fill_measures(const ll_netgame *g, ll_row_set *rows)
{
    measure all[LL_PLAYERS_MAX];
    for (int i = 0; i < g->config.player_count; i++)
        all[i] = measure_of(g, i);
    ll_row_set_put(rows, &ll_netgame_measure_record, all, g->config.player_count);
}
