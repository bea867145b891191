/* Speed and accuracy of fluids: fluid speed ROUNDS | fluid places CASE METHOD ROUNDS | fluid accuracy
 *
 * Prints CSV. Speed: frames of 1/60 s of every case, by the process' CPU clock; the cases take turns.
 * Places: of the particles after each round. Accuracy: runs of particles that are too long
 * for tests. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fluid/core/fluid.h"
#include "fluid/ocean/ocean.h"
#include "fluid/particle/particle.h"

#define FRAME (1. / 60)

static double cpu_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static void must(ll_status status)
{
    if (!ll_failed(&status))
        return;
    fprintf(stderr, "fluid: %s\n", status.text);
    exit(1);
}

static void *block_of(size_t size)
{
    void *block = aligned_alloc(64, (size + 63) & ~(size_t)63);
    if (block == NULL)
        abort();
    return block;
}

/* ---- speed ---- */

typedef struct bench_case {
    const char *name, *method;
    int frames; /* in a round */
    void *(*open)(const struct bench_case *c);
    void (*frame)(void *block, int64_t number);
    const char *(*note)(void *block, char *text, size_t size); /* what the speed was bought with */
} bench_case;

static void *start(const ll_particle_setup *setup, const ll_particle_params *params)
{
    must(ll_particles_check(setup));
    return ll_particles_init(block_of(ll_particles_size(setup)), setup, params);
}

static void *open_particles(const bench_case *c)
{
    ll_particle_setup setup;
    ll_particle_params params;
    ll_particle_scene_setup(ll_particle_scene_named("pool"), 400, &setup, &params);
    must(ll_param_set(&ll_particle_table, &params, "method", c->method, false));
    if (params.method == LL_PARTICLE_DFSPH) {
        params.cfl = 0.4;
        params.iterations = 100;
        params.tolerance = 1e-3;
    }
    return start(&setup, &params);
}

/* As few iterations as the pool stays stable with: its compression compares with that of a peer that allows
 * much. */
static void *open_particles_coarse(const bench_case *c)
{
    ll_particle_setup setup;
    ll_particle_params params;
    ll_particle_scene_setup(ll_particle_scene_named("pool"), 400, &setup, &params);
    must(ll_param_set(&ll_particle_table, &params, "method", c->method, false));
    params.iterations = 2;
    return start(&setup, &params);
}

/* As large a tolerance and as few substeps as the pool stays stable with. */
static void *open_particles_tolerant(const bench_case *c)
{
    ll_particle_setup setup;
    ll_particle_params params;
    ll_particle_scene_setup(ll_particle_scene_named("pool"), 400, &setup, &params);
    must(ll_param_set(&ll_particle_table, &params, "method", c->method, false));
    params.cfl = 0.8;
    params.iterations = 100;
    params.tolerance = 5e-3;
    return start(&setup, &params);
}

static void step_particles(void *block, int64_t number)
{
    (void)number;
    must(ll_particles_step(block, FRAME));
}

static const char *note_particles(void *block, char *text, size_t size)
{
    ll_particle_metrics m = ll_particles_measure(block, 0);
    ll_particle_stats s = ll_particles_stats(block);
    snprintf(text, size, "%d particles; %.2f substeps a frame; compression mean %.2g max %.2g", s.fluid,
             (double)s.substeps / (double)s.tick, m.density_mean, m.density_max);
    return text;
}

static void *open_ocean(const bench_case *c)
{
    ll_ocean_setup setup;
    ll_param_defaults(&ll_ocean_table, &setup);
    setup.n = 512;
    setup.loop_s = 30;
    must(ll_param_set(&ll_ocean_table, &setup, "method", c->method, false));
    return ll_ocean_init(block_of(ll_ocean_size(&setup)), &setup);
}

static void step_ocean(void *block, int64_t number)
{
    ll_ocean_evaluate(block, ll_ms(1e3 * FRAME * (double)number));
}

static const char *note_ocean(void *block, char *text, size_t size)
{
    const ll_ocean_setup *s = ll_ocean_setup_of(block);
    long long n = s->n;
    if (s->method == LL_OCEAN_GERSTNER)
        snprintf(text, size, "%lld x %lld points; %lld waves", n, n, (long long)s->waves);
    else if (s->method == LL_OCEAN_TILED)
        snprintf(text, size, "%lld x %lld points; a tile of %lld in %lld frames", n, n, (long long)s->tile,
                 (long long)s->frames);
    else
        snprintf(text, size, "%lld x %lld points; as many waves", n, n);
    return text;
}

