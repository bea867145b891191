#include "daemon/jobs/measurements.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cjson/cJSON.h>

#include "base/assert.h"
#include "base/version.h"
#include "daemon/support/log.h"
#include "experiment/report/tradeoff_json.h"
#include "threads/clock.h"

enum { THREADS = 2 };

#define SHOW_EVERY_NS (250 * LL_MS) /* rows are made readable, and stored */
#define STORE_EVERY_NS (2 * LL_SECOND)

typedef enum measurement_state { RUNNING, DONE, FAILED } measurement_state;

static const char *const states[] = {"running", "done", "failed"};

/* One that runs points into itself. */
typedef struct measurement {
    struct measurement *next;
    ll_measurements *all;
    char id[LL_ID_LENGTH + 1], date[24], version[LL_VERSION_MAX];
    ll_key_hash key;
    ll_measurement_order order;
    ll_tradeoff_request request;
    ll_tradeoff_run *run; /* NULL: it has ended */
    /* Guarded by the lock of `all`: */
    ll_task *tasks[THREADS]; /* NULL: ended */
    int working;             /* tasks that have not ended */
    bool removed;            /* from the list; freed by its last task */
    bool showing;            /* a thread makes its rows readable */
    measurement_state state;
    int64_t done, steps;
    int64_t shown_at, stored_at;
    char *answer; /* JSON; NULL: nothing yet */
    ll_status error;
} measurement;

struct ll_measurements {
    ll_tasks *tasks;
    const ll_host_config *config;
    ll_store *store;
    pthread_mutex_t lock;
    measurement *first; /* newest first */
};

static void free_measurement(measurement *m)
{
    ll_tradeoff_close(m->run);
    free(m->answer);
    free(m);
}

/* ---- as JSON, and in the store; locked ---- */

static cJSON *methods_json(const char *methods)
{
    char name[40];
    cJSON *list = *methods ? cJSON_CreateArray() : cJSON_CreateNull();
    while (ll_list_next(&methods, name, sizeof name))
        cJSON_AddItemToArray(list, cJSON_CreateString(name));
    return list;
}

static int64_t done_of(const measurement *m)
{
    return m->run ? ll_tradeoff_done(m->run) : m->done;
}

static void describe(const measurement *m, cJSON *json)
{
    cJSON_AddStringToObject(json, "family", m->order.family->name);
    cJSON_AddItemToObject(json, "methods", methods_json(m->order.methods));
    cJSON_AddStringToObject(json, "date", m->date);
    cJSON_AddStringToObject(json, "version", m->version);
    cJSON_AddStringToObject(json, "state", states[m->state]);
    cJSON_AddNumberToObject(json, "steps", (double)m->steps);
    cJSON_AddNumberToObject(json, "done", (double)done_of(m));
    cJSON_AddItemToObject(json, "answer", m->answer ? cJSON_CreateRaw(m->answer) : cJSON_CreateNull());
    cJSON_AddItemToObject(json, "error",
                          ll_failed(&m->error) ? cJSON_CreateString(m->error.text) : cJSON_CreateNull());
}

static void store(measurement *m)
{
    if (m->removed || !m->all->store)
        return;
    char key[LL_KEY_HASH_TEXT + 1];
    ll_key_hash_write(&m->key, key);
    cJSON *json = cJSON_CreateObject();
    describe(m, json);
    if (m->answer) /* as a string: parsed and written again its numbers would be others in the last digit */
        cJSON_ReplaceItemInObject(json, "answer", cJSON_CreateString(m->answer));
    cJSON_AddStringToObject(json, "key", key);
    char *text = cJSON_PrintUnformatted(json);
    if (text)
        ll_store_put_text(m->all->store, LL_STORE_MEASUREMENT, m->id, ll_unix_ms(), text);
    cJSON_free(text);
    cJSON_Delete(json);
    m->stored_at = ll_now_ns();
}

/* ---- the list; locked ---- */

static measurement **find(ll_measurements *all, const char *id)
{
    measurement **link = &all->first;
    while (*link && strcmp((*link)->id, id) != 0)
        link = &(*link)->next;
    return link;
}

static measurement *running(const ll_measurements *all, const ll_tradeoff_family *family)
{
    measurement *m = all->first;
    while (m && !(m->state == RUNNING && m->order.family == family))
        m = m->next;
    return m;
}

