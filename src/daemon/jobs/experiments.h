/* Experiments of the daemon: their store, and the threads that run them at the lowest priority, so that live
 * sessions come first. Experiments that run when the daemon ends continue at its next start. Any thread. */
#pragma once

#include "daemon/hosting/host.h"
#include "daemon/support/keys.h"
#include "experiment/store/result_store.h"

typedef struct ll_experiments ll_experiments;

/* Opens the store in `folder`, or one in memory if that is NULL. `config` and `folder`
 * must outlive it. */
ll_status ll_experiments_open(const char *folder, const ll_host_config *config, ll_experiments **experiments);
void ll_experiments_request_stop(ll_experiments *experiments); /* returns at once; NULL: no effect */
void ll_experiments_stop(ll_experiments *experiments);         /* each thread interrupts its present run */
void ll_experiments_close(ll_experiments *experiments);

/* Opens their streams. All viewers' hooks must have ended before the stop. */
ll_status ll_experiments_open_streams(ll_experiments *experiments, ll_ws *ws);

ll_result_store *ll_experiments_store(ll_experiments *experiments);

/* Registers an experiment and starts it. Generates `id` and `key`; the key is not kept. LL_LIMIT: too many
 * runs, or too many experiments, in total, of `class_key` or, if that is NULL, of this client. LL_IO: its
 * results would not fit. */
ll_status ll_experiments_add(ll_experiments *experiments, const ll_experiment *experiment, const char *client,
                             ll_class_key *class_key, char id[LL_ID_LENGTH + 1], char key[LL_KEY_LENGTH + 1]);

ll_status ll_experiments_find(ll_experiments *experiments, const char *id, ll_experiment_record *record);
/* Parses its specification, which may take long. */
ll_status ll_experiments_read(ll_experiments *experiments, const char *id, const ll_interrupt *interrupt,
                              ll_experiment **experiment);
bool ll_experiments_permits(const ll_experiment_record *record, const char *key);

/* LL_CONFLICT: it has ended, or it is of another version, which this one cannot resume. */
ll_status ll_experiments_set(ll_experiments *experiments, const ll_experiment_record *record,
                             ll_experiment_state state);
/* Cancels experiments that have run too long, deletes expired ones, and counts those of class keys. */
void ll_experiments_delete_expired(ll_experiments *experiments);
/* The same now and then, by one thread, about once a second: which also tries the store if it fails, and logs
 * that it began to or works again. */
void ll_experiments_tidy(ll_experiments *experiments);
ll_status ll_experiments_remove(ll_experiments *experiments, const char *id);

/* Adds its progress to `json`: state, runs, done, rate_per_s and left_s. The rate is that of the stored runs
 * since it was started or resumed here. */
void ll_experiments_describe(ll_experiments *experiments, const ll_experiment_record *record,
                             struct cJSON *json);
