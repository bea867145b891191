/* The REST API: what its handlers share. Each other file has the handlers of one subject; table.c has the
 * table of routes.
 *
 * Handlers run on threads of the web server. They find a session, read it under its lock and write a
 * response; they report errors only as problem documents. */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>

#include "daemon/class/classes.h"
#include "daemon/hosting/host.h"
#include "daemon/http/documents.h"
#include "daemon/http/http.h"
#include "daemon/jobs/jobs.h"
#include "daemon/jobs/measurements.h"
#include "daemon/listener/web_server.h"
#include "daemon/store/store.h"
#include "experiment/store/result_store.h"

struct cJSON;

typedef enum ll_api_phase { LL_API_STARTING, LL_API_READY, LL_API_DRAINING } ll_api_phase;

typedef struct ll_api_idempotency ll_api_idempotency;
typedef struct ll_experiments ll_experiments;

typedef struct ll_api {
    ll_host *host;
    ll_store *store;
    ll_experiments *experiments;
    struct ll_tasks *tasks;
    ll_classes *classes;                 /* set before the phase is LL_API_READY */
    ll_jobs *jobs;                       /* searches for advice */
    ll_measurements *measurements;       /* of speed against error */
    _Atomic(ll_web_server *) web_server; /* set when it is started */
    const char *scenarios;               /* folder */
    ll_documents documents;              /* constant ones */
    atomic_int phase;
    ll_time started;
    ll_http_route *routes; /* the table with the configured body limit */
    int route_count;
    ll_api_idempotency *idempotency;
    struct { /* answered requests, by class of status: 1xx .. 5xx; 0: any other */
        _Atomic uint64_t count[6], duration_us[6]; /* durations: sums */
    } answered;
} ll_api;

ll_status ll_api_init(ll_api *api, ll_host *host, ll_store *store, ll_experiments *experiments,
                      struct ll_tasks *tasks);
/* Makes all constant documents, those of the page in the folder `www` included. A folder that is not there is
 * logged, and its documents are missing. */
ll_status ll_api_describe(ll_api *api, const char *www);
void ll_api_end(ll_api *api);
void ll_api_done(void *context, const ll_http_request *request, const ll_http_route *route, int status,
                 double seconds);

/* ---- helpers of handlers ---- */

/* False when the daemon is not ready for sessions; a 503 was answered. */
bool ll_api_started(void *api, const ll_http_request *request, ll_http_response *response);

/* The session of the path's first parameter; NULL: a 404 or 503 was answered. */
ll_session_entry *ll_api_session(ll_api *api, const ll_http_request *request, ll_http_response *response);

/* Whether the request has the owner's key, or that of `player` (>= 0). Otherwise answers 401 or 403. */
bool ll_api_permits(const ll_http_request *request, ll_http_response *response,
                    const ll_session_entry *session_entry, int player);

/* The key of the request, if it has one; else NULL. */
const char *ll_api_find_key(const ll_http_request *request);
/* The key of the request; NULL: a 401 was answered that names the key needed, `whose`. */
const char *ll_api_key(const ll_http_request *request, ll_http_response *response, const char *whose);

/* Whether the request may create: any client, or only with the class key or the operator's. Otherwise answers
 * 401, 403 or 429. */
bool ll_api_may_create(ll_api *api, const ll_http_request *request, ll_http_response *response);
/* The class key of the request, whose quotas count in place of the address's; NULL: it has none, or one
 * without a name. */
struct ll_class_key *ll_api_class_key(const ll_api *api, const ll_http_request *request);
bool ll_api_is_operator(const ll_api *api, const char *key);
/* Whether the daemon's own figures may be answered: to who reaches the daemon itself, and through a proxy,
 * trusted or not, with the operator's key. Otherwise answers 404, or as the key deserves. It holds for each
 * spelling of the path. */
bool ll_api_admits_inside(ll_api *api, const ll_http_request *request, ll_http_response *response);

/* Whether the client, or the class key if that is not NULL, may create one more session, class, experiment or
 * job; a fork of `origin` (may be NULL) counts by its log. Otherwise answers 429. Called before the body is
 * parsed, so that a refused request counts too. */
bool ll_api_rate(ll_api *api, const ll_http_request *request, ll_http_response *response,
                 struct ll_class_key *class_key, const ll_session_entry *origin);
/* The same of a class's board, or of a copy of `origin`: these have rates of their own. */
bool ll_api_class_rate(ll_api *api, const ll_http_request *request, ll_http_response *response,
                       const ll_class_entry *entry, const ll_session_entry *origin);

/* A value of the query: true or false; absent: false. */
ll_status ll_api_query_flag(const ll_http_request *request, const char *name, bool *flag);

/* The body as a JSON object; NULL: a 400 was answered. Caller deletes. */
struct cJSON *ll_api_body(const ll_http_request *request, ll_http_response *response);
/* The same of one that may be left out: then an empty object. */
struct cJSON *ll_api_optional_body(const ll_http_request *request, ll_http_response *response);

