#include "link/profile/profile.h"

#include <string.h>

/* ---- in a block ---- */

size_t ll_profile_size(const ll_profile_params *p)
{
    size_t samples = (size_t)p->capacity_count + 3 * (size_t)p->time_count + (size_t)p->table_count;
    return sizeof(ll_link_profile) + samples * sizeof(double);
}

const int64_t *ll_profile_capacity(const ll_link_profile *p)
{
    return (const int64_t *)(p + 1);
}

const int64_t *ll_profile_trace_times(const ll_link_profile *p)
{
    return ll_profile_capacity(p) + p->capacity_count;
}

const double *ll_profile_trace_delays(const ll_link_profile *p)
{
    return (const double *)(ll_profile_trace_times(p) + p->trace_count);
}

const double *ll_profile_trace_losses(const ll_link_profile *p)
{
    return ll_profile_trace_delays(p) + p->trace_count;
}

const double *ll_profile_delay_table(const ll_link_profile *p)
{
    return ll_profile_trace_losses(p) + p->trace_count;
}

static void copy_times(const int64_t *to, const double *ms, int32_t count)
{
    for (int32_t i = 0; i < count; i++)
        ((int64_t *)to)[i] = ll_ms(ms[i]);
}

static void copy_numbers(const double *to, const double *from, int32_t count)
{
    memcpy((double *)to, from, (size_t)count * sizeof *from);
}

void ll_profile_init(ll_link_profile *p, const ll_profile_params *from)
{
    *p = (ll_link_profile){.distance_ms = ll_profile_distance_ms(from),
                           .slot_min_ms = from->slot_min_ms,
                           .slot_max_ms = from->slot_max_ms,
                           .slot_packets = from->slot_packets,
                           .slot_bytes = from->slot_bytes,
                           .cell_bytes = from->cell_bytes,
                           .cell_overhead_bytes = from->cell_overhead_bytes,
                           .slot_start = from->slot_start,
                           .ecn = from->ecn,
                           .capacity_count = from->capacity_count,
                           .trace_count = from->time_count,
                           .table_count = from->table_count};
    copy_times(ll_profile_capacity(p), from->capacity_ms, p->capacity_count);
    copy_times(ll_profile_trace_times(p), from->trace_t_ms, p->trace_count);
    copy_numbers(ll_profile_trace_delays(p), from->trace_delay_ms, p->trace_count);
    copy_numbers(ll_profile_trace_losses(p), from->trace_lost, p->trace_count);
    copy_numbers(ll_profile_delay_table(p), from->delay_table, p->table_count);
}

void ll_profile_state_init(ll_profile_state *state)
{
    *state = (ll_profile_state){.opportunity = INT64_MIN, .slot = LL_LONG_AGO, .last = LL_LONG_AGO};
}

/* ---- bounds ---- */

static double largest(const double *x, int32_t count)
{
    double most = 0;
    for (int32_t i = 0; i < count; i++)
        most = x[i] > most ? x[i] : most;
    return most;
}

double ll_profile_table_max(const ll_profile_params *p)
{
    return largest(p->delay_table, p->table_count) / LL_DELAY_TABLE_SCALE;
}

double ll_profile_trace_max_ms(const ll_profile_params *p)
{
    return largest(p->trace_delay_ms, p->time_count);
}

double ll_profile_distance_ms(const ll_profile_params *p)
{
    return p->distance_km * p->route_factor / LL_FIBRE_KM_PER_MS;
}
