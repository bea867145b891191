/* `laglab store`: lists, shows, pauses, resumes and deletes the experiments of a store. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "cli/arguments.h"
#include "cli/verbs.h"
#include "experiment/store/result_store.h"

typedef struct store_args {
    const char *positional[LL_POSITIONAL_MAX];
    int count;
    const char *url;
    bool force;
} store_args;

static void print_time(int64_t unix_s, char text[32])
{
    time_t at = (time_t)unix_s;
    struct tm utc;
    gmtime_r(&at, &utc);
    strftime(text, 32, "%Y-%m-%dT%H:%M:%SZ", &utc);
}

/* ---- the verbs ---- */

static void print_row(void *context, const ll_experiment_record *r)
{
    char made[32];
    (void)context;
    print_time(r->created_s, made);
    printf("%-26s %-9s %8" PRId64 " of %-8" PRId64 " %s  %s\n", r->id, ll_experiment_state_names[r->state],
           r->done, r->to - r->from, made, r->version);
}

static ll_status list(ll_result_store *store, const store_args *o)
{
    if (o->count > 1)
        return ll_error(LL_BAD_INPUT, "list: must have no arguments; got %.60s", o->positional[1]);
    return store->kind->list(store, print_row, NULL);
}

static ll_status show(ll_result_store *store, const store_args *o)
{
    ll_experiment_record r;
    char made[32], *text = NULL;
    if (o->count != 2)
        return ll_error(LL_BAD_INPUT, "show: must have the id of one experiment; see list");
    LL_TRY(store->kind->record(store, o->positional[1], &r));
    LL_TRY(store->kind->specification(store, o->positional[1], &text));
    print_time(r.created_s, made);
    printf("id       %s\nstate    %s\nruns     %" PRId64 " to %" PRId64 "\ndone     %" PRId64
           "\nleased   %" PRId64 "\nmade     %s\nversion  %s\nowner    %s\n%s\n",
           r.id, ll_experiment_state_names[r.state], r.from, r.to - 1, r.done, r.leased, made, r.version,
           r.owner_hash[0] ? "clients with the key that the API returned" : "none: a sweep", text);
    free(text);
    return ll_ok();
}

/* Checks all before changing the first. */
static ll_status change(ll_result_store *store, const store_args *o, ll_experiment_state from,
                        ll_experiment_state to)
{
    ll_experiment_record r;
    ll_status status =
        o->count < 2 ? ll_error(LL_BAD_INPUT, "%s: must have ids of experiments; see list", o->positional[0])
                     : ll_ok();
    for (int i = 1; i < o->count && !ll_failed(&status); i++) {
        status = store->kind->record(store, o->positional[i], &r);
        if (!ll_failed(&status) && r.state != from && r.state != to)
            status = ll_error(LL_CONFLICT, "%s is %s; only an experiment that is %s can be %s", r.id,
                              ll_experiment_state_names[r.state], ll_experiment_state_names[from],
                              ll_experiment_state_names[to]);
    }
    for (int i = 1; i < o->count && !ll_failed(&status); i++)
        status = store->kind->set_state(store, o->positional[i], to);
    return status;
}

static ll_status pause_some(ll_result_store *store, const store_args *o)
{
    return change(store, o, LL_EXPERIMENT_RUNNING, LL_EXPERIMENT_PAUSED);
}

static ll_status resume(ll_result_store *store, const store_args *o)
{
    return change(store, o, LL_EXPERIMENT_PAUSED, LL_EXPERIMENT_RUNNING);
}

/* Checks all before deleting the first. */
static ll_status delete (ll_result_store *store, const store_args *o)
{
    ll_experiment_record r;
    ll_status status =
        o->count < 2 ? ll_error(LL_BAD_INPUT, "delete: must have ids of experiments; see list") : ll_ok();
    for (int i = 1; i < o->count && !ll_failed(&status); i++) {
        status = store->kind->record(store, o->positional[i], &r);
        bool over = r.state != LL_EXPERIMENT_RUNNING && r.state != LL_EXPERIMENT_PAUSED;
        if (!ll_failed(&status) && !over && !o->force)
            status = ll_error(LL_CONFLICT, "%s is %s; --force deletes it", r.id,
                              ll_experiment_state_names[r.state]);
    }
    for (int i = 1; i < o->count && !ll_failed(&status); i++)
        status = store->kind->remove(store, o->positional[i]);
    return status;
}

static const struct {
    const char *name;
    ll_status (*run)(ll_result_store *store, const store_args *order);
} verbs[] = {{"list", list}, {"show", show}, {"pause", pause_some}, {"resume", resume}, {"delete", delete}};

static const char usage[] =
    "store list|show ID|pause ID...|resume ID...|delete ID... [--store URL] [--force]";

int ll_verb_store(int argc, char **argv)
{
    store_args o = {0};
    const ll_option options[] = {{"--store", "URL",
                                  "sqlite:FILE or postgresql://USER@HOST/DATABASE; default: $LAGLAB_STORE",
                                  .value = &o.url},
                                 {"--force", NULL, "Also delete unfinished experiments.", .flag = &o.force},
                                 {0}};
    ll_status status = ll_arguments(usage, argc, argv, options, o.positional, &o.count);
    size_t verb = 0, count = sizeof verbs / sizeof verbs[0];
    while (verb < count && (o.count == 0 || strcmp(o.positional[0], verbs[verb].name) != 0))
        verb++;
    o.url = ll_result_store_url(o.url);
    if (!ll_failed(&status) && verb == count)
        status = ll_error(LL_BAD_INPUT, "store: must be one of list, show, pause, resume, delete");
    if (!ll_failed(&status) && !o.url)
        status = ll_error(LL_BAD_INPUT, "--store: required, or set LAGLAB_STORE");
    ll_result_store *store = NULL;
    LL_THEN(status, ll_result_store_open(o.url, &store));
    LL_THEN(status, verbs[verb].run(store, &o));
    ll_result_store_close(store);
    return ll_failed(&status) ? ll_argument_fail(&status) : 0;
}
