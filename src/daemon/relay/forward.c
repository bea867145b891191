/* REST requests are passed on to the owner, with the client's key and address, and its answers back.
 *
 * What pages read when they are opened, GETs without a key, is kept for a moment: many viewers ask for the
 * same at once, and the owner answers once. What is kept is dropped when parameters of a session change or
 * anything else than a GET was passed on, so that no client reads what was before its own change. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <curl/curl.h>

#include "daemon/http/http_problem.h"
#include "daemon/relay/internal.h"
#include "daemon/support/tasks.h"

enum {
    KEPT = 64,            /* answers */
    KEPT_BYTES = 1 << 20, /* of one */
    KEY = 300,            /* bytes of a request's target and Accept */
    IDLE = 16,            /* handles that keep a connection */
    HOPS_MOST = 3,        /* relays in a chain; more are a circle, whose requests wait for each other */
    READ_MS = 10000,      /* for an answer that others wait for */
    ANSWER_MS = 600000,
};

/* Passed on from the client, and back from the owner. */
static const char *const request_headers[] = {
    "Authorization", "Content-Type",    "Accept", "Accept-Language",   "If-None-Match",
    "If-Match",      "Idempotency-Key", "Prefer", "X-Forwarded-Proto", "X-Forwarded-Host"};
static const char *const response_headers[] = {"Cache-Control",
                                               "ETag",
                                               "Location",
                                               "Link",
                                               "Retry-After",
                                               "Allow",
                                               "Vary",
                                               "WWW-Authenticate",
                                               "Content-Disposition",
                                               "Content-Language",
                                               "Accept-Patch"};

/* GETs whose answers are kept: what pages read when they are opened. */
static const char *const kept_paths[] = {"/api/v1/scenarios",          "/api/v1/schema",
                                         "/api/v1/stream/schema.json", "/api/v1/metrics",
                                         "/api/v1/creation",           "/api/v1/sessions/"};

typedef struct kept_answer {
    char key[KEY];    /* empty: none */
    bool fetching;    /* by another request: wait */
    uint64_t fetches; /* that have ended */
    int64_t until_ns;
    uint64_t epoch;
    ll_http_response answer; /* bytes are owned */
} kept_answer;

struct ll_forward {
    const ll_relay_config *config;
    ll_owner *owner;
    relay_streams *streams;

    pthread_mutex_t lock;
    pthread_cond_t fetched;
    kept_answer kept[KEPT];
    int turn; /* the next to be replaced */
    CURL *idle[IDLE];
    int idle_count;
    atomic_ullong requests, from_kept, failed;
};

ll_forward *ll_forward_new(const ll_relay_config *config, ll_owner *owner, relay_streams *streams)
{
    ll_forward *f = calloc(1, sizeof *f);
    if (f == NULL)
        return NULL;
    f->config = config;
    f->owner = owner;
    f->streams = streams;
    pthread_mutex_init(&f->lock, NULL);
    pthread_cond_init(&f->fetched, NULL);
    return f;
}

void ll_forward_free(ll_forward *f)
{
    if (f == NULL)
        return;
    for (int i = 0; i < KEPT; i++)
        ll_http_clear(&f->kept[i].answer);
    for (int i = 0; i < f->idle_count; i++)
        curl_easy_cleanup(f->idle[i]);
    pthread_mutex_destroy(&f->lock);
    pthread_cond_destroy(&f->fetched);
    free(f);
}

ll_forward_stats ll_forward_get_stats(ll_forward *f)
{
    return (ll_forward_stats){.requests = atomic_load(&f->requests),
                              .kept = atomic_load(&f->from_kept),
                              .failed = atomic_load(&f->failed)};
}

/* ---- one request to the owner ---- */

static CURL *take_handle(ll_forward *f)
{
    pthread_mutex_lock(&f->lock);
    CURL *curl = f->idle_count > 0 ? f->idle[--f->idle_count] : NULL;
    pthread_mutex_unlock(&f->lock);
    return curl != NULL ? curl : ll_owner_request(f->owner);
}

static void give_handle(ll_forward *f, CURL *curl)
{
    pthread_mutex_lock(&f->lock);
    bool kept = f->idle_count < IDLE;
    if (kept)
        f->idle[f->idle_count++] = curl;
    pthread_mutex_unlock(&f->lock);
    if (!kept)
        curl_easy_cleanup(curl);
}

typedef struct transfer {
    ll_forward *forward;
    const ll_http_request *request;
    ll_http_response *response;
    bool for_all; /* the answer is kept for others */
    bool too_large;
} transfer;

