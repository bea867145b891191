/* What is measured of a world of rigid bodies at every step. */
#include <string.h>

#include "base/run_status.h"
#include "rigid/distance.h"
#include "sim/rigid.h"

static double energy_of(const ll_rigid_metrics *m)
{
    return m->kinetic_energy + m->potential_energy;
}

static ll_rigid_metrics now(const ll_rigid_sim *s, int i)
{
    return ll_rigid_measure(ll_rigid_sim_world(s, i), ll_rigid_sim_references(s), (int32_t)s->references,
                            s->setup.beyond_x);
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

/* A joint that is drawn apart from the start gives what it holds, m or rad. */
#define JOINT_ERROR 1e-3

/* Bodies that overlap are pushed apart by contacts. */
static double energy_scale(const ll_rigid_sim *s, int i)
{
    const ll_rigid_record *r = &s->record[i];
    const ll_scene *scene = ll_rigid_sim_scene(&s->setup);
    if ((scene != NULL && scene->drive != NULL) || ll_rigid_is_driven(ll_rigid_sim_world(s, i)) ||
        r->now.joint_error > JOINT_ERROR)
        return 0;
    double push = ll_rigid_sim_params(&s->setup, i).push_speed;
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

/* Far enough that no volume can tell them near: each is within twice the shape's own reach. */
static bool far_apart(const ll_shape_view *a, const ll_shape_view *b)
{
    double reach = 2 * (ll_shape_extent(&a->geometry) + ll_shape_extent(&b->geometry));
    ll_vec2 d = ll_sub(a->pose.p, b->pose.p);
    return ll_dot(d, d) > reach * reach;
}

static void judge(ll_rigid_record *r, const ll_shape_view *a, const ll_shape_view *b)
{
    double distance = ll_distance(&a->geometry, a->pose, &b->geometry, b->pose).distance;
    for (int v = 0; v < LL_VOLUMES; v++) {
        ll_volume_record *record = &r->volume[v];
        bool hit = ll_bound_hit((ll_volume)v, &a->geometry, a->pose, &b->geometry, b->pose);
        record->tests++;
        record->hits += hit;
        record->exact_hits += distance <= 0;
        record->missed_hits += !hit && distance <= 0;
        if (hit && distance > 0) {
            record->false_hits++;
            record->gap_sum += distance;
            record->gap_max = ll_max(record->gap_max, distance);
        }
    }
}

static bool moves(const ll_rigid *w, ll_body_id id)
{
    ll_body_state state;
    ll_status status = ll_rigid_get_body(w, id, &state);
    return !ll_failed(&status) && state.type == LL_BODY_DYNAMIC;
}

static void compare_volumes(const ll_rigid *w, ll_rigid_record *r)
{
    int32_t end = ll_rigid_shape_end(w);
    end = end < LL_RIGID_COMPARED_MAX ? end : LL_RIGID_COMPARED_MAX;
    for (int32_t i = 0; i < end; i++) {
        ll_shape_view a, b;
        if (!ll_rigid_shape_at(w, i, &a))
            continue;
        for (int32_t k = i + 1; k < end; k++)
            if (ll_rigid_shape_at(w, k, &b) && a.body.index != b.body.index && !far_apart(&a, &b) &&
                (moves(w, a.body) || moves(w, b.body)))
                judge(r, &a, &b);
    }
}

/* ---- a step ---- */

static double larger(double a, double b)
{
    return a > b ? a : b;
}

/* A hand that has drawn bodies has given them energy. */
static ll_status judge_energy(ll_rigid_sim *s, int i)
{
    ll_rigid_record *r = &s->record[i];
    double gained = energy_of(&r->now) - r->energy_start;
    if (s->held)
        r->energy_scale = 0;
    if (!(r->energy_scale > 0) || gained <= LL_BLOWN_UP * r->energy_scale)
        return ll_ok();
    ll_status status = ll_error(
        LL_DIVERGED,
        "The solver %s blew up in step %lld: the bodies have gained %.3g J, above %d times the %.3g J "
        "that there is to be had.",
        ll_rigid_solver_names[ll_rigid_sim_params(&s->setup, i).solver],
        (long long)ll_rigid_get_stats(ll_rigid_sim_world(s, i)).step, gained, LL_BLOWN_UP, r->energy_scale);
    r->diverged_at = ll_rigid_get_stats(ll_rigid_sim_world(s, i)).step;
    memcpy(r->reason, status.text, sizeof r->reason);
    return status;
}

ll_status ll_rigid_sim_measure(ll_rigid_sim *s, int i)
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
        compare_volumes(w, r);
    return judge_energy(s, i);
}
