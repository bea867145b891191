#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rigid/engine.h"

static int settings;
static char **setting;

static double set(const char *name, double standard)
{
    size_t length = strlen(name);
    for (int i = 0; i < settings; i++)
        if (strncmp(setting[i], name, length) == 0 && setting[i][length] == '=')
            return atof(setting[i] + length + 1);
    return standard;
}

/* s: of this thread, or with the setting `wall` of the clock. */
static double now(void)
{
    struct timespec t;
    if (set("wall", 0) == 0)
        return cpu_now();
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void happen(const engine *e, void *state, const bench_event *event, bool *gone)
{
    for (int i = 0; i < event->removed_count; i++) {
        e->remove_body(state, event->removed[i]);
        gone[event->removed[i]] = true;
    }
    for (int i = 0; i < event->body_count; i++)
        e->add_body(state, &event->bodies[i]);
    for (int i = 0; i < event->joint_count; i++)
        e->add_joint(state, &event->joints[i]);
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Where the dynamic bodies of the beginning that are still there are at the end against where they were. */
static void print_change(const engine *e, void *state, const bench_event *first, const bool *gone)
{
    double sag = 0, drift = 0, tilt = 0, top = -INFINITY, top_y = 0, lowest = INFINITY;
    for (int i = 0; i < first->body_count; i++) {
        const bench_body *b = &first->bodies[i];
        double pose[3];
        if (b->type != 2 || gone[i])
            continue;
        e->get(state, i, pose);
        sag = fmax(sag, b->y - pose[1]);
        drift = fmax(drift, fabs(pose[0] - b->x));
        tilt = fmax(tilt, fabs(remainder(pose[2] - b->angle, 2 * 3.14159265358979)));
        lowest = fmin(lowest, pose[1]);
        if (b->y > top) {
            top = b->y;
            top_y = pose[1];
        }
        if (!isfinite(pose[0] + pose[1] + pose[2]))
            sag = drift = tilt = 1e9;
    }
    printf("\"sag\":%.6g,\"drift\":%.6g,\"tilt\":%.6g,\"top_sag\":%.6g,\"top_y\":%.9g,\"lowest\":%.6g}\n",
           sag, drift, tilt, isfinite(top) ? top - top_y : 0, top_y, isfinite(lowest) ? lowest : 0);
}

int run_engine(const engine *e, int argc, char **argv)
{
    if (argc < 4) {
        fprintf(stderr, "SCENE.json STEPS SECONDS [setting=value]... are wanted\n");
        return 2;
    }
    const bench_scene *s = read_scene(argv[1]);
    int steps = atoi(argv[2]), made = 0, at = 0;
    double most = atof(argv[3]), *spent = calloc((size_t)steps + 1, sizeof *spent), sum = 0;
    bool *gone = calloc((size_t)s->world.made + 1, sizeof *gone);
    settings = argc - 4;
    setting = argv + 4;
    void *state = e->open(&s->world, set);
    if (s->event_count > 0 && s->events[0].step == 0) /* what is there at first is not timed */
        happen(e, state, &s->events[at++], gone);
    for (; made < steps && sum < most; made++) {
        double begin = now();
        while (at < s->event_count && s->events[at].step == made)
            happen(e, state, &s->events[at++], gone);
        e->step(state, s->world.dt);
        spent[made] = now() - begin;
        sum += spent[made];
    }
    qsort(spent, (size_t)made, sizeof *spent, by_size);
    printf("{\"steps\":%d,\"mean_ms\":%.6g,\"median_ms\":%.6g,", made, 1e3 * sum / made,
           1e3 * spent[made / 2]);
    print_change(e, state, &s->events[0], gone);
    return 0;
}
