/* A ball that bounces ever lower and comes to rest after infinitely many impacts in a finite time. */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"

typedef struct params {
    double g, h, e, rest_speed;
} params;

static const ll_param rows[] = {
    LL_ODE_PARAM(params, g, "m/s2", 0.01, 1000, 10, "Gravity."),
    LL_ODE_PARAM(params, h, "m", 1e-3, 1e4, 1, "Initial height."),
    LL_ODE_PARAM(params, e, NULL, 0, 1, 0.5, "Coefficient of restitution."),
    LL_ODE_PARAM(params, rest_speed, "m/s", 0, 1, 1e-9, "Rebound speed below which the ball rests."),
};
LL_ODE_TABLE(ll_ode_bouncing_ball_table, "bouncing_ball", "Parameters of the ball.", rows, params);

static void acceleration(const void *p, double t, const double *q, const double *v, double *a)
{
    (void)t, (void)q, (void)v;
    a[0] = -((const params *)p)->g;
}

static double height(const void *p, double t, const double *y)
{
    (void)p, (void)t;
    return y[0];
}

static ll_ode_action bounce(const void *p, double t, double *y)
{
    const params *c = p;
    (void)t;
    y[0] = 0;
    y[1] = -c->e * y[1];
    if (y[1] > c->rest_speed)
        return LL_ODE_GO_ON;
    y[1] = 0;
    return LL_ODE_REST;
}

static const ll_ode_event impact = {.name = "impact", .direction = -1, .g = height, .jump = bounce};

static void series(const void *p, double t, int order, double *row)
{
    (void)t;
    for (int k = 0; k < order; k++, row += 2) {
        row[2] = row[1] * ll_series_inverse[k + 1];
        row[3] = k == 0 ? -((const params *)p)->g : 0;
    }
}

static void system_of(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 2,
                    .autonomous = true,
                    .params = p,
                    .acceleration = acceleration,
                    .series = series,
                    .events = &impact,
                    .event_count = 1};
}

static void start(const void *p, double *y)
{
    y[0] = ((const params *)p)->h;
    y[1] = 0;
}

static bool exact(const void *p, double t, double *y)
{
    const params *c = p;
    double fall = ll_sqrt(2 * c->h / c->g), speed = c->g * fall;
    if (t < fall) {
        y[0] = c->h - c->g * t * t / 2;
        y[1] = -c->g * t;
        return true;
    }
    for (t -= fall, speed *= c->e; speed > c->rest_speed; speed *= c->e) {
        double flight = 2 * speed / c->g;
        if (t < flight) {
            y[0] = (speed - c->g * t / 2) * t;
            y[1] = speed - c->g * t;
            return true;
        }
        t -= flight;
    }
    y[0] = y[1] = 0;
    return true;
}

static const char *const components[] = {"y_m", "v_mps"};

const ll_ode_problem ll_ode_bouncing_ball = {.name = "bouncing_ball",
                                             .help = "A ball that bounces to rest; impacts are located.",
                                             .source = "closed form",
                                             .params = &ll_ode_bouncing_ball_table,
                                             .system = system_of,
                                             .duration = 2,
                                             .start = start,
                                             .components = components,
                                             .exact = exact};
