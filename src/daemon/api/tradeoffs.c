/* Speed against error of a family of methods. A measurement is a job, which requests start, poll and end; its
 * answer has the rows and choices of `laglab tradeoff`. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/api/api.h"
#include "experiment/advise/tradeoff.h"
#include "experiment/report/tradeoff_json.h"
#include "experiment/statistics/interval.h"
#include "param/param.h"
#include "threads/clock.h"

#define PATH "/api/v1/tradeoffs/"

enum { SEEDS_DEFAULT = 20, SEEDS_MOST = 100 };

#define DURATION_LEAST 0.05 /* s */
#define DURATION_MOST 1000.0

/* Owns what the job's request refers to. */
typedef struct measurement {
    const ll_tradeoff_family *family;
    ll_tradeoff_request request;
    char methods[1024], duration[32];
} measurement;

/* ---- what is asked for ---- */

static ll_status read_family(const cJSON *given, measurement *m)
{
    char known[300] = "";
    m->family = cJSON_IsString(given) ? ll_tradeoff_family_find(given->valuestring) : NULL;
    if (m->family)
        return ll_ok();
    for (const ll_tradeoff_family *f = ll_tradeoff_families; f->name; f++)
        snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", *known ? ", " : "", f->name);
    return ll_field_error(LL_BAD_INPUT, "family", "family: must be one of %s; got %.60s", known,
                          cJSON_IsString(given) ? given->valuestring
                          : given               ? "no text"
                                                : "nothing");
}

static bool is_seeds(double value)
{
    return value >= LL_INTERVAL_MIN && value <= SEEDS_MOST && value == floor(value);
}

static ll_status read_seeds(const cJSON *body, measurement *m)
{
    const cJSON *seeds = cJSON_GetObjectItemCaseSensitive(body, "seeds");
    const cJSON *check = cJSON_GetObjectItemCaseSensitive(body, "check_seeds");
    if (seeds && !(cJSON_IsNumber(seeds) && is_seeds(seeds->valuedouble)))
        return ll_field_error(LL_BAD_INPUT, "seeds", "seeds: must be a whole number from %d to %d.",
                              LL_INTERVAL_MIN, SEEDS_MOST);
    if (check && !(cJSON_IsNumber(check) && (check->valuedouble == 0 || is_seeds(check->valuedouble))))
        return ll_field_error(LL_BAD_INPUT, "check_seeds",
                              "check_seeds: must be 0, or a whole number from %d to %d.", LL_INTERVAL_MIN,
                              SEEDS_MOST);
    m->request.seeds = seeds ? (int)seeds->valuedouble : SEEDS_DEFAULT;
    m->request.check_seeds = check ? (int)check->valuedouble : m->request.seeds;
    return ll_ok();
}

static ll_status read_duration(const cJSON *given, measurement *m)
{
    if (!given)
        return ll_ok();
    if (!(cJSON_IsNumber(given) && given->valuedouble >= DURATION_LEAST &&
          given->valuedouble <= DURATION_MOST))
        return ll_field_error(LL_BAD_INPUT, "duration_s", "duration_s: must be a number from %g to %g s.",
                              DURATION_LEAST, DURATION_MOST);
    ll_number_text(given->valuedouble, m->duration);
    m->request.duration = m->duration;
    return ll_ok();
}

static ll_status read_methods(const cJSON *given, measurement *m)
{
    const cJSON *name;
    int n = 0;
    if (!given)
        return ll_ok();
    if (!cJSON_IsArray(given) || cJSON_GetArraySize(given) == 0)
        return ll_field_error(LL_BAD_INPUT, "methods", "methods: must be an array of names.");
    cJSON_ArrayForEach(name, given)
    {
        char field[32];
        const char *text = cJSON_IsString(name) ? name->valuestring : "";
        const ll_tradeoff_request alone = {.methods = text};
        size_t used = strlen(m->methods);
        snprintf(field, sizeof field, "methods.%d", n++);
        if (*text == '\0' || strchr(text, ',') || ll_tradeoff_steps(m->family, &alone) == 0 ||
            used + strlen(text) + 2 > sizeof m->methods)
            return ll_field_error(LL_BAD_INPUT, field, "%s: must be a method of %s; got %.40s", field,
                                  m->family->name, *text ? text : "no name");
        if (used > 0)
            m->methods[used++] = ',';
        memcpy(m->methods + used, text, strlen(text) + 1);
    }
    m->request.methods = m->methods;
    return ll_ok();
}

