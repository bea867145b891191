/* Scenes of particles as rows of fluid.h; their one parameter is the resolution. */
#include <math.h>

#include "base/detmath.h"
#include "fluid/particle/particle.h"
#include "fluid/scenes/scenes.h"

#define PI 3.14159265358979323846

typedef struct params {
    int64_t size;
} params;

static void set_up(const char *scene, const void *given, ll_particle_setup *setup)
{
    ll_particle_params standard;
    ll_particle_scene_setup(ll_particle_scene_named(scene), (double)((const params *)given)->size, setup,
                            &standard);
}

static ll_status check(const char *scene, const void *given)
{
    ll_particle_setup setup;
    set_up(scene, given, &setup);
    ll_status status = ll_particles_check(&setup);
    if (ll_failed(&status))
        return ll_field_error(LL_BAD_INPUT, "params.size", "params.size: %s", status.text);
    return ll_fluid_check_bytes("params.size", "particles", (int64_t)ll_particles_size(&setup));
}

static size_t size(const char *scene, const void *given)
{
    ll_particle_setup setup;
    set_up(scene, given, &setup);
    return ll_particles_size(&setup);
}

static void init(const char *scene, void *block, const void *given, const void *solver)
{
    ll_particle_setup setup;
    set_up(scene, given, &setup);
    ll_particles_init(block, &setup, solver);
}

/* ---- reference solutions ---- */

/* Martin and Moyce (1952), n^2 = 2: the front Z over T = t sqrt(2 g / a), with a gate that took 0.175 to
 * open. */
static const double measured[][2] = {{.41, 1.11},  {.84, 1.22},  {1.19, 1.44}, {1.43, 1.67}, {1.63, 1.89},
                                     {1.83, 2.11}, {1.98, 2.33}, {2.20, 2.56}, {2.32, 2.78}, {2.51, 3.00},
                                     {2.65, 3.22}, {2.83, 3.44}, {2.98, 3.67}, {3.11, 3.89}, {3.33, 4.11}};
enum { MEASURED = sizeof measured / sizeof measured[0] };

/* 0 before the first and after the last point. */
static double measured_front(double t)
{
    double time = t * ll_sqrt(2) + 0.175;
    for (int i = 1; i < MEASURED; i++)
        if (time >= measured[i - 1][0] && time < measured[i][0])
            return measured[i - 1][1] + (time - measured[i - 1][0]) / (measured[i][0] - measured[i - 1][0]) *
                                            (measured[i][1] - measured[i - 1][1]);
    return 0;
}

#define DAM_BREAK(X)                                                                                         \
    X(number, front_measured_m, "m", wanted,                                                                 \
      "position of the front at this time in the experiment of Martin and Moyce; 0 beyond their "            \
      "measurements",                                                                                        \
      LL_FLUID_FAILED)                                                                                       \
    X(signed_number, front_error, NULL, wanted > 0 ? front / wanted - 1 : 0,                                 \
      "error of the front's position against the experiment, relative; 0 beyond the measurements",           \
      LL_FLUID_FAILED)                                                                                       \
    X(number, front_over_ritter, NULL, front / (1 + 2 * ll_sqrt(2) * t),                                     \
      "position of the front divided by that of Ritter's solution, which no front can overtake",             \
      LL_FLUID_FAILED)

const ll_metric_table ll_fluid_dam_break_metrics = {.path = "",
                                                    .also = LL_FLUID_AGAIN,
                                                    .when = "Only of the scene dam_break.",
                                                    .help = "Errors against the experiment.",
                                                    LL_METRICS_FROM(DAM_BREAK)};

static int dam_break_numbers(const void *block, ll_fluid_number *out)
{
    double t = ll_particles_stats(block).time, front = ll_particles_measure(block, 0).front;
    double wanted = measured_front(t);
    return LL_FLUID_TELL(out, DAM_BREAK);
}

#define HYDROSTATIC(X)                                                                                       \
    X(number, pressure_error_rms, NULL, ll_particles_measure(block, 1).pressure_rms,                         \
      "root mean square difference of a particle's pressure from the weight above it, relative to that of "  \
      "the whole column",                                                                                    \
      LL_FLUID_FAILED)

const ll_metric_table ll_fluid_hydrostatic_metrics = {.path = "",
                                                      .also = LL_FLUID_AGAIN,
                                                      .when = "Only of the scene hydrostatic.",
                                                      .help = "Errors against the exact solution.",
                                                      LL_METRICS_FROM(HYDROSTATIC)};

static int hydrostatic_numbers(const void *block, ll_fluid_number *out)
{
    return LL_FLUID_TELL(out, HYDROSTATIC);
}

