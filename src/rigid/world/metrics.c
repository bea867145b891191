#include "rigid/world/metrics.h"

#include "rigid/joint/joint.h"

void ll_rigid_refer(const ll_rigid *w, double fall, ll_body_reference *references, int32_t count)
{
    for (int32_t i = 0; i < count; i++)
        references[i] = (ll_body_reference){ll_sub(ll_poses(w)[i].p, ll_vec(0, fall)), ll_bodies(w)[i].angle};
}

static bool drives(const ll_joint *j)
{
    return j->body[0] != LL_NONE && (j->def.type == LL_JOINT_MOUSE || j->def.type == LL_JOINT_MOTOR ||
                                     j->def.motored || j->def.hertz > 0);
}

bool ll_rigid_is_driven(const ll_rigid *w)
{
    for (int32_t i = 0; i < w->body_end; i++)
        if (ll_bodies(w)[i].type == LL_BODY_KINEMATIC)
            return true;
    for (int32_t i = 0; i < w->joint_end; i++)
        if (drives(&ll_joints(w)[i]))
            return true;
    return false;
}

static void measure_body(const ll_rigid *w, int32_t i, const ll_body_reference *first, ll_rigid_metrics *m)
{
    const ll_body *b = &ll_bodies(w)[i];
    ll_vec2 p = ll_poses(w)[i].p, v = ll_solver_bodies(w)[i].v;
    double spin = ll_solver_bodies(w)[i].w;
    m->bodies++;
    m->kinetic_energy += 0.5 * b->mass * ll_dot(v, v) + 0.5 * b->inertia * spin * spin;
    m->potential_energy -=
        b->mass * b->gravity_scale * (w->params.gravity_x * p.x + w->params.gravity_y * p.y);
    m->momentum = ll_madd(m->momentum, b->mass, v);
    m->spin_momentum += b->inertia * spin + b->mass * ll_cross(p, v);
    m->speed_max = ll_max(m->speed_max, ll_length(v));
    if (first == NULL)
        return;
    m->drift_max = ll_max(m->drift_max, fabs(p.x - first->position.x));
    m->sag_max = ll_max(m->sag_max, first->position.y - p.y);
    m->tilt_max = ll_max(m->tilt_max, fabs(b->angle - first->angle));
}

static double joint_error(const ll_rigid *w, const ll_joint *j)
{
    ll_constraint_row rows[LL_ROWS] = {{0}};
    double most = 0, angle = ll_bodies(w)[j->body[1]].angle - ll_bodies(w)[j->body[0]].angle;
    ll_joint_row_types[j->def.type].rows(j, ll_poses(w)[j->body[0]], ll_poses(w)[j->body[1]], angle, rows);
    for (int i = 0; i < LL_ROWS; i++)
        if (rows[i].hertz == 0 && rows[i].most == INFINITY)
            most = ll_max(most, rows[i].kind == LL_ROW_EQUAL ? fabs(rows[i].c) : ll_max(0, -rows[i].c));
    return most;
}

ll_rigid_metrics ll_rigid_measure(const ll_rigid *w, const ll_body_reference *references, int32_t count,
                                  double tunnel_x)
{
    ll_rigid_metrics m = {0};
    for (int32_t i = 0; i < w->body_end; i++) {
        if (ll_bodies(w)[i].type != LL_BODY_DYNAMIC)
            continue;
        measure_body(w, i, i < count ? &references[i] : NULL, &m);
        m.passed += ll_poses(w)[i].p.x > tunnel_x;
    }
    for (int32_t i = 0; i < w->joint_end; i++)
        if (ll_joints(w)[i].body[0] != LL_NONE)
            m.joint_error = ll_max(m.joint_error, joint_error(w, &ll_joints(w)[i]));
    double sum = 0;
    for (int32_t i = 0; i < w->contact_end; i++) {
        ll_contact_view c;
        if (!ll_rigid_contact_at(w, i, &c))
            continue;
        m.contacts++;
        for (int k = 0; k < c.count; k++, m.points++) {
            double depth = ll_max(0, -c.at[k].separation);
            m.penetration_max = ll_max(m.penetration_max, depth);
            sum += depth;
        }
    }
    m.penetration_mean = m.points > 0 ? sum / m.points : 0;
    return m;
}