static ll_status read_request(const ll_api *api, const cJSON *body, measurement *m)
{
    static const char *const names[] = {"family", "methods", "seeds", "check_seeds", "duration_s", NULL};
    m->request.scenarios = api->scenarios;
    m->request.now_ns = ll_thread_cpu_ns;
    LL_TRY(ll_api_only(body, names));
    LL_TRY(read_family(cJSON_GetObjectItemCaseSensitive(body, "family"), m));
    LL_TRY(read_seeds(body, m));
    LL_TRY(read_duration(cJSON_GetObjectItemCaseSensitive(body, "duration_s"), m));
    return read_methods(cJSON_GetObjectItemCaseSensitive(body, "methods"), m);
}

/* ---- the job ---- */

/* As text, which takes a fraction of the memory of a tree: it is kept for minutes. */
static cJSON *as_text(cJSON *tree)
{
    char *text = cJSON_PrintUnformatted(tree);
    cJSON *raw = text ? cJSON_CreateRaw(text) : NULL;
    cJSON_free(text);
    cJSON_Delete(tree);
    return raw;
}

static ll_status answer(void *context, const ll_interrupt *interrupt, _Atomic int64_t *done, cJSON **json)
{
    measurement *m = context;
    ll_tradeoff tradeoff = {0};
    m->request.interrupt = interrupt;
    m->request.done = done;
    ll_status status = ll_tradeoff_run(m->family, &m->request, &tradeoff);
    if (!ll_failed(&status))
        *json = as_text(ll_tradeoff_json(&tradeoff));
    ll_tradeoff_free(&tradeoff);
    if (!ll_failed(&status) && !*json)
        return ll_error(LL_NO_MEMORY, "out of memory: answer");
    if (status.code == LL_INTERRUPTED)
        return ll_error(LL_INTERRUPTED, "interrupted after %lld settings", (long long)atomic_load(done));
    return status;
}

/* ---- handlers ---- */

void ll_get_tradeoffs(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context;
    (void)request;
    cJSON *json = cJSON_CreateObject(), *families = ll_tradeoff_families_json(), *family;
    cJSON_ArrayForEach(family, families)
    {
        char shipped[80];
        cJSON *results = cJSON_AddObjectToObject(family, "results");
        snprintf(shipped, sizeof shipped, "tradeoffs/%s.json",
                 cJSON_GetObjectItem(family, "name")->valuestring);
        cJSON_AddNullToObject(results, "job");
        cJSON_AddStringToObject(results, "shipped", shipped);
    }
    cJSON_AddItemToObject(json, "families", families);
    ll_http_json(response, 200, json);
}

void ll_post_tradeoffs(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    if (!ll_api_started(api, request, response) || !ll_api_may_create(api, request, response) ||
        !ll_api_rate(api, request, response, ll_api_class_key(api, request), NULL))
        return;
    cJSON *body = ll_api_body(request, response);
    measurement *m = body ? calloc(1, sizeof *m) : NULL;
    if (!m) {
        response->failed = body != NULL;
        cJSON_Delete(body);
        return;
    }
    ll_status status = read_request(api, body, m);
    if (ll_failed(&status)) {
        free(m);
        ll_api_problem(response, request, &status);
    } else {
        ll_job_spec spec = {.kind = LL_JOB_TRADEOFF,
                            .run = answer,
                            .free = free,
                            .context = m,
                            .most = ll_tradeoff_steps(m->family, &m->request)};
        ll_api_job_start(api, request, response, &spec, PATH);
    }
    cJSON_Delete(body);
}

void ll_get_tradeoff(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api_job_get(context, request, response, LL_JOB_TRADEOFF);
}

void ll_delete_tradeoff(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api_job_delete(context, request, response, LL_JOB_TRADEOFF, "the measurement's owner_key");
}
