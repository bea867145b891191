/* What a scene costs next to a bare loop of the same physics: bare [ROUNDS]
 *
 * Prints a JSON array, an object per case: nanoseconds of CPU time per step, the least of the rounds, and
 * bytes, of the loop and of laglab's session, which runs forward as `laglab run` does. The loops hold nothing
 * but the state of the physics; they record, check and compare nothing. Both end in the same place, which
 * `bare_end` and `laglab_end` show. */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/mix.h"
#include "session/scenario.h"
#include "session/session.h"

static double cpu_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static void check(ll_status status)
{
    if (ll_failed(&status)) {
        fprintf(stderr, "bare: %s\n", status.text);
        exit(1);
    }
}

/* ---- free fall: semi-implicit Euler ---- */

#define FALL_STEPS 300000

typedef struct falling {
    double s, v;
} falling;

static double fall(void)
{
    const double g = 10, dt = 0.01;
    falling f = {0, 0};
    for (int i = 0; i < FALL_STEPS; i++) {
        f.v += g * dt;
        f.s += f.v * dt;
        __asm__ volatile("" : "+x"(f.s), "+x"(f.v)); /* each step is made */
    }
    return f.s;
}

/* ---- a box of 1 m that falls on the ground: soft contacts, four substeps (Catto, "Solver2D", 2024) ---- */

#define BOX_STEPS 3600
#define SUBSTEPS 4
#define SPECULATIVE 0.02 /* m */
#define SLOP 0.0         /* m: overlap that is left */
#define PUSH_MAX 3.0     /* m/s */

typedef struct corner {
    double rx, ry, gap;     /* from the centre; above the ground when the step began */
    double normal, tangent; /* impulses, kept for the next step */
    int touches;
} corner;

typedef struct box {
    double x, y, vx, vy, spin, angle;
    corner at[2]; /* the lower ones: this box never turns over */
} box;

typedef struct softness {
    double bias, mass, impulse;
} softness;

static softness soft(double hertz, double damping, double h)
{
    double omega = 6.283185307179586 * hertz, a = 2 * damping + h * omega, b = h * omega * a, c = 1 / (1 + b);
    return (softness){omega / a, b * c, c};
}

#define MASS 1.0
#define INERTIA (MASS / 6)
#define FRICTION 0.6

static void push(box *b, const corner *c, double jx, double jy)
{
    b->vx += jx / MASS;
    b->vy += jy / MASS;
    b->spin += (c->rx * jy - c->ry * jx) / INERTIA;
}

static void solve_corner(box *b, corner *c, double sunk, double h, const softness *s)
{
    double gap = c->gap + sunk, bias = 0, mass = 1, relax = 0;
    if (gap > 0) {
        bias = gap / h;
    } else if (s) {
        bias = s->bias * (gap + SLOP < 0 ? gap + SLOP : 0);
        bias = bias < -PUSH_MAX ? -PUSH_MAX : bias;
        mass = s->mass;
        relax = s->impulse;
    }
    double vn = b->vy + b->spin * c->rx, kn = 1 / MASS + c->rx * c->rx / INERTIA;
    double total = c->normal - mass * (vn + bias) / kn - relax * c->normal;
    total = total > 0 ? total : 0;
    push(b, c, 0, total - c->normal);
    c->normal = total;
    double vt = b->vx - b->spin * c->ry, kt = 1 / MASS + c->ry * c->ry / INERTIA, most = FRICTION * c->normal;
    total = c->tangent - vt / kt;
    total = total > most ? most : total < -most ? -most : total;
    push(b, c, total - c->tangent, 0);
    c->tangent = total;
}

/* For the small angles of this box. */
static void find_corners(box *b)
{
    for (int i = 0; i < 2; i++) {
        corner *c = &b->at[i];
        double side = i == 0 ? -0.5 : 0.5;
        c->rx = side + 0.5 * b->angle;
        c->ry = -0.5 + side * b->angle;
        c->gap = b->y + c->ry;
        c->touches = c->gap < SPECULATIVE;
        c->normal = c->touches ? c->normal : 0;
        c->tangent = c->touches ? c->tangent : 0;
    }
}

static void step_box(box *b, double h, const softness *s)
{
    double start = b->y;
    find_corners(b);
    for (int k = 0; k < SUBSTEPS; k++) {
        b->vy -= 10 * h;
        for (int i = 0; i < 2; i++)
            if (b->at[i].touches)
                push(b, &b->at[i], b->at[i].tangent, b->at[i].normal);
        for (int i = 0; i < 2; i++)
            if (b->at[i].touches)
                solve_corner(b, &b->at[i], b->y - start, h, s);
        b->x += h * b->vx;
        b->y += h * b->vy;
        b->angle += h * b->spin;
        for (int i = 0; i < 2; i++)
            if (b->at[i].touches)
                solve_corner(b, &b->at[i], b->y - start, h, NULL);
    }
}

static double drop_box(void)
{
    const double h = 1 / 60.0 / SUBSTEPS;
    const softness s = soft(30, 10, h);
    box b = {.y = 2};
    for (int i = 0; i < BOX_STEPS; i++)
        step_box(&b, h, &s);
    return b.y;
}

/* ---- a car: the race's exact step under throttle and linear drag ---- */

#define RACE_STEPS 216000

typedef struct car {
    double x, v;
} car;

/* The script's pedal: one of six positions in slots of 750 +- 500 ms. */
static double pedal_at(int64_t slot)
{
    static const double pedal[] = {1, 1, 0.8, 0.6, 0.3, -0.4};
    return pedal[ll_mix((uint64_t)slot * LL_MIX_STEP) % 6];
}

