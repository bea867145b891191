/* Changes of parameters: of the log, and of the timeline, which the scenario schedules. Its steps act before
 * the commands of the same tick, and a command that drops all later commands does not drop them. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/vtime.h"
#include "session/internal.h"

ll_status ll_change_values(const ll_sim_kind *kind, void *config, const cJSON *patch, ll_param_change *change,
                           void *context)
{
    void *before = ll_param_clone(kind->table, config, NULL);
    if (!before)
        return ll_error(LL_NO_MEMORY, "out of memory: change");
    ll_status status =
        ll_param_patch(kind->table, patch, config, change, context); /* all at once: rules may relate them */
    if (!ll_failed(&status) && kind->may_change) {
        status = kind->may_change(config, before);
        if (ll_failed(&status))
            ll_param_copy(kind->table, config, before);
    }
    if (!ll_failed(&status))
        kind->settle(config, before);
    free(before);
    return status;
}

ll_status ll_apply_values(const ll_sim_kind *kind, void *config, const char *values)
{
    cJSON *json = cJSON_Parse(values);
    if (!json)
        return ll_error(LL_NO_MEMORY, "out of memory: change");
    ll_status status = ll_change_values(kind, config, json, NULL, NULL);
    cJSON_Delete(json);
    return status;
}

/* ---- timeline ---- */

int64_t ll_timeline_tick(const ll_scenario_head *head, int32_t step, ll_freq freq)
{
    if (step >= head->timeline_count)
        return INT64_MAX;
    ll_time at = (ll_time)llround(head->timeline[step].at_s * 1e9);
    int64_t tick = ll_tick_at(at, freq);
    return ll_tick_time(tick, freq) < at ? tick + 1 : tick; /* not before its time */
}

static ll_status in_step(const ll_status *status, int step)
{
    char field[48];
    snprintf(field, sizeof field, "timeline.%d.set", step);
    ll_code code = status->code == LL_CONFLICT ? LL_BAD_INPUT : status->code; /* a row that is not live */
    return ll_field_error(code, field, "%s: %s", field, status->text);
}

ll_status ll_timeline_check(const ll_sim_kind *kind, const void *config)
{
    const ll_scenario_head *head = config;
    ll_status status = ll_ok();
    void *probe = head->timeline_count > 0 ? ll_param_clone(kind->table, config, NULL) : NULL;
    if (head->timeline_count > 0 && !probe)
        return ll_error(LL_NO_MEMORY, "out of memory: scenario");
    for (int i = 0; i < head->timeline_count && !ll_failed(&status); i++) {
        if (i > 0 && head->timeline[i].at_s < head->timeline[i - 1].at_s) {
            char field[48];
            snprintf(field, sizeof field, "timeline.%d.at_s", i);
            status = ll_field_error(LL_BAD_INPUT, field,
                                    "%s: must be at least %g, that of the previous step; got %g", field,
                                    head->timeline[i - 1].at_s, head->timeline[i].at_s);
        } else {
            status = ll_apply_values(kind, probe, head->timeline[i].set);
            if (ll_failed(&status))
                status = in_step(&status, i);
        }
    }
    free(probe);
    return status;
}
