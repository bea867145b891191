/* What the kinds of stores share: the form of their tables, and what they say. */
#pragma once

#include "experiment/store/result_store.h"

enum { LL_STORE_SCHEMA = 2 };

/* All of a record but what ll_store_settle adds: id, state, first, past, created_s, runs done, runs leased,
 * whether a chunk was given up, owner_hash, version, age_s. A chunk's state is 0 free, 1 leased, 2 done, 3
 * given up. `now` is Unix time in the database's words. */
#define LL_STORE_RECORD(now)                                                                                 \
    "SELECT e.id,e.state,e.first,e.past,e.created_s,"                                                        \
    " coalesce((SELECT sum(past-first) FROM chunk c WHERE c.id=e.id AND c.state=2),0),"                      \
    " coalesce((SELECT sum(past-first) FROM chunk c WHERE c.id=e.id AND c.state=1),0),"                      \
    " EXISTS(SELECT 1 FROM chunk c WHERE c.id=e.id AND c.state=3),e.owner_hash,e.version," now               \
    "-e.created_s FROM experiment e "

/* Done, when all rows are there; failed, when some chunk was given up. */
void ll_store_settle(ll_experiment_record *record, bool given_up);

/* A URL without what nobody may read: of the part before the last @ only the user's name, and no query. */
void ll_store_name_url(const char *url, char *name, size_t size);

/* `name` is the store's, without secrets. */
ll_status ll_store_unknown(const char *id);
ll_status ll_store_taken(const char *name, const char *id);
ll_status ll_store_lost(const ll_lease *lease);
ll_status ll_store_newer(const char *name, int64_t schema);