/* In a channel of width 1 with force 1 and viscosity 0.1, from rest. */
static double poiseuille_velocity(double y, double t)
{
    double u = 5 * y * (1 - y);
    for (int k = 1; k < 40; k += 2)
        u -= 40 / (PI * k * PI * k * PI * k) * ll_sin(k * PI * y) * ll_exp(-0.1 * k * k * PI * PI * t);
    return u;
}

#define POISEUILLE(X)                                                                                        \
    X(number, velocity_error_rms, NULL, middle > 0 ? sqrt(squares / v.count) / middle : 0,                   \
      "root mean square error of the velocities against the exact profile at this time, relative to the "    \
      "exact velocity in the middle",                                                                        \
      LL_FLUID_FAILED)                                                                                       \
    X(number, velocity_wanted_mps, "m/s", middle,                                                            \
      "exact velocity in the middle of the channel at this time", LL_FLUID_FAILED)

const ll_metric_table ll_fluid_poiseuille_metrics = {.path = "",
                                                     .also = LL_FLUID_AGAIN,
                                                     .when = "Only of the scene poiseuille.",
                                                     .help = "Errors against the exact solution.",
                                                     LL_METRICS_FROM(POISEUILLE)};

static int poiseuille_numbers(const void *block, ll_fluid_number *out)
{
    ll_particle_view v = ll_particles_view(block);
    double t = ll_particles_stats(block).time, squares = 0;
    for (int32_t a = 0; a < v.count; a++) {
        double error = v.u[a] - poiseuille_velocity(v.y[a], t);
        squares += error * error;
    }
    double middle = poiseuille_velocity(0.5, t);
    return LL_FLUID_TELL(out, POISEUILLE);
}

/* ---- rows ---- */

#define SCENE(name_, title_, standard_, seconds_, source_, numbers_, metrics_, text_)                        \
    static const ll_param name_##_rows[] = {                                                                 \
        {LL_PARAM_ROW("size", INT, params, size), .min = 8, .max = 1000, .default_value = standard_,         \
         .help = "Particles along the scene's own length."},                                                 \
    };                                                                                                       \
    const ll_param_table ll_fluid_##name_##_params = {                                                       \
        .name = #name_, .help = text_, .rows = name_##_rows, .count = 1, .size = sizeof(params)};            \
    static ll_status name_##_check(const void *given, const void *solver)                                    \
    {                                                                                                        \
        (void)solver;                                                                                        \
        return check(#name_, given);                                                                         \
    }                                                                                                        \
    static size_t name_##_size(const void *given, const void *solver)                                        \
    {                                                                                                        \
        (void)solver;                                                                                        \
        return size(#name_, given);                                                                          \
    }                                                                                                        \
    static void name_##_init(void *block, const void *given, const void *solver)                             \
    {                                                                                                        \
        init(#name_, block, given, solver);                                                                  \
    }                                                                                                        \
    const ll_fluid_scene ll_fluid_##name_ = {.name = #name_,                                                 \
                                             .title = title_,                                                \
                                             .help = text_,                                                  \
                                             .source = source_,                                              \
                                             .method = &ll_fluid_particles,                                  \
                                             .params = &ll_fluid_##name_##_params,                           \
                                             .solver = &ll_fluid_##name_##_solver,                           \
                                             .duration_s = seconds_,                                         \
                                             .check = name_##_check,                                         \
                                             .size = name_##_size,                                           \
                                             .init = name_##_init,                                           \
                                             .numbers = numbers_,                                            \
                                             .metrics = metrics_}

SCENE(dam_break, "Dam break", 20, 2.4, "Martin and Moyce 1952; Ritter 1892", dam_break_numbers,
      &ll_fluid_dam_break_metrics,
      "A column of 1 m x 2 m falls into a dry tank under gravity 1; compared with a measured front.");
SCENE(hydrostatic, "Hydrostatic column", 40, 10, "density times gravity times depth", hydrostatic_numbers,
      &ll_fluid_hydrostatic_metrics,
      "A column of 1 m at rest under gravity 1; its pressure is compared with its depth.");
SCENE(poiseuille, "Poiseuille flow", 20, 2, "series of the flow from rest", poiseuille_numbers,
      &ll_fluid_poiseuille_metrics,
      "Fluid between two walls, driven by a constant force; compared with the exact profile.");
SCENE(drop, "Falling drop", 30, 1, "momentum of free fall", NULL, NULL,
      "A disc in free fall that is stretched; its momentum is known exactly.");
SCENE(raft, "Floating box", 20, 10, "Archimedes", NULL, NULL,
      "A box of 0.6 of the fluid's density falls in and floats with 0.6 of its height under water.");
SCENE(pool, "Pool", 200, 10, "Macklin and Mueller 2013", NULL, NULL,
      "A step in the level of a pool of 20 m runs to and fro, at a game's scale and cost.");
