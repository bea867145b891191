/* Rows and rules of a profile. */
#include <stdio.h>

#include "link/profile/profile.h"

const char *const ll_profile_names[] = {"none", "profile_0", "profile_1", "profile_2", "profile_3", NULL};
_Static_assert(sizeof ll_profile_names / sizeof ll_profile_names[0] == LL_PROFILES_MAX + 2,
               "a name for each profile");

static const char *const slot_starts[] = {"idle", "grid", NULL};

#define AT(NAME) .name = #NAME, .offset = offsetof(ll_profile_params, NAME)
#define REAL(NAME) AT(NAME), .type = LL_PARAM_REAL
#define INT(NAME) AT(NAME), .type = LL_PARAM_INT
#define NUMBERS(NAME, COUNT, MAX, LEAST, MOST)                                                               \
    AT(NAME), .type = LL_PARAM_NUMBERS, .count_offset = offsetof(ll_profile_params, COUNT), .max = (MAX),    \
              .vector = {LEAST, MOST}
#define HOUR_MS 3600000

static const ll_param rows[] = {
    {REAL(distance_km), .max = 40000, .unit = "km",
     .help = "Length of the way: adds the time of light in fibre, two thirds of that in vacuum: 0.0050035 ms "
             "per km."},
    {REAL(route_factor), .min = 1, .max = 5, .default_value = 1,
     .help = "Length of the fibre over distance_km, where that is a straight line."},
    {REAL(slot_min_ms), .max = 500, .unit = "ms",
     .help = "Shortest slot; with slot_start grid the same as "
             "slot_max_ms."},
    {REAL(slot_max_ms), .max = 500, .unit = "ms",
     .help = "Longest slot: packets leave only where a slot begins; lengths are uniform from slot_min_ms. 0: "
             "no slots."},
    {INT(slot_packets), .min = 1, .max = 1000, .default_value = 1000,
     .help = "Packets that leave in one slot."},
    {INT(slot_bytes), .min = 1, .max = 10000000, .default_value = 10000000, .unit = "B",
     .help = "Bytes after which a slot is full, headers included."},
    {AT(slot_start), .type = LL_PARAM_CHOICE, .choices = slot_starts,
     .help =
         "idle: a slot begins when a packet comes to a link where none waits, which so waits a whole one. "
         "grid: slots begin at fixed times."},
    {INT(cell_bytes), .max = 1500, .unit = "B",
     .help = "Bytes of a cell, 48 in ATM: packets travel in whole cells. 0: no cells. Needs a rate or a "
             "capacity."},
    {INT(cell_overhead_bytes), .max = 1500, .unit = "B", .help = "Header of each cell; 5 in ATM."},
    {AT(ecn), .type = LL_PARAM_BOOL,
     .help = "ECN: packets that the loss model would drop are marked and arrive."},
    {NUMBERS(delay_table, table_count, LL_DELAY_TABLE_MAX, -32768, 32767),
     .help = "Delays as a table of netem: a packet is delayed by jitter_ms times a random value over 8192, "
             "instead of by the distribution."},
    {NUMBERS(capacity_ms, capacity_count, LL_CAPACITY_MAX, 0, HOUR_MS), .unit = "ms",
     .help = "Capacity as a trace of Mahimahi: each value is the time of an opportunity to send 1504 bytes. "
             "Times do not decrease, and repeat after the last one."},
    {NUMBERS(trace_t_ms, time_count, LL_TRACE_MAX, 0, HOUR_MS), .unit = "ms",
     .help =
         "Times from which trace_delay_ms and trace_lost hold: from 0, increasing. The last holds as long "
         "as the one before it; then the trace repeats."},
    {NUMBERS(trace_delay_ms, delay_count, LL_TRACE_MAX, 0, 1000), .unit = "ms",
     .help = "Measured delay from each of those times on, added to the link's."},
    {NUMBERS(trace_lost, lost_count, LL_TRACE_MAX, 0, 1),
     .help = "1 where packets sent from that time on are lost, otherwise 0."},
};

typedef struct field {
    char name[64];
} field;

static field field_of(const char *path, const char *name, int32_t index)
{
    field f;
    if (index < 0)
        snprintf(f.name, sizeof f.name, "%s%s", path, name);
    else
        snprintf(f.name, sizeof f.name, "%s%s.%d", path, name, index);
    return f;
}

static bool is_whole(double x)
{
    return (double)(int64_t)x == x;
}

