#include "experiment/report.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/metric_path.h"
#include "experiment/plot.h"
#include "experiment/points.h"
#include "experiment/until.h"

static const char head[] =
    "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
    "content=\"width=device-width\"><style>\n"
    "body{font:15px/1.45 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#1b1f24;"
    "background:#fff}h1{font-size:1.6rem;margin-bottom:.2rem}h2{font-size:1.2rem;margin-top:2rem}\n"
    "figure{margin:1rem 0}figcaption{font-weight:600}svg{max-width:100%;height:auto}svg text{font:12px "
    "system-ui,"
    "sans-serif;fill:#1b1f24}.g{stroke:#d8dee4;fill:none}circle{fill:#0072b2;fill-opacity:.75}"
    "circle.on{fill:#b34700;fill-opacity:1}.front{fill:none;stroke:#b34700;stroke-width:1.5}.ci{stroke:#"
    "0072b2;"
    "stroke-opacity:.4}\n"
    ".multiples{display:grid;grid-template-columns:repeat(auto-fill,minmax(20rem,1fr));gap:1rem}\n"
    ".data{max-height:14rem;overflow:auto;border:1px solid "
    "#d8dee4}table{border-collapse:collapse;font-size:.85rem;"
    "font-variant-numeric:tabular-nums}th,td{padding:.15rem .6rem;text-align:right;border-bottom:1px solid "
    "#eaeef2}"
    "th{position:sticky;top:0;background:#f6f8fa}td.l{text-align:left}tr.on "
    "td{color:#8a3700;font-weight:600}\n"
    "pre{background:#f6f8fa;padding:.8rem;overflow:auto;font-size:.8rem;white-space:pre-wrap}\n"
    "@media "
    "print{body{margin:0;max-width:none}.data{max-height:none;overflow:visible;border:0}figure{break-inside:"
    "avoid-page}th{position:static}pre{white-space:pre-wrap}}\n"
    "</style><title>";

static bool numeric(const ll_axis *axis)
{
    return axis->type == LL_CELL_REAL || axis->type == LL_CELL_INT;
}

/* ---- plots ---- */

static int by_x(const void *a, const void *b)
{
    double x = ((const ll_plot_point *)a)->x, y = ((const ll_plot_point *)b)->x;
    return (x > y) - (x < y);
}

/* What is drawn and compared of a metric. */
static const char *name_of(const ll_experiment *e, int metric, char name[LL_COLUMN_NAME_MAX])
{
    bool is_signed = ll_metric_is_signed(e->base.kind, e->metrics[metric]);
    snprintf(name, LL_COLUMN_NAME_MAX, is_signed ? "|%s|" : "%s", e->metrics[metric]);
    return name;
}

/* A point as it is drawn: by magnitude, which the bounds are of only where all runs have one sign. */
static ll_plot_point drawn(const ll_point *from, int metric)
{
    const ll_summary *m = &from->metrics[metric];
    double size = from->size[metric], rest = 1e-9 * size;
    ll_plot_point p = {.y = size, .low = NAN, .high = NAN, .front = from->front, .name = from->name};
    if (fabs(m->mean - size) <= rest) {
        p.low = m->of_mean.low;
        p.high = m->of_mean.high;
    } else if (fabs(m->mean + size) <= rest) {
        p.low = -m->of_mean.high;
        p.high = -m->of_mean.low;
    }
    return p;
}

static ll_status plot_trade(const ll_experiment *e, const ll_points *points, FILE *file)
{
    int x = e->cost_metric, y = e->error_metric;
    char x_name[LL_COLUMN_NAME_MAX], y_name[LL_COLUMN_NAME_MAX];
    ll_plot_point *p = calloc((size_t)points->count + 1, sizeof *p);
    if (!p)
        return ll_error(LL_NO_MEMORY, "no memory for a plot");
    for (int i = 0; i < points->count; i++) {
        const ll_point *from = &points->points[i];
        p[i] = drawn(from, y);
        p[i].x = from->size[x];
    }
    qsort(p, (size_t)points->count, sizeof *p, by_x);
    fputs("<h2>Error against cost</h2><p>Left is cheap, low is good. The marked points are the Pareto "
          "front: to be "
          "better in one, another must be worse in the other. A point with a run that failed is not "
          "drawn.</p>\n",
          file);
    ll_plot_write(&(ll_plot){"Error against cost", name_of(e, x, x_name), name_of(e, y, y_name), p,
                             points->count, true, true, e->front_count > 2, 760, 420},
                  file);
    free(p);
    return ll_ok();
}

/* A choice stands at the place of its first appearance in the list of values. */
static double place_of(const ll_axis *axis, const cJSON *value)
{
    const cJSON *item;
    int k = 0;
    if (numeric(axis))
        return value->valuedouble;
    cJSON_ArrayForEach(item, axis->values)
    {
        if (cJSON_Compare(item, value, true))
            return k;
        k++;
    }
    return k;
}

static const char *label_of(const ll_axis *axis, const cJSON *value)
{
    if (numeric(axis))
        return NULL;
    return cJSON_IsString(value) ? value->valuestring : cJSON_IsTrue(value) ? "true" : "false";
}

