/* Measurements of speed against error, which belong to the daemon: each runs to its end with or without a
 * reader, all may read its rows while they are measured, and the newest of each family outlives the daemon,
 * in the store. One of a family runs at a time. What the end of the daemon interrupted is kept as far as it
 * came.
 *
 * Two threads measure, which are tasks (daemon/support/tasks.h). Any thread. */
#pragma once

#include "daemon/hosting/host.h"
#include "daemon/store/store.h"
#include "daemon/support/keys.h"
#include "daemon/support/tasks.h"
#include "experiment/advise/tradeoff.h"

struct cJSON;
typedef struct ll_measurements ll_measurements;

typedef struct ll_measurement_order {
    const ll_tradeoff_family *family;
    char methods[1024], duration[32]; /* as in ll_tradeoff_request; empty: NULL there */
    int seeds, check_seeds;
} ll_measurement_order;

/* With those that are stored. `config` and `store`, which may be NULL, must outlive it. */
ll_status ll_measurements_open(ll_tasks *tasks, const ll_host_config *config, ll_store *store,
                               ll_measurements **measurements);
void ll_measurements_close(ll_measurements *measurements); /* after the tasks have ended; NULL: no effect */

/* Starts one, and generates `id` and `key`; of the same order as one that runs, has that one's id and an
 * empty key. LL_CONFLICT: one of another order of this family runs. */
ll_status ll_measurements_start(ll_measurements *measurements, const ll_measurement_order *order,
                                char id[LL_ID_LENGTH + 1], char key[LL_KEY_LENGTH + 1]);
/* Adds to `json` what GET /api/v1/tradeoffs/{id} answers. LL_NOT_FOUND. */
ll_status ll_measurements_describe(ll_measurements *measurements, const char *id, struct cJSON *json);
/* The one of this family that runs, else the newest; false: none. */
bool ll_measurements_newest(ll_measurements *measurements, const ll_tradeoff_family *family,
                            char id[LL_ID_LENGTH + 1]);
/* Ends and deletes it. LL_NOT_FOUND; LL_FORBIDDEN: wrong key; key NULL: the operator. */
ll_status ll_measurements_remove(ll_measurements *measurements, const char *id, const char *key);