static ll_status check_capacity(const ll_profile_params *p, const char *path)
{
    for (int32_t i = 0; i < p->capacity_count; i++) {
        double before = i > 0 ? p->capacity_ms[i - 1] : 0, now = p->capacity_ms[i];
        field f = field_of(path, "capacity_ms", i);
        if (!is_whole(now))
            return ll_field_error(LL_BAD_INPUT, f.name, "%s: must be a whole number of ms; got %g", f.name,
                                  now);
        if (now < before)
            return ll_field_error(LL_BAD_INPUT, f.name,
                                  "%s: must be at least the one before it, %g ms; got %g", f.name, before,
                                  now);
    }
    field f = field_of(path, "capacity_ms", -1);
    if (p->capacity_count > 0 && p->capacity_ms[p->capacity_count - 1] <= 0)
        return ll_field_error(LL_BAD_INPUT, f.name, "%s: the last time must be at least 1 ms; got 0", f.name);
    return ll_ok();
}

static ll_status check_times(const ll_profile_params *p, const char *path)
{
    for (int32_t i = 0; i < p->time_count; i++) {
        field f = field_of(path, "trace_t_ms", i);
        if (i == 0 && p->trace_t_ms[0] > 0)
            return ll_field_error(LL_BAD_INPUT, f.name, "%s: must be 0; got %g", f.name, p->trace_t_ms[0]);
        if (i > 0 && p->trace_t_ms[i] - p->trace_t_ms[i - 1] < 0.001)
            return ll_field_error(
                LL_BAD_INPUT, f.name,
                "%s: must be later than the one before it, %g ms, by at least 0.001 ms; got %g", f.name,
                p->trace_t_ms[i - 1], p->trace_t_ms[i]);
    }
    return ll_ok();
}

static ll_status check_trace(const ll_profile_params *p, const char *path)
{
    const struct {
        const char *name;
        int32_t count;
    } columns[] = {{"trace_delay_ms", p->delay_count}, {"trace_lost", p->lost_count}};
    LL_TRY(check_times(p, path));
    for (int i = 0; i < 2; i++) {
        field f = field_of(path, columns[i].name, -1);
        if (columns[i].count != p->time_count)
            return ll_field_error(LL_BAD_INPUT, f.name,
                                  "%s: must have as many numbers as trace_t_ms, %d; got %d", f.name,
                                  p->time_count, columns[i].count);
    }
    for (int32_t i = 0; i < p->lost_count; i++) {
        field f = field_of(path, "trace_lost", i);
        if (!is_whole(p->trace_lost[i]))
            return ll_field_error(LL_BAD_INPUT, f.name, "%s: must be 0 or 1; got %g", f.name,
                                  p->trace_lost[i]);
    }
    return ll_ok();
}

static ll_status check_slot(const ll_profile_params *p, const char *path)
{
    field f = field_of(path, "slot_min_ms", -1);
    bool grid = p->slot_start == LL_SLOT_GRID;
    if (p->slot_min_ms > p->slot_max_ms)
        return ll_field_error(LL_BAD_INPUT, f.name, "%s: must be at most slot_max_ms, %g ms; got %g", f.name,
                              p->slot_max_ms, p->slot_min_ms);
    if (grid && p->slot_min_ms < p->slot_max_ms)
        return ll_field_error(LL_BAD_INPUT, f.name,
                              "%s: must be slot_max_ms, %g ms, where slot_start is grid; got %g", f.name,
                              p->slot_max_ms, p->slot_min_ms);
    if (p->slot_max_ms > 0 && p->slot_max_ms < 0.001) {
        f = field_of(path, "slot_max_ms", -1);
        return ll_field_error(LL_BAD_INPUT, f.name, "%s: must be 0 or at least 0.001 ms; got %g", f.name,
                              p->slot_max_ms);
    }
    return ll_ok();
}

static ll_status check_table(const ll_profile_params *p, const char *path)
{
    for (int32_t i = 0; i < p->table_count; i++) {
        field f = field_of(path, "delay_table", i);
        if (!is_whole(p->delay_table[i]))
            return ll_field_error(LL_BAD_INPUT, f.name, "%s: must be a whole number; got %g", f.name,
                                  p->delay_table[i]);
    }
    return ll_ok();
}

static ll_status check(const void *object, const char *path)
{
    const ll_profile_params *p = object;
    LL_TRY(check_slot(p, path));
    LL_TRY(check_table(p, path));
    LL_TRY(check_capacity(p, path));
    return check_trace(p, path);
}

const ll_param_table ll_profile_table = {.name = "link_profile",
                                         .help =
                                             "What few links have: traces, slots, cells, ECN, a distance.",
                                         LL_PARAM_ROWS(rows, ll_profile_params),
                                         .check = check};
