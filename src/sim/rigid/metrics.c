/* Metrics of a simulation of rigid bodies: of each world, its bounding volumes and its bodies. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>

#include "base/run_status.h"
#include "record/metric.h"
#include "sim/rigid/rigid.h"

enum { BODIES_LISTED = 1000 };

#define AGAIN "side_by_side.*"
#define FAILED "The world has diverged."
#define FAILED_TOO "the world has diverged."

/* ---- bodies ---- */

#define BODIES(X)                                                                                            \
    X(count, body, NULL, id.index, "index of the body in the world", NULL)                                   \
    X(text, type, NULL, ll_body_type_names[b.type], "type of the body: static, kinematic or dynamic", NULL)  \
    X(numbers, position, "m", ll_metric_numbers(position, 2), "position of the body frame: x, y",            \
      "The position is not finite.")                                                                         \
    X(signed_number, angle, "rad", b.angle, "angle of the body frame", "The angle is not finite.")           \
    X(numbers, velocity, "m/s", ll_metric_numbers(velocity, 2), "velocity of the centre of mass: x, y",      \
      "The velocity is not finite.")                                                                         \
    X(signed_number, angular_velocity, "rad/s", b.angular_velocity, "angular velocity of the body",          \
      "The angular velocity is not finite.")                                                                 \
    X(flag, awake, NULL, b.awake, "whether the body is awake; sleeping bodies are not stepped", NULL)

static const ll_metric_table body_table = {
    .path = "bodies.*",
    .also = AGAIN,
    .help = "A body, now. Element i is body i of the scenario's list; of a scene the first 1,000 bodies.",
    LL_METRICS_FROM(BODIES)};

static cJSON *body_json(const ll_rigid *w, ll_body_id id)
{
    ll_body_state b;
    cJSON *o = cJSON_CreateObject();
    ll_status status = ll_rigid_get_body(w, id, &b);
    if (ll_failed(&status))
        return o;
    const double position[] = {b.position.x, b.position.y}, velocity[] = {b.velocity.x, b.velocity.y};
    LL_METRICS_PUT(o, &body_table, BODIES);
    return o;
}

void ll_rigid_sim_add_bodies(cJSON *object, const ll_rigid_sim *s, int i)
{
    const ll_rigid *w = ll_rigid_sim_world(s, i);
    cJSON *array = cJSON_AddArrayToObject(object, "bodies");
    int listed = 0;
    for (int32_t k = 0; k < ll_rigid_body_end(w) && listed < BODIES_LISTED; k++) {
        ll_body_id id = ll_rigid_body_at(w, k);
        if (id.index == 0 || id.index == s->record[i].hand.index)
            continue;
        cJSON_AddItemToArray(array, body_json(w, id));
        listed++;
    }
}

/* ---- a world ---- */

#define HEADS(X)                                                                                             \
    X(text, scene, NULL, ll_scene_names[s->setup.scene],                                                     \
      "name of the scene; list: the scenario lists the bodies", NULL)                                        \
    X(text, method, NULL, ll_rigid_solver_names[p.solver], "name of the contact solver", NULL)               \
    X(text, status, NULL, ll_run_status_names[failed ? LL_RUN_DIVERGED : LL_RUN_OK],                         \
      "ok; diverged: a value is not finite, a body has left the world, or the world has blown up: the "      \
      "bodies have gained more than ten times the kinetic energy at the start plus that of a fall through "  \
      "the view. Gains of energy are not checked in a world with a motor, spring, kinematic body, dragging " \
      "person, or joint pulled apart at the start",                                                          \
      NULL)                                                                                                  \
    X(text, reason, NULL, failed ? r->reason : NULL, "reason for the status diverged, and when it happened", \
      "The status is ok: the reason is left out.")

static const ll_metric_table head_table = {
    .path = "", .also = AGAIN, .help = "The world and its status.", LL_METRICS_FROM(HEADS)};

