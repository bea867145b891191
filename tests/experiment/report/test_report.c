/* Reports: their size for many rows, and paired differences. tests/page/report.test.mjs reads them in a
 * browser. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "base/rng.h"
#include "experiment/fixture.h"
#include "experiment/report/differences.h"
#include "experiment/report/report.h"
#include "support/near.h"

/* Rows with metrics that no compression makes shorter. */
typedef struct noise {
    const ll_experiment *e;
    int64_t run;
} noise;

static double noise_at(const ll_experiment *e, int64_t run, int metric)
{
    return ll_rng_unit(7, (uint32_t)metric, (uint64_t)run) * (1 + 9 * metric) +
           (double)(run / e->head.repeats % 4);
}

static bool next_noise(void *context, ll_row *row, ll_status *status)
{
    noise *n = context;
    *status = ll_ok();
    if (n->run == n->e->points * n->e->head.repeats)
        return false;
    ll_row_clear(row);
    row->run = n->run++;
    for (int m = 0; m < n->e->metric_count; m++)
        row->metrics[m] = noise_at(n->e, row->run, m);
    return true;
}

#define SCENARIO                                                                                             \
    "\"scenario\":{\"kind\":\"motion\",\"problem\":\"oscillator\",\"duration_s\":0.1,"                       \
    "\"methods\":[{\"method\":\"rk4\"}]},"
#define FOUR_METRICS                                                                                         \
    "\"metrics\":[\"methods.0.e_max\",\"methods.0.e_final\",\"methods.0.evaluations\",\"methods.0.e_l2\"]"

static char *report_of(const char *text, size_t *size)
{
    char *page = NULL;
    ll_experiment *e = experiment(text);
    FILE *file = open_memstream(&page, size);
    assert_non_null(file);
    must(ll_report_write(e, "0", NULL, next_noise, &(noise){e, 0}, file));
    fclose(file);
    ll_experiment_free(e);
    return page;
}

static double head_number(const char *page, const char *name)
{
    const char *begin = strstr(page, "id=\"head\">");
    assert_non_null(begin);
    begin += strlen("id=\"head\">");
    const char *end = strstr(begin, "</script>");
    cJSON *head = cJSON_ParseWithLength(begin, (size_t)(end - begin));
    assert_non_null(head);
    double number = cJSON_GetObjectItem(head, name)->valuedouble;
    cJSON_Delete(head);
    return number;
}

static void two_hundred_thousand_points_of_noise_stay_small(void **state)
{
    (void)state;
    size_t size;
    char *page =
        report_of("{" SCENARIO "\"axes\":[{\"path\":\"methods.0.dt_s\",\"from\":0.01,\"to\":0.1,\"count\":"
                  "1000},{\"path\":\"params.omega\",\"from\":0.5,\"to\":5,\"count\":200}]," FOUR_METRICS "}",
                  &size);
    assert_in_range(size, LL_REPORT_BYTES_MAX * 3 / 4, LL_REPORT_BYTES_MAX);
    /* Digits are not enough: it is a sample, and the page has its numbers. */
    assert_true(head_number(page, "planes") == 3);
    assert_true(head_number(page, "points") == 200000);
    assert_in_range(head_number(page, "shown"), 50000, 199999);
    assert_non_null(strstr(page, "\"name\":\"point\""));
    free(page);
}

static void many_runs_of_noise_stay_small(void **state)
{
    (void)state;
    size_t size;
    char *page =
        report_of("{" SCENARIO "\"axes\":[{\"path\":\"methods.0.dt_s\",\"from\":0.01,\"to\":0.1,\"count\":"
                  "1000}],\"repeats\":250,\"interval\":\"t\"," FOUR_METRICS "}",
                  &size);
    assert_in_range(size, LL_REPORT_BYTES_MAX * 3 / 4, LL_REPORT_BYTES_MAX);
    /* All points with all that is known of them, exactly, and as many runs as there is room for. */
    assert_true(head_number(page, "shown") == 1000);
    assert_true(head_number(page, "planes") == 8);
    assert_in_range(head_number(page, "kept"), 50, 249);
    free(page);
}

/* Of three values along two settings: the difference at a setting is of runs with equal seeds, the whole one
 * by seed of the mean over settings. */
static void differences_pair_seeds(void **state)
{
    (void)state;
    enum { REPEATS = 12, OMEGAS = 2 };
    ll_report_rows rows;
    ll_differences differences;
    ll_row row;
    ll_status status;
    ll_experiment *e =
        experiment("{" SCENARIO "\"axes\":[{\"path\":\"methods.0.dt_s\",\"values\":[0.01,0.02,0.05]},{"
                   "\"path\":\"params.omega\",\"values\":[1,2]}],\"repeats\":12," FOUR_METRICS "}");
    noise n = {e, 0};
    must(ll_report_rows_open(&rows, e, next_noise, &n));
    while (ll_report_rows_next(&rows, &row, &status))
        ;
    must(ll_differences_make(&rows, &differences));
    assert_int_equal(differences.count, 4 * (3 + 1));
    for (int i = 0; i < differences.count; i++) {
        const ll_difference *d = &differences.list[i];
        if (d->dimension != 0 || d->from != 0 || d->of != 2)
            continue;
        double all = 0;
        assert_int_equal(d->settings, OMEGAS);
        assert_int_equal(d->complete, OMEGAS);
        for (int s = 0; s < OMEGAS; s++) {
            double mean = 0;
            for (int r = 0; r < REPEATS; r++)
                mean += (noise_at(e, (2 * OMEGAS + s) * REPEATS + r, d->metric) -
                         noise_at(e, s * REPEATS + r, d->metric)) /
                        REPEATS;
            assert_near(d->details[s].mean, mean, 1e-9 * (1 + fabs(mean)));
            assert_int_equal(d->details[s].n, REPEATS);
            assert_true(d->details[s].of_mean.low < mean && mean < d->details[s].of_mean.high);
            all += mean / OMEGAS;
        }
        assert_int_equal(d->all.n, REPEATS);
        assert_near(d->all.mean, all, 1e-9 * (1 + fabs(all)));
    }
    ll_differences_free(&differences);
    ll_report_rows_close(&rows);
    ll_experiment_free(e);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_hundred_thousand_points_of_noise_stay_small),
        cmocka_unit_test(many_runs_of_noise_stay_small),
        cmocka_unit_test(differences_pair_seeds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