/* Creates a session; false: the error was answered. The caller releases it. */
bool ll_api_make_session(ll_api *api, const ll_http_request *request, ll_http_response *response,
                         const ll_create_request *create, ll_created_session *created);
/* The same from a body as of POST /sessions; `base` has what it leaves open. */
bool ll_api_create_session(ll_api *api, const ll_http_request *request, ll_http_response *response,
                           const struct cJSON *body, const ll_create_request *base,
                           ll_created_session *created);

/* A problem document with the API's status: LL_IO is 507, LL_LIMIT 429 with Retry-After. On LL_INTERRUPTED a
 * handler that is not a task is called again as a task; the answer of a task says why it was stopped. */
void ll_api_problem(ll_http_response *response, const ll_http_request *request, const ll_status *error);
/* Whether it is none; else it was answered so. */
bool ll_api_good(ll_http_response *response, const ll_http_request *request, const ll_status *status);
/* Answers with the error, or with `json`, which it takes. */
void ll_api_result(ll_http_response *response, const ll_http_request *request, const ll_status *status,
                   struct cJSON *json);

/* 400 unless all keys of `object` are in the NULL-terminated list. */
ll_status ll_api_only(const struct cJSON *object, const char *const *names);

void ll_api_links(struct cJSON *json, const char *id); /* adds `links` */

/* ---- requests of experiments ---- */

/* The experiment of the path's first parameter. False: not found, and answered. `experiment` may be NULL. */
bool ll_api_experiment(ll_api *api, const ll_http_request *request, ll_http_response *response,
                       ll_experiment_record *record, ll_experiment **experiment);

/* Whether a run is small enough to be made for a request. */
ll_status ll_api_run_size(const ll_api *api, const ll_experiment *experiment, int64_t run);

/* ---- requests of what goes on after them ---- */

/* Answers 202 with `id`, `owner_key` and `links`; without a key, of what runs already, 200 with `id` and
 * `links`. `path` ends with a slash. */
void ll_api_begun(ll_http_response *response, const char *path, const char *id, const char *key);

/* ---- requests of classes ---- */

/* The class of the path's first parameter, a code or an id; NULL: the error was answered. */
ll_class_entry *ll_api_class(ll_api *api, const ll_http_request *request, ll_http_response *response);
/* The same if its teacher, or the operator, asks. */
ll_class_entry *ll_api_own_class(ll_api *api, const ll_http_request *request, ll_http_response *response);
/* For reading. NULL: the class has ended, and a 404 was answered. */
const ll_class *ll_api_lock_class(ll_class_entry *entry, const ll_http_request *request,
                                  ll_http_response *response);
/* For a change (ll_class_entry_begin). NULL: the error was answered. */
ll_class *ll_api_change_class(ll_class_entry *entry, const ll_http_request *request,
                              ll_http_response *response);
/* Its end (ll_class_entry_store). False: the error was answered, and nothing has changed. */
bool ll_api_store_class(ll_class_entry *entry, const ll_http_request *request, ll_http_response *response,
                        const ll_status *made);
void ll_api_delete_copy(ll_api *api, const char *id);                     /* a session; empty: none */
void ll_api_class_links(const ll_class_entry *entry, struct cJSON *json); /* adds `links` */

/* ---- handlers ---- */

ll_http_handler ll_get_document, ll_get_scenarios, ll_get_scenario, ll_get_schema;
ll_http_handler ll_post_sessions, ll_get_session, ll_delete_session, ll_post_fork, ll_get_code;
ll_http_handler ll_patch_params, ll_post_control, ll_post_input;
ll_http_handler ll_get_state, ll_get_hello, ll_get_frame, ll_get_metrics, ll_get_trace, ll_get_packets,
    ll_get_log;
ll_http_handler ll_post_experiments, ll_get_experiment, ll_delete_experiment, ll_post_experiment_control;
ll_http_handler ll_post_advise, ll_get_advice, ll_delete_advice, ll_get_experiment_run,
    ll_get_experiment_results, ll_get_experiment_report, ll_get_experiment_trace;
ll_http_handler ll_get_tradeoffs, ll_post_tradeoffs, ll_get_tradeoff, ll_delete_tradeoff;
ll_http_handler ll_get_sessions, ll_get_experiments, ll_get_creation, ll_put_creation, ll_get_class_keys;
ll_http_handler ll_post_classes, ll_get_class, ll_patch_class, ll_delete_class, ll_put_board;
ll_http_handler ll_get_members, ll_delete_members, ll_delete_seat;
ll_http_handler ll_post_members, ll_get_member, ll_patch_member, ll_delete_member, ll_put_vote;
ll_http_handler ll_get_healthz, ll_get_readyz, ll_get_prometheus;
