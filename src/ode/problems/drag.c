/* Quadratic drag. Vertical: v' = g - kd v |v|, s downwards; may start upwards. In the plane: a projectile, y
 * upwards, that comes to rest when it hits the ground. */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"
#include "ode/problems/special.h"

/* ---- vertical ---- */

typedef struct vertical {
    double g, kd, v0;
} vertical;

static const ll_param vertical_rows[] = {
    LL_ODE_PARAM(vertical, g, "m/s2", 0.01, 1000, 10, "Gravity."),
    LL_ODE_PARAM(vertical, kd, "1/m", 1e-6, 100, 1.0 / 128, "Drag: deceleration over speed squared."),
    LL_ODE_PARAM(vertical, v0, "m/s", -1000, 1000, 0, "Initial speed, downwards; negative: upwards."),
};
LL_ODE_TABLE(ll_ode_drag_vertical_table, "drag_vertical", "Parameters of the fall with drag.", vertical_rows,
             vertical);

LL_ODE_ACCELERATION(vertical_acceleration, 2, {
    const vertical *c = p;
    a[0] = c->g - c->kd * v[0] * ll_real_abs(v[0]);
})

static const struct ll_ode_kernels vertical_kernels = {LL_ODE_KERNELS(vertical_acceleration)};

static void vertical_series(const void *p, double t, int order, double *row)
{
    (void)t;
    const vertical *c = p;
    double v[LL_SERIES_TERMS];
    for (int k = 0; k < order; k++, row += 2) {
        v[k] = row[1];
        double square = 0;
        for (int j = 0; 2 * j < k; j++)
            square += v[j] * v[k - j];
        square *= 2;
        if (k % 2 == 0)
            square += v[k / 2] * v[k / 2];
        row[2] = v[k] * ll_series_inverse[k + 1];
        row[3] = ((k == 0 ? c->g : 0) - c->kd * square) * ll_series_inverse[k + 1];
    }
}

static void vertical_system(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 2,
                    .autonomous = true,
                    .velocity_dependent = true,
                    .params = p,
                    .acceleration = vertical_acceleration,
                    .series = ((const vertical *)p)->v0 >= 0 ? vertical_series : NULL, /* |v| is smooth */
                    .kernels = &vertical_kernels};
}

static void vertical_start(const void *p, double *y)
{
    y[0] = 0;
    y[1] = ((const vertical *)p)->v0;
}

/* Below the terminal speed vt: v = vt tanh, s = log cosh / kd. */
static void falling(const vertical *c, double t, double v0, double *s, double *v)
{
    double vt = ll_sqrt(c->g / c->kd), start = ll_ode_atanh(v0 / vt), now = start + c->g * t / vt;
    *s = (ll_ode_log_cosh(now) - ll_ode_log_cosh(start)) / c->kd;
    *v = vt * ll_ode_tanh(now);
}

static bool vertical_exact(const void *p, double t, double *y)
{
    const vertical *c = p;
    double vt = ll_sqrt(c->g / c->kd), s = 0;
    if (c->v0 >= vt)
        return false;
    if (c->v0 >= 0) {
        falling(c, t, c->v0, &y[0], &y[1]);
        return true;
    }
    double angle = ll_ode_atan(-c->v0 / vt), apex = angle * vt / c->g, left = angle - c->g * t / vt;
    if (t < apex) { /* upwards: v = -vt tan */
        y[0] = -ll_detmath_log(ll_cos(left) / ll_cos(angle)) / c->kd;
        y[1] = -vt * ll_sin(left) / ll_cos(left);
        return true;
    }
    falling(c, t - apex, 0, &s, &y[1]);
    y[0] = s + ll_detmath_log(ll_cos(angle)) / c->kd;
    return true;
}

static const char *const vertical_components[] = {"s_m", "v_mps"};

const ll_ode_problem ll_ode_drag_vertical = {.name = "drag_vertical",
                                             .help = "A fall with quadratic drag.",
                                             .source = "closed form",
                                             .params = &ll_ode_drag_vertical_table,
                                             .system = vertical_system,
                                             .duration = 4,
                                             .start = vertical_start,
                                             .components = vertical_components,
                                             .exact = vertical_exact};

/* ---- in the plane ---- */

typedef struct plane {
    double g, kd, vx0, vy0;
} plane;

