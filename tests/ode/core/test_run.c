/* The driver: time on a grid, events, sampling, snapshots, running backwards, what is refused and what is
 * reported. */
#include <math.h>
#include <stdio.h>

#include "ode/core/problem.h"
#include "ode/harness.h"
#include "support/near.h"

static const ll_ode oscillator = {
    .dim = 2, .acceleration = oscillator_a, .series = oscillator_series, .autonomous = true};
static const ll_ode fall = {.dim = 2, .acceleration = free_fall_a, .autonomous = true};
static const double circle[2] = {1, 0};

/* ---- input ---- */

static void refused(const char *method, const ll_ode *ode, ll_ode_control control, const char *field,
                    const char *says)
{
    static double block[1000];
    const ll_ode_method *m = ll_ode_method_find(method);
    assert_true(ll_ode_run_size(m, ode) <= sizeof block);
    ll_status status = ll_ode_start((ll_ode_run *)block, m, ode, &control, circle);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_string_equal(status.field, field);
    if (strstr(status.text, says) == NULL)
        fail_msg("`%s` does not say `%s`", status.text, says);
}

static void bad_input_is_refused_with_a_sentence(void **state)
{
    (void)state;
    assert_null(ll_ode_method_find("euler"));
    refused("rk4", &oscillator, (ll_ode_control){.t_end = 1, .dt = 0}, "dt", "above 0");
    refused("rk4", &oscillator, (ll_ode_control){.t_end = 1, .dt = -0.1}, "dt", "got -0.1");
    refused("rk4", &oscillator, (ll_ode_control){.t_end = 1, .dt = 2}, "dt", "at most the duration of 1 s");
    refused("rk4", &oscillator, (ll_ode_control){.t_end = 1, .dt = (double)NAN}, "dt", "above 0");
    refused("rk4", &oscillator, (ll_ode_control){.t_end = 1, .dt = 1e-12}, "dt", "limit of 100000000 steps");
    refused("rk4", &oscillator, (ll_ode_control){.t_end = 10, .dt = 0.1, .max_steps = 99}, "dt", "99 steps");
    refused("rk4", &oscillator, (ll_ode_control){.t_end = 0, .dt = 0.1}, "t_end", "differ from t0");
    refused("rk4", &oscillator, (ll_ode_control){.t_end = (double)INFINITY, .dt = 0.1}, "t_end", "finite");
    refused("dopri5", &oscillator, (ll_ode_control){.t_end = 1}, "tolerance", "1e-15 to 0.1");
    refused("dopri5", &oscillator, (ll_ode_control){.t_end = 1, .tolerance = 1e-17}, "tolerance", "1e-15");
    refused("dopri5", &oscillator, (ll_ode_control){.t_end = 1, .tolerance = 1e-6, .first_step = -1},
            "first_step", "at least 0");
    refused("dopri5", &oscillator, (ll_ode_control){.t_end = 1, .tolerance = 1e-6, .absolute = -1},
            "absolute", "at least 0");
    refused("dopri5", &oscillator, (ll_ode_control){.t_end = 1, .tolerance = 1e-6, .largest_step = -1},
            "largest_step", "at least 0");
    refused("boris", &oscillator, (ll_ode_control){.t_end = 1, .dt = 0.1}, "method", "magnetic force");
    const ll_ode first_order = {.dim = 2, .f = van_der_pol_f};
    refused("leapfrog_kdk", &first_order, (ll_ode_control){.t_end = 1, .dt = 0.1}, "method", "mechanical");
    double mu = 1;
    const ll_ode damped = {
        .dim = 2, .acceleration = damped_a, .velocity_dependent = true, .params = &mu, .autonomous = true};
    refused("taylor", &damped, (ll_ode_control){.t_end = 1, .tolerance = 1e-6}, "method",
            "gives Taylor coefficients");
    refused("extrapolated_leapfrog", &damped, (ll_ode_control){.t_end = 1, .tolerance = 1e-6}, "method",
            "independent of velocities");
}

/* ---- time ---- */

static void steps_are_whole_numbers(void **state)
{
    (void)state;
    ll_ode_control control = {.t0 = 1, .t_end = 101, .dt = 0.1};
    setting s = begin("leapfrog_kdk", &oscillator, circle, &control);
    int n = 0;
    for (; s.run->state == LL_ODE_RUNNING; n++) {
        assert_true(s.run->t == 1 + n * 0.1);
        step(&s);
    }
    assert_int_equal(n, 1000);
    assert_int_equal(s.run->counters.steps, 1000);
    end(&s);
    /* An end that is no multiple of dt is passed by less than a step. */
    control = (ll_ode_control){.t_end = 3, .dt = 0.033};
    setting paper = begin("semi_implicit_euler", &fall, (const double[]){0, 0}, &control);
    ll_ode_advance(paper.run, paper.method, paper.ode, 3);
    assert_int_equal(paper.run->counters.steps, 91);
    assert_near(ll_ode_y(paper.run)[0], 45.58554, 1e-5);
    assert_near(paper.run->t, 3.003, 1e-12);
    end(&paper);
}

