/* Systems for the tests of the integrators: as few lines as will do, with what is known of their solutions.
 */
#pragma once

#include <math.h>

#include "base/detmath.h"
#include "ode/core/ode.h"

static inline void free_fall_a(const void *params, double t, const double *q, const double *v, double *a)
{
    (void)params, (void)t, (void)q, (void)v;
    a[0] = 10;
}

static inline void oscillator_a(const void *params, double t, const double *q, const double *v, double *a)
{
    (void)params, (void)t, (void)v;
    a[0] = -q[0];
}

static inline void oscillator_series(const void *params, double t, int order, double *row)
{
    (void)params, (void)t;
    for (int k = 1; k <= order; k++, row += 2) {
        row[2] = row[1] / k;
        row[3] = -row[0] / k;
    }
}

/* x'' = -x - 2 zeta x'; params: zeta. */
static inline void damped_a(const void *params, double t, const double *q, const double *v, double *a)
{
    (void)t;
    a[0] = -q[0] - 2 * *(const double *)params * v[0];
}

static inline void forced_a(const void *params, double t, const double *q, const double *v, double *a)
{
    (void)params, (void)q, (void)v;
    a[0] = ll_cos(t);
}

static inline void pendulum_a(const void *params, double t, const double *q, const double *v, double *a)
{
    (void)params, (void)t, (void)v;
    a[0] = -10 * ll_sin(q[0]);
}

static inline void kepler_a(const void *params, double t, const double *q, const double *v, double *a)
{
    (void)params, (void)t, (void)v;
    double r2 = q[0] * q[0] + q[1] * q[1];
    double w = -1 / (r2 * sqrt(r2));
    a[0] = w * q[0];
    a[1] = w * q[1];
}

/* Free fall under gravity 10 with drag 1/128 |v| v. */
static inline void drag_2d_a(const void *params, double t, const double *q, const double *v, double *a)
{
    (void)params, (void)t, (void)q;
    double k = sqrt(v[0] * v[0] + v[1] * v[1]) / 128;
    a[0] = -k * v[0];
    a[1] = -10 - k * v[1];
}

static inline void lorentz_a(const void *params, double t, const double *q, const double *v, double *a)
{
    (void)params, (void)t, (void)q;
    a[0] = v[1];
    a[1] = -v[0];
}

static inline void lorentz_parts(const void *params, double t, const double *q, double *e, double *b)
{
    (void)params, (void)t, (void)q;
    e[0] = e[1] = 0;
    b[0] = b[1] = 0;
    b[2] = 1;
}

/* Two equal masses 1 on massless rods of length 1, gravity 10, angles from the vertical. */
static inline void double_pendulum_a(const void *params, double t, const double *q, const double *v,
                                     double *a)
{
    (void)params, (void)t;
    double d = q[0] - q[1], s = ll_sin(d), c = ll_cos(d), s1 = ll_sin(q[0]), s2 = ll_sin(q[1]);
    double det = 2 - c * c; /* of [2 c; c 1] */
    double f1 = -s * v[1] * v[1] - 20 * s1, f2 = s * v[0] * v[0] - 10 * s2;
    a[0] = (f1 - c * f2) / det;
    a[1] = (2 * f2 - c * f1) / det;
}

static inline void arenstorf_a(const void *params, double t, const double *q, const double *v, double *a)
{
    (void)params, (void)t;
    const double mu = 0.012277471, nu = 1 - mu;
    double x = q[0], y = q[1], xe = x + mu, xm = x - nu, y2 = y * y;
    double re = xe * xe + y2, rm = xm * xm + y2;
    double we = nu / (re * sqrt(re)), wm = mu / (rm * sqrt(rm));
    a[0] = x + 2 * v[1] - we * xe - wm * xm;
    a[1] = y - 2 * v[0] - we * y - wm * y;
}

