/* The block of worlds side by side, at the start. */
#include <math.h>
#include <string.h>

#include "sim/rigid/rigid.h"

static int64_t aligned(int64_t size)
{
    return (size + 63) & ~INT64_C(63);
}

/* Computes the offsets of all parts; with a NULL block only the size. */
static int64_t lay_out(ll_rigid_sim *s, const ll_rigid_config *c)
{
    ll_rigid_limits limits = ll_rigid_sim_limits(c);
    ll_rigid_sim counted, *at = s ? s : &counted;
    int64_t end = aligned(sizeof(ll_rigid_sim));
    at->reference = end;
    end += aligned((int64_t)limits.bodies * (int64_t)sizeof(ll_body_reference));
    for (int i = 0; i < ll_rigid_sim_worlds(&c->setup); i++) {
        at->world[i] = end;
        end += aligned((int64_t)ll_rigid_size(&limits));
    }
    return end;
}

size_t ll_rigid_sim_size(const void *config)
{
    return (size_t)lay_out(NULL, config);
}

static double clamp(double value, double low, double high)
{
    return ll_max(low, ll_min(value, high));
}

static void include(ll_aabb *view, ll_aabb box)
{
    view->lower = ll_vec(ll_min(view->lower.x, box.lower.x), ll_min(view->lower.y, box.lower.y));
    view->upper = ll_vec(ll_max(view->upper.x, box.upper.x), ll_max(view->upper.y, box.upper.y));
}

static double span(ll_aabb box)
{
    return ll_max(box.upper.x - box.lower.x, box.upper.y - box.lower.y);
}

/* Extends the view by a fixed shape: by all of a small and near one; by the nearest part of a ground that
 * extends far beyond. */
static void include_fixed(ll_aabb *view, ll_aabb moving, ll_aabb box)
{
    ll_aabb near = ll_aabb_grown(moving, 5 + span(moving));
    ll_vec2 middle = ll_lerp(moving.lower, moving.upper, 0.5);
    ll_vec2 nearest =
        ll_vec(clamp(middle.x, box.lower.x, box.upper.x), clamp(middle.y, box.lower.y, box.upper.y));
    if (!ll_aabb_contains(near, (ll_aabb){nearest, nearest}))
        return;
    include(view, ll_aabb_contains(near, box) ? box : (ll_aabb){nearest, nearest});
}

/* The bounding boxes of the shapes that can move, or of those that cannot. */
static void add_boxes(const ll_rigid *w, bool moving, ll_aabb among, ll_aabb *view)
{
    for (int32_t i = 0; i < ll_rigid_shape_end(w); i++) {
        ll_shape_view shape;
        ll_body_state body;
        if (!ll_rigid_shape_at(w, i, &shape))
            continue;
        ll_status status = ll_rigid_get_body(w, shape.body, &body);
        if (ll_failed(&status) || (body.type != LL_BODY_STATIC) != moving)
            continue;
        if (body.type == LL_BODY_KINEMATIC && body.angular_velocity != 0) /* everything that it sweeps over */
            shape.box =
                ll_aabb_grown((ll_aabb){shape.pose.p, shape.pose.p}, ll_shape_extent(&shape.geometry));
        if (moving || among.lower.x > among.upper.x)
            include(view, shape.box);
        else
            include_fixed(view, among, shape.box);
    }
}

/* The view: everything that can move and its surroundings, with a margin. */
static void compute_view(const ll_rigid *w, double view[4])
{
    ll_aabb all = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    add_boxes(w, true, all, &all);
    ll_aabb moving = all;
    add_boxes(w, false, moving, &all);
    if (ll_aabb_contains(moving, all) && ll_rigid_get_params(w)->gravity_y < 0)
        all.lower.y -= span(all);  /* nothing supports it: it hangs or falls */
    if (all.lower.x > all.upper.x) /* nothing yet */
        all = (ll_aabb){{-10, -10}, {10, 10}};
    double room = 1 + 0.15 * span(all);
    view[0] = all.lower.x - room;
    view[1] = all.upper.x + room;
    view[2] = all.lower.y - 0.5 * room;
    view[3] = all.upper.y + room;
}

static ll_status start_world(ll_rigid_sim *s, const ll_rigid_config *c, int i)
{
    ll_rigid_limits limits = ll_rigid_sim_limits(c);
    ll_rigid_params params = ll_rigid_sim_params(&c->setup, i);
    ll_rigid *w = ll_rigid_init((char *)s + s->world[i], &limits, &params);
    ll_status status = ll_rigid_sim_build(c, w);
    ll_rigid_record *r = &s->record[i];
    *r = (ll_rigid_record){.asleep_at = -1, .diverged_at = -1};
    if (ll_failed(&status)) {
        r->diverged_at = 0;
        memcpy(r->reason, status.text, sizeof r->reason);
    }
    return status;
}

ll_status ll_rigid_sim_init(void *block, const void *config)
{
    ll_rigid_sim *s = block;
    const ll_rigid_config *c = config;
    memset(s, 0, sizeof *s);
    s->setup = c->setup;
    s->size = lay_out(s, c);
    ll_status status = ll_ok();
    for (int i = 0; i < ll_rigid_sim_worlds(&s->setup);
         i++) /* all have the same bodies: an error occurs in all of them */
        status = start_world(s, c, i);
    s->references = ll_rigid_body_end(ll_rigid_sim_world(s, 0));
    const ll_scene *scene = ll_rigid_sim_scene(&s->setup);
    ll_scene_args args = scene != NULL ? ll_scene_args_of(scene, &s->setup.params) : (ll_scene_args){0};
    ll_rigid_refer(ll_rigid_sim_world(s, 0), scene != NULL ? ll_scene_fall(scene, &args) : 0,
                   ll_rigid_sim_references(s), (int32_t)s->references);
    compute_view(ll_rigid_sim_world(s, 0), s->view);
    for (int i = 0; i < ll_rigid_sim_worlds(&s->setup); i++)
        ll_rigid_sim_measure_start(s, i);
    return status;
}
