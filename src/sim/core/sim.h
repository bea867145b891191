/* One interface for all kinds of simulation.
 *
 * A simulation is one contiguous relocatable block whose size follows from its configuration: checkpoint and
 * rollback are a memcpy. It is a pure function of (configuration, commands stamped with virtual time). */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "base/recorder.h"
#include "base/status.h"
#include "base/team.h"
#include "base/vtime.h"
#include "game/core/game.h"
#include "param/param.h"
#include "record/metric.h"
#include "record/row_set.h"
#include "record/trace.h"

struct cJSON;

#define LL_TITLE_MAX 120
#define LL_TEXT_MAX 600

#define LL_TIMELINE_MAX 8
#define LL_TIMELINE_SET_MAX 175
#define LL_EXPECT_MAX 4
#define LL_METRIC_PATH_MAX 63

/* A change of live parameters that belongs to the scenario. */
typedef struct ll_timeline_step {
    double at_s;
    char set[LL_TIMELINE_SET_MAX + 1]; /* a merge patch, as JSON */
} ll_timeline_step;

/* A minimum of a metric at the end, so that the scenario shows what it is for. */
typedef struct ll_expectation {
    char metric[LL_METRIC_PATH_MAX + 1]; /* `players.0.corrections`, from the metrics */
    double min;
} ll_expectation;

/* The first member of every kind's configuration. */
typedef struct ll_scenario_head {
    int32_t kind; /* index into ll_sim_kinds */
    int32_t reserved;
    double duration_s;
    int64_t seed;
    char title[LL_TITLE_MAX + 4];
    char paper[LL_TITLE_MAX + 4]; /* `Figure 11` */
    char text[LL_TEXT_MAX + 8];
    int32_t timeline_count, expect_count;
    ll_timeline_step timeline[LL_TIMELINE_MAX]; /* in the order of time */
    ll_expectation expect[LL_EXPECT_MAX];
} ll_scenario_head;

/* Of a copy of a configuration that becomes part of a state: without the texts, the timeline and the
 * expectations, which no tick reads. The hash of a state then does not change with a sentence. */
static inline void ll_scenario_head_strip(ll_scenario_head *head)
{
    *head = (ll_scenario_head){.kind = head->kind, .duration_s = head->duration_s, .seed = head->seed};
}

enum { LL_STEP_PROFILER_PARTS = 30 };

/* Cost of the parts of a step, by the caller's clock: the engine reads no clock, and its state contains no
 * cost. */
typedef struct ll_step_profiler {
    int64_t (*now_ns)(void);
    int64_t ns[LL_STEP_PROFILER_PARTS]; /* in the kind's own order */
    ll_time metered;                    /* virtual time that was measured */
} ll_step_profiler;

/* Without a profiler no clock is read. */
static inline int64_t ll_step_profiler_start(const ll_step_profiler *step_profiler)
{
    return step_profiler ? step_profiler->now_ns() : 0;
}

static inline void ll_step_profiler_add(ll_step_profiler *step_profiler, int part, int64_t from)
{
    if (step_profiler)
        step_profiler->ns[part] += step_profiler->now_ns() - from;
}

static inline double ll_step_profiler_ns_per_s(const ll_step_profiler *step_profiler, int part)
{
    return step_profiler->metered > 0 ? (double)step_profiler->ns[part] / ll_to_s(step_profiler->metered) : 0;
}

/* A part of a block, in lines of LL_LINE bytes (base/prefetch.h) from its start. */
typedef struct ll_block_range {
    uint16_t line, count;
} ll_block_range;

enum { LL_BLOCK_RANGES_MAX = 96 };

/* Bytes of a block. */
typedef struct ll_block_use {
    size_t metrics;   /* what only measures: no step reads it */
    size_t histories; /* past states that steps, or measurements, look back to */
} ll_block_use;

