#include "experiment/result_store.h"

#include <stdlib.h>
#include <string.h>

const char *const ll_experiment_state_names[] = {"running", "paused", "cancelled", "done", "failed"};

static const ll_result_store_kind *const kinds[] = {&ll_result_store_sqlite};

enum { KINDS = sizeof kinds / sizeof kinds[0], ROWS_AT_ONCE = 256 };

ll_status ll_result_store_open(const char *url, ll_result_store **store)
{
    *store = NULL;
    for (int i = 0; i < KINDS; i++) {
        size_t length = strlen(kinds[i]->scheme);
        if (strncmp(url, kinds[i]->scheme, length) == 0 && url[length] == ':')
            return kinds[i]->open(url, store);
    }
    const char *scheme = strstr(url, "://");
    if (scheme || url[0] == '\0')
        return ll_field_error(LL_BAD_INPUT, "store", "a store is sqlite:FILE; got %.120s", url);
    return ll_result_store_sqlite.open(url, store);
}

void ll_result_store_close(ll_result_store *store)
{
    if (store)
        store->kind->close(store);
}

ll_status ll_stored_rows_open(ll_stored_rows *r, ll_result_store *store, const char *id)
{
    *r = (ll_stored_rows){.store = store, .id = id, .rows = malloc(ROWS_AT_ONCE * sizeof *r->rows)};
    return r->rows ? ll_ok() : ll_error(LL_NO_MEMORY, "no memory for rows");
}

bool ll_stored_rows_next(void *context, ll_row *row, ll_status *status)
{
    ll_stored_rows *r = context;
    if (r->at == r->count) {
        r->at = r->count = 0;
        *status = r->store->kind->read(r->store, r->id, r->next, r->rows, ROWS_AT_ONCE, &r->count);
        if (ll_failed(status) || r->count == 0)
            return false;
        r->next = r->rows[r->count - 1].run + 1;
    }
    *row = r->rows[r->at++];
    return true;
}

void ll_stored_rows_close(ll_stored_rows *r)
{
    free(r->rows);
    r->rows = NULL;
}
