/* Experiments of the daemon: their store, and the threads that run them with the lowest claim on the
 * processors, so that live sessions come first. What runs when the daemon ends goes on at its next start. Any
 * thread. */
#pragma once

#include "daemon/hosting/host.h"
#include "daemon/support/keys.h"
#include "experiment/store/result_store.h"

typedef struct ll_experiments ll_experiments;

/* In `config->store`, or `folder`, or in memory where that is NULL. `config` and `folder` outlive it. */
ll_status ll_experiments_open(const char *folder, const ll_host_config *config, ll_experiments **experiments);
void ll_experiments_request_stop(ll_experiments *experiments); /* returns at once; NULL is fine */
void ll_experiments_stop(ll_experiments *experiments);         /* each thread breaks off the run it is at */
void ll_experiments_close(ll_experiments *experiments);

/* Begins their streams. Any viewer's hook ends before the stop. */
ll_status ll_experiments_open_streams(ll_experiments *experiments, ll_ws *ws);

ll_result_store *ll_experiments_store(ll_experiments *experiments);

/* Registers an experiment and begins. `id` and `key` are made here; the key is not kept. LL_LIMIT: it has
 * more runs than one may, or there are as many experiments as may be, in all or of this client. LL_IO: there
 * is no room for its results. */
ll_status ll_experiments_add(ll_experiments *experiments, const ll_experiment *experiment, const char *client,
                             char id[LL_ID_LENGTH + 1], char key[LL_KEY_LENGTH + 1]);

/* Reads the record, and the specification into `experiment` unless that is NULL. */
ll_status ll_experiments_find(ll_experiments *experiments, const char *id, ll_experiment_record *record,
                              ll_experiment **experiment);
bool ll_experiments_permits(const ll_experiment_record *record, const char *key);

/* LL_CONFLICT: it is over; or of another version, and so not resumed here. */
ll_status ll_experiments_set(ll_experiments *experiments, const ll_experiment_record *record,
                             ll_experiment_state state);
/* Cancels what has run for too long, and deletes what has expired. */
void ll_experiments_delete_expired(ll_experiments *experiments);
ll_status ll_experiments_remove(ll_experiments *experiments, const char *id);

/* Adds to `json` how far it is: state, runs, done, rate_per_s and left_s. The rate is that of the runs since
 * it began or was resumed here, as far as their rows are stored. */
void ll_experiments_describe(ll_experiments *experiments, const ll_experiment_record *record,
                             struct cJSON *json);
