/* Streams of experiments: a viewer is greeted with how far it is, and told again when that changed, until it
 * is over. Any thread. */
#pragma once

#include "experiment/store/result_store.h"

typedef struct ll_experiments ll_experiments;
typedef struct ll_progress ll_progress;
typedef struct ll_ws ll_ws;
struct cJSON;

/* What there is to tell, as experiments.h has it. */
typedef struct ll_progress_source {
    ll_experiments *experiments;
    ll_status (*find)(ll_experiments *experiments, const char *id, ll_experiment_record *record,
                      ll_experiment **experiment);
    void (*describe)(ll_experiments *experiments, const ll_experiment_record *record, struct cJSON *json);
    void (*tidy)(ll_experiments *experiments);
} ll_progress_source;

ll_status ll_progress_start(const ll_progress_source *source, ll_ws *ws, ll_progress **progress);

/* Makes the stream of an experiment known, unless it is. Nothing after the stop. */
void ll_progress_add(ll_progress *progress, const char *id);
/* It was deleted: its viewers are told, and its stream is gone. */
void ll_progress_remove(ll_progress *progress, const char *id);

void ll_progress_stop(ll_progress *progress); /* when no hook runs any more: after ll_web_server_drain */
void ll_progress_free(ll_progress *progress); /* NULL is fine */
