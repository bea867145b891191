#include "daemon/jobs/experiments.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/jobs/progress.h"
#include "daemon/support/log.h"
#include "experiment/run/work.h"

enum { ROW_BYTES = 64, METRIC_BYTES = 9 }; /* of a stored row, about */

enum { PACES = 64, LOWEST_NICE = 19 };

/* The daemon alone works on a store of its own; others work on one that was named. */
#define OWN_LEASE_S 1e6
#define SHARED_LEASE_S 60

/* From when and where the rate of an experiment is counted. */
typedef struct pace {
    char id[LL_EXPERIMENT_ID_MAX + 1];
    ll_time since;
    int64_t done;
} pace;

/* Whose an experiment is, as long as the daemon lives. */
typedef struct maker {
    struct maker *next;
    char id[LL_EXPERIMENT_ID_MAX + 1], client[48];
} maker;

struct ll_experiments {
    const ll_host_config *config;
    ll_result_store *store;
    ll_workers *workers;
    _Atomic(ll_progress *) progress; /* NULL before the door is open */
    pthread_mutex_t lock;            /* of the paces */
    pace paces[PACES];               /* a ring: the oldest goes */
    int next_pace;
    maker *makers; /* `lock` */
};

/* ---- what is there ---- */

/* How many are kept, and one that has had its time. What a sweep put into a store that is shared has no owner
 * and is not the daemon's to count or to delete. */
typedef struct census {
    int64_t present;
    double ttl_s, run_ttl_s;
    char expired[LL_EXPERIMENT_ID_MAX + 1];  /* empty: there is none */
    char too_long[LL_EXPERIMENT_ID_MAX + 1]; /* it has run for its time */
} census;

static void count(void *context, const ll_experiment_record *record)
{
    census *c = context;
    bool over = record->state != LL_EXPERIMENT_RUNNING && record->state != LL_EXPERIMENT_PAUSED;
    if (!record->owner_hash[0])
        return;
    c->present++;
    if (!over && (double)record->age_s > c->run_ttl_s)
        snprintf(c->too_long, sizeof c->too_long, "%s", record->id);
    if (over && (double)record->age_s > c->ttl_s)
        snprintf(c->expired, sizeof c->expired, "%s", record->id);
}

/* ---- whose they are ---- */

static int64_t made_by(ll_experiments *x, const char *client)
{
    int64_t made = 0;
    pthread_mutex_lock(&x->lock);
    for (const maker *m = x->makers; m; m = m->next)
        made += strcmp(m->client, client) == 0;
    pthread_mutex_unlock(&x->lock);
    return made;
}

static void note_maker(ll_experiments *x, const char *id, const char *client)
{
    maker *m = malloc(sizeof *m);
    if (!m)
        return; /* it is counted in all only */
    snprintf(m->id, sizeof m->id, "%s", id);
    snprintf(m->client, sizeof m->client, "%s", client);
    pthread_mutex_lock(&x->lock);
    m->next = x->makers;
    x->makers = m;
    pthread_mutex_unlock(&x->lock);
}

static void forget_maker(ll_experiments *x, const char *id)
{
    pthread_mutex_lock(&x->lock);
    maker **link = &x->makers;
    while (*link && strcmp((*link)->id, id) != 0)
        link = &(*link)->next;
    maker *gone = *link;
    if (gone)
        *link = gone->next;
    pthread_mutex_unlock(&x->lock);
    free(gone);
}

/* Cancels what has run for too long, deletes what has expired, and counts the rest. */
static ll_status expire(ll_experiments *x, int64_t *present)
{
    for (;;) {
        census c = {.ttl_s = x->config->experiment_ttl_s, .run_ttl_s = x->config->experiment_run_ttl_s};
        ll_status status = x->store->kind->list(x->store, count, &c);
        *present = c.present;
        if (ll_failed(&status) || (!c.expired[0] && !c.too_long[0]))
            return status;
        if (c.too_long[0])
            status = x->store->kind->set_state(x->store, c.too_long, LL_EXPERIMENT_CANCELLED);
        else
            status = ll_experiments_remove(x, c.expired);
        if (ll_failed(&status) && status.code != LL_NOT_FOUND) /* somebody else may have been faster */
            return status;
    }
}

