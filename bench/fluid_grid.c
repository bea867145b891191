/* Fluids on a grid, measured: fluid_grid pressure|transform|frames|cavity|vortices|rotation [quick]
 *
 * Prints CSV. Times are of the process' CPU clock, the least of a few runs. With FFTW at hand `transform`
 * also times FFTW's transform. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#ifdef HAVE_FFTW
#include <fftw3.h>
#endif

#include "base/rng.h"
#include "fluid/core/fft.h"
#include "fluid/core/fluid.h"
#include "fluid/pressure/poisson.h"

static double cpu_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static double lesser(double a, double b)
{
    return a < b ? a : b;
}

/* ---- the pressure equation alone ---- */

static void solve_box(ll_pressure_kind kind, int n, bool disc)
{
    ll_poisson p = {.nx = n, .ny = n, .stride = (n + 4) & ~1, .tolerance = 1e-6, .sweeps_max = 100000};
    size_t cells = (size_t)p.stride * (size_t)(n + 3);
    double *fields = calloc(5 * cells, sizeof *fields), best = INFINITY;
    uint8_t *fluid = malloc(cells);
    p.x = fields;
    p.b = fields + cells;
    p.work = malloc(ll_pressure_work_size(n, n));
    memset(fluid, 1, cells);
    for (int j = 0; disc && j < n; j++)
        for (int i = 0; i < n; i++)
            fluid[ll_cell(&p, i, j)] = hypot((i + 0.5) / n - 0.4, (j + 0.5) / n - 0.5) > 0.14;
    ll_poisson_open(&p, fluid, fields + 2 * cells, fields + 3 * cells, fields + 4 * cells);
    if (kind == LL_PRESSURE_JACOBI)
        p.relaxation = 0.9;
    for (int round = 0; round < 3; round++) {
        memset(p.x, 0, cells * sizeof *p.x);
        for (int j = 0; j < n; j++)
            for (int i = 0; i < n; i++)
                p.b[ll_cell(&p, i, j)] = ll_rng_unit(1, 2, (uint64_t)(j * n + i)) - 0.5;
        ll_pressure_prepare(kind, &p);
        double begin = cpu_now();
        ll_pressure_solve(kind, &p);
        best = lesser(best, cpu_now() - begin);
    }
    printf("%s,%s,%d,%lld,%.4g,%.2g\n", disc ? "disc" : "empty", ll_pressure_names[kind], n,
           (long long)p.sweeps, best * 1e3, p.residual / p.source);
    fflush(stdout);
    free(fields);
    free(fluid);
    free(p.work);
}

static void pressure(bool quick)
{
    static const int largest[LL_PRESSURES] = {64, 128, 256, 512, 1024, 1024};
    puts("box,solver,n,sweeps,cpu_ms,residual");
    for (int disc = 0; disc < 2; disc++)
        for (int kind = 0; kind < LL_PRESSURES; kind++)
            for (int n = 64; n <= largest[kind] / (quick ? 2 : 1); n *= 2)
                if (!disc || !ll_pressure_solvers[kind]->direct)
                    solve_box((ll_pressure_kind)kind, n, disc != 0);
}

/* ---- cosine transforms there and back ---- */

static double own_transform(int n, double *data, double *work)
{
    ll_fft *plan = malloc(ll_fft_size(n));
    ll_fft_init(plan, n);
    double begin = cpu_now();
    ll_dct_run_2d(plan, plan, data, work, LL_FFT_FORWARD, NULL);
    ll_dct_run_2d(plan, plan, data, work, LL_FFT_INVERSE, NULL);
    double time = cpu_now() - begin;
    free(plan);
    return time;
}

#ifdef HAVE_FFTW
static double peer_transform(int n, double *data, unsigned effort)
{
    fftw_plan there = fftw_plan_r2r_2d(n, n, data, data, FFTW_REDFT10, FFTW_REDFT10, effort);
    fftw_plan back = fftw_plan_r2r_2d(n, n, data, data, FFTW_REDFT01, FFTW_REDFT01, effort);
    double begin = cpu_now();
    fftw_execute(there);
    fftw_execute(back);
    double time = cpu_now() - begin;
    fftw_destroy_plan(there);
    fftw_destroy_plan(back);
    return time;
}
#endif

