/* `--set path=value`: refused without changing the scenario, or set, and what is written parses to the
 * same. */
#include "check.h"

#include "session/kinds.h"
#include "session/scenario.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static const char scenario[] = "{\"kind\":\"netgame\",\"game\":\"cannon\",\"duration_s\":1,\"players\":[{"
                               "\"lag_ms\":30},{\"name\":\"B\"}]}";

static void reads_back(const ll_param_table *table, const void *config, void *other)
{
    cJSON *json = ll_param_write(table, config);
    FUZZ_CHECK(json != NULL);
    char *text = cJSON_PrintUnformatted(json);
    cJSON *parsed = cJSON_Parse(text);
    ll_param_defaults(table, other);
    ll_status status = ll_param_parse(table, parsed, other);
    FUZZ_CHECK(!fuzz_failed(&status));
    char *second = fuzz_print(ll_param_write(table, other));
    FUZZ_CHECK(strcmp(text, second) == 0);
    cJSON_Delete(parsed);
    cJSON_Delete(json);
    cJSON_free(text);
    cJSON_free(second);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    ll_scenario s = {0};
    cJSON *json = cJSON_Parse(scenario);
    ll_status status = ll_scenario_parse(json, &s);
    FUZZ_CHECK(!fuzz_failed(&status));
    cJSON_Delete(json);
    const ll_param_table *table = s.kind->table;
    char *text = calloc(1, size + 1);
    void *before = malloc(table->size);
    FUZZ_CHECK(text != NULL && before != NULL);
    memcpy(text, data, size);
    char *equals = strchr(text, '=');
    if (equals != NULL) {
        *equals = '\0';
        for (int live = 1; live >= 0; live--) {
            memcpy(before, s.config, table->size);
            status = ll_param_set(table, s.config, text, equals + 1, live);
            if (fuzz_failed(&status))
                FUZZ_CHECK(memcmp(before, s.config, table->size) == 0);
            else
                reads_back(table, s.config, before);
        }
    }
    free(text);
    free(before);
    ll_scenario_free(&s);
    return 0;
}
