#include "experiment/spec/window.h"

#include <cjson/cJSON.h>
#include <ctype.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "experiment/spec/experiment.h"
#include "experiment/spec/metric_path.h"
#include "sim/core/scenario_rows.h"

/* ---- the table ---- */

#define BOUND 1e15 /* no bound */

#define CONDITION(member) offsetof(ll_window, condition.member) - offsetof(ll_window, condition)

static const ll_param condition_rows[] = {
    {.name = "value",
     .type = LL_PARAM_TEXT,
     .offset = CONDITION(value),
     .max = LL_WINDOW_PATH_MAX,
     .help = "Column of the trace, such as player_1_down_blackout, or path of a parameter, such as "
             "players.1.lag_ms; true counts as 1. Empty: no condition."},
    {.name = "above",
     .type = LL_PARAM_REAL,
     .offset = CONDITION(above),
     .min = -BOUND,
     .max = BOUND,
     .default_value = -BOUND,
     .help = "The value must be above this."},
    {.name = "below",
     .type = LL_PARAM_REAL,
     .offset = CONDITION(below),
     .min = -BOUND,
     .max = BOUND,
     .default_value = BOUND,
     .help = "The value must be below this."},
};

static const ll_param_table condition_table = {.name = "window_condition",
                                               .help = "When a tick counts.",
                                               LL_PARAM_ROWS(condition_rows, ((ll_window *)0)->condition)};

static const ll_param rows[] = {
    {LL_PARAM_ROW("name", TEXT, ll_window, name), .min = 1, .max = LL_WINDOW_NAME_MAX, .required = true,
     .help = "Name, behind the @ of a metric: small letters, digits and _, first a letter."},
    {LL_PARAM_ROW("from_s", REAL, ll_window, from_s), .max = LL_DURATION_MAX_S, .unit = "s",
     .help = "Ticks count from this virtual time on."},
    {LL_PARAM_ROW("to_s", REAL, ll_window, to_s), .max = LL_DURATION_MAX_S,
     .default_value = LL_DURATION_MAX_S, .unit = "s",
     .help = "Ticks count before this virtual time; default: to the end."},
    {LL_PARAM_ROW("while", OBJECT, ll_window, condition), .child = &condition_table,
     .help = "When a tick counts; default: always."},
};

static ll_status check_name(const char *name, const char *path)
{
    char field[64];
    const char *end = name;
    while (islower((unsigned char)*end) || (end > name && (isdigit((unsigned char)*end) || *end == '_')))
        end++;
    if (*end == '\0')
        return ll_ok();
    snprintf(field, sizeof field, "%sname", path);
    return ll_field_error(LL_BAD_INPUT, field,
                          "%s: must be small letters, digits and _, first a letter; got %s", field, name);
}

static ll_status check_condition(const ll_window *w, const char *path)
{
    char field[64];
    bool bounded = w->condition.above > -BOUND || w->condition.below < BOUND;
    if (bounded && w->condition.value[0] == '\0') {
        snprintf(field, sizeof field, "%swhile.value", path);
        return ll_field_error(LL_BAD_INPUT, field, "%s: must be given with above or below", field);
    }
    snprintf(field, sizeof field, "%swhile", path);
    if (!bounded && w->condition.value[0] != '\0')
        return ll_field_error(LL_BAD_INPUT, field, "%s: must have above or below", field);
    if (w->condition.above >= w->condition.below)
        return ll_field_error(LL_BAD_INPUT, field, "%s: above, %g, must be less than below, %g", field,
                              w->condition.above, w->condition.below);
    return ll_ok();
}

static ll_status check(const void *object, const char *path)
{
    char field[64];
    const ll_window *w = object;
    LL_TRY(check_name(w->name, path));
    LL_TRY(check_condition(w, path));
    if (w->from_s < w->to_s)
        return ll_ok();
    snprintf(field, sizeof field, "%sto_s", path);
    return ll_field_error(LL_BAD_INPUT, field, "%s: must be above from_s, which is %g s, to %d s; got %g",
                          field, w->from_s, LL_DURATION_MAX_S, w->to_s);
}

const ll_param_table ll_window_table = {.name = "window",
                                        .help = "A part of a run over which metrics are taken.",
                                        LL_PARAM_ROWS(rows, ll_window),
                                        .check = check};

/* ---- with a scenario ---- */

int ll_column_find(ll_session *session, const char *name)
{
    char names[LL_TRACE_COLUMNS_MAX][LL_TRACE_NAME_MAX];
    ll_trace_line line = {.names = names};
    ll_session_trace_line(session, &line);
    for (int i = 0; i < line.count; i++)
        if (strcmp(names[i], name) == 0)
            return i;
    return -1;
}

static ll_status check_value(const char *value, int window, ll_session *session)
{
    char field[64];
    double number;
    if (value[0] == '\0' || ll_column_find(session, value) >= 0 ||
        ll_session_parameter(session, value, &number))
        return ll_ok();
    snprintf(field, sizeof field, "windows.%d.while.value", window);
    return ll_field_error(LL_BAD_INPUT, field,
                          "%s: must be a column of the trace or a parameter that is a number; got %s", field,
                          value);
}

