/* Scenes of rigid bodies for bench/rigid.mjs: writes them as numbers that every engine reads, and runs laglab
 * on them. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "rigid/body/world_state.h"
#include "rigid/laglab.h"
#include "rigid/scenes/scene.h"
#include "threads/team.h"

static void check(ll_status status)
{
    if (ll_failed(&status)) {
        fprintf(stderr, "rigid: %s\n", status.text);
        exit(2);
    }
}

/* ---- a scene as numbers ---- */

typedef struct numbers {
    int32_t body[1 << 16]; /* the number of each slot's body, as they were made */
    uint32_t generation[1 << 16];
    int32_t made;
} numbers;

static void print_points(const ll_vec2 *at, int count)
{
    printf("\"vertices\":[");
    for (int i = 0; i < count; i++)
        printf("%s[%.17g,%.17g]", i > 0 ? "," : "", at[i].x, at[i].y);
    printf("]");
}

/* Segments of a closed chain are written as its points; returns the first shape after them. */
static int32_t print_shape(const ll_rigid *w, int32_t at)
{
    const ll_shape *s = &ll_shapes(w)[at];
    static const int kinds[LL_SHAPE_KINDS] = {[LL_SHAPE_CIRCLE] = SHAPE_CIRCLE,
                                              [LL_SHAPE_CAPSULE] = SHAPE_CAPSULE,
                                              [LL_SHAPE_POLYGON] = SHAPE_POLYGON,
                                              [LL_SHAPE_CHAIN_SEGMENT] = SHAPE_CHAIN};
    ll_shape_view view;
    ll_vec2 points[1024];
    int count = 0;
    ll_rigid_shape_at(w, at, &view);
    int kind = view.geometry.kind;
    if (kind == LL_SHAPE_SEGMENT)
        check(ll_error(LL_BAD_INPUT, "a scene with segments is not supported by all engines"));
    if (kind == LL_SHAPE_CHAIN_SEGMENT)
        for (; at < w->shape_end && ll_shapes(w)[at].body == s->body && count < 1024; at++) {
            ll_rigid_shape_at(w, at, &view);
            points[count++] = view.geometry.vertex[0];
        }
    else
        for (at++; count < view.geometry.count; count++)
            points[count] = view.geometry.vertex[count];
    printf("{\"kind\":%d,\"radius\":%.17g,\"density\":%.17g,\"friction\":%.17g,\"restitution\":%.17g,"
           "\"category\":%u,\"mask\":%u,\"group\":%d,",
           kinds[kind], view.geometry.radius, s->density, s->friction, s->restitution, s->category, s->mask,
           -s->group);
    print_points(points, count);
    printf("}");
    return at;
}

/* Shapes stand in the order in which they were added; those of a body together. */
static void print_body(const ll_rigid *w, int32_t body, int32_t first_shape)
{
    const ll_solver_body *m = &ll_solver_bodies(w)[body];
    ll_pose p = ll_poses(w)[body];
    printf("{\"type\":%d,\"x\":%.17g,\"y\":%.17g,\"angle\":%.17g,\"vx\":%.17g,\"vy\":%.17g,\"angular_"
           "velocity\":%.17g,"
           "\"shapes\":[",
           ll_bodies(w)[body].type, p.p.x, p.p.y, ll_bodies(w)[body].angle, m->v.x, m->v.y, m->w);
    for (int32_t i = first_shape, n = 0; i < w->shape_end;)
        if (ll_shapes(w)[i].body == body) {
            printf("%s", n++ > 0 ? "," : "");
            i = print_shape(w, i);
        } else if (n > 0 && ll_bodies(w)[body].shape < i)
            break;
        else
            i++;
    printf("]}");
}

static void print_joint(const ll_joint *j, const numbers *n)
{
    const ll_joint_def *d = &j->def;
    if (d->type != LL_JOINT_REVOLUTE)
        check(ll_error(LL_BAD_INPUT, "a scene with %s joints is not supported by all engines",
                       ll_joint_type_names[d->type]));
    printf("{\"a\":%d,\"b\":%d,\"ax\":%.17g,\"ay\":%.17g,\"bx\":%.17g,\"by\":%.17g,\"limited\":%d,"
           "\"motored\":%d,\"angle\":%.17g,\"lower\":%.17g,\"upper\":%.17g,\"speed\":%.17g,\"torque\":%.17g}",
           n->body[j->body[0]], n->body[j->body[1]], d->anchor_a.x, d->anchor_a.y, d->anchor_b.x,
           d->anchor_b.y, d->limited, d->motored, d->angle, d->lower, d->upper, d->motor_speed,
           d->max_torque);
}