/* Seven stars of masses 1 to 7 in the plane: q = (x1..x7, y1..y7). */
static inline void pleiades_a(const void *params, double t, const double *q, const double *v, double *a)
{
    (void)params, (void)t, (void)v;
    for (int i = 0; i < 14; i++)
        a[i] = 0;
    for (int i = 0; i < 7; i++)
        for (int j = 0; j < i; j++) {
            double dx = q[j] - q[i], dy = q[7 + j] - q[7 + i];
            double r2 = dx * dx + dy * dy, w = 1 / (r2 * sqrt(r2));
            dx *= w;
            dy *= w;
            a[i] += (j + 1) * dx;
            a[7 + i] += (j + 1) * dy;
            a[j] -= (i + 1) * dx;
            a[7 + j] -= (i + 1) * dy;
        }
}

static const double pleiades_y0[28] = {3, 3, -1, -3, 2, -2,   2,    3, -3, 2, 0,     0, -4, 4,
                                       0, 0, 0,  0,  0, 1.75, -1.5, 0, 0,  0, -1.25, 1, 0,  0};
static const double pleiades_y3[28] = {
    0.370613914397051290,  3.23728409205723309,   -3.22255903241832335,  0.659709145577530836,
    0.342558170715657979,  1.56217210140063102,   -0.700309292221249539, -3.94343758551739206,
    -3.27138097397254993,  5.22508184345654419,   -2.59061243497746951,  1.19821369339227464,
    -0.242968234493582341, 1.09144924042897975,   3.41700380631431475,   1.35458450162550122,
    -2.59006559781077542,  2.02505373471424111,   -1.15581510016044909,  -0.807298817022302173,
    0.595239635420871877,  -3.74124496123400847,  0.377345968575062904,  0.938685886955107889,
    0.366792222720056987,  -0.347404635380849437, 2.34491544818093692,   -1.94702043426329190};

/* y'' = mu (1 - y^2) y' - y; params: mu. */
static inline void van_der_pol_f(const void *params, double t, const double *y, double *dy)
{
    (void)t;
    double mu = *(const double *)params;
    dy[0] = y[1];
    dy[1] = mu * (1 - y[0] * y[0]) * y[1] - y[0];
}

static inline void van_der_pol_j(const void *params, double t, const double *y, double *j)
{
    (void)t;
    double mu = *(const double *)params;
    j[0] = 0;
    j[1] = 1;
    j[2] = -2 * mu * y[0] * y[1] - 1;
    j[3] = mu * (1 - y[0] * y[0]);
}

static inline void robertson_f(const void *params, double t, const double *y, double *dy)
{
    (void)params, (void)t;
    double r1 = 0.04 * y[0], r2 = 1e4 * y[1] * y[2], r3 = 3e7 * y[1] * y[1];
    dy[0] = -r1 + r2;
    dy[1] = r1 - r2 - r3;
    dy[2] = r3;
}

static inline void robertson_j(const void *params, double t, const double *y, double *j)
{
    (void)params, (void)t;
    double b = 1e4 * y[2], c = 1e4 * y[1], d = 6e7 * y[1];
    j[0] = -0.04, j[1] = b, j[2] = c;
    j[3] = 0.04, j[4] = -b - d, j[5] = -c;
    j[6] = 0, j[7] = d, j[8] = 0;
}

static inline void hires_f(const void *params, double t, const double *y, double *dy)
{
    (void)params, (void)t;
    dy[0] = -1.71 * y[0] + 0.43 * y[1] + 8.32 * y[2] + 0.0007;
    dy[1] = 1.71 * y[0] - 8.75 * y[1];
    dy[2] = -10.03 * y[2] + 0.43 * y[3] + 0.035 * y[4];
    dy[3] = 8.32 * y[1] + 1.71 * y[2] - 1.12 * y[3];
    dy[4] = -1.745 * y[4] + 0.43 * y[5] + 0.43 * y[6];
    dy[5] = -280 * y[5] * y[7] + 0.69 * y[3] + 1.71 * y[4] - 0.43 * y[5] + 0.69 * y[6];
    dy[6] = 280 * y[5] * y[7] - 1.81 * y[6];
    dy[7] = -dy[6];
}

/* The seventh as published by Hairer and Wanner: y7 + y8 stays 0.0057, which 2.84999838...e-3 would not give.
 */
static const double hires_y[8] = {0.000737131257332566781, 0.000144248572631618466, 0.0000588872974096757501,
                                  0.00117565134328314915,  0.00238635619883133047,  0.00623896825274279579,
                                  0.00284999839518576866,  0.00285000160481423134};