#define MEASURES(X)                                                                                          \
    X(number, penetration_max_m, "m", known * m->penetration_max,                                            \
      "largest penetration of a contact point now", FAILED)                                                  \
    X(number, penetration_mean_m, "m", known * m->penetration_mean,                                          \
      "mean penetration of the contact points now", FAILED)                                                  \
    X(number, penetration_worst_m, "m", known * r->penetration_worst,                                        \
      "largest penetration of a contact point in the whole run", FAILED)                                     \
    X(number, drift_m, "m", known * m->drift_max,                                                            \
      "largest sideways distance of a dynamic body from its position at the start, now", FAILED)             \
    X(number, drift_worst_m, "m", known * r->drift_worst,                                                    \
      "largest sideways distance of a dynamic body from its position at the start, in the whole run",        \
      FAILED)                                                                                                \
    X(number, sag_m, "m", known * m->sag_max,                                                                \
      "largest distance of a dynamic body below its resting position, now", FAILED)                          \
    X(number, sag_worst_m, "m", known * r->sag_worst,                                                        \
      "largest distance of a dynamic body below its resting position, in the whole run", FAILED)             \
    X(number, tilt_rad, "rad", known * m->tilt_max,                                                          \
      "largest rotation of a dynamic body from its angle at the start, now", FAILED)                         \
    X(number, tilt_worst_rad, "rad", known * r->tilt_worst,                                                  \
      "largest rotation of a dynamic body from its angle at the start, in the whole run", FAILED)            \
    X(number, joint_error, "m or rad", known * m->joint_error,                                               \
      "largest error of a joint that is not a spring, now", FAILED)                                          \
    X(number, joint_error_worst, "m or rad", known * r->joint_error_worst,                                   \
      "largest error of a joint that is not a spring, in the whole run", FAILED)                             \
    X(number, speed_max_mps, "m/s", known * m->speed_max, "speed of the fastest body now", FAILED)           \
    X(number, kinetic_j, "J", known * m->kinetic_energy, "kinetic energy of all bodies now", FAILED)         \
    X(signed_number, energy_j, "J", known *energy, "kinetic and potential energy of all bodies now", FAILED) \
    X(signed_number, energy_change_j, "J", known *(energy - r->energy_start),                                \
      "change of the kinetic and potential energy since the start", FAILED)                                  \
    X(number, energy_added_j, "J", known * r->energy_most,                                                   \
      "largest excess of the kinetic and potential energy over that at the start, in the whole run", FAILED) \
    X(number, momentum_error_kgmps, "kg m/s", known *momentum_error(s, i),                                   \
      "magnitude of the change of momentum since the start that gravity does not explain",                   \
      "A body is static or kinematic, or " FAILED_TOO)                                                       \
    X(signed_number, spin_momentum_kgm2ps, "kg m^2/s", known * m->spin_momentum,                             \
      "angular momentum of all bodies about the origin", FAILED)                                             \
    X(count, tunnelled, NULL, known * m->passed,                                                             \
      "dynamic bodies that tunnelled: their centre is beyond tunnel_x now", FAILED)                          \
    X(count, stopped, NULL, known *(double)r->stopped,                                                       \
      "times that continuous collision detection stopped a body at its time of impact", FAILED)              \
    X(count, steps_asleep, NULL, known *(double)r->steps_asleep, "steps after which all bodies slept",       \
      FAILED)                                                                                                \
    X(count, asleep_at_step, NULL, r->asleep_at < 0 ? NAN : known * (double)r->asleep_at,                    \
      "step since which all bodies sleep", "A body is awake, or " FAILED_TOO)                                \
    X(count, over_limit_steps, NULL, known *(double)r->over_limit,                                           \
      "steps that found more contacts than the world has room for", FAILED)                                  \
    X(numbers, momentum_kgmps, "kg m/s", ll_metric_numbers(momentum, 2), "momentum of all bodies: x, y",     \
      FAILED)

static const ll_metric_table measure_table = {
    .path = "", .also = AGAIN, .help = "Measures of the world.", LL_METRICS_FROM(MEASURES)};

