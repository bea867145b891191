/* Large fluids stepped by one thread and by more: fluid_threads SCENE THREADS STEPS ROW=VALUE...
 *
 * Prints one line of JSON: the median wall time of a step by one thread and by THREADS, which step copies of
 * the same fluid in turn, and whether the states are the same at the end. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/hash.h"
#include "fluid/core/fluid.h"
#include "threads/team.h"

typedef struct tank {
    const ll_fluid_scene *scene;
    _Alignas(8) char params[LL_FLUID_PARAMS_MAX], solver[LL_FLUID_PARAMS_MAX];
    void *block;
    size_t size;
} tank;

static double wall_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static void must(ll_status status)
{
    if (!ll_failed(&status))
        return;
    fprintf(stderr, "fluid_threads: %s\n", status.text);
    exit(1);
}

/* `row`: `params.n=256`. */
static void set(tank *t, const char *row)
{
    char name[64];
    const char *value = strchr(row, '=');
    bool own = strncmp(row, "params.", 7) == 0;
    if (value == NULL || value - row >= (int)sizeof name || value - row < 8)
        must(ll_error(LL_BAD_INPUT, "%s is not params.ROW=VALUE or solver.ROW=VALUE", row));
    snprintf(name, sizeof name, "%.*s", (int)(value - row - 7), row + 7);
    must(ll_param_set(own ? t->scene->params : t->scene->solver, own ? t->params : t->solver, name, value + 1,
                      false));
}

static tank open_tank(const char *scene, int count, char **rows)
{
    tank t = {.scene = ll_fluid_scene_find(scene)};
    if (t.scene == NULL)
        must(ll_error(LL_BAD_INPUT, "%s is no scene", scene));
    ll_param_defaults(t.scene->params, t.params);
    ll_param_defaults(t.scene->solver, t.solver);
    for (int i = 0; i < count; i++)
        set(&t, rows[i]);
    must(t.scene->check(t.params, t.solver));
    t.size = t.scene->size(t.params, t.solver);
    t.block = aligned_alloc(64, (t.size + 63) & ~(size_t)63);
    if (t.block == NULL)
        abort();
    t.scene->init(t.block, t.params, t.solver);
    return t;
}

static uint64_t hash_of(const tank *t)
{
    return t->scene->method->hash ? t->scene->method->hash(t->block) : ll_hash(0, t->block, t->size);
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, ascending);
    return values[count / 2];
}

enum { FIRST_STEPS = 5, STEPS_MAX = 1000 };

int main(int argc, char **argv)
{
    static double times[2][STEPS_MAX];
    int threads = argc > 3 ? atoi(argv[2]) : 0, steps = argc > 3 ? atoi(argv[3]) : 0;
    if (threads < 1 || threads > LL_TEAM_PARTS_MAX || steps < 1 || steps > STEPS_MAX) {
        fprintf(stderr, "usage: fluid_threads SCENE THREADS STEPS [ROW=VALUE]...\n");
        return 2;
    }
    tank tanks[2];
    ll_team *team = NULL;
    must(ll_team_make(threads, &team));
    const ll_fluid_run runs[2] = {{0}, {.team = team}};
    for (int k = 0; k < 2; k++)
        tanks[k] = open_tank(argv[1], argc - 4, argv + 4);
    for (int i = -FIRST_STEPS; i < steps; i++)
        for (int k = 0; k < 2; k++) {
            double begin = wall_ms();
            must(tanks[k].scene->method->step(tanks[k].block, 1. / 60, &runs[k]));
            if (i >= 0)
                times[k][i] = wall_ms() - begin;
        }
    bool same = hash_of(&tanks[0]) == hash_of(&tanks[1]);
    double one = median(times[0], steps), more = median(times[1], steps);
    printf("{\"mib\": %zu, \"one_ms\": %.4g, \"more_ms\": %.4g, \"ratio\": %.4g, \"same\": %s}\n",
           tanks[0].size >> 20, one, more, one / more, same ? "true" : "false");
    ll_team_free(team);
    for (int k = 0; k < 2; k++)
        free(tanks[k].block);
    return 0;
}