/* Whole steps, a step of another length, and another time, in turns: whole steps are counted from the last
 * of these. */
static void steps_are_counted_from_where_time_was_set(void **state)
{
    (void)state;
    const double dt = 0.125; /* sums are exact */
    ll_ode_control control = {.t_end = 100, .dt = dt};
    setting s = begin("rk4", &oscillator, circle, &control);
    double t = 0;
    for (int round = 0; round < 5; round++) {
        for (int i = 0; i <= round; i++) {
            step(&s);
            assert_true(s.run->t == (t += dt));
        }
        ll_ode_step_by(s.run, s.method, s.ode, 0.0625);
        assert_true(s.run->t == (t += 0.0625));
        step(&s);
        assert_true(s.run->t == (t += dt));
        assert_near(ll_ode_y(s.run)[0], cos(t - 2 * round), 1e-3);
        ll_ode_set_time(s.run, t += 2);
    }
    end(&s);
}

static void adaptive_runs_end_exactly(void **state)
{
    (void)state;
    for (int i = 0; ll_ode_methods[i] != NULL; i++) {
        if (!ll_ode_methods[i]->adaptive)
            continue;
        for (int direction = -1; direction <= 1; direction += 2) {
            ll_ode_control control = {.t0 = 0.3, .t_end = 0.3 + direction * 7.7, .tolerance = 1e-9};
            setting s = begin(ll_ode_methods[i]->name, &oscillator, circle, &control);
            while (step(&s) == LL_ODE_RUNNING)
                ;
            double t = direction * 7.7;
            assert_int_equal(s.run->state, LL_ODE_FINISHED);
            assert_true(s.run->t == control.t_end);
            if (!(hypot(ll_ode_y(s.run)[0] - cos(t), ll_ode_y(s.run)[1] + sin(t)) < 1e-5))
                fail_msg("%s towards %g", ll_ode_methods[i]->name, control.t_end);
            end(&s);
        }
    }
}

/* Every method back from where it was, by steps of -dt: reversible ones to rounding. */
static void runs_go_backwards(void **state)
{
    (void)state;
    for (int i = 0; ll_ode_methods[i] != NULL; i++) {
        const ll_ode_method *m = ll_ode_methods[i];
        if (m->adaptive || (m->needs & LL_ODE_NEEDS_MAGNETIC) || m->order == 0)
            continue;
        double there[2];
        solve(m->name, &oscillator, circle, 3, 300, 0, there);
        ll_ode_control back = {.t0 = 3, .t_end = 0, .dt = 0.01};
        setting s = begin(m->name, &oscillator, there, &back);
        while (step(&s) == LL_ODE_RUNNING)
            ;
        double off = hypot(ll_ode_y(s.run)[0] - 1, ll_ode_y(s.run)[1]);
        if (!(off < (m->reversible ? 1e-12 : m->order == 1 ? 0.1 : 1e-3)))
            fail_msg("%s: off by %g", m->name, off);
        end(&s);
    }
}

static void a_snapshot_is_a_copy(void **state)
{
    (void)state;
    for (int i = 0; ll_ode_methods[i] != NULL; i++) {
        const ll_ode_method *m = ll_ode_methods[i];
        if (m->needs & LL_ODE_NEEDS_MAGNETIC)
            continue;
        ll_ode_control control = {.t_end = 5, .dt = 0.05, .tolerance = 1e-6};
        setting s = begin(m->name, &oscillator, circle, &control);
        for (int n = 0; n < 7; n++)
            step(&s);
        size_t size = ll_ode_run_size(m, &oscillator);
        setting copy = s;
        copy.run = malloc(size);
        memcpy(copy.run, s.run, size);
        while (step(&s) == LL_ODE_RUNNING)
            ;
        while (step(&copy) == LL_ODE_RUNNING)
            ;
        assert_memory_equal(s.run, copy.run, size);
        end(&s);
        end(&copy);
    }
}

/* ---- sampling ---- */