static void remove_from_list(measurement **link, bool of_store)
{
    measurement *m = *link;
    *link = m->next;
    m->removed = true;
    if (of_store && m->all->store)
        ll_store_delete_text(m->all->store, LL_STORE_MEASUREMENT, m->id);
    for (int i = 0; i < THREADS; i++)
        if (m->tasks[i])
            ll_task_stop(m->tasks[i], LL_TASK_CANCELLED);
    if (m->working == 0)
        free_measurement(m);
}

/* A finished measurement takes the place of all that have ended; one that failed, of those that failed too.
 */
static void remove_superseded(const measurement *by)
{
    for (measurement **link = &by->all->first; *link;) {
        measurement *m = *link;
        if (m != by && m->order.family == by->order.family && m->state != RUNNING &&
            (by->state == DONE || m->state == by->state))
            remove_from_list(link, true);
        else
            link = &m->next;
    }
}

/* ---- measuring ---- */

/* The rows so far, as JSON; NULL: there are none, or no memory. The caller frees it. */
static char *rows_so_far(measurement *m)
{
    ll_tradeoff tradeoff;
    char *text = NULL;
    ll_status status = ll_tradeoff_so_far(m->run, &tradeoff);
    if (!ll_failed(&status) && tradeoff.count > 0) {
        cJSON *json = ll_tradeoff_json(&tradeoff);
        text = cJSON_PrintUnformatted(json);
        cJSON_Delete(json);
    }
    ll_tradeoff_free(&tradeoff);
    return text;
}

static void take_rows(measurement *m, char *text)
{
    if (!text)
        return;
    free(m->answer);
    m->answer = text;
}

/* Makes the rows readable now and then, by one of the threads. */
static void show(measurement *m)
{
    pthread_mutex_lock(&m->all->lock);
    int64_t now = ll_now_ns();
    bool due = !m->showing && (!m->answer || now - m->shown_at >= SHOW_EVERY_NS);
    m->showing = m->showing || due;
    pthread_mutex_unlock(&m->all->lock);
    if (!due)
        return;
    char *text = rows_so_far(m);
    pthread_mutex_lock(&m->all->lock);
    take_rows(m, text);
    m->showing = false;
    m->shown_at = now;
    if (now - m->stored_at >= STORE_EVERY_NS)
        store(m);
    pthread_mutex_unlock(&m->all->lock);
}

/* By the last of its tasks. What the daemon's end interrupts is stored as running. */
static void end(measurement *m, bool stopped)
{
    char *text = rows_so_far(m);
    pthread_mutex_lock(&m->all->lock);
    take_rows(m, text);
    m->done = ll_tradeoff_done(m->run);
    if (!stopped)
        m->state = ll_failed(&m->error) ? FAILED : DONE;
    store(m);
    if (m->state != RUNNING && !m->removed)
        remove_superseded(m);
    ll_tradeoff_run *run = m->run;
    bool removed = m->removed;
    m->run = NULL;
    pthread_mutex_unlock(&m->all->lock);
    ll_tradeoff_close(run);
    if (removed)
        free_measurement(m);
}

/* One of its tasks has ended. */
static void leave(measurement *m, ll_task *task, const ll_status *status)
{
    bool stopped = ll_task_end_reason(task) == LL_TASK_STOPPED;
    pthread_mutex_lock(&m->all->lock);
    for (int i = 0; i < THREADS; i++)
        if (m->tasks[i] == task)
            m->tasks[i] = NULL;
    if (ll_failed(status) && !stopped && !ll_failed(&m->error)) {
        char how_far[60];
        snprintf(how_far, sizeof how_far, "interrupted after %lld settings", (long long)done_of(m));
        m->error = status->code == LL_INTERRUPTED ? ll_task_error(task, how_far) : *status;
    }
    bool last = --m->working == 0;
    pthread_mutex_unlock(&m->all->lock);
    if (last)
        end(m, stopped);
}

static void work(void *context, ll_task *task)
{
    measurement *m = context;
    pthread_mutex_lock(&m->all->lock); /* after the lock, its tasks are set */
    pthread_mutex_unlock(&m->all->lock);
    ll_interrupt interrupt = ll_task_interrupt(task);
    ll_status status =
        ll_task_end_reason(task) == LL_TASK_RUNNING ? ll_ok() : ll_error(LL_INTERRUPTED, "not started");
    while (!ll_failed(&status) && ll_tradeoff_next(m->run, &interrupt, &status))
        show(m);
    leave(m, task, &status);
}

/* ---- starting ---- */