static void fill(double *data, int n)
{
    for (int i = 0; i < n * n; i++)
        data[i] = ll_rng_unit(3, 4, (uint64_t)i) - 0.5;
}

static void transform(bool quick)
{
    puts("library,n,cpu_ms");
    for (int n = 64; n <= (quick ? 256 : 1024); n *= 2) {
        double *data = malloc((size_t)(n * n) * sizeof *data), *work = malloc((size_t)(n * n) * sizeof *work);
        double best[3] = {INFINITY, INFINITY, INFINITY};
        for (int round = 0; round < 7; round++) {
            fill(data, n);
            best[0] = lesser(best[0], own_transform(n, data, work));
#ifdef HAVE_FFTW
            best[1] = lesser(best[1], peer_transform(n, data, FFTW_ESTIMATE));
            best[2] = lesser(best[2], peer_transform(n, data, FFTW_MEASURE));
#endif
        }
        static const char *const names[] = {"laglab", "FFTW estimated plan", "FFTW measured plan"};
        for (int i = 0; i < 3; i++)
            if (best[i] < INFINITY)
                printf("%s,%d,%.4g\n", names[i], n, best[i] * 1e3);
        fflush(stdout);
        free(data);
        free(work);
    }
}

/* ---- scenes ---- */

typedef struct run {
    ll_fluid_number numbers[LL_FLUID_NUMBERS_MAX];
    int count;
    double cpu_s;
} run;

/* `settings`: `params.n=32 solver.pressure=direct`, parted by spaces. */
static run run_scene(const char *name, const char *settings, int steps, double dt)
{
    static _Alignas(8) char params[LL_FLUID_PARAMS_MAX], solver[LL_FLUID_PARAMS_MAX];
    const ll_fluid_scene *scene = ll_fluid_scene_find(name);
    char text[300];
    run r = {.count = 0};
    ll_status status = ll_ok();
    ll_param_defaults(scene->params, params);
    ll_param_defaults(scene->solver, solver);
    snprintf(text, sizeof text, "%s", settings);
    for (char *word = strtok(text, " "); word && !ll_failed(&status); word = strtok(NULL, " ")) {
        char *value = strchr(word, '=');
        *value++ = '\0';
        bool own = strncmp(word, "params.", 7) == 0;
        status =
            ll_param_set(own ? scene->params : scene->solver, own ? params : solver, word + 7, value, false);
    }
    if (!ll_failed(&status))
        status = scene->check(params, solver);
    void *block = ll_failed(&status) ? NULL : malloc(scene->size(params, solver));
    if (block) {
        scene->init(block, params, solver);
        double begin = cpu_now();
        for (int i = 0; i < steps && !ll_failed(&status); i++)
            status = scene->method->step(block, dt, NULL);
        r.cpu_s = cpu_now() - begin;
        r.count = scene->method->numbers(block, r.numbers);
        if (scene->numbers)
            r.count += scene->numbers(block, r.numbers + r.count);
        free(block);
    }
    if (ll_failed(&status)) {
        fprintf(stderr, "%s %s: %s\n", name, settings, status.text);
        exit(1);
    }
    return r;
}

static double number(const run *r, const char *name)
{
    for (int i = 0; i < r->count; i++)
        if (strcmp(r->numbers[i].name, name) == 0)
            return r->numbers[i].value;
    return NAN;
}

static void frames(bool quick)
{
    static const char *const settings[] = {
        "",
        "solver.advection=semi_lagrangian",
        "solver.advection=bfecc",
        "solver.splitting=reflection",
        "solver.pressure=pcg",
        "solver.pressure=jacobi solver.tolerance=0 solver.sweeps=20",
        "solver.pressure=jacobi solver.tolerance=0 solver.sweeps=40",
        "solver.pressure=gauss_seidel solver.tolerance=0 solver.sweeps=20",
    };
    puts("n,settings,ms_per_frame,frames_per_s,residual,divergence_max_per_s,sweeps_mean");
    for (int n = 128; n <= (quick ? 256 : 512); n *= 2)
        for (size_t i = 0; i < sizeof settings / sizeof settings[0]; i++) {
            char all[200];
            int steps = quick ? 60 : 300;
            snprintf(all, sizeof all, "params.n=%d %s", n, settings[i]);
            run r = run_scene("cylinder", all, steps, 1.0 / 60);
            printf("%d,%s,%.4g,%.4g,%.2g,%.2g,%.3g\n", n, settings[i][0] ? settings[i] : "as it is",
                   r.cpu_s / steps * 1e3, steps / r.cpu_s, number(&r, "residual"),
                   number(&r, "divergence_max"), number(&r, "sweeps_mean"));
            fflush(stdout);
        }
}

