#include "daemon/jobs/progress_stream.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cjson/cJSON.h>

#include "daemon/hosting/host.h"
#include "daemon/stream/requests.h"
#include "daemon/support/log.h"
#include "threads/clock.h"

#define LOOK_EVERY_NS 250000000L
#define TIDY_EVERY_NS LL_SECOND
/* While it runs, also when no run has ended: the rate falls and the remaining time grows. */
#define SEND_EVERY_NS (1000 * LL_MS)

typedef struct viewer {
    struct viewer *next;
    ll_ws_viewer id;
    bool hello_sent;
} viewer;

/* An experiment with a stream. The list's lock guards its viewers; only the thread removes it from the
 * list. */
typedef struct watched {
    struct watched *next;
    char id[LL_EXPERIMENT_ID_MAX + 1];
    ll_ws_stream *stream;
    viewer *viewers;
    bool removed;
    int64_t done; /* as last sent */
    ll_experiment_state state;
    ll_time sent_at;
} watched;

struct ll_progress {
    ll_progress_source source;
    ll_ws *ws;
    pthread_t thread;
    pthread_mutex_t lock; /* guards all members below */
    pthread_cond_t wake;
    watched *first;
    int viewers;
    bool stopping, news; /* news: a viewer came, or an experiment was deleted */
};

/* ---- sending; the list is locked ---- */

static void send_progress(ll_progress *p, const watched *w, viewer *v, const ll_experiment_record *record)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "type", v->hello_sent ? "progress" : "hello");
    if (!v->hello_sent)
        cJSON_AddStringToObject(json, "experiment", w->id);
    p->source.describe(p->source.experiments, record, json);
    char *text = cJSON_PrintUnformatted(json);
    cJSON_Delete(json);
    if (text)
        (v->hello_sent ? ll_ws_send : ll_ws_hello)(p->ws, v->id, text, strlen(text));
    v->hello_sent = v->hello_sent || text;
    free(text);
    if (record->state >= LL_EXPERIMENT_CANCELLED)
        ll_ws_close(p->ws, v->id, LL_WS_NORMAL, "the experiment has ended");
}

static void send_progress_to_all(ll_progress *p, watched *w, const ll_experiment_record *record)
{
    ll_time now = ll_now_ns();
    bool late = record->state == LL_EXPERIMENT_RUNNING && now - w->sent_at >= SEND_EVERY_NS;
    bool changed = late || record->done != w->done || record->state != w->state;
    for (viewer *v = w->viewers; v; v = v->next)
        if (changed || !v->hello_sent)
            send_progress(p, w, v, record);
    w->done = record->done;
    w->state = record->state;
    w->sent_at = changed ? now : w->sent_at;
}

/* ---- the thread ---- */

/* Reads the store without the lock, since the store may be on another machine. */
static void poll_experiment(ll_progress *p, watched *w)
{
    ll_experiment_record record;
    pthread_mutex_unlock(&p->lock);
    ll_status status = p->source.find(p->source.experiments, w->id, &record);
    pthread_mutex_lock(&p->lock);
    if (!ll_failed(&status))
        send_progress_to_all(p, w, &record);
    else if (status.code == LL_NOT_FOUND)
        w->removed = true;
}

static void close_removed(ll_progress *p)
{
    for (watched **link = &p->first; *link;) {
        watched *w = *link;
        if (!w->removed) {
            link = &w->next;
            continue;
        }
        *link = w->next;
        pthread_mutex_unlock(&p->lock); /* the hooks may run at once */
        ll_ws_stream_close(w->stream, LL_WS_NO_SESSION, "the experiment was deleted");
        pthread_mutex_lock(&p->lock);
        link = &p->first;
    }
}

static void wait_for_news(ll_progress *p)
{
    struct timespec until = ll_deadline(CLOCK_MONOTONIC, LOOK_EVERY_NS + (p->viewers == 0 ? LL_SECOND : 0));
    while (!p->stopping && !p->news)
        if (pthread_cond_timedwait(&p->wake, &p->lock, &until) != 0)
            break;
    p->news = false;
}

