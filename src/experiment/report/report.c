#include "experiment/report/report.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/format/points.h"
#include "experiment/report/data.h"
#include "experiment/report/page_files.h"
#include "experiment/report/plot.h"
#include "experiment/report/plots.h"
#include "experiment/spec/metric_path.h"
#include "experiment/spec/until.h"

enum { ROWS_MAX = 50 }; /* rows in the table of all points */

static const char where_all[] =
    "the results: <code>laglab sweep experiment.json --points --out points.csv</code>, or with a daemon "
    "<code>results?points=true</code> next to this page";

/* ---- tables and texts ---- */

static void write_number(double value, FILE *file)
{
    if (isfinite(value))
        fprintf(file, "<td>%.6g</td>", value);
    else
        fputs("<td></td>", file);
}

static void write_summary(const ll_summary *s, FILE *file)
{
    char text[LL_SUMMARY_TEXT_MAX];
    write_number(s->mean, file);
    write_number(s->of_mean.low, file);
    write_number(s->of_mean.high, file);
    fputs("<td class=\"l\">", file);
    ll_summary_text(s, text);
    ll_html_text(text, file);
    fputs("</td>", file);
    write_number(s->deviation, file);
    for (int q = 0; q < 3; q++)
        write_number(s->quartiles[q], file);
}

static void write_point(const ll_experiment *e, const ll_point *p, FILE *file)
{
    cJSON *values = ll_experiment_point(e, p->point);
    char *name = ll_point_name(values);
    fprintf(file, "<tr%s><td>%" PRId64 "</td><td class=\"l\">", p->front ? " class=\"on\"" : "", p->point);
    ll_html_text(name ? name : "", file);
    fprintf(file, "</td><td>%" PRId64 "</td><td>%" PRId64 "</td>", p->runs, p->failed);
    for (int i = 0; i < e->metric_count; i++)
        write_summary(&p->metrics[i], file);
    fputs("</tr>\n", file);
    free(name);
    cJSON_Delete(values);
}

static void write_head(const ll_experiment *e, FILE *file)
{
    fputs("<thead><tr><th>Point</th><th>Values</th><th>Runs</th><th>Failed</th>", file);
    for (int i = 0; i < e->metric_count; i++) {
        fputs("<th>", file);
        ll_html_text(e->metrics[i], file);
        fputs("</th><th>95 % from</th><th>to</th><th>by</th><th>SD</th><th>25 %</th><th>median</th><th>75 "
              "%</th>",
              file);
    }
    fputs("</tr></thead>", file);
}

static void write_left_out(const ll_experiment *e, const ll_points *points, FILE *file)
{
    if (points->left_out == 0)
        return;
    fputs("<p class=\"note\">Of ", file);
    ll_html_count(e->points, file);
    fputs(" points ", file);
    ll_html_count(points->count, file);
    fprintf(file,
            ", a random sample, are in the plots and tables here, and the front is of these. All are in "
            "%s.</p>\n",
            where_all);
}

/* Coverage of the table's intervals: once for each method. */
static void write_coverage(const ll_experiment *e, const ll_points *points, FILE *file)
{
    enum { MOST = 16 };
    const ll_summary *found[MOST];
    int count = 0;
    for (int64_t k = 0; k < (int64_t)points->count * e->metric_count && count < MOST; k++) {
        const ll_summary *s = &points->points[k / e->metric_count].metrics[k % e->metric_count];
        int same = 0;
        while (same < count &&
               (found[same]->covers != s->covers || found[same]->of_mean.method != s->of_mean.method))
            same++;
        if (same == count && s->of_mean.method != LL_INTERVAL_NONE)
            found[count++] = s;
    }
    if (count > 0)
        fputs("<p>How often such intervals hold the mean:</p><ul>", file);
    for (int i = 0; i < count; i++)
        fprintf(file, "<li>%s: %s</li>", ll_interval_method_names[found[i]->of_mean.method],
                found[i]->covers);
    if (count > 0)
        fputs("</ul>\n", file);
}

static ll_status write_points(const ll_experiment *e, const ll_points *points, FILE *file)
{
    bool *front = malloc((size_t)points->count + 1), *shown = malloc((size_t)points->count + 1);
    if (!front || !shown) {
        free(front);
        free(shown);
        return ll_error(LL_NO_MEMORY, "out of memory: table");
    }
    for (int k = 0; k < points->count; k++)
        front[k] = points->points[k].front;
    ll_choice choice = ll_choose_shown(front, points->count, ROWS_MAX, shown);
    fputs(choice.shown == points->count ? "<h2>All points</h2>" : "<h2>Points</h2>", file);
    ll_plot_shown(&choice, points->count, where_all, file);
    fputs("<div class=\"data\"><table>", file);
    write_head(e, file);
    fputs("<tbody>\n", file);
    for (int k = 0; k < points->count; k++)
        if (shown[k])
            write_point(e, &points->points[k], file);
    fputs("</tbody></table></div>\n", file);
    write_coverage(e, points, file);
    if (points->identical > 0)
        fprintf(file,
                "<p>At %" PRId64 " of %" PRId64 " points all repeats gave identical metrics: nothing random "
                "in this scenario affects them, or only rarely.</p>\n",
                points->identical, e->points);
    free(front);
    free(shown);
    return ll_ok();
}

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
    ll_html_text(text ? text : "", file);
    fputs("</pre>\n", file);
    cJSON_free(text);
}