static bool is_same(const ll_measurement_order *a, const ll_measurement_order *b)
{
    return a->family == b->family && strcmp(a->methods, b->methods) == 0 &&
           strcmp(a->duration, b->duration) == 0 && a->seeds == b->seeds && a->check_seeds == b->check_seeds;
}

static void set_order(measurement *m, const ll_measurement_order *order)
{
    m->order = *order;
    m->request = (ll_tradeoff_request){.scenarios = m->all->config->scenarios,
                                       .methods = *m->order.methods ? m->order.methods : NULL,
                                       .duration = *m->order.duration ? m->order.duration : NULL,
                                       .seeds = order->seeds,
                                       .check_seeds = order->check_seeds,
                                       .now_ns = ll_thread_cpu_ns};
    m->steps = ll_tradeoff_steps(order->family, &m->request);
}

static void set_date(measurement *m)
{
    time_t now = time(NULL);
    struct tm utc;
    gmtime_r(&now, &utc);
    strftime(m->date, sizeof m->date, "%Y-%m-%dT%H:%M:%SZ", &utc);
    snprintf(m->version, sizeof m->version, "%s", ll_version);
}

static ll_status make(ll_measurements *all, const ll_measurement_order *order, const char *key,
                      measurement **out)
{
    measurement *m = *out = calloc(1, sizeof *m);
    if (!m || !ll_new_id(all->config->shard, m->id) || !ll_key_hash_make(key, &m->key))
        return ll_error(LL_NO_MEMORY, "out of memory: measurement");
    m->all = all;
    set_order(m, order);
    set_date(m);
    return ll_tradeoff_open(order->family, &m->request, &m->run);
}

/* The second task fails where there is no place for it. Locked. */
static ll_status start_tasks(measurement *m)
{
    ll_task_spec spec = {
        .client = "measurements", .budget_s = m->all->config->job_cpu_s, .run = work, .context = m};
    snprintf(spec.session, sizeof spec.session, "%s", m->id);
    ll_status status = ll_ok();
    while (m->working < THREADS && !ll_failed(&status)) {
        status = ll_tasks_add(m->all->tasks, &spec, &m->tasks[m->working]);
        m->working += !ll_failed(&status);
    }
    return m->working > 0 ? ll_ok() : status;
}

static ll_status add(ll_measurements *all, const ll_measurement_order *order, measurement *m,
                     char id[LL_ID_LENGTH + 1], char key[LL_KEY_LENGTH + 1])
{
    measurement *other = running(all, order->family);
    if (other && !is_same(&other->order, order))
        return ll_field_error(
            LL_CONFLICT, "family",
            "family: another measurement of %s runs, with other methods, seeds or duration: "
            "%lld of %lld settings. Wait for its end, or end it with its key.",
            order->family->name, (long long)done_of(other), (long long)other->steps);
    if (other) {
        snprintf(id, LL_ID_LENGTH + 1, "%s", other->id);
        key[0] = '\0';
        return ll_ok();
    }
    LL_TRY(start_tasks(m));
    snprintf(id, LL_ID_LENGTH + 1, "%s", m->id);
    m->next = all->first;
    all->first = m;
    store(m);
    return ll_ok();
}

ll_status ll_measurements_start(ll_measurements *all, const ll_measurement_order *order,
                                char id[LL_ID_LENGTH + 1], char key[LL_KEY_LENGTH + 1])
{
    measurement *m = NULL;
    ll_status status =
        ll_new_key(key) ? make(all, order, key, &m) : ll_error(LL_NO_MEMORY, "out of memory: measurement");
    bool added = false;
    if (!ll_failed(&status)) {
        pthread_mutex_lock(&all->lock);
        status = add(all, order, m, id, key);
        added = all->first == m;
        pthread_mutex_unlock(&all->lock);
    }
    if (m && !added)
        free_measurement(m);
    return status;
}

/* ---- what others ask ---- */

static ll_status no_measurement(void)
{
    return ll_error(LL_NOT_FOUND, "Measurement not found, or a newer one has taken its place.");
}

ll_status ll_measurements_describe(ll_measurements *all, const char *id, cJSON *json)
{
    pthread_mutex_lock(&all->lock);
    const measurement *m = *find(all, id);
    if (m) {
        cJSON_AddStringToObject(json, "id", m->id);
        describe(m, json);
    }
    pthread_mutex_unlock(&all->lock);
    return m ? ll_ok() : no_measurement();
}