static size_t on_body(char *bytes, size_t one, size_t size, void *context)
{
    transfer *t = context;
    size_t most = (size_t)t->forward->config->max_answer_mib << 20;
    t->too_large = t->response->size + size > most;
    if (!t->too_large)
        ll_http_append(t->response, bytes, size);
    return t->too_large || t->response->failed ? 0 : one * size;
}

static void copy_header(ll_http_response *response, const char *name, const char *value, size_t size)
{
    char text[sizeof response->header[0].value];
    if (size < sizeof text && response->headers < LL_HTTP_HEADERS) {
        memcpy(text, value, size);
        text[size] = '\0';
        ll_http_set_header(response, name, text);
    }
}

static size_t on_header(char *line, size_t one, size_t size, void *context)
{
    transfer *t = context;
    const char *colon = memchr(line, ':', size);
    if (size > 5 && memcmp(line, "HTTP/", 5) == 0) { /* of a 100 there is another head before */
        t->response->headers = 0;
        t->response->type[0] = '\0';
    }
    if (colon == NULL)
        return one * size;
    size_t name = (size_t)(colon - line);
    const char *value = colon + 1, *end = line + size;
    while (value < end && (*value == ' ' || *value == '\t'))
        value++;
    while (end > value && (end[-1] == '\r' || end[-1] == '\n' || end[-1] == ' '))
        end--;
    size_t length = (size_t)(end - value);
    if (name == 12 && strncasecmp(line, "Content-Type", name) == 0)
        snprintf(t->response->type, sizeof t->response->type, "%.*s", (int)(length < 63 ? length : 63),
                 value);
    for (size_t i = 0; i < sizeof response_headers / sizeof response_headers[0]; i++)
        if (strlen(response_headers[i]) == name && strncasecmp(line, response_headers[i], name) == 0)
            copy_header(t->response, response_headers[i], value, length);
    return one * size;
}

static int on_progress(void *context, curl_off_t a, curl_off_t b, curl_off_t c, curl_off_t d)
{
    (void)a, (void)b, (void)c, (void)d;
    const transfer *t = context;
    struct ll_task *task = t->request->task;
    return atomic_load(&t->forward->owner->stopping) ||
           (task != NULL && ll_task_end_reason(task) != LL_TASK_RUNNING);
}

static struct curl_slist *add_header(struct curl_slist *list, const char *name, const char *value)
{
    char line[1100];
    int size = value != NULL && value[0] != '\0' ? snprintf(line, sizeof line, "%s: %s", name, value) : 0;
    struct curl_slist *grown = size > 0 && (size_t)size < sizeof line ? curl_slist_append(list, line) : NULL;
    return grown != NULL ? grown : list;
}

static int hops_of(const ll_http_request *request)
{
    const char *text = ll_http_header(request, "X-Laglab-Hops");
    long hops = text != NULL ? strtol(text, NULL, 10) : 0;
    return hops >= 0 && hops < HOPS_MOST ? (int)hops : HOPS_MOST; /* a client can send any number */
}

static struct curl_slist *headers_of(const ll_http_request *request, bool for_all)
{
    char hops[16];
    struct curl_slist *list = NULL;
    snprintf(hops, sizeof hops, "%d", hops_of(request) + 1);
    for (size_t i = 0; i < sizeof request_headers / sizeof request_headers[0]; i++) {
        bool forwarded = strncmp(request_headers[i], "X-", 2) == 0;       /* true only of a trusted proxy */
        bool own = for_all && strncmp(request_headers[i], "If-", 3) == 0; /* a 304 is for one client */
        if (!own && (!forwarded || request->proxied))
            list = add_header(list, request_headers[i], ll_http_header(request, request_headers[i]));
    }
    list = add_header(list, "X-Forwarded-For", request->peer);
    list = add_header(list, "X-Request-Id", request->id);
    list = add_header(list, "X-Laglab-Hops", hops);
    struct curl_slist *grown = curl_slist_append(list, "Expect:"); /* none */
    return grown != NULL ? grown : list;
}