static void samples_lie_on_the_solution(void **state)
{
    (void)state;
    static const struct {
        const char *method;
        double tolerance, within;
    } known[] = {{"bs32", 1e-8, 1e-6},     {"dopri5", 1e-10, 1e-8}, {"tsit5", 1e-10, 1e-8},
                 {"dop853", 1e-12, 1e-10}, {"rodas4", 1e-8, 1e-5},  {"rodas5p", 1e-10, 1e-7},
                 {"radau5", 1e-11, 1e-7},  {"radau9", 1e-12, 1e-8}, {"radau13", 1e-13, 1e-9},
                 {"taylor", 1e-12, 1e-10}, {"rk4", 0, 1e-7},        {"leapfrog_kdk", 0, 1.8e-4}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        ll_ode_control control = {.t_end = 10, .dt = 0.02, .tolerance = known[i].tolerance};
        setting s = begin(known[i].method, &oscillator, circle, &control);
        double most = 0;
        for (int k = 1; k <= 997; k++) {
            double t = 10. * k / 997, y[2];
            ll_ode_advance(s.run, s.method, s.ode, t);
            ll_ode_sample(s.run, s.method, s.ode, t, y);
            most = larger(most, hypot(y[0] - cos(t), y[1] + sin(t)));
        }
        if (!(most < known[i].within))
            fail_msg("%s: off by %g", known[i].method, most);
        end(&s);
    }
}

/* The order of the dense output itself: the error in the middle of one step of h. */
static void dense_output_has_its_order(void **state)
{
    (void)state;
    static const struct {
        const char *method;
        double order; /* of the error of one step: one more than that of the polynomial */
    } known[] = {{"bs32", 4}, {"dopri5", 5}, {"tsit5", 5}, {"dop853", 8}, {"rk4", 4}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        double error[2];
        for (int k = 0; k < 2; k++) {
            double h = i == 3 ? 1.0 / (k + 1) : 0.25 / (k + 1), y[2], t = 0.4 * h;
            ll_ode_control control = {
                .t_end = 4, .dt = h, .tolerance = 0.1, .first_step = h, .largest_step = h};
            setting s = begin(known[i].method, &oscillator, circle, &control);
            step(&s);
            ll_ode_sample(s.run, s.method, s.ode, t, y);
            error[k] = hypot(y[0] - cos(t), y[1] + sin(t));
            end(&s);
        }
        double seen = log2(error[0] / error[1]);
        if (!(fabs(seen - known[i].order) < 0.35))
            fail_msg("%s: %.2f", known[i].method, seen);
    }
}

/* ---- variable steps ---- */

/* Free fall to 3 s by steps of 1/60 and 1/30 s in turns: figures of the reference page. */
static void variable_steps_and_verlet(void **state)
{
    (void)state;
    static const struct {
        const char *method;
        double place, within;
    } known[] = {{"stormer_verlet", 50, 1e-9},
                 {"verlet_time_corrected", 45.1667, 5e-5},
                 {"verlet_improved", 45, 4e-13},
                 {"velocity_verlet", 45, 1e-12}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        ll_ode_control control = {.t_end = 100, .dt = 1};
        setting s = begin(known[i].method, &fall, (const double[]){0, 0}, &control);
        for (int n = 0; n < 120; n++)
            ll_ode_step_by(s.run, s.method, s.ode, n % 2 ? 1. / 30 : 1. / 60);
        assert_near(s.run->t, 3, 1e-12);
        if (!(fabs(ll_ode_y(s.run)[0] - known[i].place) <= known[i].within))
            fail_msg("%s: %.12g", known[i].method, ll_ode_y(s.run)[0]);
        end(&s);
    }
}

/* ---- events ---- */

static double height(const void *params, double t, const double *y)
{
    (void)params, (void)t;
    return y[0];
}

static ll_ode_action bounce(const void *params, double t, double *y)
{
    (void)t;
    const double *p = params; /* restitution, least speed */
    y[0] = 0;
    y[1] *= -p[0];
    if (y[1] > p[1])
        return LL_ODE_GO_ON;
    y[1] = 0;
    return LL_ODE_REST;
}

static void ball_a(const void *params, double t, const double *q, const double *v, double *a)
{
    (void)params, (void)t, (void)q, (void)v;
    a[0] = -10;
}