#define COUNTS(X)                                                                                            \
    X(number, passes_per_s, "1/s", s->setup.hz *ll_rigid_passes(&p),                                         \
      "passes of the solver over the contacts per simulated second", NULL)                                   \
    X(count, body_count, NULL, t.bodies, "bodies of the world", NULL)                                        \
    X(count, awake, NULL, t.awake, "bodies that do not sleep", NULL)                                         \
    X(count, joints, NULL, t.joints, "joints of the world", NULL)                                            \
    X(count, pairs, NULL, t.pairs, "pairs of shapes whose bounding boxes overlap", NULL)                     \
    X(count, contacts, NULL, t.touching, "pairs of shapes that touch", NULL)                                 \
    X(count, points, NULL, t.points, "contact points of all contacts", NULL)                                 \
    X(count, recycled, NULL, t.recycled, "manifolds kept by contact recycling", NULL)                        \
    X(count, tested, NULL, t.tested, "manifolds that the narrow phase computed", NULL)                       \
    X(count, colours, NULL, t.colours, "graph colours in use", NULL)                                         \
    X(count, overflow, NULL, t.overflow, "contacts without a graph colour, which are solved one by one",     \
      NULL)                                                                                                  \
    X(count, islands, NULL, t.islands, "islands at the last check for sleeping", NULL)

static const ll_metric_table count_table = {
    .path = "", .also = AGAIN, .help = "Counts of the last step.", LL_METRICS_FROM(COUNTS)};

/* Change beyond that by gravity; unknown with static or kinematic bodies, for which momentum is not
 * conserved. */
static double momentum_error(const ll_rigid_sim *s, int i)
{
    const ll_rigid *w = ll_rigid_sim_world(s, i);
    const ll_rigid_record *r = &s->record[i];
    if (r->now.bodies != ll_rigid_get_stats(w).bodies)
        return NAN;
    double t = (double)ll_rigid_get_stats(w).step / s->setup.hz;
    ll_vec2 gravity = ll_vec(r->mass * t * s->setup.gravity[0], r->mass * t * s->setup.gravity[1]);
    ll_vec2 start = ll_vec(r->momentum_start[0], r->momentum_start[1]);
    return ll_length(ll_sub(ll_sub(r->now.momentum, start), gravity));
}

/* Null for a world that has failed. */
static void measured(cJSON *o, const ll_rigid_sim *s, int i)
{
    const ll_rigid_record *r = &s->record[i];
    const ll_rigid_metrics *m = &r->now;
    double energy = m->kinetic_energy + m->potential_energy, known = r->diverged_at < 0 ? 1 : NAN;
    const double momentum[] = {known * m->momentum.x, known * m->momentum.y};
    LL_METRICS_PUT(o, &measure_table, MEASURES);
}

/* ---- bounding volumes ---- */

#define VOLUMES(X)                                                                                           \
    X(number, area_overestimated_pct, "%", overestimate(w, volume),                                          \
      "total area of the bounding volumes above that of the solid shapes", NULL)                             \
    X(count, tests, NULL, r->tests, "pairs of shapes that were compared", NULL)                              \
    X(count, hits, NULL, r->hits, "pairs whose bounding volumes overlap", NULL)                              \
    X(count, false_hits, NULL, r->false_hits,                                                                \
      "pairs whose bounding volumes overlap while their shapes do not", NULL)                                \
    X(count, missed_hits, NULL, r->missed_hits,                                                              \
      "pairs whose shapes overlap while their bounding volumes do not", NULL)                                \
    X(number, gap_mean_m, "m", r->false_hits > 0 ? r->gap_sum / (double)r->false_hits : 0,                   \
      "mean distance of the shapes in false hits", NULL)                                                     \
    X(number, gap_max_m, "m", r->gap_max, "largest distance of the shapes in a false hit", NULL)

static const ll_metric_table volume_table = {
    .path = "volumes.*",
    .also = AGAIN,
    .help = "A kind of bounding volume, over the whole run; the counts are 0 without compare_volumes.",
    LL_METRICS_FROM(VOLUMES)};