static double race(void)
{
    const double dt = 1 / 60.0, c = 0.3, e = 0.99501247919268232, f = (1 - e) / c, g = (dt - f) / c, top = 16;
    car a = {0, 0};
    double pedal = 1;
    for (int i = 0; i < RACE_STEPS; i++) {
        if (i >= 120 && i % 45 == 0)
            pedal = pedal_at(i / 45);
        double force = pedal > 0 ? pedal * 6 : a.v > 0 ? pedal * 9 : 0, x = a.x, v = a.v;
        a.x += v * f + force * g;
        a.v = v * e + force * f;
        if (a.v > top) {
            a.v = top;
            a.x = x + dt * (v + top) / 2;
        } else if (a.v < 0) {
            a.v = 0;
            a.x = x + v * v / (2 * -force);
        }
        __asm__ volatile("" : "+x"(a.x), "+x"(a.v));
    }
    return a.x;
}

/* ---- both ---- */

typedef struct contest {
    const char *name;
    const char *scenario;
    const char *metric; /* the only one that is asked for; NULL: all */
    const char *end[5]; /* where the state reports the same quantity as the loop; NULL-terminated */
    double (*loop)(void);
    int steps;
    size_t bytes;
} contest;

static const contest contests[] = {
    {"free fall, semi-implicit Euler",
     "{\"kind\":\"motion\",\"problem\":\"free_fall\",\"duration_s\":3000,"
     "\"methods\":[{\"method\":\"semi_implicit_euler\",\"dt_s\":0.01}]}",
     NULL,
     {"methods", "0", "state", "0"},
     fall,
     FALL_STEPS,
     sizeof(falling)},
    {"one box on the ground, four substeps",
     "{\"kind\":\"rigid\",\"duration_s\":60,\"hz\":60,\"gravity\":[0,-10],"
     "\"solver\":{\"method\":\"soft_step\",\"substeps\":4,\"sleep\":false},\"bodies\":["
     "{\"type\":\"static\",\"shape\":\"box\",\"size\":[20,1],\"position\":[0,-0.5]},"
     "{\"type\":\"dynamic\",\"shape\":\"box\",\"size\":[1,1],\"position\":[0,2],\"friction\":0.6,"
     "\"restitution\":0}]}",
     NULL,
     {"bodies", "1", "position", "1"},
     drop_box,
     BOX_STEPS,
     sizeof(box)},
    {"race of one player",
     "{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":3600,\"params\":{\"laps\":10000},\"players\":[{"
     "\"name\":"
     "\"A\",\"lag_ms\":150,\"prediction\":true,\"reconciliation\":true,\"interpolation\":true}]}",
     "players.0.bandwidth.up_bytes_per_s",
     {NULL},
     race,
     RACE_STEPS,
     sizeof(car)},
};

static cJSON *at_path(cJSON *from, const char *const *path)
{
    for (; *path && from; path++)
        from = cJSON_IsArray(from) ? cJSON_GetArrayItem(from, atoi(*path)) : cJSON_GetObjectItem(from, *path);
    return from;
}

/* Seconds of CPU time of the steps alone. */
static double run_session(const contest *c, cJSON *out, bool tells)
{
    cJSON *json;
    ll_scenario scenario;
    ll_session *session;
    check(ll_json_parse(c->scenario, strlen(c->scenario), &json));
    check(ll_scenario_parse(json, &scenario));
    check(ll_session_open_forward(&scenario, NULL, &session));
    if (c->metric)
        ll_session_observe_only(session, &c->metric, 1);
    double begin = cpu_now();
    check(ll_session_run_to(session, ll_session_get_info(session).end_tick));
    double spent = cpu_now() - begin;
    if (tells) {
        cJSON *cost = ll_session_cost(session), *report = ll_session_metrics(session);
        cJSON *end = c->end[0] ? at_path(cJSON_GetObjectItem(report, "metrics"), c->end) : NULL;
        cJSON_AddNumberToObject(out, "laglab_bytes", cJSON_GetObjectItem(cost, "block_bytes")->valuedouble);
        if (end)
            cJSON_AddNumberToObject(out, "laglab_end", end->valuedouble);
        cJSON_Delete(cost);
        cJSON_Delete(report);
    }
    ll_session_destroy(session);
    cJSON_Delete(json);
    return spent;
}

static cJSON *compete(const contest *c, int rounds)
{
    cJSON *out = cJSON_CreateObject();
    double bare = 1e9, ours = 1e9, end = 0;
    for (int i = 0; i < rounds; i++) {
        double begin = cpu_now();
        end = c->loop();
        double spent = cpu_now() - begin, session = run_session(c, out, i == 0);
        bare = spent < bare ? spent : bare;
        ours = session < ours ? session : ours;
    }
    cJSON_AddStringToObject(out, "case", c->name);
    cJSON_AddNumberToObject(out, "steps", c->steps);
    cJSON_AddNumberToObject(out, "bare_ns", bare / c->steps * 1e9);
    cJSON_AddNumberToObject(out, "laglab_ns", ours / c->steps * 1e9);
    cJSON_AddNumberToObject(out, "bare_bytes", (double)c->bytes);
    cJSON_AddNumberToObject(out, "bare_end", end);
    return out;
}

int main(int argc, char **argv)
{
    int rounds = argc > 1 ? atoi(argv[1]) : 5;
    cJSON *all = cJSON_CreateArray();
    for (size_t i = 0; i < sizeof contests / sizeof contests[0]; i++)
        cJSON_AddItemToArray(all, compete(&contests[i], rounds));
    char *line = cJSON_PrintUnformatted(all);
    puts(line);
    cJSON_free(line);
    cJSON_Delete(all);
    return 0;
}