static CURLcode perform(CURL *curl, transfer *t, const char *url, long limit_ms)
{
    const ll_http_request *request = t->request;
    bool get = strcmp(request->method, "GET") == 0;
    struct curl_slist *headers = headers_of(request, t->for_all);
    curl_easy_setopt(curl, CURLOPT_URL, url);
    curl_easy_setopt(curl, CURLOPT_PATH_AS_IS, 1L);
    curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers);
    curl_easy_setopt(curl, CURLOPT_TIMEOUT_MS, limit_ms);
    curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, on_body);
    curl_easy_setopt(curl, CURLOPT_WRITEDATA, t);
    curl_easy_setopt(curl, CURLOPT_HEADERFUNCTION, on_header);
    curl_easy_setopt(curl, CURLOPT_HEADERDATA, t);
    curl_easy_setopt(curl, CURLOPT_XFERINFOFUNCTION, on_progress);
    curl_easy_setopt(curl, CURLOPT_XFERINFODATA, t);
    if (get || (strcmp(request->method, "DELETE") == 0 && request->body_size == 0)) {
        curl_easy_setopt(curl, CURLOPT_HTTPGET, 1L);
    } else {
        curl_easy_setopt(curl, CURLOPT_POST, 1L);
        curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE_LARGE, (curl_off_t)request->body_size);
        curl_easy_setopt(curl, CURLOPT_POSTFIELDS, request->body);
    }
    curl_easy_setopt(curl, CURLOPT_CUSTOMREQUEST, get ? NULL : request->method);
    CURLcode code = curl_easy_perform(curl);
    curl_easy_setopt(curl, CURLOPT_HTTPHEADER, NULL);
    curl_slist_free_all(headers);
    return code;
}

static void refuse(ll_http_response *response, const ll_http_request *request, int status, const char *format,
                   const char *owner, const char *why)
{
    ll_status error = ll_error(LL_UNAVAILABLE, format, owner, why);
    ll_http_clear(response);
    if (status == 503)
        ll_http_problem_later(response, request, status, 1, &error);
    else
        ll_http_problem_as(response, request, status, &error);
    ll_http_set_header(response, "Cache-Control", "no-store");
}

static void fetch(ll_forward *f, const ll_http_request *request, ll_http_response *response, bool for_all,
                  long limit_ms)
{
    char url[8192];
    long status = 0;
    transfer t = {.forward = f, .request = request, .response = response, .for_all = for_all};
    const char *owner = f->owner->url;
    int size = snprintf(url, sizeof url, "%s%s", owner, request->target);
    CURL *curl = (size_t)size < sizeof url && request->target[0] == '/' ? take_handle(f) : NULL;
    if (curl == NULL) {
        refuse(response, request, 503, "The owner, %.100s, cannot be asked: %.60s.", owner,
               "no memory, or a target too long");
        return;
    }
    CURLcode code = perform(curl, &t, url, limit_ms);
    curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &status);
    give_handle(f, curl);
    if (code == CURLE_OK && status >= 200) {
        response->status = (int)status;
        return;
    }
    atomic_fetch_add(&f->failed, 1);
    if (t.too_large)
        refuse(response, request, 502, "The answer of the owner, %.100s, is too large to be passed on%s.",
               owner, " (max_answer_mib); ask the owner itself");
    else
        refuse(response, request, 503, "The owner, %.100s, does not answer: %.100s.", owner,
               curl_easy_strerror(code));
}

/* ---- answers that are kept ---- */

static bool is_kept_path(const char *path)
{
    for (size_t i = 0; i < sizeof kept_paths / sizeof kept_paths[0]; i++) {
        size_t size = strlen(kept_paths[i]);
        bool folder = kept_paths[i][size - 1] == '/';
        if (strncmp(path, kept_paths[i], size) != 0)
            continue;
        if (folder ? strchr(path + size, '/') == NULL : path[size] == '\0' || path[size] == '/')
            return true;
    }
    return false;
}

/* False: an answer to this request is for its client alone, or has to be the latest. */
static bool key_of(const ll_http_request *request, char key[KEY])
{
    const char *accept = ll_http_header(request, "Accept"),
               *language = ll_http_header(request, "Accept-Language");
    if (strcmp(request->method, "GET") != 0 || request->body_size > 0 || !is_kept_path(request->path) ||
        ll_http_header(request, "Authorization") != NULL)
        return false;
    int size = snprintf(key, KEY, "%s %s %s", request->target, accept != NULL ? accept : "",
                        language != NULL ? language : "");
    return size > 0 && size < KEY;
}

static void copy_answer(const ll_http_response *from, ll_http_response *to)
{
    ll_http_clear(to);
    ll_http_append(to, from->bytes, from->size);
    to->status = from->status;
    memcpy(to->type, from->type, sizeof to->type);
    memcpy(to->header, from->header, sizeof to->header);
    to->headers = from->headers;
}

