/* Any scenario: refused with a message, or it runs. Its written parameters parse to the same. */
#include "check.h"

#include "session/scenario.h"
#include "session/session.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void read_back(ll_session *session)
{
    char *text = fuzz_print(ll_session_params(session));
    cJSON *json;
    ll_scenario again = {0};
    ll_status status = ll_json_parse(text, strlen(text), &json);
    FUZZ_CHECK(!fuzz_failed(&status));
    status = ll_scenario_parse(json, &again);
    FUZZ_CHECK(!fuzz_failed(&status));
    char *second = fuzz_print(ll_param_write(again.kind->table, again.config));
    FUZZ_CHECK(strcmp(text, second) == 0);
    ll_scenario_free(&again);
    cJSON_Delete(json);
    cJSON_free(text);
    cJSON_free(second);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    cJSON *json = NULL;
    ll_session *session = NULL;
    ll_status status = ll_json_parse((const char *)data, size, &json);
    FUZZ_CHECK(fuzz_failed(&status) == (json == NULL));
    if (json == NULL)
        return 0;
    status = ll_session_create(json, -1, NULL, NULL, &session);
    FUZZ_CHECK(fuzz_failed(&status) == (session == NULL));
    if (session != NULL) {
        int64_t end = ll_session_get_info(session).end_tick;
        status = ll_session_run_to(session, end < 30 ? end : 30);
        FUZZ_CHECK(!fuzz_failed(&status) || status.code == LL_DIVERGED);
        read_back(session);
        cJSON_free(fuzz_print(ll_session_metrics(session)));
        cJSON_free(fuzz_print(ll_session_state(session)));
        ll_session_destroy(session);
    }
    cJSON_Delete(json);
    return 0;
}