/* Smallest shape of a body that is new. */
static int32_t first_shape(const ll_rigid *w, int32_t body)
{
    int32_t first = w->shape_end;
    for (int32_t s = ll_bodies(w)[body].shape; s != LL_NONE; s = ll_shapes(w)[s].next)
        first = s < first ? s : first;
    return first;
}

/* What is there and was not, and what was and is not. */
static bool print_event(const ll_rigid *w, numbers *n, int step, bool comma)
{
    static bool fresh[1 << 16];
    int32_t removed[1 << 10], removals = 0, additions = 0;
    for (int32_t i = 0; i < w->body_end; i++) {
        const ll_body *b = &ll_bodies(w)[i];
        bool there = b->type != LL_NONE;
        fresh[i] = there && n->generation[i] != b->generation;
        if (n->generation[i] != 0 && (!there || fresh[i]) && removals < 1 << 10) {
            removed[removals++] = n->body[i];
            n->generation[i] = 0;
        }
        additions += fresh[i];
    }
    if (removals + additions == 0)
        return false;
    printf("%s{\"step\":%d,\"removed\":[", comma ? ",\n" : "", step);
    for (int32_t i = 0; i < removals; i++)
        printf("%s%d", i > 0 ? "," : "", removed[i]);
    printf("],\"bodies\":[");
    for (int32_t i = 0, k = 0; i < w->body_end; i++)
        if (fresh[i]) {
            printf("%s", k++ > 0 ? ",\n" : "");
            n->body[i] = n->made++;
            n->generation[i] = ll_bodies(w)[i].generation;
            print_body(w, i, first_shape(w, i));
        }
    printf("],\"joints\":[");
    for (int32_t i = 0, k = 0; i < w->joint_end; i++) {
        const ll_joint *j = &ll_joints(w)[i];
        if (j->body[0] == LL_NONE ||
            ll_body_sims(w)[j->body[0]].inv_mass + ll_body_sims(w)[j->body[1]].inv_mass == 0)
            continue; /* between two that cannot move some engines refuse it */
        if (fresh[j->body[0]] || fresh[j->body[1]]) {
            printf("%s", k++ > 0 ? ",\n" : "");
            print_joint(j, n);
        }
    }
    printf("]}");
    return true;
}

/* A world of the scene, with its own parameters and the settings `name=value`. */
static ll_rigid *make_scene(const ll_scene *scene, ll_scene_args *args, int settings, char **setting)
{
    ll_rigid_params p;
    ll_rigid_limits limits = {.broad = LL_BROAD_GRID};
    ll_param_defaults(&ll_rigid_table, &p);
    for (int i = 0; i < settings; i++) {
        char path[32] = "";
        const char *value = strchr(setting[i], '=');
        if (value != NULL)
            snprintf(path, sizeof path, "%.*s", (int)(value - setting[i]), setting[i]);
        check(ll_param_set(&ll_scene_args_table, args, path, value != NULL ? value + 1 : "", false));
    }
    *args = ll_scene_args_of(scene, args);
    if (scene->params != NULL)
        scene->params(args, &p);
    scene->limits(args, &limits);
    check(ll_rigid_check(&limits));
    ll_rigid *w = ll_rigid_init(aligned_alloc(64, (ll_rigid_size(&limits) + 63) & ~(size_t)63), &limits, &p);
    check(scene->build(w, args));
    return w;
}

static const ll_scene *scene_named(const char *name)
{
    const ll_scene *scene = ll_scene_named(name);
    if (scene == NULL)
        check(ll_error(LL_BAD_INPUT, "there is no scene %s", name));
    return scene;
}

