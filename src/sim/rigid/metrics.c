/* The metrics of a simulation of rigid bodies: of each world, its volumes and its bodies. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>

#include "base/run_status.h"
#include "record/metric.h"
#include "sim/rigid/rigid.h"

enum { BODIES_TOLD = 1000 };

#define AGAIN "side_by_side.*"
#define FAILED "The world has diverged."
#define FAILED_TOO "the world has diverged."

/* ---- bodies ---- */

#define BODIES(X)                                                                                            \
    X(count, body, NULL, id.index, "its index in the world", NULL)                                           \
    X(text, type, NULL, ll_body_type_names[b.type], "static, kinematic or dynamic", NULL)                    \
    X(numbers, position, "m", ll_metric_numbers(position, 2), "of the body's frame: x, y",                   \
      "It is not finite.")                                                                                   \
    X(signed_number, angle, "rad", b.angle, "of the body's frame", "It is not finite.")                      \
    X(numbers, velocity, "m/s", ll_metric_numbers(velocity, 2), "of the centre of mass: x, y",               \
      "It is not finite.")                                                                                   \
    X(signed_number, angular_velocity, "rad/s", b.angular_velocity, "its spin", "It is not finite.")         \
    X(flag, awake, NULL, b.awake, "whether it is stepped", NULL)

static const ll_metric_table body_table = {
    .path = "bodies.*",
    .also = AGAIN,
    .help = "A body, now. Element i is body i of a list; of a scene the first 1,000.",
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
    int told = 0;
    for (int32_t k = 0; k < ll_rigid_body_end(w) && told < BODIES_TOLD; k++) {
        ll_body_id id = ll_rigid_body_at(w, k);
        if (id.index == 0 || id.index == s->record[i].hand.index)
            continue;
        cJSON_AddItemToArray(array, body_json(w, id));
        told++;
    }
}

/* ---- a world ---- */

#define HEADS(X)                                                                                             \
    X(text, scene, NULL, ll_scene_names[s->setup.scene], "the scene; list: of bodies", NULL)                 \
    X(text, method, NULL, ll_rigid_solver_names[p.solver], "the contact solver", NULL)                       \
    X(text, status, NULL, ll_run_status_names[failed ? LL_RUN_DIVERGED : LL_RUN_OK],                         \
      "ok, or diverged: a value was not finite, a body left the world, or it blew up: where nothing is "     \
      "driven (no motor, spring, kinematic body or hand, nothing drawn apart at first), the bodies have "    \
      "gained more than ten times the kinetic energy of the start and what a fall through the view gives",   \
      NULL)                                                                                                  \
    X(text, reason, NULL, failed ? r->reason : NULL, "why it is not ok, and when", "It is ok: left out.")

static const ll_metric_table head_table = {
    .path = "", .also = AGAIN, .help = "What it is.", LL_METRICS_FROM(HEADS)};

#define MEASURES(X)                                                                                          \
    X(number, penetration_max_m, "m", known * m->penetration_max,                                            \
      "depth of the deepest of the contacts' points, now", FAILED)                                           \
    X(number, penetration_mean_m, "m", known * m->penetration_mean, "mean depth of these points", FAILED)    \
    X(number, penetration_worst_m, "m", known * r->penetration_worst, "the deepest of the whole run",        \
      FAILED)                                                                                                \
    X(number, drift_m, "m", known * m->drift_max,                                                            \
      "the farthest that a body is sideways of where it was at first, now", FAILED)                          \
    X(number, drift_worst_m, "m", known * r->drift_worst, "the same of the whole run", FAILED)               \
    X(number, sag_m, "m", known * m->sag_max, "the farthest that a body is below its resting place, now",    \
      FAILED)                                                                                                \
    X(number, sag_worst_m, "m", known * r->sag_worst, "the same of the whole run", FAILED)                   \
    X(number, tilt_rad, "rad", known * m->tilt_max,                                                          \
      "the farthest that a body is turned from how it was at first, now", FAILED)                            \
    X(number, tilt_worst_rad, "rad", known * r->tilt_worst, "the same of the whole run", FAILED)             \
    X(number, joint_error, "m or rad", known * m->joint_error,                                               \
      "largest error of a joint that is no spring, now", FAILED)                                             \
    X(number, joint_error_worst, "m or rad", known * r->joint_error_worst, "the same of the whole run",      \
      FAILED)                                                                                                \
    X(number, speed_max_mps, "m/s", known * m->speed_max, "of the fastest body, now", FAILED)                \
    X(number, kinetic_j, "J", known * m->kinetic_energy, "kinetic energy, now", FAILED)                      \
    X(signed_number, energy_j, "J", known *energy, "kinetic and potential energy, now", FAILED)              \
    X(signed_number, energy_change_j, "J", known *(energy - r->energy_start), "since the start", FAILED)     \
    X(number, energy_added_j, "J", known * r->energy_most, "the most that it was above the start", FAILED)   \
    X(number, momentum_error_kgmps, "kg m/s", known *momentum_error(s, i),                                   \
      "what momentum has changed beyond what gravity gives", "Something is fixed or driven, or " FAILED_TOO) \
    X(signed_number, spin_momentum_kgm2ps, "kg m^2/s", known * m->spin_momentum, "about the origin", FAILED) \
    X(count, tunnelled, NULL, known * m->passed, "dynamic bodies whose centre is beyond tunnel_x, now",      \
      FAILED)                                                                                                \
    X(count, stopped, NULL, known *(double)r->stopped, "how often swept detection put a body back", FAILED)  \
    X(count, steps_asleep, NULL, known *(double)r->steps_asleep, "steps at whose end all slept", FAILED)     \
    X(count, asleep_at_step, NULL, r->asleep_at < 0 ? NAN : known * (double)r->asleep_at,                    \
      "since which step all sleep", "They do not, or " FAILED_TOO)                                           \
    X(count, over_limit_steps, NULL, known *(double)r->over_limit,                                           \
      "steps that found more contacts than there was room for", FAILED)                                      \
    X(numbers, momentum_kgmps, "kg m/s", ll_metric_numbers(momentum, 2), "of all bodies: x, y", FAILED)

