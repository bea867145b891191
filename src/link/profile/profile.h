/* What few links have beyond their rows: measured capacity or delay, slots, cells, ECN, a table of delays, a
 * length of fibre. A scenario lists profiles once, and a direction of a link names one. A link without one
 * holds and pays nothing of this. docs/links.md has every rule. */
#pragma once

#include "base/vtime.h"
#include "param/param.h"

#define LL_PROFILES_MAX 4             /* of a scenario */
#define LL_CAPACITY_MAX 8192          /* opportunities of a trace of capacity */
#define LL_TRACE_MAX 2048             /* rows of a trace of delay and loss */
#define LL_DELAY_TABLE_MAX 4096       /* values, as many as those of netem's own tables */
#define LL_OPPORTUNITY_BYTES 1504     /* that one opportunity sends, as in Mahimahi */
#define LL_DELAY_TABLE_SCALE 8192     /* netem's: the table's value of one jitter_ms */
#define LL_FIBRE_KM_PER_MS 199.861639 /* two thirds of the speed of light, 299,792.458 km/s */

/* idle: a packet that finds nothing waiting waits a whole slot, as in netem. grid: slots begin at whole
 * multiples of their length, so that it waits half of one in the mean. */
typedef enum ll_slot_start { LL_SLOT_IDLE, LL_SLOT_GRID } ll_slot_start;

/* As a scenario gives it; `ll_profile_table` has names, ranges and defaults. */
typedef struct ll_profile_params {
    double distance_km, route_factor;
    double slot_min_ms, slot_max_ms; /* 0 and 0: no slots */
    int64_t slot_packets, slot_bytes;
    int64_t cell_bytes, cell_overhead_bytes; /* cell 0: none */
    int32_t slot_start;                      /* ll_slot_start */
    int32_t capacity_count, table_count, time_count, delay_count, lost_count;
    bool ecn, reserved[7];
    double capacity_ms[LL_CAPACITY_MAX]; /* not decreasing; the last one is the period */
    double delay_table[LL_DELAY_TABLE_MAX];
    double trace_t_ms[LL_TRACE_MAX], trace_delay_ms[LL_TRACE_MAX], trace_lost[LL_TRACE_MAX];
} ll_profile_params;

extern const ll_param_table ll_profile_table;
extern const char *const ll_profile_names[]; /* none, profile_0, ...: the choices of a direction */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded"

/* The same in a block: as long as its samples. They follow: stamps of capacity, stamps of the trace (ns),
 * then its delays in ms and its losses, and the table. */
typedef struct ll_link_profile {
    double distance_ms, slot_min_ms, slot_max_ms;
    int64_t slot_packets, slot_bytes, cell_bytes, cell_overhead_bytes;
    int32_t slot_start, ecn;
    int32_t capacity_count, trace_count, table_count, reserved;
} ll_link_profile;

/* What a direction remembers of it between packets. */
typedef struct ll_profile_state {
    int64_t opportunity;              /* in use; over all turns of the trace */
    int64_t used;                     /* bytes of it */
    ll_time slot, last;               /* the slot in use, and when the last packet left it */
    int64_t slot_packets, slot_bytes; /* that still fit */
    int64_t marked;                   /* packets and copies, since the statistics began */
    int64_t trace_lost;               /* packets and copies that the trace lost, likewise */
} ll_profile_state;

#pragma GCC diagnostic pop

size_t ll_profile_size(const ll_profile_params *params); /* of a profile with its samples; a multiple of 8 */
void ll_profile_init(ll_link_profile *profile, const ll_profile_params *params);
void ll_profile_state_init(ll_profile_state *state);

const int64_t *ll_profile_capacity(const ll_link_profile *profile); /* ns */
const int64_t *ll_profile_trace_times(const ll_link_profile *profile);
const double *ll_profile_trace_delays(const ll_link_profile *profile);
const double *ll_profile_trace_losses(const ll_link_profile *profile);
const double *ll_profile_delay_table(const ll_link_profile *profile);

/* Largest value of the table, in jitter_ms; largest delay of the trace, in ms. 0 without them. */
double ll_profile_table_max(const ll_profile_params *params);
double ll_profile_trace_max_ms(const ll_profile_params *params);
double ll_profile_distance_ms(const ll_profile_params *params);
