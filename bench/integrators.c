/* Work against precision of laglab's adaptive methods, GSL's odeiv2, SUNDIALS and Boost.Odeint on one
 * problem:
 * integrators PROBLEM DURATION ROUNDS PER_DECADE [name=value]...
 *
 * Prints CSV, a line per method and tolerance. All call the same f and the same Jacobian. Preparation is
 * not timed: a run is from the start to the end, again and again. The methods take
 * turns, so that a change of the machine's load meets all of them. DURATION 0 is the problem's own. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "integrators/solver.h"
#include "ode/core/problem.h"
#include "ode/core/run.h"

enum { ROUNDS_MAX = 32, DECADES = 13, FAILURES_MAX = 3 };

#define BLOCK_S 2e-3 /* runs are timed in blocks of at least so long: reading the clock costs too */
/* A run of more is not repeated, and tighter tolerances are left out; also after FAILURES_MAX tolerances in a
 * row that met the limit of steps (a loose one may meet it alone, on an orbit that escapes). */
#define LONG_S 0.05

/* One method at one tolerance. */
typedef struct refinement_level {
    const solver *solver;
    void *state;
    bool ok;
    double error;
    counts counts;
    int block, timed; /* runs in a block, 0: the first is enough; blocks */
    double cpu_s[ROUNDS_MAX];
} refinement_level;

static double cpu_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static void check(ll_status status)
{
    if (ll_failed(&status)) {
        fprintf(stderr, "integrators: %s\n", status.text);
        exit(2);
    }
}

static const ll_ode_problem *find_problem(const char *name, int settings, char **setting, void *params)
{
    const ll_ode_problem *problem = ll_ode_problem_find(name);
    if (problem == NULL)
        check(ll_error(LL_BAD_INPUT, "there is no problem %s", name));
    ll_param_defaults(problem->params, params);
    for (int i = 0; i < settings; i++) {
        char path[64];
        const char *value = strchr(setting[i], '=');
        if (value == NULL)
            check(ll_error(LL_BAD_INPUT, "name=value is wanted, not %s", setting[i]));
        snprintf(path, sizeof path, "%.*s", (int)(value - setting[i]), setting[i]);
        check(ll_param_set(problem->params, params, path, value + 1, false));
    }
    if (problem->prepare != NULL)
        problem->prepare(params);
    return problem;
}

/* The distance from the solution over its size, both Euclidean. */
static double relative_error(const double *y, const double *solution, int dim)
{
    double distance = 0, size = 0;
    for (int i = 0; i < dim; i++) {
        distance += (y[i] - solution[i]) * (y[i] - solution[i]);
        size += solution[i] * solution[i];
    }
    return sqrt(distance / size);
}

/* laglab's, by the first two derivatives (Hairer, Norsett and Wanner I, section II.4). */
static double first_step(const task *t)
{
    const ll_ode_method *method = ll_ode_method_find("dopri5");
    ll_ode_control control = {.t_end = t->duration, .tolerance = t->relative, .absolute = t->absolute};
    ll_ode_run *run = malloc(ll_ode_run_size(method, &t->ode));
    check(ll_ode_start(run, method, &t->ode, &control, t->start));
    double h = run->h;
    free(run);
    return h;
}

/* The first run of a refinement level: it warms the caches, and gives error, counts and how many runs make a
 * block. */
static void try_refinement_level(refinement_level *r, const task *t, const double *solution)
{
    double y[LL_ODE_DIM_MAX], begin = cpu_now();
    r->ok = r->solver->run(r->state, y);
    double spent = cpu_now() - begin;
    r->counts = r->solver->count(r->state);
    r->error = r->ok ? relative_error(y, solution, t->ode.dim) : NAN;
    r->cpu_s[0] = spent;
    if (r->ok && spent <= LONG_S)
        r->block = (int)ceil(BLOCK_S / fmax(spent, 1e-7));
    else
        r->timed = 1;
}

