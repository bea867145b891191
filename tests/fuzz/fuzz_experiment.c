/* Any experiment: refused with a message, or its points are within its axes, its text gives the same
 * experiment, and its first run gives a row or a refusal. */
#include "check.h"

#include "experiment/spec/experiment.h"

#define SHORT_S 0.5 /* longer runs are not made */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void same_from_text(const ll_experiment *experiment)
{
    char *text = ll_experiment_text(experiment);
    cJSON *json;
    ll_experiment *again;
    FUZZ_CHECK(text != NULL && fuzz_is_text(text));
    ll_status status = ll_json_parse(text, strlen(text), &json);
    FUZZ_CHECK(!fuzz_failed(&status));
    status = ll_experiment_parse(json, "scenarios", NULL, &again);
    FUZZ_CHECK(!fuzz_failed(&status));
    FUZZ_CHECK(again->points == experiment->points && again->runs == experiment->runs);
    FUZZ_CHECK(ll_experiment_key(again) == ll_experiment_key(experiment));
    ll_experiment_free(again);
    cJSON_Delete(json);
    free(text);
}

static void look_at_points(const ll_experiment *experiment)
{
    const int64_t some[] = {0, experiment->points / 2, experiment->points - 1};
    for (size_t i = 0; i < sizeof some / sizeof some[0]; i++) {
        cJSON *point = ll_experiment_point(experiment, some[i]);
        FUZZ_CHECK(cJSON_IsObject(point));
        FUZZ_CHECK(cJSON_GetArraySize(point) <= experiment->axis_count);
        cJSON_Delete(point);
    }
}

static void run_one(const ll_experiment *experiment)
{
    ll_scenario scenario;
    ll_row row;
    ll_status status = ll_experiment_open(experiment, experiment->runs - 1, &scenario);
    if (fuzz_failed(&status))
        return;
    double duration_s = ((const ll_scenario_head *)scenario.config)->duration_s;
    ll_scenario_free(&scenario);
    if (!(duration_s <= SHORT_S))
        return;
    status = ll_experiment_run(experiment, experiment->runs - 1, NULL, NULL, &row);
    FUZZ_CHECK(!fuzz_failed(&status));
    FUZZ_CHECK(row.run == experiment->runs - 1 && fuzz_is_text(row.error));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    cJSON *json = NULL;
    ll_experiment *experiment = NULL;
    ll_status status = ll_json_parse((const char *)data, size, &json);
    if (fuzz_failed(&status))
        return 0;
    status = ll_experiment_parse(json, "scenarios", NULL, &experiment);
    FUZZ_CHECK(fuzz_failed(&status) == (experiment == NULL));
    if (experiment != NULL) {
        FUZZ_CHECK(experiment->points >= 1 && experiment->runs >= experiment->points);
        FUZZ_CHECK(experiment->runs <= LL_EXPERIMENT_RUNS_MAX);
        look_at_points(experiment);
        same_from_text(experiment);
        run_one(experiment);
    }
    ll_experiment_free(experiment);
    cJSON_Delete(json);
    return 0;
}