typedef struct ll_sim_kind {
    const char *name;
    const char *help;
    const ll_param_table *table; /* of the whole scenario; the struct begins with ll_scenario_head */

    size_t (*size)(const void *config); /* bytes of the block: known before anything is made */
    /* LL_BAD_INPUT names a field with an error that shows only when it is built; the block then stays as
     * requested. */
    ll_status (*init)(void *block, const void *config);
    /* Whether a running session may change from one configuration to the other, beyond what its rows say.
     * NULL: it may. */
    ll_status (*may_change)(const void *config, const void *before);
    /* Adjusts dependent values after a change; `before` is the configuration before it, NULL for a new
     * one. */
    void (*settle)(void *config, const void *before);
    ll_freq (*tick_freq)(const void *config); /* of the session's ticks */

    /* If a few seeds give the same metrics, all do: no rare random events. */
    bool no_rare_events;
    /* `advance` writes events to its recorder: rows of ll_event (netcode/protocol/event.h). */
    bool records_events;

    /* Runs every event up to and including `until`; `step_profiler` may be NULL. LL_DIVERGED names the tick
     * and the entity of the first value that is not finite; the block then stays at that tick. During a long
     * tick the function `interrupt` is called; NULL never interrupts. After LL_INTERRUPTED the block is
     * invalid. A kind may do parts of a tick by `team`, with the same bits; NULL: one thread. */
    ll_status (*advance)(void *block, ll_time until, const ll_recorder *recorder,
                         ll_step_profiler *step_profiler, const ll_interrupt *interrupt, ll_team *team);
    /* The time of a block, also of one that has failed. NULL: the caller advances it by one tick at a time,
     * so that the tick of a failure is known; other kinds are advanced by many ticks. */
    ll_time (*stands_at)(const void *block);

    /* What the next tick will touch, at most LL_BLOCK_RANGES_MAX parts: a hint, for prefetching. Returns
     * their number. NULL: the kind cannot say. */
    int (*touches)(const void *block, ll_block_range *range);
    ll_block_use (*use)(const void *block); /* NULL: it has neither */

    /* Live parameters of the configuration have changed at `now`; `config` is the new one. */
    void (*change)(void *block, const void *config, ll_time now);
    /* A change takes effect from time 0: it resets the block, which the caller then advances to `now`
     * again. */
    bool begins_anew;

    /* A person's controls. `accepts` checks whether the configuration lets a person control `player` in this
     * way; NULL: no person can. */
    ll_status (*accepts)(const void *config, int player, const ll_action *action);
    void (*input)(void *block, int player, const ll_action *action);
    /* Controls of `player` in its client's last frame, from a person or a script. NULL if `accepts` is. */
    ll_action (*controls)(const void *block, int player);

    uint64_t (*hash)(const void *block);
    struct cJSON *(*state)(const void *block);
    struct cJSON *(*metrics)(const void *block);
    /* Reasons, known in advance, why metrics of a run of this configuration will be null or meaningless: a
     * list of sentences. NULL: this kind knows none. */
    struct cJSON *(*notices)(const void *config);
    const ll_metric_table *const *metric_tables; /* of these metrics, NULL-terminated */

    /* What must be observed for the metric at `path`, as bits of the kind's own; and what a block observes
     * from now on: everything after `init`. Metrics that need more are then without meaning; all else stays
     * the same, with the same hash. NULL: the kind always observes everything. */
    uint32_t (*observed_for)(const char *path);
    void (*observe)(void *block, uint32_t what);

    /* Adds the profiler's cost of each part of `advance` to `cost`. NULL: the kind does not measure cost. */
    void (*costs)(const void *config, const ll_step_profiler *step_profiler, struct cJSON *cost);

    /* Runs the scenario's parts one by one and adds the cost of each to `metrics`, by the caller's clock.
     * NULL: it has no parts. */
    void (*time_parts)(const void *config, struct cJSON *metrics, int64_t (*now_ns)(void));

    /* The paper's printed output for the scenario, line by line. LL_BAD_INPUT: the paper prints none for it.
     * NULL: none for this kind. */
    ll_status (*text)(const void *config, void (*write)(void *context, const char *text, size_t length),
                      void *context);

    struct cJSON *(*layout)(
        const void *config); /* data that a viewer needs to read the rows: sent in the hello */

    /* The streamed records, NULL-terminated; and the rows of the requested ones, as they are in the block. */
    const ll_record *const *records;
    void (*fill)(const void *block, ll_row_set *rows);

    /* Names of the players whose packets a recorder gets (netcode/protocol/packet.h), NULL beyond the last.
     * NULL: the kind sends no packets. */
    const char *(*player_name)(const void *config, int player);

    /* A trace has a line per tick: the columns of these tables (NULL-terminated), at most
     * LL_TRACE_COLUMNS_MAX. `trace` adds the same ones at any time. */
    const ll_metric_table *const *trace_tables;
    void (*trace)(const void *block, ll_trace_line *trace);
} ll_sim_kind;

/* The table of kinds: a row is the name of a constant ll_sim_NAME that the room sim/NAME defines. */
/* clang-format off */
#define LL_SIM_KINDS(ROW) \
    ROW(netgame) \
    ROW(motion) \
    ROW(rigid) \
    ROW(fluid)
/* clang-format on */

extern const ll_sim_kind *const ll_sim_kinds[]; /* NULL-terminated */