static const ll_metric_table measure_table = {
    .path = "", .also = AGAIN, .help = "What is measured of the world.", LL_METRICS_FROM(MEASURES)};

#define COUNTS(X)                                                                                            \
    X(number, passes_per_s, "1/s", s->setup.hz *ll_rigid_passes(&p), "passes over the contacts in a second", \
      NULL)                                                                                                  \
    X(count, body_count, NULL, t.bodies, "bodies", NULL)                                                     \
    X(count, awake, NULL, t.awake, "bodies that do not sleep", NULL)                                         \
    X(count, joints, NULL, t.joints, "joints", NULL)                                                         \
    X(count, pairs, NULL, t.pairs, "overlapping boxes", NULL)                                                \
    X(count, contacts, NULL, t.touching, "pairs that touch", NULL)                                           \
    X(count, points, NULL, t.points, "of the contacts", NULL)                                                \
    X(count, recycled, NULL, t.recycled, "manifolds that were kept", NULL)                                   \
    X(count, tested, NULL, t.tested, "manifolds that were computed", NULL)                                   \
    X(count, colours, NULL, t.colours, "colours of the graph of contacts in use", NULL)                      \
    X(count, overflow, NULL, t.overflow, "contacts without a colour, solved one by one", NULL)               \
    X(count, islands, NULL, t.islands, "at the last check for sleeping", NULL)

static const ll_metric_table count_table = {
    .path = "", .also = AGAIN, .help = "Counts of the last step.", LL_METRICS_FROM(COUNTS)};

/* What has changed beyond what gravity gives; with something that is fixed or driven there is no such law. */
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

static void measured(cJSON *o, const ll_rigid_sim *s, int i)
{
    const ll_rigid_record *r = &s->record[i];
    const ll_rigid_metrics *m = &r->now;
    double energy = m->kinetic_energy + m->potential_energy, known = r->diverged_at < 0 ? 1 : NAN;
    const double momentum[] = {known * m->momentum.x, known * m->momentum.y};
    LL_METRICS_PUT(o, &measure_table, MEASURES);
}

/* ---- volumes ---- */

#define VOLUMES(X)                                                                                           \
    X(number, area_overestimated_pct, "%", overestimate(w, volume),                                          \
      "how much larger than the solid shapes the volumes are in all", NULL)                                  \
    X(count, tests, NULL, r->tests, "pairs that were judged", NULL)                                          \
    X(count, hits, NULL, r->hits, "pairs whose volumes overlap", NULL)                                       \
    X(count, false_hits, NULL, r->false_hits, "of these, pairs whose shapes do not", NULL)                   \
    X(count, missed_hits, NULL, r->missed_hits, "pairs whose shapes overlap, and their volumes do not",      \
      NULL)                                                                                                  \
    X(number, gap_mean_m, "m", r->false_hits > 0 ? r->gap_sum / (double)r->false_hits : 0,                   \
      "how far apart the shapes were at false hits, mean", NULL)                                             \
    X(number, gap_max_m, "m", r->gap_max, "and at most", NULL)

static const ll_metric_table volume_table = {
    .path = "volumes.*",
    .also = AGAIN,
    .help = "A bounding volume over the whole run; counts with compare_volumes, else 0.",
    LL_METRICS_FROM(VOLUMES)};

#define TIMES(X)                                                                                             \
    X(number, ns_per_test, "ns", ll_rigid_sim_time_volume(w, volume, now_ns), "processor time for a pair",   \
      "There are fewer than two shapes.")

static const ll_metric_table time_table = {.path = "volumes.*",
                                           .also = AGAIN,
                                           .when = "With compare_volumes, of laglab run.",
                                           .help = "What a bounding volume costs.",
                                           LL_METRICS_FROM(TIMES)};

/* Of the solid shapes: how much larger than the shapes the volumes are in all, in percent. */
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

/* ---- all of it ---- */

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

/* ---- what is timed after a run ---- */

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