static void impacts_are_located_by_every_method(void **state)
{
    (void)state;
    static const double params[2] = {0.9, 1e-3};
    static const ll_ode_event impact = {.name = "impact", .direction = -1, .g = height, .jump = bounce};
    const ll_ode ball = {.dim = 2,
                         .acceleration = ball_a,
                         .params = params,
                         .autonomous = true,
                         .events = &impact,
                         .event_count = 1};
    static const char *const exact[] = {"velocity_verlet",
                                        "leapfrog_kdk",
                                        "stormer_verlet",
                                        "rk4",
                                        "ab3",
                                        "dopri5",
                                        "dop853",
                                        "radau5",
                                        "rodas4",
                                        "implicit_midpoint",
                                        "extrapolated_leapfrog"};
    for (size_t i = 0; i < sizeof exact / sizeof exact[0]; i++) {
        ll_ode_control control = {.t_end = 12, .dt = 1. / 60, .tolerance = 1e-10};
        setting s = begin(exact[i], &ball, (const double[]){1, 0}, &control);
        double t1 = sqrt(0.2), want = t1;
        for (int n = 1; s.run->state == LL_ODE_RUNNING;) {
            step(&s);
            if (s.run->event < 0)
                continue;
            if (n <= 40 && !(fabs(s.run->event_t[0] - want) < 1e-11 * n))
                fail_msg("%s: impact %d at %.15g, not %.15g", exact[i], n, s.run->event_t[0], want);
            want += 2 * t1 * pow(0.9, n);
            n++;
        }
        assert_int_equal(s.run->state, LL_ODE_FINISHED);
        assert_true(s.run->at_rest && ll_ode_y(s.run)[0] == 0 && ll_ode_y(s.run)[1] == 0);
        assert_true(s.run->event_n[0] == s.run->counters.events);
        assert_in_range(s.run->event_n[0], 80, 84); /* 4.47 0.9^n < 1e-3 */
        assert_true(s.run->t >= 12 && s.run->t < 12 + 1. / 60);
        end(&s);
    }
}

/* Before the jump the curve is that of the fall, after it that of the bounce. */
static void samples_know_the_jump(void **state)
{
    (void)state;
    static const double params[2] = {1, 1e-3};
    static const ll_ode_event impact = {.name = "impact", .direction = -1, .g = height, .jump = bounce};
    const ll_ode ball = {.dim = 2,
                         .acceleration = ball_a,
                         .params = params,
                         .autonomous = true,
                         .events = &impact,
                         .event_count = 1};
    static const char *const methods[] = {"velocity_verlet", "dopri5",  "dop853",
                                          "radau5",          "rodas5p", "extrapolated_midpoint"};
    for (int i = 0; i < 6; i++) {
        ll_ode_control control = {.t_end = 4, .dt = 0.125, .tolerance = 1e-10};
        setting s = begin(methods[i], &ball, (const double[]){1, 0}, &control);
        double t1 = sqrt(0.2);
        for (int k = 1; k < 400; k++) {
            double t = 0.01 * k, y[2], u = fmod(t + t1, 2 * t1) - t1;
            ll_ode_advance(s.run, s.method, s.ode, t);
            ll_ode_sample(s.run, s.method, s.ode, t, y);
            if (!(fabs(y[0] - (1 - 5 * u * u)) < 1e-9 && fabs(y[1] + 10 * u) < 1e-9))
                fail_msg("%s at %g: %g, %g", methods[i], t, y[0], y[1]);
        }
        end(&s);
    }
}

static double first(const void *params, double t, const double *y)
{
    (void)params, (void)t;
    return y[0];
}

static double second(const void *params, double t, const double *y)
{
    (void)params, (void)t;
    return y[1];
}

/* Crossings that are only noted: cos t falls at pi/2 + 2 k pi, -sin t crosses zero at every k pi. */
static void crossings_are_noted_by_direction(void **state)
{
    (void)state;
    static const ll_ode_event events[2] = {{.name = "a", .direction = -1, .g = first},
                                           {.name = "b", .direction = 0, .g = second}};
    const ll_ode ode = {.dim = 2,
                        .acceleration = oscillator_a,
                        .series = oscillator_series,
                        .autonomous = true,
                        .events = events,
                        .event_count = 2};
    const double pi = 3.14159265358979323846;
    static const char *const methods[] = {"dop853", "dopri5", "radau9", "taylor"};
    for (int i = 0; i < 4; i++) {
        ll_ode_control control = {.t_end = 20.3, .tolerance = 1e-13, .largest_step = 1};
        setting s = begin(methods[i], &ode, circle, &control);
        while (s.run->state == LL_ODE_RUNNING) {
            step(&s);
            if (s.run->event >= 0) {
                double t = s.run->t, want = s.run->event == 0
                                                ? pi / 2 + 2 * pi * (double)(s.run->event_n[0] - 1)
                                                : pi * (double)s.run->event_n[1];
                if (!(fabs(t - want) < 1e-10))
                    fail_msg("%s: event %d at %.15g, not %.15g", methods[i], s.run->event, t, want);
            }
        }
        assert_int_equal(s.run->event_n[0], 3);
        assert_int_equal(s.run->event_n[1], 6);
        end(&s);
    }
}

