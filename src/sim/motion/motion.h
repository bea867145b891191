/* Simulations of kind `motion`: one problem of the ode room, integrated by several methods side by side from
 * the same start, each measured against the solution.
 *
 * The solution is the problem's formula. Without a formula, each method has a reference run by the best
 * method at the smallest tolerance; a second reference by another method gives the uncertainty of the first.
 * A change of a method, its step or a parameter takes effect from time 0: the run is repeated up to the
 * present, so that a view never mixes two configurations. */
#pragma once

#include "ode/core/accumulator.h"
#include "ode/core/measure.h"
#include "ode/core/problem.h"
#include "ode/core/run.h"
#include "sim/core/sim.h"

#define LL_MOTION_METHODS_MAX 8
#define LL_MOTION_STEPS_MAX 20000000

enum { LL_MOTION_FIXED, LL_MOTION_FRAME, LL_MOTION_ACCUMULATOR }; /* steps */
enum { LL_MOTION_EXACT, LL_MOTION_FLOAT, LL_MOTION_COMPENSATED }; /* clock */
enum { LL_MOTION_DOUBLE, LL_MOTION_SINGLE };                      /* precision */
enum { LL_MOTION_ALTERNATING, LL_MOTION_RANDOM };                 /* frames */
extern const char *const ll_motion_step_names[],
    *const ll_motion_clock_names[], *const ll_motion_precision_names[], *const ll_motion_frame_names[];

typedef struct ll_motion_method {
    double dt_s;            /* of fixed-step methods */
    double tolerance;       /* of adaptive ones */
    double origin_offset_m; /* distance of the body from the origin in single precision */
    int32_t method;         /* index into ll_ode_methods */
    int32_t steps, clock, precision;
    bool shown;
    uint8_t reserved[7];
} ll_motion_method;

typedef struct ll_motion_config {
    ll_scenario_head head;
    int64_t reserved_after_head;  /* keeps the layout of a block, and so its hash */
    double tick_hz;               /* of sampling */
    double frame_s, frame_jitter; /* mean length; relative deviation */
    int32_t problem;              /* index into ll_ode_problems */
    int32_t method_count;
    int32_t frames;
    bool reverse; /* halfway time is reversed, and it runs back to the start */
    uint8_t reserved[3];
    double params[LL_ODE_PARAMS_MAX / sizeof(double)];
    ll_motion_method methods[LL_MOTION_METHODS_MAX];
} ll_motion_config;

extern const ll_param_table ll_motion_table;

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

/* Progress of a method's time stepping. */
typedef struct ll_motion_drive {
    ll_accumulator saved; /* frame time */
    ll_time frames_end;   /* of the frames so far */
    int64_t frames;
    int64_t ticks;     /* of a clock that adds up its step */
    float clock, lost; /* s */
    int32_t turned;
    int32_t reserved;
    ll_ode_counters before; /* the time reversal */
} ll_motion_drive;

/* Uncertainty of the solution: the difference of two references, over the steps of the first; all 0 for a
 * formula. Times are the session's. */
typedef struct ll_motion_uncertainty {
    ll_ode_measure by;
    double predictable_s; /* until then it is below LL_ODE_PREDICTABLE of the scale */
    int64_t parted;       /* it exceeds that: errors are unknown from here on */
} ll_motion_uncertainty;

/* The start of a block. Offsets are from here; a vector has `dim` doubles. */
typedef struct ll_motion {
    int64_t size;
    ll_motion_config config;
    ll_time now;
    int32_t dim;
    int32_t formula;                         /* whether there is one */
    int64_t solution;                        /* vector: the present solution, for drawing; */
    int64_t reference;                       /* and the run that computes it where there is no formula */
    int64_t first, second, uncertainty_each; /* two references, and the differences of their components */
    int64_t ahead;                           /* run to the end when a method may have blown up: */
    int64_t looked;                          /* whether it has been run; */
    ll_ode_scale whole;                      /* of the whole solution then */
    ll_motion_uncertainty uncertainty;
    struct {
        int64_t run, reference; /* ll_ode_run */
        int64_t shown,
            wanted;   /* vectors: the present state, for drawing; the solution at the method's own time */
        int64_t each; /* measures of components */
    } at[LL_MOTION_METHODS_MAX];
    ll_ode_measure measure[LL_MOTION_METHODS_MAX];
    ll_motion_drive drive[LL_MOTION_METHODS_MAX];
} ll_motion;