static void write_title(const ll_experiment *e, const char *version, FILE *file)
{
    const ll_scenario_head *scenario = e->base.config;
    const char *title = e->head.title[0]     ? e->head.title
                        : scenario->title[0] ? scenario->title
                                             : "Experiment";
    ll_html_begin_styled(title, ll_report_style, file);
    if (e->head.text[0]) {
        fputs("<p>", file);
        ll_html_text(e->head.text, file);
        fputs("</p>\n", file);
    }
    fputs("<p>Scenario <code>", file);
    ll_html_text(e->head.scenario_id[0] ? e->head.scenario_id : e->base.kind->name, file);
    fputs("</code>, ", file);
    ll_html_count(e->points, file);
    fprintf(file, " point%s with %s", e->points == 1 ? "" : "s", ll_until_is_set(e) ? "up to " : "");
    ll_html_count(e->head.repeats, file);
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
            ll_html_text(item->valuestring, file);
            fputs("</p>\n", file);
        }
    cJSON_Delete(before);
}

static void write_front(const ll_experiment *e, FILE *file)
{
    fputs("<p>Marked points are the Pareto front of", file);
    for (int i = 0; i < e->front_count; i++) {
        fputs(i ? ", <code>" : " <code>", file);
        ll_html_text(e->metrics[e->front[i]], file);
        fputs("</code>", file);
    }
    fputs(": no other point is as good in all of them and better in one.</p>\n", file);
}

/* For browsers without scripts; the script removes it. */
static ll_status write_static(const ll_experiment *e, const ll_points *points, FILE *file)
{
    fputs("<div id=\"static\"><noscript><p class=\"note\" role=\"note\">Scripts are off: only some plots and "
          "points "
          "are shown.</p></noscript>\n",
          file);
    if (e->front_count > 2)
        write_front(e, file);
    write_left_out(e, points, file);
    ll_status status = ll_report_plots_write(e, points, where_all, file);
    LL_THEN(status, write_points(e, points, file));
    fputs("</div>\n", file);
    return status;
}

static void write_results(const char *results, FILE *file)
{
    fputs("<p id=\"where\">All rows are in ", file);
    if (results) {
        fputs("<code>", file);
        ll_html_text(results, file);
        fputs("</code>", file);
    } else {
        fputs("the results: <code>laglab sweep experiment.json --out rows.csv</code>, or with a daemon "
              "<code>results</code> next to this page",
              file);
    }
    fputs(".</p>\n", file);
}

static ll_status write_text(const ll_experiment *e, const char *version, const char *results,
                            const ll_points *points, FILE *file)
{
    write_title(e, version, file);
    write_notices(e, points, file);
    fputs("<div id=\"views\"></div>\n", file);
    ll_status status = write_static(e, points, file);
    write_results(results, file);
    write_specification(e, version, file);
    fputs("</main>\n", file);
    return status;
}

/* The text first: what it leaves is the room of the data. */
static ll_status write_page(const ll_report_rows *rows, const char *version, const char *results,
                            const ll_points *points, FILE *file)
{
    char *text = NULL;
    size_t size = 0, script = strlen(ll_report_script) + 200, most = LL_REPORT_BYTES_MAX;
    ll_differences differences = {0};
    FILE *memory = open_memstream(&text, &size);
    ll_status status = memory ? write_text(rows->experiment, version, results, points, memory)
                              : ll_error(LL_NO_MEMORY, "out of memory: report");
    if (memory && fclose(memory) != 0)
        status = ll_error(LL_NO_MEMORY, "out of memory: report");
    LL_THEN(status, ll_differences_make(rows, &differences));
    if (!ll_failed(&status))
        fwrite(text, 1, size, file);
    LL_THEN(status, ll_report_data_write(rows, points, &differences, version,
                                         most > size + script ? most - size - script : 0, file));
    fprintf(file, "<script>\n(() => {\n%s})();\n</script></body></html>\n", ll_report_script);
    ll_differences_free(&differences);
    free(text);
    return ll_failed(&status)                  ? status
           : fflush(file) != 0 || ferror(file) ? ll_error(LL_IO, "cannot write the report")
                                               : ll_ok();
}

ll_status ll_report_write_for(const ll_experiment *e, const char *version, const char *results,
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

ll_status ll_report_write(const ll_experiment *e, const char *version, ll_row_source *source, void *context,
                          FILE *file)
{
    return ll_report_write_for(e, version, NULL, source, context, file);
}