static void *watch(void *context)
{
    ll_progress *p = context;
    pthread_setname_np(pthread_self(), "progress");
    ll_time tidied = 0;
    pthread_mutex_lock(&p->lock);
    while (!p->stopping) {
        for (watched *w = p->first; w; w = w->next)
            if (w->viewers && !w->removed)
                poll_experiment(p, w);
        close_removed(p);
        wait_for_news(p);
        if (p->stopping || ll_now_ns() - tidied < TIDY_EVERY_NS)
            continue;
        pthread_mutex_unlock(&p->lock); /* removes deleted ones from the list */
        p->source.tidy(p->source.experiments);
        pthread_mutex_lock(&p->lock);
        tidied = ll_now_ns();
    }
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

/* ---- hooks, on the stream's thread ---- */

static void on_opened(void *context, void *session, ll_ws_viewer id, ll_frame_format format)
{
    (void)format;
    ll_progress *p = context;
    watched *w = session;
    viewer *v = calloc(1, sizeof *v);
    if (!v) {
        ll_ws_close(p->ws, id, LL_WS_TRY_LATER, "no memory");
        return;
    }
    v->id = id;
    pthread_mutex_lock(&p->lock);
    v->next = w->viewers;
    w->viewers = v;
    p->viewers++;
    p->news = true;
    pthread_cond_signal(&p->wake);
    pthread_mutex_unlock(&p->lock);
}

static void on_message(void *context, void *session, ll_ws_viewer id, const char *text, size_t length)
{
    (void)session, (void)text, (void)length;
    ll_progress *p = context;
    ll_status error = ll_error(
        LL_BAD_INPUT,
        "This stream is read-only. POST to an experiment's `control` pauses, resumes or cancels it.");
    ll_request_refuse(p->ws, id, "", 400, &error);
}

static void on_closed(void *context, void *session, ll_ws_viewer id)
{
    ll_progress *p = context;
    watched *w = session;
    viewer *gone = NULL;
    pthread_mutex_lock(&p->lock);
    viewer **link = &w->viewers;
    while (*link && (*link)->id != id)
        link = &(*link)->next;
    if (*link) {
        gone = *link;
        *link = gone->next;
        p->viewers--;
    }
    pthread_mutex_unlock(&p->lock);
    free(gone);
}

static void free_watched(watched *w)
{
    while (w->viewers) {
        viewer *v = w->viewers;
        w->viewers = v->next;
        free(v);
    }
    free(w);
}

static void on_released(void *context, void *session)
{
    (void)context;
    free_watched(session);
}

/* ---- list of experiments ---- */

static watched *find(const ll_progress *p, const char *id)
{
    watched *w = p->first;
    while (w && (w->removed || strcmp(w->id, id) != 0))
        w = w->next;
    return w;
}

void ll_progress_add(ll_progress *p, const char *id)
{
    pthread_mutex_lock(&p->lock);
    watched *w = p->stopping || find(p, id) ? NULL : calloc(1, sizeof *w);
    if (w) {
        *w = (watched){.next = p->first, .done = -1};
        snprintf(w->id, sizeof w->id, "%s", id);
        ll_status status = ll_ws_stream_open(p->ws, LL_STREAM_EXPERIMENT, id, w, &w->stream);
        if (ll_failed(&status)) /* GET still reports the progress */
            free(w);
        else
            p->first = w;
    }
    pthread_mutex_unlock(&p->lock);
}

void ll_progress_remove(ll_progress *p, const char *id)
{
    pthread_mutex_lock(&p->lock);
    watched *w = find(p, id);
    if (w) {
        w->removed = p->news = true;
        pthread_cond_signal(&p->wake);
    }
    pthread_mutex_unlock(&p->lock);
}

/* ---- start and stop ---- */

ll_status ll_progress_start(const ll_progress_source *source, ll_ws *ws, ll_progress **progress)
{
    ll_progress *p = *progress = calloc(1, sizeof *p);
    if (!p)
        return ll_error(LL_NO_MEMORY, "out of memory: streams of experiments");
    p->source = *source;
    p->ws = ws;
    pthread_mutex_init(&p->lock, NULL);
    ll_cond_init(&p->wake);
    ll_ws_hooks hooks = {.context = p,
                         .opened = on_opened,
                         .message = on_message,
                         .closed = on_closed,
                         .released = on_released};
    ll_ws_set_hooks(ws, LL_STREAM_EXPERIMENT, &hooks);
    if (pthread_create(&p->thread, NULL, watch, p) == 0)
        return ll_ok();
    p->stopping = true;
    ll_progress_free(p);
    *progress = NULL;
    return ll_error(LL_NO_MEMORY, "cannot start thread of the experiments' streams");
}

void ll_progress_stop(ll_progress *p)
{
    pthread_mutex_lock(&p->lock);
    bool stopped = p->stopping;
    p->stopping = true;
    pthread_cond_signal(&p->wake);
    pthread_mutex_unlock(&p->lock);
    if (!stopped)
        pthread_join(p->thread, NULL);
}

void ll_progress_free(ll_progress *p)
{
    if (!p)
        return;
    while (p->first) {
        watched *w = p->first;
        p->first = w->next;
        free_watched(w);
    }
    pthread_cond_destroy(&p->wake);
    pthread_mutex_destroy(&p->lock);
    free(p);
}