static const char *header_of(const ll_http_response *response, const char *name)
{
    for (int i = 0; i < response->headers; i++)
        if (strcasecmp(response->header[i].name, name) == 0)
            return response->header[i].value;
    return NULL;
}

/* The answer to a client that may have it already. */
static void give_answer(const ll_http_response *kept, const ll_http_request *request,
                        ll_http_response *response)
{
    const char *has = ll_http_header(request, "If-None-Match"), *tag = header_of(kept, "ETag");
    if (kept->status == 200 && has != NULL && tag != NULL && ll_http_matches_tag(has, tag)) {
        response->status = 304;
        ll_http_set_header(response, "ETag", tag);
    } else {
        copy_answer(kept, response);
    }
}

static bool is_valid(const ll_forward *f, const kept_answer *kept)
{
    return kept->until_ns > ll_relay_now() && kept->epoch == atomic_load(&f->streams->epoch);
}

/* The place of the key, or one for it; with the lock held. NULL: all are being fetched. */
static kept_answer *place_of(ll_forward *f, const char *key)
{
    for (int i = 0; i < KEPT; i++)
        if (strcmp(f->kept[i].key, key) == 0)
            return &f->kept[i];
    for (int i = 0; i < KEPT; i++) {
        kept_answer *place = &f->kept[f->turn];
        f->turn = (f->turn + 1) % KEPT;
        if (place->fetching)
            continue;
        ll_http_clear(&place->answer);
        place->until_ns = 0;
        snprintf(place->key, sizeof place->key, "%s", key);
        return place;
    }
    return NULL;
}

/* Fetches an answer that others wait for. */
static void fetch_for_all(ll_forward *f, kept_answer *place, const ll_http_request *request,
                          ll_http_response *response)
{
    uint64_t epoch = atomic_load(&f->streams->epoch);
    ll_http_response answer = {.status = 200};
    pthread_mutex_unlock(&f->lock);
    fetch(f, request, &answer, true, READ_MS);
    pthread_mutex_lock(&f->lock);
    bool keeps = !answer.failed && answer.size <= KEPT_BYTES && answer.status != 304;
    place->fetching = false;
    place->fetches++;
    ll_http_clear(&place->answer);
    place->until_ns = 0;
    if (keeps) {
        copy_answer(&answer, &place->answer);
        place->epoch = epoch;
        place->until_ns = ll_relay_now() + (int64_t)(f->config->cache_s * 1e9);
    }
    if (place->answer.failed)
        place->until_ns = 0;
    pthread_cond_broadcast(&f->fetched);
    ll_http_clear(response);
    *response = answer;
}

static void answer_kept(ll_forward *f, const char *key, const ll_http_request *request,
                        ll_http_response *response)
{
    bool waited = false;
    pthread_mutex_lock(&f->lock);
    kept_answer *place = place_of(f, key);
    uint64_t fetches = place != NULL ? place->fetches : 0;
    for (; place != NULL && place->fetching && place->fetches == fetches; waited = true)
        pthread_cond_wait(&f->fetched, &f->lock);
    /* It was replaced meanwhile, or the answer cannot be kept, or another one fetches it again: all who have
     * waited ask the owner at once, and no request waits twice. */
    if (place != NULL &&
        (strcmp(place->key, key) != 0 || (waited && (place->fetching || place->until_ns == 0))))
        place = NULL;
    if (place != NULL && is_valid(f, place)) {
        atomic_fetch_add(&f->from_kept, 1);
        give_answer(&place->answer, request, response);
    } else if (place != NULL) {
        place->fetching = true;
        fetch_for_all(f, place, request, response);
    }
    pthread_mutex_unlock(&f->lock);
    if (place == NULL)
        fetch(f, request, response, false, READ_MS);
}

void ll_forward_request(ll_forward *f, const ll_http_request *request, ll_http_response *response)
{
    char key[KEY];
    if (hops_of(request) >= HOPS_MOST) {
        refuse(response, request, 508, "Too many relays; is %.100s one of itself?%s", f->owner->url, "");
        return;
    }
    if (f->config->cache_s > 0 && key_of(request, key)) {
        atomic_fetch_add(&f->requests, 1);
        answer_kept(f, key, request, response);
        return;
    }
    /* Others may take as long as the owner needs. */
    if (request->task == NULL && ll_http_become_task(request, response))
        return;
    atomic_fetch_add(&f->requests, 1);
    fetch(f, request, response, false, ANSWER_MS);
    if (strcmp(request->method, "GET") != 0)
        atomic_fetch_add(&f->streams->epoch, 1);
}
