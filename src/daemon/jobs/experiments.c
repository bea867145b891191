#include "daemon/jobs/experiments.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/jobs/progress_stream.h"
#include "daemon/support/access.h"
#include "daemon/support/log.h"
#include "experiment/run/work.h"
#include "threads/clock.h"

enum { ROW_BYTES = 64, METRIC_BYTES = 9 }; /* of a stored row, about */

enum { RATE_SAMPLES = 64, LOWEST_NICE = 19 };

#define EXPIRE_EVERY_NS (10 * LL_SECOND) /* between two deletions of expired experiments */

/* Start of the interval over which an experiment's rate is measured. */
typedef struct rate_sample {
    char id[LL_EXPERIMENT_ID_MAX + 1];
    ll_time since;
    int64_t done;
} rate_sample;

/* The client that created an experiment, known until the daemon ends. */
typedef struct creator {
    struct creator *next;
    char id[LL_EXPERIMENT_ID_MAX + 1], client[48];
} creator;

struct ll_experiments {
    const ll_host_config *config;
    ll_result_store *store;
    ll_workers *workers;
    _Atomic(ll_progress *) progress;        /* NULL before the web server is started */
    pthread_mutex_t lock;                   /* guards the rates */
    rate_sample rate_samples[RATE_SAMPLES]; /* a ring buffer */
    int next_pace;
    creator *creators; /* guarded by `lock` */
    /* Of the thread that tidies up: */
    ll_time failing_since; /* of the store; 0: it works */
    ll_time expired_at;
};

/* ---- stored experiments ---- */

/* Number of stored experiments, and one of them that has expired. */
typedef struct experiment_counts {
    int64_t present;
    const ll_access *access;
    int64_t of_key[LL_CLASS_KEYS_MAX];
    double ttl_s, run_ttl_s;
    char expired[LL_EXPERIMENT_ID_MAX + 1];  /* empty: none */
    char too_long[LL_EXPERIMENT_ID_MAX + 1]; /* has run longer than its time */
} experiment_counts;

static void count(void *context, const ll_experiment_record *record)
{
    experiment_counts *c = context;
    bool over = record->state != LL_EXPERIMENT_RUNNING && record->state != LL_EXPERIMENT_PAUSED;
    c->present++;
    const ll_class_key *key = ll_access_named_key(c->access, record->class_key);
    if (key)
        c->of_key[key - c->access->class_keys.keys]++;
    if (!over && (double)record->age_s > c->run_ttl_s)
        snprintf(c->too_long, sizeof c->too_long, "%s", record->id);
    if (over && (double)record->age_s > c->ttl_s)
        snprintf(c->expired, sizeof c->expired, "%s", record->id);
}

/* ---- creators ---- */

static int64_t created_by(ll_experiments *x, const char *client)
{
    int64_t made = 0;
    pthread_mutex_lock(&x->lock);
    for (const creator *m = x->creators; m; m = m->next)
        made += strcmp(m->client, client) == 0;
    pthread_mutex_unlock(&x->lock);
    return made;
}

static void note_creator(ll_experiments *x, const char *id, const char *client)
{
    creator *m = malloc(sizeof *m);
    if (!m)
        return; /* it still counts in the total */
    snprintf(m->id, sizeof m->id, "%s", id);
    snprintf(m->client, sizeof m->client, "%s", client);
    pthread_mutex_lock(&x->lock);
    m->next = x->creators;
    x->creators = m;
    pthread_mutex_unlock(&x->lock);
}

static void drop_creator(ll_experiments *x, const char *id)
{
    pthread_mutex_lock(&x->lock);
    creator **link = &x->creators;
    while (*link && strcmp((*link)->id, id) != 0)
        link = &(*link)->next;
    creator *gone = *link;
    if (gone)
        *link = gone->next;
    pthread_mutex_unlock(&x->lock);
    free(gone);
}

static void note_keys(const experiment_counts *c)
{
    for (int i = 0; c->access && i < c->access->class_keys.count; i++)
        atomic_store(&c->access->class_keys.keys[i].used[LL_KEY_EXPERIMENTS], c->of_key[i]);
}

/* Cancels experiments that have run too long, deletes expired ones, counts the others. */
static ll_status expire(ll_experiments *x, int64_t *present)
{
    for (;;) {
        experiment_counts c = {.access = x->config->access,
                               .ttl_s = x->config->experiment_ttl_s,
                               .run_ttl_s = x->config->experiment_run_ttl_s};
        ll_status status = ll_result_store_list(x->store, count, &c);
        *present = c.present;
        if (!ll_failed(&status))
            note_keys(&c);
        if (ll_failed(&status) || (!c.expired[0] && !c.too_long[0]))
            return status;
        if (c.too_long[0])
            status = ll_result_store_set_state(x->store, c.too_long, LL_EXPERIMENT_CANCELLED);
        else
            status = ll_experiments_remove(x, c.expired);
        if (ll_failed(&status) && status.code != LL_NOT_FOUND) /* a client may have deleted it */
            return status;
    }
}

/* ---- start and stop ---- */

