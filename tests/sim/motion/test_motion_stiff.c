/* Stiff problems by every implicit method, over refinement series from steps that resolve nothing to steps
 * that resolve everything, and over all tolerances: a run with status `ok` is near the solution and converges
 * with the method's order; a run that is not near it has failed. */
#include "motion_lab.h"
#include "ode/core/method.h"
#include "support/near.h"

typedef struct known {
    const char *problem;
    double T;
    int dim;
    double solution[8]; /* at T, with more digits than a double has */
    double size[8];     /* order of magnitude of the largest value of a component */
    int halvings;       /* of the step, from T / 2 */
} known;

/* Robertson, HIRES, the Oregonator and van der Pol's oscillator with mu = 1000: Test Set for IVP Solvers, and
 * by two methods in binary128. Van der Pol's with 3 and 5: Taylor series with 30 digits (mpmath). The last
 * three: the linearly implicit Euler method, extrapolated to nine columns, at 1e-9, in Python. */
static const known problems[] = {
    {"robertson",
     40,
     3,
     {0.715827068719405090, 9.18553476455776390e-6, 0.284163745745830352},
     {1, 3.6e-5, 0.28},
     17},
    {"hires",
     321.8122,
     8,
     {0.000737131257332566781, 0.000144248572631618466, 0.0000588872974096757501, 0.00117565134328314915,
      0.00238635619883133047, 0.00623896825274279579, 0.00284999839518576866, 0.00285000160481423134},
     {1, 0.16, 0.014, 0.5, 0.22, 0.6, 0.0057, 0.0057},
     17},
    {"oregonator",
     360,
     3,
     {1.00081487031852272, 1228.17852154988798, 132.055494284650829},
     {1.2e5, 2e3, 3e4},
     17},
    {"van_der_pol\",\"params\":{\"mu\":1000},\"title\":\"",
     2000,
     2,
     {1.70616773217046501, -8.92809701024816548e-4},
     {2, 1340},
     13},
    {"van_der_pol\",\"params\":{\"mu\":3},\"title\":\"",
     11,
     2,
     {1.4300798875226748106, -0.39122041368156572908},
     {2, 5.1},
     15},
    {"van_der_pol\",\"params\":{\"mu\":5},\"title\":\"",
     20,
     2,
     {-1.6012968795428539088, 0.19832667633866208455},
     {2, 7.6},
     15},
    {"robertson\",\"params\":{\"k1\":0.1,\"k2\":1e8,\"k3\":5e3},\"title\":\"",
     100,
     3,
     {0.14972126246316944, 3.2701748522746927e-06, 0.8502754673623539},
     {1, 3.16e-5, 0.85},
     17},
    {"oregonator\",\"params\":{\"s\":50,\"w\":0.3,\"q\":1e-5},\"title\":\"",
     150,
     3,
     {1.117341772856983, 9.521112828985505, 1.1022788089483335},
     {96849, 1324.7, 27203},
     16},
    {"hires\",\"params\":{\"k\":1000},\"title\":\"",
     200,
     8,
     {0.0026930009134076465, 0.0005266925826783507, 0.0004399637644857499, 0.004612519034672074,
      0.0693121434364073, 0.27416718055475947, 0.005662617714748473, 3.738228523617118e-05},
     {1, 0.1325, 0.0196, 0.4585, 0.186, 0.749, 0.0057, 0.0057},
     16},
};

enum { PROBLEMS = sizeof problems / sizeof problems[0], AT_ONCE = 8, RUNGS = 17 };

/* From docs/accuracy.md, for the first of the problems: number of halvings of the longest step that is ok,
 * and its largest error. -1: no step is. */
static const struct {
    int halved;
    double off;
} longest[][3] = {
    {{0, 0.18}, {8, 1e-4}, {7, 0.042}},    {{6, 0.022}, {7, 0.011}, {7, 0.012}},
    {{14, 0.006}, {13, 1e-3}, {13, 1e-3}}, {{-1, 0}, {-1, 0}, {-1, 0}},
    {{7, 0.27}, {4, 0.13}, {4, 0.13}},     {{10, 0.09}, {6, 0.09}, {6, 0.09}},
};

typedef struct refinement_level {
    double error;    /* at T, of the worst component relative to its size; NAN: not ok */
    double reported; /* e_final_weighted */
} refinement_level;

static refinement_level read_refinement_level(const known *p, const cJSON *m)
{
    refinement_level r = {NAN, lab_number(m, "e_final_weighted")};
    const char *status = lab_status(m);
    bool ok = strcmp(status, "ok") == 0;
    assert_true(ok || strcmp(status, "failed") == 0 || strcmp(status, "diverged") == 0);
    assert_true(ok == (cJSON_GetObjectItem(m, "reason") == NULL));
    for (int i = 0; i < p->dim && ok; i++) {
        double error = fabs(lab_state(m, "state", i) - p->solution[i]) / p->size[i];
        r.error = i == 0 ? error : larger(r.error, error);
    }
    return r;
}