/* ---- life ---- */

static ll_status start_workers(ll_experiments *x)
{
    bool shared = ll_result_store_url(x->config->store) != NULL;
    ll_workers_order order = {.store = x->store,
                              .threads = (int)x->config->threads,
                              .nice = LOWEST_NICE,
                              .lease_s = shared ? SHARED_LEASE_S : OWN_LEASE_S,
                              .persist = true};
    ll_status status = shared ? ll_ok() : x->store->kind->release(x->store); /* of a daemon that was killed */
    if (!ll_failed(&status))
        status = ll_workers_start(&order, &x->workers);
    if (ll_failed(&status))
        return status;
    ll_status told = ll_result_store_admits_all(x->store);
    if (told.code == LL_CONFLICT)
        ll_log_write("warn", "experiments", "%s", told.text);
    return status;
}

ll_status ll_experiments_open(const char *folder, const ll_host_config *config, ll_experiments **experiments)
{
    char url[600];
    ll_experiments *x = *experiments = calloc(1, sizeof *x);
    if (!x)
        return ll_error(LL_NO_MEMORY, "There is no memory for experiments.");
    x->config = config;
    pthread_mutex_init(&x->lock, NULL);
    const char *shared = ll_result_store_url(config->store);
    snprintf(url, sizeof url, folder ? "sqlite:%s/experiments.db" : "sqlite::memory:", folder);
    int64_t present;
    ll_status status = ll_result_store_open(shared ? shared : url, &x->store);
    if (!ll_failed(&status))
        status = expire(x, &present);
    if (!ll_failed(&status))
        status = start_workers(x);
    if (ll_failed(&status)) {
        ll_experiments_close(x);
        *experiments = NULL;
    }
    return status;
}

static void show(void *progress, const ll_experiment_record *record)
{
    ll_progress_add(progress, record->id);
}

ll_status ll_experiments_show(ll_experiments *x, ll_ws *ws)
{
    ll_progress *progress;
    const ll_progress_source source = {x, ll_experiments_find, ll_experiments_describe, ll_experiments_tidy};
    ll_status status = ll_progress_start(&source, ws, &progress);
    if (ll_failed(&status))
        return status;
    atomic_store(&x->progress, progress);
    return x->store->kind->list(x->store, show, progress);
}

void ll_experiments_ask_to_end(ll_experiments *x)
{
    if (x && x->workers)
        ll_workers_ask_to_end(x->workers);
}

void ll_experiments_stop(ll_experiments *x)
{
    ll_progress *progress = x ? atomic_load(&x->progress) : NULL;
    if (progress)
        ll_progress_stop(progress);
    if (!x || !x->workers)
        return;
    ll_status status = ll_workers_stop(x->workers);
    x->workers = NULL;
    if (ll_failed(&status))
        ll_log_write("error", "experiments", "%s", status.text);
}

void ll_experiments_close(ll_experiments *x)
{
    if (!x)
        return;
    ll_experiments_stop(x);
    ll_progress_free(atomic_load(&x->progress));
    ll_result_store_close(x->store);
    while (x->makers)
        forget_maker(x, x->makers->id);
    pthread_mutex_destroy(&x->lock);
    free(x);
}

ll_result_store *ll_experiments_store(ll_experiments *x)
{
    return x->store;
}

/* ---- keys ---- */

static bool hash_text(const char *key, char text[LL_OWNER_HASH_MAX + 1])
{
    ll_key_hash hash;
    if (!ll_key_hash_make(key, &hash))
        return false;
    for (int i = 0; i < LL_KEY_RECORD; i++)
        snprintf(text + 2 * i, 3, "%02x", hash.bytes[i]);
    return true;
}