static void time_block(refinement_level *r)
{
    double y[LL_ODE_DIM_MAX], begin = cpu_now();
    for (int i = 0; i < r->block; i++)
        r->solver->run(r->state, y);
    r->cpu_s[r->timed++] = (cpu_now() - begin) / r->block;
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void print_refinement_level(refinement_level *r, double tolerance)
{
    qsort(r->cpu_s, (size_t)r->timed, sizeof r->cpu_s[0], by_size);
    printf("%s,%s,%.3g,%s,", r->solver->library, r->solver->method, tolerance, r->ok ? "ok" : "failed");
    printf(r->ok ? "%.6g" : "", r->error);
    printf(",%.6g,%.6g,%d,%" PRId64 ",%" PRId64 ",%" PRId64 "\n", r->cpu_s[0], r->cpu_s[r->timed / 2],
           r->timed * (r->block > 0 ? r->block : 1), r->counts.steps, r->counts.evaluations,
           r->counts.jacobians);
}

/* All methods at one tolerance. `failures` in a row are kept from level to level; those with FAILURES_MAX are
 * left out. */
static void measure(const solver *solvers, int count, int *failures, const task *t, const double *solution,
                    int rounds)
{
    refinement_level refinement_levels[SOLVERS_MAX];
    int n = 0;
    for (int i = 0; i < count; i++) {
        void *state = failures[i] < FAILURES_MAX ? solvers[i].open(&solvers[i], t) : NULL;
        if (state == NULL)
            continue;
        refinement_level *r = &refinement_levels[n++];
        *r = (refinement_level){.solver = &solvers[i], .state = state};
        try_refinement_level(r, t, solution);
        bool out_of_steps = !r->ok && r->counts.steps > SOLVER_STEPS_MAX / 2;
        failures[i] = r->ok && r->cpu_s[0] > LONG_S ? FAILURES_MAX : out_of_steps ? failures[i] + 1 : 0;
    }
    for (int round = 0; round < rounds; round++)
        for (int i = 0; i < n; i++)
            if (refinement_levels[i].block > 0)
                time_block(&refinement_levels[i]);
    for (int i = 0; i < n; i++) {
        print_refinement_level(&refinement_levels[i], t->relative);
        refinement_levels[i].solver->close(refinement_levels[i].state);
    }
    fflush(stdout);
}

int main(int argc, char **argv)
{
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    if (argc < 5)
        check(ll_error(LL_BAD_INPUT, "PROBLEM DURATION ROUNDS PER_DECADE [name=value]... are wanted"));
    const ll_ode_problem *problem = find_problem(argv[1], argc - 5, argv + 5, params);
    int rounds = atoi(argv[3]), per_decade = atoi(argv[4]);
    if (rounds < 1 || rounds > ROUNDS_MAX - 1 || per_decade < 1)
        check(ll_error(LL_BAD_INPUT, "1 to %d rounds and at least one level per decade are required",
                       ROUNDS_MAX - 1));

    task t = {.duration = atof(argv[2]) > 0 ? atof(argv[2]) : problem->duration};
    problem->system(params, &t.ode);
    t.ode.event_count = 0; /* the others look for none */
    problem->start(params, t.start);
    double solution[LL_ODE_DIM_MAX];
    if (problem->exact == NULL || !problem->exact(params, t.duration, solution)) {
        if (problem->reference == NULL || t.duration != problem->duration)
            check(ll_error(LL_BAD_INPUT, "no solution of %s is known at %g s", argv[1], t.duration));
        memcpy(solution, problem->reference, (size_t)t.ode.dim * sizeof *solution);
    }

    solver solvers[SOLVERS_MAX];
    int count = laglab_solvers(solvers, 0);
    count = gsl_solvers(solvers, count);
    count = sundials_solvers(solvers, count);
#ifdef HAVE_ODEINT
    count = odeint_solvers(solvers, count);
#endif
    int failures[SOLVERS_MAX];
    for (int i = 0; i < count; i++)
        failures[i] = solvers[i].newton && t.ode.jacobian == NULL ? FAILURES_MAX : 0;

    puts("library,method,tolerance,status,error,cpu_min_s,cpu_median_s,runs,steps,evaluations,jacobians");
    for (int k = per_decade; k <= DECADES * per_decade; k++) {
        t.relative = pow(10, -(double)k / per_decade);
        t.absolute = problem->stiff ? 1e-3 * t.relative : t.relative;
        t.first_step = first_step(&t);
        measure(solvers, count, failures, &t, solution, rounds);
    }
    return 0;
}