bool ll_measurements_newest(ll_measurements *all, const ll_tradeoff_family *family, char id[LL_ID_LENGTH + 1])
{
    pthread_mutex_lock(&all->lock);
    const measurement *best = running(all, family);
    for (const measurement *m = all->first; m && !(best && best->state != FAILED); m = m->next)
        if (m->order.family == family && (!best || m->state == DONE))
            best = m;
    if (best)
        snprintf(id, LL_ID_LENGTH + 1, "%s", best->id);
    pthread_mutex_unlock(&all->lock);
    return best != NULL;
}

ll_status ll_measurements_remove(ll_measurements *all, const char *id, const char *key)
{
    ll_status status = ll_ok();
    pthread_mutex_lock(&all->lock);
    measurement **link = find(all, id);
    if (!*link)
        status = no_measurement();
    else if (key && !ll_key_matches(&(*link)->key, key, strlen(key)))
        status = ll_error(LL_FORBIDDEN, "Key of another measurement.");
    else
        remove_from_list(link, true);
    pthread_mutex_unlock(&all->lock);
    return status;
}

/* ---- start and stop ---- */

static const char *text_in(const cJSON *json, const char *name)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, name));
    return text ? text : "";
}

static int64_t number_in(const cJSON *json, const char *name)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, name);
    return cJSON_IsNumber(item) && item->valuedouble > 0 ? (int64_t)item->valuedouble : 0;
}

static measurement_state state_in(const cJSON *json)
{
    const char *name = text_in(json, "state");
    return strcmp(name, states[DONE]) == 0 ? DONE : strcmp(name, states[FAILED]) == 0 ? FAILED : RUNNING;
}

static void read_ended(measurement *m, const cJSON *json)
{
    const cJSON *name;
    const char *answer = text_in(json, "answer");
    cJSON_ArrayForEach(name, cJSON_GetObjectItemCaseSensitive(json, "methods"))
    {
        size_t used = strlen(m->order.methods);
        if (cJSON_IsString(name))
            snprintf(m->order.methods + used, sizeof m->order.methods - used, "%s%s", used ? "," : "",
                     name->valuestring);
    }
    snprintf(m->date, sizeof m->date, "%s", text_in(json, "date"));
    snprintf(m->version, sizeof m->version, "%s", text_in(json, "version"));
    m->done = number_in(json, "done");
    m->steps = number_in(json, "steps");
    m->state = state_in(json);
    m->answer = *answer ? strdup(answer) : NULL;
    if (m->state == FAILED)
        m->error = ll_error(LL_INTERRUPTED, "%s", text_in(json, "error"));
    if (m->state == RUNNING) {
        m->state = FAILED;
        m->error = ll_error(LL_INTERRUPTED, "The daemon ended: interrupted after %lld of %lld settings.",
                            (long long)m->done, (long long)m->steps);
    }
}

static void restore(void *context, const char *id, int64_t seen_ms, const char *text)
{
    (void)seen_ms;
    ll_measurements *all = context;
    cJSON *json = cJSON_Parse(text);
    const ll_tradeoff_family *family = ll_tradeoff_family_find(text_in(json, "family"));
    measurement *m = family ? calloc(1, sizeof *m) : NULL;
    if (m && ll_key_hash_read(text_in(json, "key"), &m->key)) {
        m->all = all;
        m->order.family = family;
        snprintf(m->id, sizeof m->id, "%s", id);
        read_ended(m, json);
        measurement **link = &all->first; /* ids are random: newest first by their dates */
        while (*link && strcmp((*link)->date, m->date) > 0)
            link = &(*link)->next;
        m->next = *link;
        *link = m;
    } else {
        free(m);
        ll_log_write("warn", "stored measurement left out", "%s", id);
    }
    cJSON_Delete(json);
}

ll_status ll_measurements_open(ll_tasks *tasks, const ll_host_config *config, ll_store *store,
                               ll_measurements **measurements)
{
    ll_measurements *all = *measurements = calloc(1, sizeof *all);
    if (!all)
        return ll_error(LL_NO_MEMORY, "out of memory: measurements");
    all->tasks = tasks;
    all->config = config;
    all->store = store;
    pthread_mutex_init(&all->lock, NULL);
    return ll_store_list_texts(store, LL_STORE_MEASUREMENT, restore, all);
}

void ll_measurements_close(ll_measurements *all)
{
    if (!all)
        return;
    while (all->first)
        remove_from_list(&all->first, false);
    pthread_mutex_destroy(&all->lock);
    free(all);
}