/* ---- failures ---- */

static void explode_f(const void *params, double t, const double *y, double *dy)
{
    (void)params, (void)t;
    dy[0] = y[0] * y[0]; /* y = 1 / (1 - t) */
}

static void what_fails_is_reported(void **state)
{
    (void)state;
    const ll_ode explode = {.dim = 1, .f = explode_f, .autonomous = true};
    const double one = 1;
    for (int i = 0; ll_ode_methods[i] != NULL; i++) {
        const ll_ode_method *m = ll_ode_methods[i];
        if (m->needs != 0)
            continue;
        ll_ode_control control = {.t_end = 3, .dt = 1e-3, .tolerance = 1e-8, .max_steps = 1000000};
        setting s = begin(m->name, &explode, &one, &control);
        while (step(&s) == LL_ODE_RUNNING)
            ;
        char text[160];
        ll_ode_reason_text(s.run, text, sizeof text);
        /* An implicit step may find a solution on the other side of the pole. */
        if (s.run->state != LL_ODE_DIVERGED && !m->a_stable)
            fail_msg("%s went through a pole", m->name);
        if (s.run->state == LL_ODE_DIVERGED) {
            assert_true(s.run->failed_t > 0.99 && s.run->failed_t < 1.1);
            assert_non_null(strstr(text, " at t = "));
            assert_true(ll_ode_y(s.run)[0] - ll_ode_y(s.run)[0] == 0); /* of the last good step */
            assert_int_equal(step(&s), LL_ODE_DIVERGED);
        }
        end(&s);
    }
    ll_ode_control control = {.t_end = 1e6, .tolerance = 1e-6, .max_steps = 500};
    setting s = begin("dopri5", &oscillator, circle, &control);
    while (step(&s) == LL_ODE_RUNNING)
        ;
    assert_int_equal(s.run->reason, LL_ODE_STEP_LIMIT);
    assert_int_equal(s.run->counters.steps + s.run->counters.rejected, 500);
    end(&s);
}

/* ---- steps of changing length ---- */

static double length(bool random, int n, double mean)
{
    double share = random ? (double)((unsigned)n * 2654435761u % 1000u) / 999 - 0.5 : n % 3 - 1;
    return mean * (1 + 0.6 * share);
}

/* The error after about 7 s on a circle, by steps of lengths from 0.4 to 1.6 of the mean. */
static double error_by_changing_steps(const char *method, bool random, double mean)
{
    ll_ode_control control = {.t_end = 1000, .dt = mean};
    setting s = begin(method, &oscillator, circle, &control);
    double t = 0;
    for (int n = 0; t < 7; n++) {
        double h = length(random, n, mean);
        ll_ode_step_by(s.run, s.method, s.ode, h);
        t += h;
    }
    const double *y = ll_ode_y(s.run);
    double error = hypot(y[0] - cos(t), y[1] + sin(t));
    end(&s);
    return error;
}

static void adams_keeps_its_order_by_changing_steps(void **state)
{
    (void)state;
    static const struct {
        const char *method;
        double order, mean;
    } known[] = {{"ab2", 2, 0.01}, {"ab3", 3, 0.01}, {"ab4", 4, 0.02}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        for (int random = 0; random < 2; random++) {
            double coarse = error_by_changing_steps(known[i].method, random, known[i].mean);
            double fine = error_by_changing_steps(known[i].method, random, known[i].mean / 4);
            double order = log(coarse / fine) / log(4);
            if (!(fabs(order - known[i].order) < 0.2))
                fail_msg("%s: order %g by %s steps", known[i].method, order, random ? "random" : "changing");
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(adams_keeps_its_order_by_changing_steps),
        cmocka_unit_test(bad_input_is_refused_with_a_sentence),
        cmocka_unit_test(steps_are_whole_numbers),
        cmocka_unit_test(steps_are_counted_from_where_time_was_set),
        cmocka_unit_test(adaptive_runs_end_exactly),
        cmocka_unit_test(runs_go_backwards),
        cmocka_unit_test(a_snapshot_is_a_copy),
        cmocka_unit_test(samples_lie_on_the_solution),
        cmocka_unit_test(dense_output_has_its_order),
        cmocka_unit_test(variable_steps_and_verlet),
        cmocka_unit_test(impacts_are_located_by_every_method),
        cmocka_unit_test(samples_know_the_jump),
        cmocka_unit_test(crossings_are_noted_by_direction),
        cmocka_unit_test(what_fails_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
