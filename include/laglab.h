/* laglab as a library: runs a scenario, moves it tick by tick, and reads what it measures.
 *
 *   laglab_run *run;
 *   const char *const sets[] = {"players.0.lag_ms=200", "duration_s=10", NULL};
 *   double error_m;
 *   if (laglab_open_named(FOLDER, "race", sets, &run) != LAGLAB_OK ||
 *       laglab_run_to(run, laglab_end_tick(run)) != LAGLAB_OK ||
 *       laglab_metric(run, "players.0.remote_error_m.mean", &error_m) != LAGLAB_OK)
 *       fprintf(stderr, "%s\n", laglab_error(run));
 *   laglab_close(run);
 *
 * A run is a pure function of its scenario, its seed and what is set during it: values and hash are those of
 * `laglab run` of the same version, on every machine. (That prints some metrics with 15 digits; here they
 * have all.) No function reads a clock, the environment or a global, and the locale of the program has no
 * effect; files are read by laglab_open_named alone.
 *
 * Functions that can fail return a code; laglab_error has the sentence. Text is UTF-8. Texts that functions
 * return belong to the run, and are valid until it moves, changes or is closed, unless the function says
 * otherwise. One thread at a time may use a run; threads may use different runs at the same time. */
#ifndef LAGLAB_H
#define LAGLAB_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define LAGLAB_PUBLIC __attribute__((visibility("default")))
#else
#define LAGLAB_PUBLIC
#endif

typedef struct laglab_run laglab_run;

typedef enum laglab_code {
    LAGLAB_OK = 0,
    LAGLAB_BAD_INPUT, /* invalid text or value: laglab_error_field says where */
    LAGLAB_NOT_FOUND, /* no such scenario */
    LAGLAB_CONFLICT,  /* valid, but not at this tick or of this scenario */
    LAGLAB_DIVERGED,  /* the simulation had a value that is not finite */
    LAGLAB_NO_MEMORY,
    LAGLAB_FAILED /* any other reason: the sentence says it */
} laglab_code;

/* The release and a fingerprint of all sources, as 0.2.0+3f2a9c1b4d5e. Valid without limit. */
LAGLAB_PUBLIC const char *laglab_version(void);

/* ---- opening ---- */

/* Opens a scenario at tick 0. `json` is its text, as `laglab run FILE` reads it. `sets`: changes as of
 * `laglab run --set`, each `path=value`, such as "players.0.lag_ms=200", "seed=7", "duration_s=10"; their
 * order does not matter; NULL ends them, and may be given in place of the list.
 * `*run` is always set. On an error it only has the sentence, and must be closed too; NULL: no memory. */
LAGLAB_PUBLIC laglab_code laglab_open(const char *json, const char *const *sets, laglab_run **run);

/* The same for a scenario of a library: `folder`/`id`.json. `id` is like "race" or "paper/fig11". The folder
 * that is installed with this library is the variable `scenarios` of its pkg-config file. */
LAGLAB_PUBLIC laglab_code laglab_open_named(const char *folder, const char *id, const char *const *sets,
                                            laglab_run **run);

LAGLAB_PUBLIC void laglab_close(laglab_run *run); /* NULL is fine */

/* One sentence about the last call with this run that failed: it names the field, the range and the value.
 * Empty: none has failed. */
LAGLAB_PUBLIC const char *laglab_error(const laglab_run *run);
LAGLAB_PUBLIC const char *laglab_error_field(const laglab_run *run); /* path of its field, or empty */

/* ---- time ---- */

LAGLAB_PUBLIC int64_t laglab_tick(const laglab_run *run);
LAGLAB_PUBLIC int64_t laglab_end_tick(const laglab_run *run); /* of the duration */
LAGLAB_PUBLIC double laglab_time_s(const laglab_run *run);    /* virtual time at the present tick */

/* Computes up to a tick, at full speed. An earlier tick is computed again from a kept state, and has the
 * same hash. LAGLAB_DIVERGED: the run ends at an earlier tick. */
LAGLAB_PUBLIC laglab_code laglab_run_to(laglab_run *run, int64_t tick);

/* ---- changing ---- */

/* Sets a live parameter at the present tick: "players.0.lag_ms=300". Later changes that were made before
 * going back are dropped. LAGLAB_CONFLICT: the parameter cannot change during a run. */
LAGLAB_PUBLIC laglab_code laglab_set(laglab_run *run, const char *set);

/* Controls of a person, held until the next call. The player's `control` must be `person`. Axes are -1 to 1;
 * the game says what they and the bits of `buttons` do. */
LAGLAB_PUBLIC laglab_code laglab_input(laglab_run *run, int player, double axis_0, double axis_1,
                                       uint32_t buttons);

/* ---- reading ---- */

/* Of the whole simulated state at the present tick; `laglab run` prints it as 16 hexadecimal digits. */
LAGLAB_PUBLIC uint64_t laglab_hash(laglab_run *run);

/* A metric from tick 0 to the present tick, by its path, such as "players.0.remote_error_m.mean"; a flag is
 * 0 or 1. NaN: it was not counted in this run. LAGLAB_BAD_INPUT: there is no such number. */
LAGLAB_PUBLIC laglab_code laglab_metric(laglab_run *run, const char *path, double *value);

/* A metric that is a name or a sentence, such as "methods.0.status". NULL: it is left out. */
LAGLAB_PUBLIC laglab_code laglab_metric_text(laglab_run *run, const char *path, const char **text);

/* The metrics at the present tick: how many laglab_metric knows, and their paths by index. NULL beyond. */
LAGLAB_PUBLIC size_t laglab_metric_count(laglab_run *run);
LAGLAB_PUBLIC const char *laglab_metric_path(laglab_run *run, size_t index);

typedef enum laglab_document {
    LAGLAB_SCENARIO, /* with all values, as they are now: laglab_open reads it */
    LAGLAB_METRICS,
    LAGLAB_STATE
} laglab_document;

/* A document as JSON text, for what no function above reads. The caller frees it by laglab_free. NULL: no
 * memory, or `which` is unknown. */
LAGLAB_PUBLIC char *laglab_json(laglab_run *run, laglab_document which);
LAGLAB_PUBLIC void laglab_free(char *text);

#ifdef __cplusplus
}
#endif

#endif