static ll_status plot_axis(const ll_experiment *e, const ll_points *points, const ll_axis *axis, FILE *file)
{
    char column[LL_COLUMN_NAME_MAX], name[LL_COLUMN_NAME_MAX], title[2 * LL_COLUMN_NAME_MAX];
    const ll_param *row = ll_param_find(e->base.kind->table, e->base.config, axis->path, NULL);
    ll_axis_column(axis->path, row ? row->unit : NULL, column, sizeof column);
    ll_plot_point *p = calloc((size_t)points->count + 1, sizeof *p);
    if (!p)
        return ll_error(LL_NO_MEMORY, "no memory for a plot");
    for (int i = 0; i < points->count; i++) {
        const ll_point *from = &points->points[i];
        const cJSON *value = cJSON_GetObjectItemCaseSensitive(from->values, axis->path);
        p[i] = drawn(from, e->error_metric);
        p[i].x = place_of(axis, value);
        p[i].label = label_of(axis, value);
        p[i].front = false;
    }
    qsort(p, (size_t)points->count, sizeof *p, by_x);
    snprintf(title, sizeof title, "Error along %s", column);
    ll_plot_write(&(ll_plot){title, column, name_of(e, e->error_metric, name), p, points->count,
                             axis->scale == 1, true, true, 400, 260},
                  file);
    free(p);
    return ll_ok();
}

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

static void write_points(const ll_experiment *e, const ll_points *points, FILE *file)
{
    fputs("<h2>All points</h2><div "
          "class=\"data\"><table><thead><tr><th>Point</th><th>Values</th><th>Runs</th><th>Failed</th>",
          file);
    for (int i = 0; i < e->metric_count; i++) {
        fputs("<th>", file);
        ll_html_text(e->metrics[i], file);
        fputs("</th><th>95 % from</th><th>to</th><th>by</th><th>SD</th><th>25 %</th><th>median</th><th>75 "
              "%</th>",
              file);
    }
    fputs("</tr></thead><tbody>\n", file);
    for (int k = 0; k < points->count; k++) {
        const ll_point *p = &points->points[k];
        fprintf(file, "<tr%s><td>%" PRId64 "</td><td class=\"l\">", p->front ? " class=\"on\"" : "",
                p->point);
        ll_html_text(p->name, file);
        fprintf(file, "</td><td>%" PRId64 "</td><td>%" PRId64 "</td>", p->runs, p->failed);
        for (int i = 0; i < e->metric_count; i++)
            write_summary(&p->metrics[i], file);
        fputs("</tr>\n", file);
    }
    fputs("</tbody></table></div>\n", file);
    if (points->identical > 0)
        fprintf(file,
                "<p>At %" PRId64 " of %" PRId64
                " points all repeats gave identical metrics: nothing random in "
                "this scenario reaches them, or what does is rare.</p>\n",
                points->identical, e->points);
    if (points->left_out > 0)
        fprintf(file, "<p>%" PRId64 " more points are left out here; the results have them.</p>\n",
                points->left_out);
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
    fprintf(
        file,
        "<h2>Repeat it</h2><p>Save the specification as <code>experiment.json</code>. With laglab %s this "
        "gives the same rows, bit for bit, on any machine%s:</p><pre>laglab sweep experiment.json --out "
        "results.csv --report report.html</pre><h2>Specification</h2><pre>",
        version, has_cost(e) ? ", but for <code>cost.ns_per_sim_s</code>, which is measured" : "");
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
    fputs(head, file);
    ll_html_text(title, file);
    fputs("</title></head><body>\n<h1>", file);
    ll_html_text(title, file);
    fputs("</h1>\n<p>", file);
    ll_html_text(e->head.text, file);
    fprintf(file, "</p>\n<p>Scenario <code>");
    ll_html_text(e->head.scenario_id[0] ? e->head.scenario_id : e->base.kind->name, file);
    fprintf(file,
            "</code>, %" PRId64 " points with %s%" PRId64 " runs each, seeds %" PRId64 " to %" PRId64
            "; key %016" PRIx64 ", laglab %s.</p>\n",
            e->points, ll_until_is_set(e) ? "up to " : "", e->head.repeats, scenario->seed,
            scenario->seed + e->head.repeats - 1, ll_experiment_key(e), version);
}

static void write_front(const ll_experiment *e, FILE *file)
{
    fputs("<p>Marked is the front of", file);
    for (int i = 0; i < e->front_count; i++) {
        fputs(i ? ", <code>" : " <code>", file);
        ll_html_text(e->metrics[e->front[i]], file);
        fputs("</code>", file);
    }
    fputs(": no other point is as good in all of them and better in one.</p>\n", file);
}

ll_status ll_report_write(const ll_experiment *e, const char *version, ll_row_source *source, void *context,
                          FILE *file)
{
    ll_points points;
    ll_status status = ll_points_read(e, source, context, &points);
    if (ll_failed(&status))
        return status;
    write_title(e, version, file);
    if (e->front_count > 0)
        ll_points_mark_front(&points, e->front, e->front_count);
    if (e->front_count > 2)
        write_front(e, file);
    if (e->cost_metric >= 0)
        status = plot_trade(e, &points, file);
    if (e->axis_count > 0)
        fputs("<h2>Along each axis</h2><div class=\"multiples\">\n", file);
    for (int i = 0; i < e->axis_count && !ll_failed(&status); i++)
        status = plot_axis(e, &points, &e->axes[i], file);
    if (e->axis_count > 0)
        fputs("</div>\n", file);
    write_points(e, &points, file);
    write_specification(e, version, file);
    fputs("</body></html>\n", file);
    ll_points_free(&points);
    return ll_failed(&status)                  ? status
           : fflush(file) != 0 || ferror(file) ? ll_error(LL_IO, "the report could not be written")
                                               : ll_ok();
}
