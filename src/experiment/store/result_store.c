#include "experiment/store/result_store.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/store/kinds.h"
#include "postgres/url.h"

const char *const ll_experiment_state_names[] = {"running", "paused", "cancelled", "done", "failed"};

static const struct {
    const char *scheme; /* of its URLs */
    const ll_result_store_kind *kind;
} kinds[] = {
    {"sqlite", &ll_result_store_sqlite},
#ifdef LAGLAB_POSTGRES
    {"postgresql", &ll_result_store_postgres},
    {"postgres", &ll_result_store_postgres},
#endif
};

enum { KINDS = sizeof kinds / sizeof kinds[0], ROWS_AT_ONCE = 256 };

static ll_status refuse(const char *url)
{
    char name[160];
    ll_pg_name_url(url, name, sizeof name);
    if (strncmp(url, "postgres", 8) == 0)
        return ll_field_error(LL_BAD_INPUT, "store", "store %.120s needs a laglab built with libpq", name);
    return ll_field_error(LL_BAD_INPUT, "store",
                          "store: must be sqlite:FILE or postgresql://USER@HOST/DATABASE; got %.120s", name);
}

ll_status ll_result_store_open(const char *url, ll_result_store **store)
{
    const ll_result_store_kind *kind = NULL;
    *store = NULL;
    for (int i = 0; i < KINDS; i++) {
        size_t length = strlen(kinds[i].scheme);
        if (strncmp(url, kinds[i].scheme, length) == 0 && url[length] == ':')
            kind = kinds[i].kind;
    }
    if (!kind && (strstr(url, "://") || url[0] == '\0'))
        return refuse(url);
    ll_status status = (kind ? kind : &ll_result_store_sqlite)->open(url, store);
    if (!ll_failed(&status))
        (*store)->version = ll_version;
    return status;
}

const char *ll_result_store_url(const char *url)
{
    if (!url || url[0] == '\0')
        url = getenv("LAGLAB_STORE");
    return url && url[0] ? url : NULL;
}

void ll_result_store_close(ll_result_store *store)
{
    if (store)
        store->kind->close(store);
}

/* ---- versions ---- */

ll_status ll_result_store_check_version(const ll_result_store *store, const ll_experiment_record *r)
{
    bool over = r->state != LL_EXPERIMENT_RUNNING && r->state != LL_EXPERIMENT_PAUSED;
    if (over || strcmp(r->version, store->version) == 0)
        return ll_ok();
    return ll_error(LL_CONFLICT,
                    "experiment %s is of laglab %s; results of this one, %s, may differ, so it adds none: "
                    "continue with that version, or run the experiment again",
                    r->id, r->version[0] ? r->version : "of an unknown version", store->version);
}

typedef struct inspection {
    const ll_result_store *store;
    ll_status first;
} inspection;

static void inspect(void *context, const ll_experiment_record *record)
{
    inspection *i = context;
    if (!ll_failed(&i->first))
        i->first = ll_result_store_check_version(i->store, record);
}

ll_status ll_result_store_check_versions(ll_result_store *store)
{
    inspection i = {store, ll_ok()};
    ll_status status = store->kind->list(store, inspect, &i);
    return ll_failed(&status) ? status : i.first;
}

/* ---- rows of a store ---- */

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

void ll_stored_rows_seek(void *context, int64_t run)
{
    ll_stored_rows *r = context;
    r->at = r->count = 0;
    r->next = run;
}

void ll_stored_rows_close(ll_stored_rows *r)
{
    free(r->rows);
    r->rows = NULL;
}