static ll_status start_workers(ll_experiments *x)
{
    ll_workers_config config = {.store = x->store, .threads = (int)x->config->threads, .nice = LOWEST_NICE};
    LL_TRY(ll_workers_start(&config, &x->workers));
    ll_status versions = ll_result_store_check_versions(x->store);
    if (versions.code == LL_CONFLICT)
        ll_log_write("warn", "experiments", "%s", versions.text);
    return ll_ok();
}

ll_status ll_experiments_open(const char *folder, const ll_host_config *config, ll_experiments **experiments)
{
    char path[600];
    ll_experiments *x = *experiments = calloc(1, sizeof *x);
    if (!x)
        return ll_error(LL_NO_MEMORY, "out of memory: experiments");
    x->config = config;
    pthread_mutex_init(&x->lock, NULL);
    snprintf(path, sizeof path, folder ? "%s/experiments.db" : ":memory:", folder);
    int64_t present;
    ll_status status = ll_result_store_open_any(path, &x->store);
    if (!ll_failed(&status)) {
        status = expire(x, &present);
        if (ll_result_store_failing(x->store, NULL))
            status = ll_ok(); /* what is there can be read */
    }
    LL_THEN(status, start_workers(x));
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

ll_status ll_experiments_open_streams(ll_experiments *x, ll_ws *ws)
{
    ll_progress *progress;
    const ll_progress_source source = {x, ll_experiments_find, ll_experiments_describe, ll_experiments_tidy};
    LL_TRY(ll_progress_start(&source, ws, &progress));
    atomic_store(&x->progress, progress);
    return ll_result_store_list(x->store, show, progress);
}

void ll_experiments_request_stop(ll_experiments *x)
{
    if (x && x->workers)
        ll_workers_request_stop(x->workers);
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
    if (ll_failed(&status) && status.code != LL_IO) /* which was logged when it began */
        ll_log_write("error", "experiments", "%s", status.text);
}

void ll_experiments_close(ll_experiments *x)
{
    if (!x)
        return;
    ll_experiments_stop(x);
    ll_progress_free(atomic_load(&x->progress));
    ll_result_store_close(x->store);
    while (x->creators)
        drop_creator(x, x->creators->id);
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

static void begin_rate(ll_experiments *x, const char *id, int64_t done)
{
    pthread_mutex_lock(&x->lock);
    rate_sample *p = &x->rate_samples[x->next_pace++ % RATE_SAMPLES];
    snprintf(p->id, sizeof p->id, "%s", id);
    p->since = ll_now_ns();
    p->done = done;
    pthread_mutex_unlock(&x->lock);
}

/* 0: unknown */
static double rate_of(ll_experiments *x, const ll_experiment_record *record)
{
    double rate = 0;
    bool known = false;
    ll_time since = -1, now = ll_now_ns();
    pthread_mutex_lock(&x->lock);
    for (int i = 0; i < RATE_SAMPLES; i++) {
        const rate_sample *p = &x->rate_samples[i];
        if (strcmp(p->id, record->id) != 0 || p->since <= since)
            continue;
        since = p->since;
        known = true;
        rate = now > since ? (double)(record->done - p->done) / ll_to_s(now - since) : 0;
    }
    pthread_mutex_unlock(&x->lock);
    if (!known) /* it was started before this daemon: measure from now on */
        begin_rate(x, record->id, record->done);
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

/* One line of the log when the store begins to fail and one when it works again, which is tried meanwhile. */
static bool check_store(ll_experiments *x)
{
    ll_status why;
    bool failing = ll_result_store_failing(x->store, &why);
    if (failing && x->failing_since == 0) {
        x->failing_since = ll_now_ns();
        ll_log_write("error", "the store of experiments fails", "%s; experiments wait until it works again",
                     why.text);
    } else if (!failing && x->failing_since > 0) {
        ll_log_write("warn", "the store of experiments works again", "It failed for %.1f s.",
                     ll_to_s(ll_now_ns() - x->failing_since));
        x->failing_since = 0;
        if (x->workers)
            ll_workers_notify(x->workers);
    }
    if (failing)
        ll_result_store_try(x->store);
    return !failing;
}

void ll_experiments_delete_expired(ll_experiments *x)
{
    int64_t present;
    ll_status status = expire(x, &present);
    if (ll_failed(&status) && status.code != LL_IO)
        ll_log_write("warn", "experiments", "%s", status.text);
}

void ll_experiments_tidy(ll_experiments *x)
{
    ll_time now = ll_now_ns();
    if (!check_store(x) || now - x->expired_at < EXPIRE_EVERY_NS)
        return;
    x->expired_at = now;
    ll_experiments_delete_expired(x);
}

/* Whether the results of another experiment fit: those stored, and those of its runs. */
static ll_status fits(ll_experiments *x, const ll_experiment *e)
{
    const double mebi = 1 << 20;
    int64_t there = 0, most = x->config->max_results_mib << 20;
    int64_t wanted = e->runs * (ROW_BYTES + METRIC_BYTES * (int64_t)e->metric_count);
    if (most == 0)
        return ll_ok();
    ll_status status = ll_result_store_bytes(x->store, &there);
    if (ll_failed(&status) || (there < most && wanted <= most - there))
        return status;
    return ll_error(LL_IO,
                    "Results of experiments use %.1f of %.1f MiB (max_results_mib), and this one's would "
                    "take about %.1f.",
                    (double)there / mebi, (double)most / mebi, (double)wanted / mebi);
}

static ll_status key_full(ll_class_key *key)
{
    atomic_fetch_add(&key->refused, 1);
    return ll_error(LL_LIMIT, "The class key %s has as many experiments as it may have (%lld); delete some.",
                    key->name, (long long)key->most[LL_KEY_EXPERIMENTS]);
}

static ll_status allowed(ll_experiments *x, const ll_experiment *e, const char *client, ll_class_key *key)
{
    int64_t present = 0;
    if (e->runs > x->config->max_experiment_runs)
        return ll_field_error(LL_BAD_INPUT, "axes", "experiment: has %lld runs; must have at most %lld",
                              (long long)e->runs, (long long)x->config->max_experiment_runs);
    ll_status status = expire(x, &present);
    if (!ll_failed(&status) && present >= x->config->max_experiments)
        status = ll_error(LL_LIMIT, "Limit of %lld experiments reached.", (long long)present);
    if (!ll_failed(&status) && key && ll_class_key_is_full(key, LL_KEY_EXPERIMENTS))
        status = key_full(key);
    int64_t made = key ? 0 : created_by(x, client);
    if (!ll_failed(&status) && made >= x->config->max_client_experiments)
        status =
            ll_error(LL_LIMIT,
                     "Limit of %lld experiments of one address reached (max_client_experiments); delete one.",
                     (long long)made);
    return ll_failed(&status) ? status : fits(x, e);
}

ll_status ll_experiments_add(ll_experiments *x, const ll_experiment *e, const char *client,
                             ll_class_key *class_key, char id[LL_ID_LENGTH + 1], char key[LL_KEY_LENGTH + 1])
{
    ll_experiment_record record = {.to = e->runs};
    LL_TRY(allowed(x, e, client, class_key));
    if (class_key) {
        snprintf(record.class_key, sizeof record.class_key, "%s", class_key->name);
        record.most_of_key = class_key->most[LL_KEY_EXPERIMENTS];
    }
    if (!ll_new_id(x->config->shard, id) || !ll_new_key(key) || !hash_text(key, record.owner_hash))
        return ll_error(LL_NO_MEMORY, "Random numbers for keys not available.");
    snprintf(record.id, sizeof record.id, "%s", id);
    char *text = ll_experiment_text(e);
    if (!text)
        return ll_error(LL_NO_MEMORY, "out of memory: experiment");
    begin_rate(x, id, 0);
    ll_status status = ll_result_store_create(x->store, &record, text, ll_experiment_chunk(e, e->runs));
    free(text);
    if (x->workers)
        ll_workers_notify(x->workers);
    if (status.code == LL_LIMIT && class_key)
        status = key_full(class_key);
    if (!ll_failed(&status)) {
        if (!class_key)
            note_creator(x, id, client);
        ll_progress_add(atomic_load(&x->progress), id);
    }
    return status;
}

ll_status ll_experiments_find(ll_experiments *x, const char *id, ll_experiment_record *record)
{
    ll_status status =
        ll_is_id(id) ? ll_result_store_record(x->store, id, record) : ll_error(LL_NOT_FOUND, "id");
    return status.code == LL_NOT_FOUND ? ll_error(LL_NOT_FOUND, "Experiment not found.") : status;
}

ll_status ll_experiments_read(ll_experiments *x, const char *id, const ll_interrupt *interrupt,
                              ll_experiment **experiment)
{
    char *text = NULL;
    cJSON *json = NULL;
    ll_status status = ll_result_store_specification(x->store, id, &text);
    LL_THEN(status, ll_json_parse(text, strlen(text), &json));
    LL_THEN(status, ll_experiment_parse(json, x->config->scenarios, interrupt, experiment));
    cJSON_Delete(json);
    free(text);
    return status;
}

ll_status ll_experiments_set(ll_experiments *x, const ll_experiment_record *record, ll_experiment_state state)
{
    if (record->state != LL_EXPERIMENT_RUNNING && record->state != LL_EXPERIMENT_PAUSED)
        return ll_error(LL_CONFLICT, "The experiment has ended: it is %s.",
                        ll_experiment_state_names[record->state]);
    ll_status status = state == LL_EXPERIMENT_RUNNING ? ll_result_store_check_version(record) : ll_ok();
    LL_THEN(status, ll_result_store_set_state(x->store, record->id, state));
    if (ll_failed(&status) || state != LL_EXPERIMENT_RUNNING)
        return status;
    begin_rate(x, record->id, record->done);
    if (x->workers)
        ll_workers_notify(x->workers);
    return status;
}

ll_status ll_experiments_remove(ll_experiments *x, const char *id)
{
    ll_status status = ll_result_store_remove(x->store, id);
    if (ll_failed(&status) && status.code != LL_NOT_FOUND)
        return status;
    if (atomic_load(&x->progress))
        ll_progress_remove(atomic_load(&x->progress), id);
    drop_creator(x, id);
    return status;
}
