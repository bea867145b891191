/* `--set path=value`: refused without changing the scenario, or set, and what is written parses to the
 * same. The scenario is parsed once, and what left it as it was is not written. */
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

static ll_scenario first;

static void start(void)
{
    cJSON *json = cJSON_Parse(scenario);
    ll_status status = ll_scenario_parse(json, &first);
    FUZZ_CHECK(!fuzz_failed(&status));
    cJSON_Delete(json);
    const ll_param_table *table = first.kind->table;
    void *other = malloc(table->size);
    FUZZ_CHECK(other != NULL);
    reads_back(table, first.config, other);
    free(other);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (first.config == NULL)
        start();
    const char *sign = size > 0 ? memchr(data, '=', size) : NULL;
    if (sign == NULL || memchr(data, 0, (size_t)(sign - (const char *)data)) != NULL)
        return 0;
    const ll_param_table *table = first.kind->table;
    char *text = calloc(1, size + 1);
    void *config = malloc(table->size), *before = malloc(table->size);
    FUZZ_CHECK(text != NULL && config != NULL && before != NULL);
    memcpy(config, first.config, table->size);
    memcpy(text, data, size);
    char *equals = strchr(text, '=');
    *equals = '\0';
    for (int live = 1; live >= 0; live--) {
        memcpy(before, config, table->size);
        ll_status status = ll_param_set(table, config, text, equals + 1, live);
        bool same = memcmp(before, config, table->size) == 0;
        if (fuzz_failed(&status))
            FUZZ_CHECK(same);
        else if (!same)
            reads_back(table, config, before);
    }
    free(text);
    free(config);
    free(before);
    return 0;
}
