/* Measures of a world of rigid bodies at every step. */
#include <string.h>

#include "base/run_status.h"
#include "rigid/shape/distance.h"
#include "sim/rigid/rigid.h"

static double energy_of(const ll_rigid_metrics *m)
{
    return m->kinetic_energy + m->potential_energy;
}

static ll_rigid_metrics now(const ll_rigid_sim *s, int i)
{
    return ll_rigid_measure(ll_rigid_sim_world(s, i), ll_rigid_sim_references(s), (int32_t)s->references,
                            s->setup.tunnel_x);
}

static double mass_of(const ll_rigid *w)
{
    double mass = 0;
    for (int32_t i = 0; i < ll_rigid_body_end(w); i++) {
        ll_body_state state;
        ll_status status = ll_rigid_get_body(w, ll_rigid_body_at(w, i), &state);
        if (!ll_failed(&status) && state.type == LL_BODY_DYNAMIC)
            mass += state.mass;
    }
    return mass;
}

/* A joint with a larger error at the start adds energy; m or rad. */
#define JOINT_ERROR 1e-3

/* Contacts push overlapping bodies apart. */
static double energy_scale(const ll_rigid_sim *s, int i)
{
    const ll_rigid_record *r = &s->record[i];
    const ll_scene *scene = ll_rigid_sim_scene(&s->setup);
    if ((scene != NULL && scene->drive != NULL) || ll_rigid_is_driven(ll_rigid_sim_world(s, i)) ||
        r->now.joint_error > JOINT_ERROR)
        return 0;
    double push = ll_rigid_sim_params(&s->setup, i).contact_push_speed;
    double fall = fabs(s->setup.gravity[0]) * (s->view[1] - s->view[0]) +
                  fabs(s->setup.gravity[1]) * (s->view[3] - s->view[2]);
    return r->now.kinetic_energy + r->mass * (fall + push * push / 2);
}

void ll_rigid_sim_measure_start(ll_rigid_sim *s, int i)
{
    ll_rigid_record *r = &s->record[i];
    r->now = now(s, i);
    r->energy_start = energy_of(&r->now);
    r->momentum_start[0] = r->now.momentum.x;
    r->momentum_start[1] = r->now.momentum.y;
    r->mass = mass_of(ll_rigid_sim_world(s, i));
    r->energy_scale = energy_scale(s, i);
}

/* ---- bounding volumes ---- */

/* So far apart that no volume overlaps: each volume is within twice the shape's own radius. */
static bool far_apart(const ll_shape_view *a, const ll_shape_view *b)
{
    double reach = 2 * (ll_shape_extent(&a->geometry) + ll_shape_extent(&b->geometry));
    ll_vec2 d = ll_sub(a->pose.p, b->pose.p);
    return ll_dot(d, d) > reach * reach;
}

static bool moves(const ll_rigid *w, ll_body_id id)
{
    ll_body_state state;
    ll_status status = ll_rigid_get_body(w, id, &state);
    return !ll_failed(&status) && state.type == LL_BODY_DYNAMIC;
}

enum { MOST = LL_RIGID_COMPARED_MAX, PAIRS = MOST * (MOST - 1) / 2 };

typedef struct judged {
    ll_shape_view shape[MOST];
    uint8_t pair[PAIRS][2]; /* of shapes that are not far apart */
    uint8_t hit[LL_VOLUMES][PAIRS];
    int shapes, pairs;
} judged;

static void find_pairs(const ll_rigid *w, judged *j)
{
    bool moving[MOST];
    int32_t end = ll_rigid_shape_end(w);
    j->shapes = j->pairs = 0;
    for (int32_t i = 0; i < end && i < MOST; i++)
        if (ll_rigid_shape_at(w, i, &j->shape[j->shapes])) {
            moving[j->shapes] = moves(w, j->shape[j->shapes].body);
            j->shapes++;
        }
    for (int a = 0; a < j->shapes; a++)
        for (int b = a + 1; b < j->shapes; b++)
            if ((moving[a] || moving[b]) && j->shape[a].body.index != j->shape[b].body.index &&
                !far_apart(&j->shape[a], &j->shape[b])) {
                j->pair[j->pairs][0] = (uint8_t)a;
                j->pair[j->pairs++][1] = (uint8_t)b;
            }
}

/* Includes the cost of moving the volumes to the bodies' poses, and of the tests; shapes do not change. */
static void test_pairs(judged *j, ll_volume volume, int64_t rounds, ll_step_profiler *step_profiler, int part)
{
    ll_bound made[MOST];
    ll_placed_bound at[MOST];
    for (int i = 0; i < j->shapes; i++)
        made[i] = ll_bound_make(volume, &j->shape[i].geometry);
    int64_t from = ll_step_profiler_start(step_profiler);
    for (int64_t round = 0; round < rounds; round++) {
        for (int i = 0; i < j->shapes; i++)
            ll_bound_place(volume, &made[i], j->shape[i].pose, &at[i]);
        for (int i = 0; i < j->pairs; i++)
            j->hit[volume][i] = ll_bounds_meet(volume, &at[j->pair[i][0]], &at[j->pair[i][1]]);
    }
    ll_step_profiler_add(step_profiler, part, from);
}

