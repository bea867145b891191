#include "cli/experiments/results.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "cli/output.h"
#include "experiment/format/compare.h"
#include "experiment/report/report.h"

void ll_print_notices(cJSON *notices)
{
    const cJSON *item;
    cJSON_ArrayForEach(item, notices) fprintf(stderr, "laglab: %s\n", item->valuestring);
    cJSON_Delete(notices);
}

/* ---- checks ---- */

static ll_status check_other_file(const char *option, const char *path, const char *const *inputs, int count)
{
    struct stat output, input;
    for (int i = 0; path && i < count && stat(path, &output) == 0; i++)
        if (inputs[i] && stat(inputs[i], &input) == 0 && input.st_dev == output.st_dev &&
            input.st_ino == output.st_ino)
            return ll_error(LL_BAD_INPUT, "%s: must be another file than the input %.150s; got %.150s",
                            option, inputs[i], path);
    return ll_ok();
}

static ll_status check_sensitivity(const ll_results *r, const ll_experiment *e)
{
    if (r->points)
        return ll_error(LL_BAD_INPUT,
                        "--sensitivity: must be without --points, since it has no points but all runs");
    if (e->head.sample.method != LL_SAMPLE_SALTELLI)
        return ll_error(LL_BAD_INPUT,
                        "--sensitivity: must have an experiment with \"sample\": {\"method\": \"saltelli\"}");
    return ll_ok();
}

ll_status ll_results_check(ll_results *r, const ll_experiment *e, const char *const *inputs, int count)
{
    ll_status status = ll_argument_format(r->format_name, r->out, &r->format);
    LL_THEN(status, check_other_file("--out", r->out, inputs, count));
    LL_THEN(status, check_other_file("--report", r->report, inputs, count));
    if (!ll_failed(&status) && r->sensitivity)
        status = check_sensitivity(r, e);
    if (!ll_failed(&status) && r->compare && !r->points)
        status = ll_error(LL_BAD_INPUT, "--compare: must have --points");
    if (!ll_failed(&status) && r->compare)
        status = ll_compare_point(e, "--compare", r->compare, &r->baseline);
    return status;
}

const char *ll_results_of_all(const ll_results *r)
{
    return r->points ? "--points" : r->sensitivity ? "--sensitivity" : r->report ? "--report" : NULL;
}

/* ---- writing ---- */

static ll_status make_table(const ll_results *r, const ll_experiment *e, const ll_results_rows *rows,
                            ll_result_table **table)
{
    ll_row *baseline = NULL;
    int64_t count = 0;
    ll_status status = ll_ok();
    if (r->compare) {
        rows->seek(rows->context, r->baseline * e->head.repeats);
        status = ll_compare_rows(e, r->baseline, rows->next, rows->context, &baseline, &count);
    }
    rows->seek(rows->context, 0);
    if (r->sensitivity)
        return ll_result_table_sensitivity(e, rows->next, rows->context, table);
    if (!r->points)
        return ll_result_table_rows(e, rows->version, rows->next, rows->context, table);
    LL_THEN(status, ll_result_table_compared(e, baseline, count, rows->next, rows->context, table));
    free(baseline);
    return status;
}

static ll_status write_table(const ll_results *r, const ll_experiment *e, const ll_results_rows *rows)
{
    ll_result_table *table = NULL;
    ll_status status = make_table(r, e, rows, &table);
    LL_THEN(status, ll_argument_write(r->out, r->format, ll_result_table_get(table)));
    if (!ll_failed(&status) && ll_result_table_identical(table) > 0)
        fprintf(stderr,
                "laglab: at %" PRId64 " of %" PRId64 " points all repeats gave identical metrics: nothing "
                "random in the scenario affects them, or only rarely\n",
                ll_result_table_identical(table), e->points);
    if (!ll_failed(&status))
        ll_print_notices(ll_result_table_notices(table));
    ll_result_table_free(table);
    return status;
}

static ll_status write_report(const ll_results *r, const ll_experiment *e, const ll_results_rows *rows)
{
    FILE *file = fopen(r->report, "wb");
    if (!file)
        return ll_error(LL_IO, "cannot write %.200s", r->report);
    rows->seek(rows->context, 0);
    ll_status status = ll_report_write(e, rows->version, r->points || r->sensitivity ? NULL : r->out,
                                       rows->next, rows->context, file);
    if (fclose(file) != 0 && !ll_failed(&status))
        status = ll_error(LL_IO, "cannot write %.200s", r->report);
    return status;
}

ll_status ll_results_write(const ll_results *r, const ll_experiment *e, const ll_results_rows *rows)
{
    ll_status status = write_table(r, e, rows);
    if (!ll_failed(&status) && r->report)
        status = write_report(r, e, rows);
    return status;
}