static int print_scene(const char *name, int steps, int settings, char **setting)
{
    const ll_scene *scene = scene_named(name);
    static numbers n;
    ll_scene_args args = {0};
    ll_rigid *w = make_scene(scene, &args, settings, setting);
    ll_rigid_params p = w->params;
    ll_rigid_limits limits = w->limits;
    printf(
        "{\"gravity_x\":%.17g,\"gravity_y\":%.17g,\"dt\":%.17g,\"continuous\":%d,\"bodies\":%d,\"shapes\":%d,"
        "\"contacts\":%d,\"joints\":%d,\"events\":[\n",
        p.gravity_x, p.gravity_y, 1.0 / 60, p.continuous != LL_CONTINUOUS_OFF, limits.bodies, limits.shapes,
        limits.contacts, limits.joints);
    bool any = false;
    for (int i = 0; i < (scene->drive != NULL ? steps : 1); i++) {
        if (scene->drive != NULL)
            check(scene->drive(w, &args, i));
        any |= print_event(w, &n, i, any);
    }
    printf("]}\n");
    return 0;
}

/* ---- growth ---- */

typedef struct phases {
    double at, spent[LL_PHASES];
} phases;

static void phase_ended(void *context, ll_rigid_phase phase)
{
    phases *p = context;
    double now = cpu_now();
    p->spent[phase] = now - p->at;
    p->at = now;
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, by_size);
    return values[count / 2];
}

static void add_wall(ll_rigid *w, double x, double y, double width, double height)
{
    ll_material material = ll_material_defaults();
    ll_body_def def = ll_body_defaults(LL_BODY_STATIC);
    ll_geometry wall;
    ll_body_id id;
    def.position = ll_vec(x, y);
    check(ll_shape_box(width, height, ll_vec(0, 0), 0, &wall));
    check(ll_rigid_add_body(w, &def, &id));
    check(ll_rigid_add_shape(w, id, &wall, &material));
}

/* Balls of 1 m that fly about in a square at 5 m/s, without gravity, equally dense for every count: their
 * boxes are renewed in nearly every step. */
static ll_rigid *balls(int32_t count)
{
    ll_rigid_limits limits = {
        .bodies = count + 4, .shapes = count + 4, .hulls = 4, .contacts = 6 * count, .broad = LL_BROAD_GRID};
    ll_rigid_params p;
    ll_param_defaults(&ll_rigid_table, &p);
    p.substeps = 4;
    p.gravity_y = 0;
    check(ll_rigid_check(&limits));
    ll_rigid *w = ll_rigid_init(aligned_alloc(64, (ll_rigid_size(&limits) + 63) & ~(size_t)63), &limits, &p);
    ll_material material = ll_material_defaults();
    ll_geometry ball;
    ll_body_id id;
    int32_t columns = (int32_t)ceil(sqrt(count));
    double pitch = 1.25, side = pitch * (columns + 1);
    add_wall(w, 0.5 * side, -0.5, side + 2, 1);
    add_wall(w, 0.5 * side, side + 0.5, side + 2, 1);
    add_wall(w, -0.5, 0.5 * side, 1, side + 2);
    add_wall(w, side + 0.5, 0.5 * side, 1, side + 2);
    material.friction = 0;
    material.restitution = 1;
    check(ll_shape_circle(ll_vec(0, 0), 0.5, &ball));
    ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
    for (int32_t i = 0; i < count; i++) {
        double direction = 2.399963 * i; /* the golden angle: all of them, and neighbours differ */
        def.position = ll_vec(pitch * (1 + i % columns), pitch * (1 + i / columns));
        def.velocity = ll_vec(5 * cos(direction), 5 * sin(direction));
        check(ll_rigid_add_body(w, &def, &id));
        check(ll_rigid_add_shape(w, id, &ball, &material));
    }
    return w;
}