static void count_hits(const judged *j, ll_volume volume, ll_volume_record *record)
{
    for (int i = 0; i < j->pairs; i++) {
        bool hit = j->hit[volume][i], exact = j->hit[LL_VOLUME_EXACT][i];
        record->tests++;
        record->hits += hit;
        record->exact_hits += exact;
        record->missed_hits += !hit && exact;
        if (!hit || exact)
            continue;
        const ll_shape_view *a = &j->shape[j->pair[i][0]], *b = &j->shape[j->pair[i][1]];
        double distance = ll_distance(&a->geometry, a->pose, &b->geometry, b->pose).distance;
        record->false_hits++;
        record->gap_sum += distance;
        record->gap_max = ll_max(record->gap_max, distance);
    }
}

static void compare_volumes(const ll_rigid *w, ll_rigid_record *r, ll_step_profiler *step_profiler,
                            int first_part)
{
    judged j;
    find_pairs(w, &j);
    for (int v = 0; v < LL_VOLUMES; v++) {
        test_pairs(&j, (ll_volume)v, 1, step_profiler, first_part + v);
        count_hits(&j, (ll_volume)v, &r->volume[v]);
    }
}

double ll_rigid_sim_time_volume(const ll_rigid *w, ll_volume volume, int64_t (*now_ns)(void))
{
    enum { TESTS = 10000, REPEATS = 7 }; /* the minimum: other processes only add time */
    judged j;
    ll_step_profiler step_profiler = {.now_ns = now_ns};
    find_pairs(w, &j);
    if (j.shapes < 2)
        return NAN;
    if (j.pairs == 0) {
        j.pair[0][0] = (uint8_t)(j.shapes - 2);
        j.pair[j.pairs++][1] = (uint8_t)(j.shapes - 1);
    }
    int64_t rounds = 1 + TESTS / j.pairs, least = INT64_MAX;
    for (int i = 0; i < REPEATS; i++) {
        step_profiler.ns[0] = 0;
        test_pairs(&j, volume, rounds, &step_profiler, 0);
        least = step_profiler.ns[0] < least ? step_profiler.ns[0] : least;
    }
    return (double)least / (double)(rounds * j.pairs);
}

/* ---- a step ---- */

static double larger(double a, double b)
{
    return a > b ? a : b;
}

/* A pointer that drags bodies adds energy. */
static ll_status judge_energy(ll_rigid_sim *s, int i)
{
    ll_rigid_record *r = &s->record[i];
    double gained = energy_of(&r->now) - r->energy_start;
    if (s->held)
        r->energy_scale = 0;
    if (!(r->energy_scale > 0) || gained <= LL_BLOWN_UP * r->energy_scale)
        return ll_ok();
    ll_status status = ll_error(LL_DIVERGED,
                                "The solver %s blew up in step %lld: the bodies have gained %.3g J, above %d "
                                "times the available %.3g J.",
                                ll_rigid_solver_names[ll_rigid_sim_params(&s->setup, i).solver],
                                (long long)ll_rigid_get_stats(ll_rigid_sim_world(s, i)).step, gained,
                                LL_BLOWN_UP, r->energy_scale);
    r->diverged_at = ll_rigid_get_stats(ll_rigid_sim_world(s, i)).step;
    memcpy(r->reason, status.text, sizeof r->reason);
    return status;
}

ll_status ll_rigid_sim_measure(ll_rigid_sim *s, int i, ll_step_profiler *step_profiler)
{
    const ll_rigid *w = ll_rigid_sim_world(s, i);
    ll_rigid_record *r = &s->record[i];
    ll_rigid_stats stats = ll_rigid_get_stats(w);
    bool slept = r->asleep_at >= 0;
    if (stats.awake > 0) {
        r->asleep_at = -1;
    } else {
        r->steps_asleep++;
        if (slept) /* nothing can have changed */
            return ll_ok();
        r->asleep_at = stats.step;
    }
    r->now = now(s, i);
    r->stopped += stats.stopped;
    r->penetration_worst = larger(r->penetration_worst, r->now.penetration_max);
    r->joint_error_worst = larger(r->joint_error_worst, r->now.joint_error);
    r->tilt_worst = larger(r->tilt_worst, r->now.tilt_max);
    r->sag_worst = larger(r->sag_worst, r->now.sag_max);
    r->drift_worst = larger(r->drift_worst, r->now.drift_max);
    r->energy_most = larger(r->energy_most, energy_of(&r->now) - r->energy_start);
    if (s->setup.compare_volumes)
        compare_volumes(w, r, step_profiler, i * LL_RIGID_PARTS + LL_PHASES + 1);
    return judge_energy(s, i);
}
