/* Shared by the kinds of stores: the form of their tables, and messages. */
#pragma once

#include "experiment/store/result_store.h"

enum { LL_STORE_SCHEMA = 2 };

/* All of a record except what ll_store_set_state adds: id, state, first, past, created_s, runs done, runs
 * leased, whether a chunk failed, owner_hash, version, age_s, class key. State of a chunk: 0 free, 1 leased,
 * 2 done, 3 failed. `now`: Unix time in the database's syntax. */
#define LL_STORE_RECORD(now)                                                                                 \
    "SELECT e.id,e.state,e.first,e.past,e.created_s,"                                                        \
    " coalesce((SELECT sum(past-first) FROM chunk c WHERE c.id=e.id AND c.state=2),0),"                      \
    " coalesce((SELECT sum(past-first) FROM chunk c WHERE c.id=e.id AND c.state=1),0),"                      \
    " EXISTS(SELECT 1 FROM chunk c WHERE c.id=e.id AND c.state=3),e.owner_hash,e.version," now               \
    "-e.created_s,coalesce((SELECT name FROM class_key k WHERE k.id=e.id),'') FROM experiment e "

/* Names of class keys stand in a table of their own, which a store of an earlier laglab gets when it is
 * opened, and which that one does not read. */
#define LL_STORE_COUNT_KEY "SELECT count(*) FROM class_key k JOIN experiment e ON e.id=k.id WHERE k.name="

/* Sets state done when all rows are stored, failed when a chunk failed. */
void ll_store_set_state(ll_experiment_record *record, bool given_up);

/* `name` is the store's, without secrets. */
ll_status ll_store_unknown(const char *id);
ll_status ll_store_taken(const char *name, const char *id);
ll_status ll_store_lost(const ll_lease *lease);
ll_status ll_store_key_full(const ll_experiment_record *record);
ll_status ll_store_newer(const char *name, int64_t schema);
