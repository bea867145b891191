/* Shared by the kinds of stores: messages, and the state of an experiment. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "experiment/store/kinds.h"

#include "base/assert.h"

void ll_store_set_state(ll_experiment_record *r, bool given_up)
{
    LL_ASSERT(r->from <= r->to && r->done >= 0 && r->done <= r->to - r->from);
    if (r->done == r->to - r->from)
        r->state = LL_EXPERIMENT_DONE;
    else if (given_up)
        r->state = LL_EXPERIMENT_FAILED;
}

ll_status ll_store_unknown(const char *id)
{
    return ll_field_error(LL_NOT_FOUND, "experiment", "experiment %.60s not found in the store", id);
}

ll_status ll_store_taken(const char *name, const char *id)
{
    return ll_error(LL_CONFLICT, "the store %.120s has another experiment %s", name, id);
}

ll_status ll_store_lost(const ll_lease *lease)
{
    return ll_error(LL_CONFLICT, "the lease of chunk %" PRId64 " of %s is another worker's", lease->chunk,
                    lease->id);
}

ll_status ll_store_newer(const char *name, int64_t schema)
{
    return ll_error(LL_BAD_INPUT,
                    "the store %.120s is of schema %" PRId64
                    ", of a newer laglab; this one supports up to %d",
                    name, schema, LL_STORE_SCHEMA);
}

ll_status ll_store_key_full(const ll_experiment_record *record)
{
    return ll_error(LL_LIMIT, "class key %s has %lld experiments, as many as it may", record->class_key,
                    (long long)record->most_of_key);
}