static const ll_param plane_rows[] = {
    LL_ODE_PARAM(plane, g, "m/s2", 0.01, 1000, 10, "Gravity."),
    LL_ODE_PARAM(plane, kd, "1/m", 0, 100, 1.0 / 128,
                 "Drag: deceleration over speed squared; 0: a parabola."),
    LL_ODE_PARAM(plane, vx0, "m/s", -1000, 1000, 30, "Initial speed, forwards."),
    LL_ODE_PARAM(plane, vy0, "m/s", 0, 1000, 40, "Initial speed, upwards."),
};
LL_ODE_TABLE(ll_ode_drag_2d_table, "drag_2d", "Parameters of the projectile.", plane_rows, plane);

LL_ODE_ACCELERATION(plane_acceleration, 4, {
    const plane *c = p;
    real drag = c->kd * ll_real_sqrt(v[0] * v[0] + v[1] * v[1]);
    a[0] = -drag * v[0];
    a[1] = -c->g - drag * v[1];
})

static const struct ll_ode_kernels plane_kernels = {LL_ODE_KERNELS(plane_acceleration)};

static double height(const void *p, double t, const double *y)
{
    (void)p, (void)t;
    return y[1];
}

static ll_ode_action land(const void *p, double t, double *y)
{
    (void)p, (void)t;
    y[1] = 0;
    return LL_ODE_REST;
}

static const ll_ode_event impact = {.name = "impact", .direction = -1, .g = height, .jump = land};

/* The speed is the root of the sum of squares: 2 s_0 s_k = u_k - sum over 0 < j < k of s_j s_(k-j). */
static void plane_series(const void *p, double t, int order, double *row)
{
    (void)t;
    const plane *c = p;
    ll_term q[LL_SERIES_TERMS], v[LL_SERIES_TERMS], speed[LL_SERIES_TERMS];
    ll_series_take_plane(row, q, v);
    double s0 = ll_sqrt(v[0][0] * v[0][0] + v[0][1] * v[0][1]), over = 0.5 / s0;
    speed[0] = ll_term_of(s0);
    ll_series_move(q, v, (ll_term){0, -c->g} - c->kd * (speed[0] * v[0]), 0);
    for (int k = 1; k < order; k++) {
        ll_term squares = {0}, root = {0}, drag = {0};
        for (int j = 1; j < k; j++) {
            squares += v[j] * v[k - j];
            root += speed[j] * speed[k - j];
            drag += speed[j] * v[k - j];
        }
        squares += 2 * (v[0] * v[k]);
        speed[k] = ll_term_of((squares[0] + squares[1] - root[0]) * over);
        ll_series_move(q, v, -c->kd * (drag + ll_series_ends(speed, v, k)), k);
    }
    ll_series_put_plane(row, q, v, order);
}

static void plane_system(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 4,
                    .autonomous = true,
                    .velocity_dependent = true,
                    .params = p,
                    .acceleration = plane_acceleration,
                    .series = ((const plane *)p)->vx0 != 0 ? plane_series : NULL, /* never at rest: smooth */
                    .kernels = &plane_kernels,
                    .events = &impact,
                    .event_count = 1};
}

static void plane_start(const void *p, double *y)
{
    const plane *c = p;
    y[0] = y[1] = 0;
    y[2] = c->vx0;
    y[3] = c->vy0;
}

static bool parabola(const void *p, double t, double *y)
{
    const plane *c = p;
    if (c->kd != 0)
        return false;
    double land_t = 2 * c->vy0 / c->g, s = t < land_t ? t : land_t;
    y[0] = c->vx0 * s;
    y[1] = t < land_t ? (c->vy0 - c->g * s / 2) * s : 0;
    y[2] = c->vx0;
    y[3] = c->vy0 - c->g * s;
    return true;
}

static const double plane_reference[] = {77.4765955049512129, 39.1562624297932313, 13.9723273489021700,
                                         -11.4832542986015648};
static const char *const plane_components[] = {"x_m", "y_m", "vx_mps", "vy_mps"};

const ll_ode_problem ll_ode_drag_2d = {.name = "drag_2d",
                                       .help = "A projectile with quadratic drag; its impact is located.",
                                       .source = "binary128 extrapolation and collocation",
                                       .params = &ll_ode_drag_2d_table,
                                       .system = plane_system,
                                       .duration = 4,
                                       .start = plane_start,
                                       .components = plane_components,
                                       .exact = parabola,
                                       .reference = plane_reference,
                                       .floor = 1e-15};
