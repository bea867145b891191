/* Tracing in vectors: every instruction set gives the bits of the same formulas value by value. */
#include "fluid/harness.h"

#include "fluid/grid/trace.h"

enum { N = 22, STRIDE = (N + 4) & ~1, CELLS = STRIDE * (N + 3) };

static double u[CELLS], v[CELLS], in[CELLS];

static double uniform(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(*state >> 11) / 9007199254740992.0;
}

/* ---- one value ---- */

static double inside_one(double x, double n, bool periodic)
{
    if (periodic) {
        if (x < 0 || x >= n) {
            x -= n * (double)(int64_t)(x / n);
            x = x < 0 ? x + n : x;
        }
        return x;
    }
    return x < 0 ? 0 : x > n ? n : x;
}

static double between_one(const double *f, double x, double y, int32_t *first)
{
    int64_t i = (int64_t)(x + 1), j = (int64_t)(y + 1), k = j * STRIDE + i;
    double a = x + 1 - (double)i, b = y + 1 - (double)j;
    *first = (int32_t)k;
    double low = f[k] + a * (f[k + 1] - f[k]);
    double high = f[k + STRIDE] + a * (f[k + STRIDE + 1] - f[k + STRIDE]);
    return low + b * (high - low);
}

static void velocity_one(const ll_grid_tracer *t, double x, double y, double out[2])
{
    int32_t ignored;
    x = inside_one(x, N, t->periodic_x);
    y = inside_one(y, N, t->periodic_y);
    out[0] = between_one(t->u, x, y - 0.5, &ignored);
    out[1] = between_one(t->v, x - 0.5, y, &ignored);
}

static double value_one(const ll_grid_tracer *t, int32_t i, int32_t j, int32_t *first)
{
    int64_t k = (int64_t)(j + 1) * STRIDE + i + 1;
    double shift[2] = {t->place == LL_PLACE_U ? 0 : 0.5, t->place == LL_PLACE_V ? 0 : 0.5};
    double x = i + shift[0], y = j + shift[1], s = t->scale, now[2], half[2], late[2], from[2];
    if (t->place == LL_PLACE_U) {
        now[0] = u[k];
        now[1] = 0.25 * (v[k - 1] + v[k] + v[k + STRIDE - 1] + v[k + STRIDE]);
    } else if (t->place == LL_PLACE_V) {
        now[0] = 0.25 * (u[k - STRIDE] + u[k + 1 - STRIDE] + u[k] + u[k + 1]);
        now[1] = v[k];
    } else {
        now[0] = 0.5 * (u[k] + u[k + 1]);
        now[1] = 0.5 * (v[k] + v[k + STRIDE]);
    }
    velocity_one(t, x - 0.5 * s * now[0], y - 0.5 * s * now[1], half);
    velocity_one(t, x - 0.75 * s * half[0], y - 0.75 * s * half[1], late);
    double place[2] = {x, y};
    for (int c = 0; c < 2; c++) {
        double along = t->order == 1   ? now[c]
                       : t->order == 2 ? half[c]
                                       : (2 * now[c] + 3 * half[c] + 4 * late[c]);
        from[c] = t->order == 3 ? place[c] - s * along / 9 : place[c] - s * along;
    }
    from[0] = inside_one(from[0], N, t->periodic_x) - shift[0];
    from[1] = inside_one(from[1], N, t->periodic_y) - shift[1];
    return between_one(in, from[0], from[1], first);
}

/* ---- comparison ---- */

static void compare(const ll_grid_tracing *by, const char *name, ll_grid_tracer t)
{
    static double out[CELLS];
    static int32_t donors[CELLS];
    t.out = out;
    t.donors = donors;
    for (int32_t j = t.span.j0; j < t.span.j1; j++) {
        by->trace(&t, j);
        for (int32_t i = t.span.i0; i < t.span.i1; i++) {
            int32_t first;
            int64_t k = (int64_t)(j + 1) * STRIDE + i + 1;
            double wanted = value_one(&t, i, j, &first);
            if (memcmp(&wanted, &out[k], sizeof wanted) != 0 || donors[k] != first)
                fail_msg("%s, place %d, order %d, periodic %d, scale %g: (%d, %d) is %.17g, not %.17g", name,
                         (int)t.place, (int)t.order, (int)t.periodic_x, t.scale, i, j, out[k], wanted);
        }
    }
}

static void every_set(ll_grid_tracer t)
{
    compare(&ll_grid_tracing_base, "base", t);
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2"))
        compare(&ll_grid_tracing_avx2, "avx2", t);
#endif
}

/* Slow flow, and flow that crosses the box more than once. Row lengths of 19 to 22 leave every rest of four.
 */
static void every_value_has_the_bits_of_the_scalar_formulas(void **state)
{
    (void)state;
    uint64_t seed = 7;
    const double scales[] = {0, 0.3, -0.3, 4, 90};
    for (int32_t k = 0; k < CELLS; k++) {
        u[k] = uniform(&seed) - 0.5;
        v[k] = uniform(&seed) - 0.5;
        in[k] = uniform(&seed);
    }
    for (int place = LL_PLACE_U; place <= LL_PLACE_CELL; place++)
        for (int order = 1; order <= 3; order++)
            for (int periodic = 0; periodic < 2; periodic++)
                for (size_t s = 0; s < sizeof scales / sizeof *scales; s++)
                    every_set((ll_grid_tracer){.u = u,
                                               .v = v,
                                               .stride = STRIDE,
                                               .nx = N,
                                               .ny = N,
                                               .periodic_x = periodic != 0,
                                               .periodic_y = periodic != 0,
                                               .place = (ll_grid_place)place,
                                               .order = order,
                                               .scale = scales[s],
                                               .in = in,
                                               .span = {(int32_t)s % 4, N, 1, N}});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_value_has_the_bits_of_the_scalar_formulas),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