bool ll_experiments_permits(const ll_experiment_record *record, const char *key)
{
    ll_key_hash hash;
    if (strlen(record->owner_hash) != 2 * LL_KEY_RECORD)
        return false;
    for (int i = 0; i < LL_KEY_RECORD; i++) {
        char byte[3] = {record->owner_hash[2 * i], record->owner_hash[2 * i + 1]};
        hash.bytes[i] = (unsigned char)strtoul(byte, NULL, 16);
    }
    return ll_key_matches(&hash, key, strlen(key));
}

/* ---- experiments ---- */

static void begin_pace(ll_experiments *x, const char *id, int64_t done)
{
    pthread_mutex_lock(&x->lock);
    pace *p = &x->paces[x->next_pace++ % PACES];
    snprintf(p->id, sizeof p->id, "%s", id);
    p->since = ll_host_now();
    p->done = done;
    pthread_mutex_unlock(&x->lock);
}

/* 0 when it is not known. */
static double rate_of(ll_experiments *x, const ll_experiment_record *record)
{
    double rate = 0;
    bool known = false;
    ll_time since = -1, now = ll_host_now();
    pthread_mutex_lock(&x->lock);
    for (int i = 0; i < PACES; i++) {
        const pace *p = &x->paces[i];
        if (strcmp(p->id, record->id) != 0 || p->since <= since)
            continue;
        since = p->since;
        known = true;
        rate = now > since ? (double)(record->done - p->done) / ll_to_s(now - since) : 0;
    }
    pthread_mutex_unlock(&x->lock);
    if (!known) /* it was begun before this daemon, or by another: from this look on */
        begin_pace(x, record->id, record->done);
    return rate;
}

void ll_experiments_describe(ll_experiments *x, const ll_experiment_record *r, cJSON *json)
{
    bool running = r->state == LL_EXPERIMENT_RUNNING;
    double rate = running ? rate_of(x, r) : 0;
    cJSON_AddStringToObject(json, "state", ll_experiment_state_names[r->state]);
    cJSON_AddNumberToObject(json, "runs", (double)(r->to - r->from));
    cJSON_AddNumberToObject(json, "done", (double)r->done);
    cJSON_AddNumberToObject(json, "rate_per_s", rate);
    if (rate > 0)
        cJSON_AddNumberToObject(json, "left_s", (double)(r->to - r->from - r->done) / rate);
    else
        cJSON_AddNullToObject(json, "left_s");
}

void ll_experiments_tidy(ll_experiments *x)
{
    int64_t present;
    ll_status status = expire(x, &present);
    if (ll_failed(&status))
        ll_log_write("warn", "experiments", "%s", status.text);
}

/* Whether the results of one more fit: of those that are there, and of this one's runs. */
static ll_status fits(ll_experiments *x, const ll_experiment *e)
{
    const double mebi = 1 << 20;
    int64_t there = 0, most = x->config->max_results_mib << 20;
    int64_t wanted = e->runs * (ROW_BYTES + METRIC_BYTES * (int64_t)e->metric_count);
    if (most == 0 || !x->store->kind->bytes)
        return ll_ok();
    ll_status status = x->store->kind->bytes(x->store, &there);
    if (ll_failed(&status) || (there < most && wanted <= most - there))
        return status;
    return ll_error(LL_IO,
                    "The experiments' results take %.1f of %.1f MiB (max_results_mib), and this one's would "
                    "take about %.1f.",
                    (double)there / mebi, (double)most / mebi, (double)wanted / mebi);
}

