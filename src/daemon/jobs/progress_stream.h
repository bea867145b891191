/* Streams of experiments: a new viewer gets the progress, and again when it changes, until the experiment
 * ends. Any thread. */
#pragma once

#include "experiment/store/result_store.h"

typedef struct ll_experiments ll_experiments;
typedef struct ll_progress ll_progress;
typedef struct ll_ws ll_ws;
struct cJSON;

/* Source of the progress; see experiments.h. */
typedef struct ll_progress_source {
    ll_experiments *experiments;
    ll_status (*find)(ll_experiments *experiments, const char *id, ll_experiment_record *record);
    void (*describe)(ll_experiments *experiments, const ll_experiment_record *record, struct cJSON *json);
    void (*tidy)(ll_experiments *experiments);
} ll_progress_source;

ll_status ll_progress_start(const ll_progress_source *source, ll_ws *ws, ll_progress **progress);

/* Opens the stream of an experiment, unless it is open. No effect after the stop. */
void ll_progress_add(ll_progress *progress, const char *id);
/* It was deleted: sends that to its viewers and closes its stream. */
void ll_progress_remove(ll_progress *progress, const char *id);

void ll_progress_stop(ll_progress *progress); /* when no hook runs any more: after ll_web_server_drain */
void ll_progress_free(ll_progress *progress); /* NULL: no effect */