/* Several configurations of a method side by side, as many as a motion takes. */
static void refinement_run(const known *p, const char *method, const char *setting, const double *values,
                           int count, refinement_level *refinement_levels)
{
    for (int from = 0; from < count; from += AT_ONCE) {
        char text[1536];
        int at =
            snprintf(text, sizeof text, "\"problem\":\"%s\",\"tick_hz\":1,\"duration_s\":%.17g,\"methods\":[",
                     p->problem, p->T);
        int here = count - from < AT_ONCE ? count - from : AT_ONCE;
        for (int k = 0; k < here; k++)
            at += snprintf(text + at, sizeof text - (size_t)at, "%s{\"method\":\"%s\",\"%s\":%.17g}",
                           k ? "," : "", method, setting, values[from + k]);
        snprintf(text + at, sizeof text - (size_t)at, "]");
        cJSON *metrics = lab_run(text);
        for (int k = 0; k < here; k++)
            refinement_levels[from + k] = read_refinement_level(p, lab_method(metrics, k));
        cJSON_Delete(metrics);
    }
}

/* A run that is ok is within two fifths of a component's size (the kind's own third is of the size that it
 * saw), and the reported error is the true one. */
static void near_or_failed(const known *p, const char *method, double value, const refinement_level *r)
{
    if (isnan(r->error))
        return;
    if (!(r->error < 0.4))
        fail_msg("%s, %s, %g: ok and off by %g", p->problem, method, value, r->error);
    if (!(r->error <= 1e-7) && !(r->reported > r->error / 3 && r->reported < r->error * 3))
        fail_msg("%s, %s, %g: off by %g, reported is %g", p->problem, method, value, r->error, r->reported);
}

static void as_documented(const known *p, int k, int method, const refinement_level *refinement_levels)
{
    int first = 0;
    if (k >= (int)(sizeof longest / sizeof longest[0]))
        return;
    while (first < p->halvings && isnan(refinement_levels[first].error))
        first++;
    first = first == p->halvings ? -1 : first;
    if (first != longest[k][method].halved ||
        (first >= 0 && !(refinement_levels[first].error < longest[k][method].off)))
        fail_msg("%s, method %d: ok after %d halvings, off by %g", p->problem, method, first,
                 first < 0 ? NAN : refinement_levels[first].error);
}

static void steps_of_any_length_are_right_or_fail(void **state)
{
    (void)state;
    static const char *const methods[] = {"implicit_euler", "implicit_midpoint", "trapezoid"};
    int ok = 0, failed = 0;
    for (int k = 0; k < PROBLEMS; k++)
        for (int j = 0; j < 3; j++) {
            const known *p = &problems[k];
            double steps[RUNGS];
            refinement_level refinement_levels[RUNGS];
            for (int n = 0; n < p->halvings; n++)
                steps[n] = p->T / (2 << n);
            refinement_run(p, methods[j], "dt_s", steps, p->halvings, refinement_levels);
            double order = ll_ode_method_find(methods[j])->order;
            for (int n = 0; n < p->halvings; n++) {
                near_or_failed(p, methods[j], steps[n], &refinement_levels[n]);
                ok += !isnan(refinement_levels[n].error);
                failed += isnan(refinement_levels[n].error);
                /* A step that was short enough stays so, and half of it is not worse except for its sign. */
                const bool enough = n > 0 && refinement_levels[n - 1].error < 0.1;
                if (enough && !(refinement_levels[n].error < 2 * refinement_levels[n - 1].error + 1e-8))
                    fail_msg("%s, %s: %g at %g, %g at %g", p->problem, methods[j],
                             refinement_levels[n - 1].error, steps[n - 1], refinement_levels[n].error,
                             steps[n]);
            }
            as_documented(p, k, j, refinement_levels);
            const refinement_level *last = &refinement_levels[p->halvings - 1];
            double slope = log2(last[-2].error / last->error) / 2;
            if (!isnan(last->error) && !(last->error <= 1e-9) && !(fabs(slope - order) < 0.15))
                fail_msg("%s, %s: order %g at an error of %g", p->problem, methods[j], slope, last->error);
        }
    assert_true(ok > 100 && failed > 100);
}

static void tolerances_of_any_size_are_right_or_fail(void **state)
{
    (void)state;
    static const char *const methods[] = {"rodas4", "rodas5p", "radau5", "radau9", "radau13"};
    static const double tolerances[] = {0.1,  0.03, 0.01, 3e-3, 1e-3,  1e-4,  1e-5,  1e-6,
                                        1e-7, 3e-8, 1e-8, 1e-9, 3e-10, 1e-10, 1e-11, 1e-12};
    enum { COUNT = sizeof tolerances / sizeof tolerances[0] };
    for (int k = 0; k < PROBLEMS; k++)
        for (int j = 0; j < 5; j++) {
            refinement_level refinement_levels[COUNT];
            refinement_run(&problems[k], methods[j], "tolerance", tolerances, COUNT, refinement_levels);
            for (int n = 0; n < COUNT; n++) {
                near_or_failed(&problems[k], methods[j], tolerances[n], &refinement_levels[n]);
                if (!(tolerances[n] > 1e-6) && !(refinement_levels[n].error < 1e4 * tolerances[n]))
                    fail_msg("%s, %s at %g: %g", problems[k].problem, methods[j], tolerances[n],
                             refinement_levels[n].error);
            }
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steps_of_any_length_are_right_or_fail),
        cmocka_unit_test(tolerances_of_any_size_are_right_or_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