#pragma GCC diagnostic pop

static inline const ll_ode_problem *ll_motion_problem(const ll_motion_config *config)
{
    return ll_ode_problems[config->problem];
}

static inline const ll_ode_method *ll_motion_method_of(const ll_motion_config *config, int i)
{
    return ll_ode_methods[config->methods[i].method];
}

static inline ll_ode_run *ll_motion_run_at(const ll_motion *m, int64_t offset)
{
    return (ll_ode_run *)((char *)m + offset);
}

static inline ll_ode_run *ll_motion_run(const ll_motion *m, int i)
{
    return ll_motion_run_at(m, m->at[i].run);
}

static inline double *ll_motion_vector(const ll_motion *m, int64_t offset)
{
    return (double *)((char *)m + offset);
}

/* The system of a configuration; it keeps a pointer to the configuration. Sets values derived from its
 * parameters. */
ll_ode ll_motion_system(ll_motion_config *config);
ll_ode_control ll_motion_control(const ll_motion_config *config, int i);

/* ---- drive.c ---- */

void ll_motion_drive_start(ll_motion *m, int i, const ll_ode *ode); /* the run is started already */

/* Makes the steps of method `i` up to the session's time `t`, s, which only increases. */
ll_ode_state ll_motion_drive_to(ll_motion *m, int i, const ll_ode *ode, double t, ll_pace *pace);

double ll_motion_end(const ll_motion_config *config); /* of the forward run */
double ll_motion_moment(const ll_motion_config *config,
                        double t);                       /* of the motion, at the session's time `t` */
double ll_motion_time(const ll_motion *m, int i);        /* of the motion, of the method's state */
double ll_motion_clock_error(const ll_motion *m, int i); /* s: its clock's time minus that time */

/* ---- measure.c: the solution, and measures against it ---- */

/* Restarts the reference runs and the measures, after the methods' runs. */
void ll_motion_measure_start(ll_motion *m, const ll_ode *ode, const double *y0);

/* The present solution, for drawing; time only increases. */
void ll_motion_solve(ll_motion *m, const ll_ode *ode, double t, ll_pace *pace);

/* Measures the last step of method `i`, and ends its run if it has blown up. */
void ll_motion_measure_step(ll_motion *m, int i, const ll_ode *ode, ll_pace *pace);

/* After the whole run of method `i`: marks it as failed if its steps do not resolve a stiff problem. */
void ll_motion_judge(ll_motion *m, int i, const ll_ode *ode);

/* ---- metrics.c: measurements of a block ---- */
extern const ll_metric_table *const ll_motion_metric_tables[];
ll_run_status ll_motion_status(const ll_motion *m, int i); /* of a method */
struct cJSON *ll_motion_metrics(const void *block);
void ll_motion_time_parts(const void *config, struct cJSON *metrics, int64_t (*now_ns)(void));

/* ---- report.c: reports of a block ---- */
struct cJSON *ll_motion_state(const void *block);
ll_status ll_motion_text(const void *config, void (*write)(void *context, const char *text, size_t length),
                         void *context);
struct cJSON *ll_motion_layout(const void *config);
extern const ll_metric_table *const ll_motion_trace_tables[];
void ll_motion_trace(const void *block, ll_trace_line *trace);
extern const ll_record *const ll_motion_records[];
void ll_motion_fill(const void *block, ll_row_set *rows);