/* A step of a world of `count` bodies when all move, and when all sleep. */
static void measure_growth(int32_t count, int steps)
{
    ll_rigid *w = balls(count);
    double broad[256], solve[256], whole[256], begin;
    phases p;
    ll_rigid_probe probe = {phase_ended, &p};
    for (int i = 0; i < steps; i++) {
        begin = p.at = cpu_now();
        check(ll_rigid_step(w, 1.0 / 60, &probe));
        whole[i] = cpu_now() - begin;
        broad[i] = p.spent[LL_PHASE_BROAD];
        solve[i] = p.spent[LL_PHASE_SOLVE];
    }
    ll_rigid_params params = *ll_rigid_get_params(w);
    params.sleep_threshold = 10; /* all lie down: this measures sleep, not how it comes */
    check(ll_rigid_set_params(w, &params));
    for (int32_t i = 0; i < ll_rigid_body_end(w); i++)
        if (ll_bodies(w)[i].type == LL_BODY_DYNAMIC)
            check(ll_rigid_set_velocity(w, ll_rigid_body_at(w, i), ll_vec(0, 0), 0));
    for (int i = 0; i < 600 && ll_rigid_get_stats(w).awake > 0; i++)
        check(ll_rigid_step(w, 1.0 / 60, NULL));
    int asleep = 20000;
    begin = cpu_now();
    for (int i = 0; i < asleep; i++)
        check(ll_rigid_step(w, 1.0 / 60, NULL));
    double rest = (cpu_now() - begin) / asleep;
    printf("{\"bodies\":%d,\"broad_ms\":%.6g,\"solve_ms\":%.6g,\"step_ms\":%.6g,\"asleep_us\":%.6g,\"awake\":"
           "%d}\n",
           count, 1e3 * median(broad, steps), 1e3 * median(solve, steps), 1e3 * median(whole, steps),
           1e6 * rest, ll_rigid_get_stats(w).awake);
    free(w);
}

/* ---- threads ---- */

static double wall_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

typedef struct wall_phases {
    double at, sum[LL_PHASES];
} wall_phases;

static void wall_phase_ended(void *context, ll_rigid_phase phase)
{
    wall_phases *p = context;
    double now = wall_now();
    p->sum[phase] += now - p->at;
    p->at = now;
}

/* Wall time of the steps by 1 and by `threads` threads, in turn within each step so that both see the same
 * machine. */
static int measure_threads(const char *name, int steps, int threads, int settings, char **setting)
{
    const ll_scene *scene = scene_named(name);
    ll_scene_args args[2] = {0};
    ll_rigid *w[2];
    ll_team *team[2] = {NULL, NULL};
    wall_phases spans[2] = {0};
    double *spent[2];
    check(ll_team_make(threads, &team[1]));
    for (int k = 0; k < 2; k++) {
        w[k] = make_scene(scene, &args[k], settings, setting);
        ll_rigid_params params = w[k]->params; /* as the engines of the other tables */
        params.sleep = false;
        params.substeps = 4;
        check(ll_rigid_set_params(w[k], &params));
        spent[k] = calloc((size_t)steps, sizeof(double));
    }
    for (int i = 0; i < steps; i++)
        for (int k = 0; k < 2; k++) {
            ll_rigid_probe probe = {wall_phase_ended, &spans[k]};
            double begin = wall_now();
            if (scene->drive != NULL)
                check(scene->drive(w[k], &args[k], i));
            spans[k].at = wall_now();
            check(ll_rigid_step_by_team(w[k], 1.0 / 60, &probe, team[k]));
            spent[k][i] = wall_now() - begin;
        }
    double one = median(spent[0], steps), more = median(spent[1], steps);
    printf("{\"scene\":\"%s\",\"bodies\":%d,\"threads\":%d,\"one_ms\":%.6g,\"more_ms\":%.6g,\"ratio\":%.4g,"
           "\"same\":%s",
           name, ll_rigid_get_stats(w[0]).bodies, threads, 1e3 * one, 1e3 * more, one / more,
           ll_rigid_hash(w[0]) == ll_rigid_hash(w[1]) ? "true" : "false");
    for (int i = 0; i < LL_PHASES; i++)
        printf(",\"%s\":[%.4g,%.4g]", ll_rigid_phase_names[i], 1e3 * spans[0].sum[i] / steps,
               1e3 * spans[1].sum[i] / steps);
    printf("}\n");
    ll_team_free(team[1]);
    return 0;
}

int main(int argc, char **argv)
{
    static const int32_t sizes[] = {100, 300, 1000, 3000, 10000, 30000, 100000};
    if (argc > 2 && strcmp(argv[1], "growth") == 0) {
        int steps = atoi(argv[2]);
        for (int i = 0; i < 7; i++)
            measure_growth(sizes[i], steps < 1 ? 1 : steps > 256 ? 256 : steps);
        return 0;
    }
    if (argc > 3 && strcmp(argv[1], "scene") == 0)
        return print_scene(argv[2], atoi(argv[3]), argc - 4, argv + 4);
    if (argc > 4 && strcmp(argv[1], "threads") == 0)
        return measure_threads(argv[2], atoi(argv[3]), atoi(argv[4]), argc - 5, argv + 5);
    return run_engine(&laglab_engine, argc, argv);
}