static void cavity(bool quick)
{
    static const int re[2] = {100, 1000}, seconds[2] = {30, 150};
    puts("re,n,seconds,error_max,ghia_error_max,order,cpu_s");
    for (int i = 0; i < 2; i++) {
        double before = NAN;
        for (int n = 16; n <= (quick ? 64 : 128); n *= 2) {
            char all[100];
            snprintf(all, sizeof all, "params.re=%d params.n=%d", re[i], n);
            run r = run_scene("cavity", all, seconds[i] * 20, 0.05);
            double error = number(&r, "error_max");
            printf("%d,%d,%d,%.3g,%.3g,%.2f,%.3g\n", re[i], n, seconds[i], error,
                   number(&r, "ghia_error_max"), log2(before / error), r.cpu_s);
            fflush(stdout);
            before = error;
        }
    }
}

static void vortices(bool quick)
{
    static const char *const settings[] = {
        "solver.advection=semi_lagrangian",
        "solver.advection=maccormack",
        "solver.advection=bfecc",
        "solver.advection=semi_lagrangian solver.splitting=reflection",
        "solver.advection=maccormack solver.splitting=reflection",
        "solver.advection=bfecc solver.splitting=reflection",
        "solver.advection=central",
    };
    puts("n,viscosity_m2ps,settings,error_l2,decay_error,numerical_viscosity_m2ps,cpu_s");
    for (int viscous = 0; viscous < 2; viscous++)
        for (size_t i = 0; i < sizeof settings / sizeof settings[0]; i++)
            for (int n = 32; n <= (quick ? 64 : 128); n *= 2) {
                char all[200];
                double dt = acos(-1) / n; /* the mean flow goes half a cell a step */
                snprintf(all, sizeof all, "params.n=%d params.viscosity_m2ps=%g solver.substeps=1 %s", n,
                         0.01 * viscous, settings[i]);
                run r = run_scene("taylor_green", all, (int)(5 / dt + 0.5), dt);
                printf("%d,%g,%s,%.3g,%.3g,%.3g,%.3g\n", n, 0.01 * viscous, settings[i],
                       number(&r, "error_l2"), number(&r, "decay_error"),
                       number(&r, "numerical_viscosity_m2ps"), r.cpu_s);
                fflush(stdout);
            }
}

static void rotation(bool quick)
{
    static const char *const shapes[] = {"gaussian", "slotted_disc"};
    static const char *const schemes[] = {"semi_lagrangian", "maccormack", "bfecc", "central"};
    puts("shape,advection,n,error_l1,mass_change,least,most,cpu_s");
    for (int s = 0; s < 2; s++)
        for (int a = 0; a < 4; a++)
            for (int n = 64; n <= (quick ? 128 : 256); n *= 2) {
                char all[200];
                snprintf(all, sizeof all, "params.n=%d params.shape=%s solver.advection=%s solver.cfl=2", n,
                         shapes[s], schemes[a]);
                run r = run_scene("rotation", all, 4 * n, 0.25 / n);
                printf("%s,%s,%d,%.3g,%.3g,%.3g,%.3g,%.3g\n", shapes[s], schemes[a], n,
                       number(&r, "error_l1"), number(&r, "mass_change"), number(&r, "dye_min"),
                       number(&r, "dye_max"), r.cpu_s);
                fflush(stdout);
            }
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        void (*measure)(bool quick);
    } parts[] = {{"pressure", pressure}, {"transform", transform}, {"frames", frames},
                 {"cavity", cavity},     {"vortices", vortices},   {"rotation", rotation}};
    bool quick = argc > 2 && strcmp(argv[2], "quick") == 0;
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++)
        if (argc > 1 && strcmp(argv[1], parts[i].name) == 0) {
            parts[i].measure(quick);
            return 0;
        }
    fputs("fluid_grid pressure|transform|frames|cavity|vortices|rotation [quick]\n", stderr);
    return 2;
}