static ll_status allowed(ll_experiments *x, const ll_experiment *e, const char *client)
{
    int64_t present = 0;
    if (e->runs > x->config->max_experiment_runs)
        return ll_field_error(LL_BAD_INPUT, "axes",
                              "The experiment has %lld runs; this daemon takes at most %lld.",
                              (long long)e->runs, (long long)x->config->max_experiment_runs);
    ll_status status = expire(x, &present);
    if (!ll_failed(&status) && present >= x->config->max_experiments)
        status =
            ll_error(LL_LIMIT, "There are %lld experiments already, which is the limit.", (long long)present);
    int64_t made = made_by(x, client);
    if (!ll_failed(&status) && made >= x->config->max_client_experiments)
        status = ll_error(LL_LIMIT,
                          "%lld experiments of this address are kept, which is the limit "
                          "(max_client_experiments): delete one.",
                          (long long)made);
    return ll_failed(&status) ? status : fits(x, e);
}

ll_status ll_experiments_add(ll_experiments *x, const ll_experiment *e, const char *client,
                             char id[LL_ID_LENGTH + 1], char key[LL_KEY_LENGTH + 1])
{
    ll_experiment_record record = {.to = e->runs};
    ll_status status = allowed(x, e, client);
    if (ll_failed(&status))
        return status;
    if (!ll_new_id(id) || !ll_new_key(key) || !hash_text(key, record.owner_hash))
        return ll_error(LL_NO_MEMORY, "The system gives no random numbers for keys.");
    snprintf(record.id, sizeof record.id, "%s", id);
    char *text = ll_experiment_text(e);
    if (!text)
        return ll_error(LL_NO_MEMORY, "There is no memory for an experiment.");
    begin_pace(x, id, 0);
    status = x->store->kind->create(x->store, &record, text, ll_experiment_chunk(e, e->runs, 0));
    free(text);
    if (x->workers)
        ll_workers_wake(x->workers);
    if (!ll_failed(&status)) {
        note_maker(x, id, client);
        ll_progress_add(atomic_load(&x->progress), id);
    }
    return status;
}

ll_status ll_experiments_find(ll_experiments *x, const char *id, ll_experiment_record *record,
                              ll_experiment **experiment)
{
    char *text = NULL;
    cJSON *json = NULL;
    if (!ll_is_id(id))
        return ll_error(LL_NOT_FOUND, "There is no experiment with this id.");
    ll_status status = x->store->kind->record(x->store, id, record);
    if (status.code == LL_NOT_FOUND)
        return ll_error(LL_NOT_FOUND, "There is no experiment with this id.");
    if (ll_failed(&status) || !experiment)
        return status;
    ll_progress_add(atomic_load(&x->progress), id); /* another machine may have made it */
    status = x->store->kind->specification(x->store, id, &text);
    if (!ll_failed(&status))
        status = ll_json_parse(text, strlen(text), &json);
    if (!ll_failed(&status))
        status = ll_experiment_parse(json, x->config->scenarios, experiment);
    cJSON_Delete(json);
    free(text);
    return status;
}

ll_status ll_experiments_set(ll_experiments *x, const ll_experiment_record *record, ll_experiment_state state)
{
    if (record->state != LL_EXPERIMENT_RUNNING && record->state != LL_EXPERIMENT_PAUSED)
        return ll_error(LL_CONFLICT, "The experiment is over: it is %s.",
                        ll_experiment_state_names[record->state]);
    ll_status status = state == LL_EXPERIMENT_RUNNING ? ll_result_store_admits(x->store, record) : ll_ok();
    if (!ll_failed(&status))
        status = x->store->kind->set_state(x->store, record->id, state);
    if (ll_failed(&status) || state != LL_EXPERIMENT_RUNNING)
        return status;
    begin_pace(x, record->id, record->done);
    if (x->workers)
        ll_workers_wake(x->workers);
    return status;
}

ll_status ll_experiments_remove(ll_experiments *x, const char *id)
{
    if (atomic_load(&x->progress))
        ll_progress_remove(atomic_load(&x->progress), id);
    forget_maker(x, id);
    return x->store->kind->remove(x->store, id);
}