static void *open_smoke(const bench_case *c)
{
    static _Alignas(8) char params[LL_FLUID_PARAMS_MAX], solver[LL_FLUID_PARAMS_MAX];
    const ll_fluid_scene *scene = ll_fluid_scene_find("cylinder");
    (void)c;
    ll_param_defaults(scene->params, params);
    ll_param_defaults(scene->solver, solver);
    must(ll_param_set(scene->params, params, "n", "256", false));
    must(ll_param_set(scene->solver, solver, "tolerance", "1e-3", false));
    must(scene->check(params, solver));
    void *block = block_of(scene->size(params, solver));
    scene->init(block, params, solver);
    return block;
}

static void step_smoke(void *block, int64_t number)
{
    (void)number;
    must(ll_fluid_scene_find("cylinder")->method->step(block, FRAME, NULL));
}

static const char *note_smoke(void *block, char *text, size_t size)
{
    (void)block;
    snprintf(text, size, "256 x 256 cells; smoke past a cylinder; residual 1e-3");
    return text;
}

static const bench_case cases[] = {
    {"particles", "pbf", 60, open_particles, step_particles, note_particles},
    {"particles", "dfsph", 20, open_particles, step_particles, note_particles},
    {"particles by two iterations", "pbf", 60, open_particles_coarse, step_particles, note_particles},
    {"particles by a tolerance of 0.005", "dfsph", 20, open_particles_tolerant, step_particles,
     note_particles},
    {"ocean", "gerstner", 60, open_ocean, step_ocean, note_ocean},
    {"ocean", "spectrum", 20, open_ocean, step_ocean, note_ocean},
    {"ocean", "tiled", 60, open_ocean, step_ocean, note_ocean},
    {"smoke", "multigrid", 20, open_smoke, step_smoke, note_smoke},
};
enum { CASES = sizeof cases / sizeof cases[0] };
enum { FIRST_FRAMES = 20 }; /* until it moves */

static void speed(int rounds)
{
    void *block[CASES];
    int64_t number[CASES] = {0};
    for (int i = 0; i < CASES; i++) {
        block[i] = cases[i].open(&cases[i]);
        for (int k = 0; k < FIRST_FRAMES; k++)
            cases[i].frame(block[i], number[i]++);
    }
    puts("case,method,round,frames,cpu_s,note");
    for (int round = 0; round < rounds; round++)
        for (int i = 0; i < CASES; i++) {
            char text[160];
            double begin = cpu_now();
            for (int k = 0; k < cases[i].frames; k++)
                cases[i].frame(block[i], number[i]++);
            printf("%s,%s,%d,%d,%.6g,%s\n", cases[i].name, cases[i].method, round, cases[i].frames,
                   cpu_now() - begin, cases[i].note(block[i], text, sizeof text));
        }
    for (int i = 0; i < CASES; i++)
        free(block[i]);
}

/* ---- places ---- */

static void places(const char *name, const char *method, int rounds)
{
    const bench_case *c = cases;
    while (c < cases + CASES && (strcmp(c->method, method) != 0 || strcmp(c->name, name) != 0))
        c++;
    if (c == cases + CASES || c->note != note_particles) {
        fprintf(stderr, "fluid: %s, %s is no case of particles\n", name, method);
        exit(2);
    }
    void *block = c->open(c);
    puts("round,x,y");
    for (int i = 0; i < FIRST_FRAMES; i++)
        c->frame(block, i);
    for (int round = 0; round < rounds; round++) {
        for (int i = 0; i < c->frames; i++)
            c->frame(block, i);
        ll_particle_view v = ll_particles_view(block);
        for (int32_t i = 0; i < v.count; i++)
            printf("%d,%.9g,%.9g\n", round, v.x[i], v.y[i]);
    }
    free(block);
}

/* ---- accuracy ---- */

/* Martin and Moyce (1952), n^2 = 2: Z over T = n t sqrt(g / a); the gate took 0.175 to open. */
enum { FRONTS = 15 };
static const double front_time[FRONTS] = {.41,  .84,  1.19, 1.43, 1.63, 1.83, 1.98, 2.20,
                                          2.32, 2.51, 2.65, 2.83, 2.98, 3.11, 3.33};
static const double front_place[FRONTS] = {1.11, 1.22, 1.44, 1.67, 1.89, 2.11, 2.33, 2.56,
                                           2.78, 3.00, 3.22, 3.44, 3.67, 3.89, 4.11};

typedef struct run {
    const ll_particle_scene *scene;
    int method, size;
    double front_squares, front_max, ritter_max, density_max, pressure_squares;
    int fronts, late;
} run;

