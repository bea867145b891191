#include "experiment/report/report.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/report/data.h"
#include "experiment/report/page.h"
#include "experiment/spec/metric_path.h"
#include "experiment/spec/until.h"

static bool has_cost(const ll_experiment *e)
{
    bool has = false;
    for (int i = 0; i < e->metric_count; i++)
        has |= ll_metric_is_cost(e->metrics[i]);
    return has;
}

static void write_specification(const ll_experiment *e, const char *version, FILE *file)
{
    char *text = cJSON_Print(e->json);
    fprintf(file,
            "<h2>Reproduction</h2><p>Save the specification as <code>experiment.json</code>. With laglab %s "
            "this gives the same rows, bit for bit, on any machine%s:</p><pre>laglab sweep experiment.json "
            "--out results.csv --report report.html</pre><h2>Specification</h2><pre>",
            version, has_cost(e) ? ", except <code>cost.ns_per_sim_s</code>, which is measured" : "");
    ll_page_text(text ? text : "", file);
    fputs("</pre>\n", file);
    cJSON_free(text);
}

static void write_title(const ll_experiment *e, const char *version, FILE *file)
{
    const ll_scenario_head *scenario = e->base.config;
    const char *title = e->head.title[0]     ? e->head.title
                        : scenario->title[0] ? scenario->title
                                             : "Experiment";
    ll_page_begin(title, file);
    if (e->head.text[0]) {
        fputs("<p>", file);
        ll_page_text(e->head.text, file);
        fputs("</p>\n", file);
    }
    fputs("<p>Scenario <code>", file);
    ll_page_text(e->head.scenario_id[0] ? e->head.scenario_id : e->base.kind->name, file);
    fputs("</code>, ", file);
    ll_page_count(e->points, file);
    fprintf(file, " point%s with %s", e->points == 1 ? "" : "s", ll_until_is_set(e) ? "up to " : "");
    ll_page_count(e->head.repeats, file);
    if (e->head.repeats == 1)
        fprintf(file, " run each, seed %" PRId64, scenario->seed);
    else
        fprintf(file, " runs each, seeds %" PRId64 " to %" PRId64, scenario->seed,
                scenario->seed + e->head.repeats - 1);
    fprintf(file, "; key %016" PRIx64 ", laglab %s.</p>\n", ll_experiment_key(e), version);
}

/* Notices known before the runs, and those of the results. */
static void write_notices(const ll_experiment *e, const ll_points *points, FILE *file)
{
    cJSON *before = ll_experiment_notices(e);
    const cJSON *const both[] = {before, points->notices};
    const cJSON *item;
    for (int k = 0; k < 2; k++)
        cJSON_ArrayForEach(item, both[k])
        {
            fputs("<p class=\"note\" role=\"note\">", file);
            ll_page_text(item->valuestring, file);
            fputs("</p>\n", file);
        }
    cJSON_Delete(before);
}

static void write_identical(const ll_experiment *e, const ll_points *points, FILE *file)
{
    if (points->identical > 0)
        fprintf(file,
                "<p>At %" PRId64 " of %" PRId64 " points all repeats gave identical metrics: nothing random "
                "in this scenario affects them, or only rarely.</p>\n",
                points->identical, e->points);
}

static void write_results(const char *results, FILE *file)
{
    fputs("<p id=\"where\">All rows are in ", file);
    if (results) {
        fputs("<code>", file);
        ll_page_text(results, file);
        fputs("</code>", file);
    } else {
        fputs("the results: <code>laglab sweep experiment.json --out rows.csv</code>, or with a daemon "
              "<code>results</code> next to this page",
              file);
    }
    fputs(".</p>\n", file);
}

static void write_text(const ll_experiment *e, const char *version, const char *results,
                       const ll_points *points, FILE *file)
{
    write_title(e, version, file);
    write_notices(e, points, file);
    write_identical(e, points, file);
    ll_page_views(
        "The points as CSV: <code>laglab sweep experiment.json --points --out points.csv</code>, or "
        "with a daemon <code>results?points=true</code> next to this page.",
        file);
    write_results(results, file);
    write_specification(e, version, file);
}

/* The text first: what it leaves is the room of the data. */
static ll_status write_page(const ll_report_rows *rows, const char *version, const char *results,
                            const ll_points *points, FILE *file)
{
    char *text = NULL;
    size_t size = 0, script = strlen(ll_report_script) + 200, most = LL_REPORT_BYTES_MAX;
    ll_differences differences = {0};
    FILE *memory = open_memstream(&text, &size);
    if (memory)
        write_text(rows->experiment, version, results, points, memory);
    ll_status status =
        memory && fclose(memory) == 0 ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: report");
    LL_THEN(status, ll_differences_make(rows, &differences));
    if (!ll_failed(&status))
        fwrite(text, 1, size, file);
    LL_THEN(status, ll_report_data_write(rows, points, &differences, version,
                                         most > size + script ? most - size - script : 0, file));
    ll_page_end(file);
    ll_differences_free(&differences);
    free(text);
    return ll_failed(&status)                  ? status
           : fflush(file) != 0 || ferror(file) ? ll_error(LL_IO, "cannot write the report")
                                               : ll_ok();
}

ll_status ll_report_write(const ll_experiment *e, const char *version, const char *results,
                          ll_row_source *source, void *context, FILE *file)
{
    ll_points points = {0};
    ll_report_rows rows;
    LL_TRY(ll_report_rows_open(&rows, e, source, context));
    ll_status status = ll_points_read(e, ll_report_rows_next, &rows, &points);
    if (!ll_failed(&status)) {
        if (e->front_count > 0)
            ll_points_mark_front(&points, e->front, e->front_count);
        status = write_page(&rows, version, results, &points, file);
        ll_points_free(&points);
    }
    ll_report_rows_close(&rows);
    return status;
}