#define TIMES(X)                                                                                             \
    X(number, ns_per_test, "ns", ll_rigid_sim_time_volume(w, volume, now_ns),                                \
      "processor time to compare the bounding volumes of a pair", "There are fewer than two shapes.")

static const ll_metric_table time_table = {.path = "volumes.*",
                                           .also = AGAIN,
                                           .when =
                                               "Only in the output of `laglab run`, with compare_volumes.",
                                           .help = "Processor time of a kind of bounding volume.",
                                           LL_METRICS_FROM(TIMES)};

/* Over the solid shapes: total area of the volumes above that of the shapes, in percent. */
static double overestimate(const ll_rigid *w, ll_volume volume)
{
    double exact = 0, bound = 0;
    for (int32_t i = 0; i < ll_rigid_shape_end(w); i++) {
        ll_shape_view v;
        if (!ll_rigid_shape_at(w, i, &v) || !ll_shape_is_solid((ll_shape_kind)v.geometry.kind))
            continue;
        exact += ll_shape_area(&v.geometry);
        bound += ll_bound_area(volume, &v.geometry, v.pose.q);
    }
    return exact > 0 ? 100 * (bound / exact - 1) : 0;
}

static void volumes(cJSON *o, const ll_rigid_sim *s, int i)
{
    const ll_rigid *w = ll_rigid_sim_world(s, i);
    cJSON *all = cJSON_AddObjectToObject(o, "volumes");
    for (int k = 0; k < LL_VOLUMES; k++) {
        const ll_volume_record *r = &s->record[i].volume[k];
        ll_volume volume = (ll_volume)k;
        LL_METRICS_PUT(cJSON_AddObjectToObject(all, ll_volume_names[k]), &volume_table, VOLUMES);
    }
}

/* ---- metrics of a run ---- */

const ll_metric_table *const ll_rigid_sim_metric_tables[] = {
    &head_table, &measure_table, &count_table, &volume_table, &time_table, &body_table, NULL};

static cJSON *metrics_of(const void *block, int i)
{
    const ll_rigid_sim *s = block;
    const ll_rigid_record *r = &s->record[i];
    ll_rigid_params p = ll_rigid_sim_params(&s->setup, i);
    ll_rigid_stats t = ll_rigid_get_stats(ll_rigid_sim_world(s, i));
    bool failed = r->diverged_at >= 0;
    cJSON *o = cJSON_CreateObject();
    LL_METRICS_PUT(o, &head_table, HEADS);
    measured(o, s, i);
    LL_METRICS_PUT(o, &count_table, COUNTS);
    volumes(o, s, i);
    ll_rigid_sim_add_bodies(o, s, i);
    return o;
}

cJSON *ll_rigid_sim_metrics(const void *block)
{
    const ll_rigid_sim *s = block;
    return ll_side_by_side_report(block, ll_rigid_sim_worlds(&s->setup), metrics_of);
}

/* ---- processor time, measured after a run ---- */

static void time_volumes(const ll_rigid *w, cJSON *o, int64_t (*now_ns)(void))
{
    cJSON *all = cJSON_GetObjectItemCaseSensitive(o, "volumes");
    for (int k = 0; k < LL_VOLUMES; k++) {
        ll_volume volume = (ll_volume)k;
        LL_METRICS_PUT(cJSON_GetObjectItemCaseSensitive(all, ll_volume_names[k]), &time_table, TIMES);
    }
}

void ll_rigid_sim_time_parts(const void *config, cJSON *metrics, int64_t (*now_ns)(void))
{
    ll_rigid_sim *s = malloc(ll_rigid_sim_size(config));
    if (s == NULL)
        return;
    ll_status status = ll_rigid_sim_init(s, config);
    for (int i = 0; i < ll_rigid_sim_worlds(&s->setup) && !ll_failed(&status); i++) {
        cJSON *o = metrics;
        if (i > 0)
            o = cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(metrics, "side_by_side"), i - 1);
        if (s->setup.compare_volumes)
            time_volumes(ll_rigid_sim_world(s, i), o, now_ns);
    }
    free(s);
}