ll_status ll_windows_check(const ll_experiment *e, ll_session *session)
{
    const ll_experiment_head *head = &e->head;
    for (int i = 0; i < head->window_count; i++) {
        char field[64];
        LL_TRY(check_value(head->windows[i].condition.value, i, session));
        for (int j = 0; j < i; j++) {
            snprintf(field, sizeof field, "windows.%d.name", i);
            if (strcmp(head->windows[i].name, head->windows[j].name) == 0)
                return ll_field_error(LL_BAD_INPUT, field, "%s: %s is the name of another window", field,
                                      head->windows[i].name);
        }
    }
    return ll_ok();
}

/* ---- a metric in a window ---- */

static const char *const statistics[LL_COLUMN_STATISTICS] = {"mean", "rms", "min", "max",
                                                             "p50",  "p95", "p99"};

static ll_status find_window(const ll_experiment *e, const char *field, const char *name, int *window)
{
    char names[160] = "";
    for (*window = 0; *window < e->head.window_count; ++*window) {
        const char *found = e->head.windows[*window].name;
        size_t used = strlen(names);
        if (strcmp(found, name) == 0)
            return ll_ok();
        snprintf(names + used, sizeof names - used, "%s%s", used ? ", " : "", found);
    }
    if (names[0] == '\0')
        return ll_field_error(LL_BAD_INPUT, field, "%s: must end in @ and a window; the experiment has none",
                              field);
    return ll_field_error(LL_BAD_INPUT, field,
                          "%s: must end in @ and a window, which is one of: %s; got %.40s", field, names,
                          name);
}

/* Cuts the part of a distribution off the path: what it is in a window, LL_WINDOWED_NOT if it cannot be. */
static ll_windowed_as part_of(char *path)
{
    char *dot = strrchr(path, '.');
    if (dot == NULL || strcmp(dot, ".count") == 0)
        return dot ? LL_WINDOWED_CHANGE : LL_WINDOWED_NOT;
    ll_windowed_as as = strcmp(dot, ".mean") == 0  ? LL_WINDOWED_MEAN
                        : strcmp(dot, ".rms") == 0 ? LL_WINDOWED_RMS
                                                   : LL_WINDOWED_NOT;
    if (as != LL_WINDOWED_NOT)
        *dot = '\0';
    return as;
}

static ll_status parse_metric(const ll_metric_field *metric, const char *field, ll_windowed *w)
{
    bool is_time = metric->type == LL_METRIC_NUMBER && metric->unit && strcmp(metric->unit, "s") == 0;
    if (metric->type == LL_METRIC_COUNT || is_time)
        w->as = LL_WINDOWED_CHANGE;
    else if (metric->is_rate)
        w->as = LL_WINDOWED_RATE;
    else if (metric->type == LL_METRIC_DISTRIBUTION || metric->type == LL_METRIC_LATENCY ||
             metric->type == LL_METRIC_GAUGE)
        w->as = part_of(w->path);
    if (w->as != LL_WINDOWED_NOT)
        return ll_ok();
    return ll_field_error(
        LL_BAD_INPUT, field,
        "%s: must be a count, a time, a rate, the mean, rms or count of a distribution, or a "
        "statistic of a column of the trace; got %.100s",
        field, w->path);
}

static ll_status parse_column(const char *field, ll_session *session, ll_windowed *w)
{
    char *dot = strrchr(w->path, '.');
    if (dot)
        *dot = '\0';
    if (!dot || ll_column_find(session, w->path) < 0)
        return ll_field_error(LL_BAD_INPUT, field,
                              "%s: the scenario has neither a metric nor a column of the trace %.100s", field,
                              w->path);
    w->as = LL_WINDOWED_COLUMN;
    for (int i = 0; i < LL_COLUMN_STATISTICS; i++)
        if (strcmp(statistics[i], dot + 1) == 0) {
            w->statistic = (ll_column_statistic)i;
            return ll_ok();
        }
    return ll_field_error(LL_BAD_INPUT, field,
                          "%s: must be one of: mean, rms, min, max, p50, p95, p99 of %.60s; got %.40s", field,
                          w->path, dot + 1);
}

ll_status ll_windowed_parse(const ll_experiment *e, const char *field, const char *path, const cJSON *present,
                            ll_session *session, ll_windowed *w)
{
    const char *at = strrchr(path, '@');
    *w = (ll_windowed){.as = LL_WINDOWED_NOT};
    LL_TRY(find_window(e, field, at + 1, &w->window));
    snprintf(w->path, sizeof w->path, "%.*s", (int)(at - path), path);
    if (strcmp(w->path, "counted_s") == 0) {
        w->as = LL_WINDOWED_TIME;
        return ll_ok();
    }
    const ll_metric_field *metric = ll_metric_find(e->base.kind->metric_tables, w->path);
    return metric && ll_metric_at(present, w->path) ? parse_metric(metric, field, w)
                                                    : parse_column(field, session, w);
}
