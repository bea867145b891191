/* Speed against error of a family of methods, whose measurements belong to the daemon. Their answers have the
 * rows and choices of `laglab tradeoff`. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/api/api.h"
#include "experiment/advise/tradeoff.h"
#include "experiment/report/tradeoff_json.h"
#include "experiment/statistics/interval.h"
#include "param/param.h"

#define PATH "/api/v1/tradeoffs/"

enum { SEEDS_DEFAULT = 10, SEEDS_MOST = 100 };

#define DURATION_LEAST 0.05 /* s */
#define DURATION_MOST 1000.0

/* ---- what is asked for ---- */

static ll_status read_family(const cJSON *given, ll_measurement_order *m)
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

static ll_status read_seeds(const cJSON *body, ll_measurement_order *m)
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
    m->seeds = seeds ? (int)seeds->valuedouble : SEEDS_DEFAULT;
    m->check_seeds = check ? (int)check->valuedouble : m->seeds;
    return ll_ok();
}

static ll_status read_duration(const cJSON *given, ll_measurement_order *m)
{
    if (!given)
        return ll_ok();
    if (!(cJSON_IsNumber(given) && given->valuedouble >= DURATION_LEAST &&
          given->valuedouble <= DURATION_MOST))
        return ll_field_error(LL_BAD_INPUT, "duration_s", "duration_s: must be a number from %g to %g s.",
                              DURATION_LEAST, DURATION_MOST);
    ll_number_text(given->valuedouble, m->duration);
    return ll_ok();
}

static bool has_method(const ll_tradeoff_family *family, const char *name)
{
    const ll_tradeoff_request alone = {.methods = name};
    return *name && !strchr(name, ',') && ll_tradeoff_steps(family, &alone) > 0;
}

static ll_status read_methods(const cJSON *given, ll_measurement_order *m)
{
    const cJSON *name;
    int n = 0;
    if (cJSON_IsString(given) && strcmp(given->valuestring, "all") == 0)
        return ll_ok();
    if (!given) {
        snprintf(m->methods, sizeof m->methods, "%s", m->family->first);
        return ll_ok();
    }
    if (!cJSON_IsArray(given) || cJSON_GetArraySize(given) == 0)
        return ll_field_error(LL_BAD_INPUT, "methods", "methods: must be an array of names, or all.");
    cJSON_ArrayForEach(name, given)
    {
        char field[32];
        const char *text = cJSON_IsString(name) ? name->valuestring : "";
        size_t used = strlen(m->methods), length = strlen(text);
        snprintf(field, sizeof field, "methods.%d", n++);
        if (!has_method(m->family, text) || used + length + 2 > sizeof m->methods)
            return ll_field_error(LL_BAD_INPUT, field, "%s: must be a method of %s; got %.40s", field,
                                  m->family->name, *text ? text : "no name");
        if (used > 0)
            m->methods[used++] = ',';
        memcpy(m->methods + used, text, length + 1);
    }
    return ll_ok();
}

static ll_status read_order(const cJSON *body, ll_measurement_order *m)
{
    static const char *const names[] = {"family", "methods", "seeds", "check_seeds", "duration_s", NULL};
    LL_TRY(ll_api_only(body, names));
    LL_TRY(read_family(cJSON_GetObjectItemCaseSensitive(body, "family"), m));
    LL_TRY(read_seeds(body, m));
    LL_TRY(read_duration(cJSON_GetObjectItemCaseSensitive(body, "duration_s"), m));
    return read_methods(cJSON_GetObjectItemCaseSensitive(body, "methods"), m);
}

/* ---- handlers ---- */

static void add_results(const ll_api *api, cJSON *family)
{
    const char *name = cJSON_GetObjectItem(family, "name")->valuestring;
    char id[LL_ID_LENGTH + 1], shipped[80];
    cJSON *results = cJSON_AddObjectToObject(family, "results");
    snprintf(shipped, sizeof shipped, "tradeoffs/%s.json", name);
    if (ll_measurements_newest(api->measurements, ll_tradeoff_family_find(name), id))
        cJSON_AddStringToObject(results, "job", id);
    else
        cJSON_AddNullToObject(results, "job");
    cJSON_AddStringToObject(results, "shipped", shipped);
}

void ll_get_tradeoffs(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)request;
    cJSON *json = cJSON_CreateObject(), *families = ll_tradeoff_families_json(), *family;
    cJSON_ArrayForEach(family, families) add_results(context, family);
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
    if (!body)
        return;
    ll_measurement_order order = {0};
    char id[LL_ID_LENGTH + 1], key[LL_KEY_LENGTH + 1];
    ll_status status = read_order(body, &order);
    LL_THEN(status, ll_measurements_start(api->measurements, &order, id, key));
    if (ll_api_good(response, request, &status))
        ll_api_begun(response, PATH, id, key);
    cJSON_Delete(body);
}

void ll_get_tradeoff(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    if (!ll_api_started(api, request, response))
        return;
    cJSON *json = cJSON_CreateObject();
    ll_status status = ll_measurements_describe(api->measurements, request->parameter[0], json);
    ll_api_result(response, request, &status, json);
}

void ll_delete_tradeoff(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    if (!ll_api_started(api, request, response))
        return;
    const char *key = ll_api_key(request, response, "the measurement's owner_key");
    if (!key)
        return;
    ll_status status = ll_measurements_remove(api->measurements, request->parameter[0],
                                              ll_api_is_operator(api, key) ? NULL : key);
    if (ll_api_good(response, request, &status))
        response->status = 204;
}
