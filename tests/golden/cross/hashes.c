/* Lines of tests/golden/hashes.csv, made anew: `hashes ID...`. Its own main, as cmocka is not there for every
 * CPU. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include <cjson/cJSON.h>

#include "base/version.h"
#include "library/library.h"
#include "session/scenario.h"
#include "session/session.h"

const char ll_version[] = "cross";

static int print(const char *id)
{
    cJSON *json = NULL, *item;
    ll_session *s = NULL;
    ll_status status = ll_scenario_load("scenarios", id, &json);
    if (!ll_failed(&status))
        status = ll_session_create(json, -1, NULL, NULL, &s);
    if (!ll_failed(&status))
        status = ll_session_run_to(s, ll_session_get_info(s).end_tick);
    if (ll_failed(&status)) {
        fprintf(stderr, "%s: %s\n", id, status.text);
        return 1;
    }
    printf("%s,%" PRId64 ",%016" PRIx64, id, ll_session_get_info(s).tick, ll_session_hash(s));
    cJSON *report = ll_session_metrics(s);
    const cJSON *activity = cJSON_GetObjectItem(cJSON_GetObjectItem(report, "metrics"), "activity");
    char separator = ',';
    cJSON_ArrayForEach(item, activity)
    {
        printf("%c%s=%.17g", separator, cJSON_GetObjectItem(item, "metric")->valuestring,
               cJSON_GetObjectItem(item, "value")->valuedouble);
        separator = ';';
    }
    printf("\n");
    fflush(stdout);
    cJSON_Delete(report);
    ll_session_destroy(s);
    cJSON_Delete(json);
    return 0;
}

int main(int argc, char **argv)
{
    int failed = 0;
    for (int i = 1; i < argc; i++)
        failed += print(argv[i]);
    return failed > 0;
}