static void note_front(run *r, double before, double now, double t)
{
    double dt = r->scene->dt;
    for (int k = 0; k < FRONTS; k++) {
        double at = (front_time[k] - 0.175) / sqrt(2);
        if (at <= t - dt || at > t)
            continue;
        double error = (before + (at - t + dt) / dt * (now - before)) / front_place[k] - 1;
        r->front_squares += error * error;
        r->front_max = fmax(r->front_max, fabs(error));
        r->fronts++;
    }
    r->ritter_max = fmax(r->ritter_max, now / (1 + 2 * sqrt(2) * t));
}

/* Adds what pressure lacks to that of a column of height 1, by particle. */
static void add_errors(const ll_particles *p, double *sum)
{
    ll_particle_view v = ll_particles_view(p);
    for (int i = 0; i < v.count; i++)
        sum[v.id[i]] += v.pressure[i] - (1 - v.y[i]);
}

static double rms(const double *values, int count, double scale)
{
    double squares = 0;
    for (int i = 0; i < count; i++)
        squares += values[i] * values[i];
    return sqrt(squares / count) * scale;
}

static double poiseuille_rms(const ll_particles *p, double t)
{
    ll_particle_view view = ll_particles_view(p);
    double squares = 0;
    for (int i = 0; i < view.count; i++) {
        double y = view.y[i], u = 5 * y * (1 - y);
        for (int k = 1; k < 40; k += 2)
            u -= 40 / pow(M_PI * k, 3) * sin(k * M_PI * y) * exp(-0.1 * k * k * M_PI * M_PI * t);
        squares += (view.u[i] - u) * (view.u[i] - u);
    }
    return sqrt(squares / view.count) / 0.769190642828260;
}

static void print(const run *r, const char *quantity, double value, double cpu)
{
    printf("%s,%s,%d,%s,%.4g,%.3g\n", r->scene->name, ll_particle_method_names[r->method], r->size, quantity,
           value, cpu);
}

static void run_one(const char *name, int method, int size)
{
    run r = {.scene = ll_particle_scene_named(name), .method = method, .size = size};
    ll_particle_setup setup;
    ll_particle_params params;
    ll_particle_scene_setup(r.scene, size, &setup, &params);
    params.method = method;
    if (method == LL_PARTICLE_PBF)
        params.iterations = 10;
    must(ll_particles_check(&setup));
    ll_particles *p = ll_particles_init(block_of(ll_particles_size(&setup)), &setup, &params);
    int count = ll_particles_view(p).count;
    double *errors = calloc((size_t)count, sizeof *errors);
    if (errors == NULL)
        abort();
    double begin = cpu_now(), front = 1, dt = r.scene->dt, end = r.scene->duration;
    for (int i = 1; i * dt < end + dt / 2; i++) {
        must(ll_particles_step(p, dt));
        ll_particle_metrics m = ll_particles_measure(p, r.scene->depth);
        note_front(&r, front, m.front, i * dt);
        front = m.front;
        r.density_max = fmax(r.density_max, m.density_max);
        if (i * dt > end - 1) { /* the last second */
            r.pressure_squares += m.pressure_rms * m.pressure_rms;
            add_errors(p, errors);
            r.late++;
        }
    }
    double cpu = cpu_now() - begin;
    print(&r, "compression_max", r.density_max, cpu);
    if (strcmp(name, "dam_break") == 0) {
        print(&r, "front_rms", sqrt(r.front_squares / r.fronts), cpu);
        print(&r, "front_max", r.front_max, cpu);
        print(&r, "front_over_ritter_max", r.ritter_max, cpu);
    } else if (strcmp(name, "hydrostatic") == 0) {
        print(&r, "pressure_rms", sqrt(r.pressure_squares / r.late), cpu);
        print(&r, "pressure_of_mean_rms", rms(errors, count, 1. / r.late), cpu);
    } else
        print(&r, "velocity_rms", poiseuille_rms(p, end), cpu);
    free(errors);
    free(p);
}

static void accuracy(void)
{
    puts("scene,method,size,quantity,value,cpu_s");
    for (int method = 0; method < LL_PARTICLE_METHODS; method++) {
        for (int size = 20; size <= 40; size += 20) {
            run_one("dam_break", method, size);
            run_one("hydrostatic", method, size);
        }
        run_one("poiseuille", method, 32);
    }
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "accuracy") == 0)
        accuracy();
    else if (argc > 1 && strcmp(argv[1], "speed") == 0)
        speed(argc > 2 ? atoi(argv[2]) : 5);
    else if (argc == 5 && strcmp(argv[1], "places") == 0)
        places(argv[2], argv[3], atoi(argv[4]));
    else {
        fprintf(stderr, "usage: fluid speed ROUNDS | fluid places CASE METHOD ROUNDS | fluid accuracy\n");
        return 2;
    }
    return 0;
}
