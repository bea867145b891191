#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"
#include "rigid/body/world_state.h"

const char *const ll_body_type_names[LL_BODY_TYPES + 1] = {"static", "kinematic", "dynamic", NULL};

ll_body_def ll_body_defaults(ll_body_type type)
{
    return (ll_body_def){.type = (int32_t)type, .gravity_scale = 1, .may_sleep = 1};
}

ll_material ll_material_defaults(void)
{
    return (ll_material){.density = 1, .friction = 0.6, .category = 1, .mask = UINT32_MAX};
}

/* ---- ids ---- */

ll_status ll_body_slot(const ll_rigid *w, ll_body_id id, int32_t *slot)
{
    int32_t i = id.index - 1;
    *slot = 0;
    if (i < 0 || i >= w->body_end || ll_bodies(w)[i].type == LL_NONE ||
        ll_bodies(w)[i].generation != id.generation)
        return ll_error(LL_NOT_FOUND, "body: no body %d of generation %u.", id.index, id.generation);
    *slot = i;
    return ll_ok();
}

ll_body_id ll_rigid_body_at(const ll_rigid *w, int32_t index)
{
    const ll_body *b = &ll_bodies(w)[index];
    return b->type == LL_NONE ? (ll_body_id){0, 0} : (ll_body_id){index + 1, b->generation};
}

int32_t ll_rigid_body_end(const ll_rigid *w)
{
    return w->body_end;
}

/* ---- boxes ---- */

const ll_geometry *ll_geometry_of(const ll_rigid *w, const ll_shape *shape, ll_geometry *circle)
{
    if (shape->hull != LL_NONE)
        return &ll_hulls(w)[shape->hull];
    circle->kind = LL_SHAPE_CIRCLE;
    circle->count = 1;
    circle->radius = shape->radius;
    circle->centre = circle->vertex[0] = shape->centre;
    return circle;
}

ll_aabb ll_tight_box(const ll_rigid *w, const ll_shape *shape, ll_pose pose)
{
    ll_geometry circle;
    const ll_geometry *g = ll_geometry_of(w, shape, &circle);
    int32_t volume = w->limits.volumes ? w->params.bounding_volume : LL_VOLUME_EXACT;
    if (volume == LL_VOLUME_SPHERE || volume == LL_VOLUME_OBB)
        g = &ll_bounds(w)[shape - ll_shapes(w)];
    return ll_shape_aabb(g, pose);
}

void ll_mark_moved(ll_rigid *w, int32_t shape)
{
    if (ll_moved_flags(w)[shape])
        return;
    LL_VALIDATE(w->moved < w->shape_end); /* each shape once */
    ll_moved_flags(w)[shape] = 1;
    ll_moved_lists(w)[w->moved++] = shape;
}

void ll_renew_boxes(ll_rigid *w, int32_t body)
{
    ll_body *b = &ll_bodies(w)[body];
    const ll_solver_body *m = &ll_solver_bodies(w)[body];
    b->slack = b->type == LL_BODY_STATIC ? 0 : ll_min(0.05, 0.125 * b->extent);
    b->drift = 0;
    for (int32_t s = b->shape; s != LL_NONE; s = ll_shapes(w)[s].next) {
        ll_aabb box = ll_tight_box(w, &ll_shapes(w)[s], ll_poses(w)[body]);
        if (w->params.continuous == LL_CONTINUOUS_SPECULATIVE) {
            ll_vec2 ahead = ll_scale(w->dt, m->v);
            box = ll_aabb_union(box, (ll_aabb){ll_add(box.lower, ahead), ll_add(box.upper, ahead)});
            box = ll_aabb_grown(box, ll_min(fabs(m->w) * w->dt, 2) * b->extent);
        }
        ll_boxes(w)[s] = ll_aabb_grown(box, b->slack + b->margin);
    }
}

void ll_place_boxes(ll_rigid *w, int32_t body)
{
    for (int32_t s = ll_bodies(w)[body].shape; s != LL_NONE; s = ll_shapes(w)[s].next) {
        ll_broad_of(w)->move(ll_broad_state(w), ll_boxes(w), s);
        ll_mark_moved(w, s);
    }
}

void ll_refresh_boxes(ll_rigid *w, int32_t body)
{
    ll_renew_boxes(w, body);
    ll_place_boxes(w, body);
}

/* ---- making ---- */

static ll_status check_number(const char *field, double value, double most)
{
    if (fabs(value) <= most)
        return ll_ok();
    return ll_field_error(LL_BAD_INPUT, field, "%s: must be finite and at most %g in size; got %g.", field,
                          most, value);
}

ll_status ll_check_numbers(int count, const char *const *fields, const double *values, double most)
{
    for (int i = 0; i < count; i++) {
        LL_TRY(check_number(fields[i], values[i], most));
    }
    return ll_ok();
}

static ll_status check_body(const ll_body_def *def)
{
    if (def->type < 0 || def->type >= LL_BODY_TYPES)
        return ll_field_error(LL_BAD_INPUT, "type", "type: must be static, kinematic or dynamic; got %d.",
                              def->type);
    static const char *const fields[] = {"position.x",    "position.y", "angle",
                                         "velocity.x",    "velocity.y", "angular_velocity",
                                         "gravity_scale", "damping",    "angular_damping"};
    const double values[] = {def->position.x,    def->position.y, def->angle,
                             def->velocity.x,    def->velocity.y, def->angular_velocity,
                             def->gravity_scale, def->damping,    def->angular_damping};
    ll_status status = ll_check_numbers(2, fields, values, LL_WORLD_MAX);
    LL_THEN(status, ll_check_numbers(7, fields + 2, values + 2, 1e6));
    if (!ll_failed(&status) && (def->damping < 0 || def->angular_damping < 0))
        status = ll_field_error(LL_BAD_INPUT, "damping",
                                "damping, angular_damping: both must be at least 0; got %g and %g.",
                                def->damping, def->angular_damping);
    return status;
}

ll_status ll_rigid_add_body(ll_rigid *w, const ll_body_def *def, ll_body_id *out)
{
    LL_TRY(check_body(def));
    if (w->bodies == w->limits.bodies)
        return ll_error(LL_LIMIT, "world: full; its limit is %d bodies.", w->limits.bodies);
    int32_t i = w->free_body;
    if (i == LL_NONE)
        i = w->body_end++;
    else
        w->free_body = ll_bodies(w)[i].island;
    LL_ASSERT(i >= 0 && i < w->limits.bodies);
    uint32_t generation = ll_bodies(w)[i].generation + 1;
    ll_bodies(w)[i] = (ll_body){.angle = def->angle,
                                .gravity_scale = def->gravity_scale,
                                .damping = def->damping,
                                .angular_damping = def->angular_damping,
                                .generation = generation,
                                .type = def->type,
                                .shape = LL_NONE,
                                .contact = LL_NONE,
                                .joint = LL_NONE,
                                .awake = LL_NONE,
                                .island = i,
                                .may_sleep = def->may_sleep != 0,
                                .fixed_rotation = def->fixed_rotation != 0,
                                .bullet = def->bullet != 0};
    bool moves = def->type != LL_BODY_STATIC;
    ll_poses(w)[i] = (ll_pose){def->position, {ll_cos(def->angle), ll_sin(def->angle)}};
    ll_solver_bodies(w)[i] = (ll_solver_body){
        .v = moves ? def->velocity : ll_vec(0, 0), .w = moves ? def->angular_velocity : 0, .q = {1, 0}};
    w->bodies++;
    w->bullets += def->bullet != 0;
    if (moves)
        ll_put_in_awake_list(w, i);
    *out = (ll_body_id){i + 1, generation};
    return ll_ok();
}

/* ---- mass ---- */

static void set_inverses(ll_rigid *w, int32_t body)
{
    ll_body *b = &ll_bodies(w)[body];
    bool dynamic = b->type == LL_BODY_DYNAMIC;
    b->inv_mass = dynamic && b->mass > 0 ? 1 / b->mass : 0;
    b->inv_inertia = dynamic && b->inertia > 0 && !b->fixed_rotation ? 1 / b->inertia : 0;
    LL_ASSERT(b->inv_mass >= 0 && b->inv_inertia >= 0); /* 0: not moved by forces */
    ll_body_sims(w)[body] = (ll_body_sim){b->inv_mass, b->inv_inertia, b->core, b->margin};
}

/* Moves the centre of mass to where the shapes put it. All local coordinates refer to it. */
static void sum_mass(ll_rigid *w, int32_t body)
{
    ll_body *b = &ll_bodies(w)[body];
    ll_geometry circle;
    double mass = 0;
    ll_vec2 centre = {0, 0};
    for (int32_t s = b->shape; s != LL_NONE; s = ll_shapes(w)[s].next) {
        ll_mass m = ll_shape_mass(ll_geometry_of(w, &ll_shapes(w)[s], &circle), ll_shapes(w)[s].density);
        mass += m.mass;
        centre = ll_madd(centre, m.mass, m.centre);
    }
    centre = mass > 0 && b->type == LL_BODY_DYNAMIC ? ll_scale(1 / mass, centre) : ll_vec(0, 0);
    b->mass = mass;
    b->inertia = b->extent = 0;
    b->core = INFINITY;
    for (int32_t s = b->shape; s != LL_NONE; s = ll_shapes(w)[s].next) {
        ll_shape *shape = &ll_shapes(w)[s];
        shape->centre = ll_sub(shape->centre, centre);
        if (shape->hull != LL_NONE)
            ll_shape_shift(&ll_hulls(w)[shape->hull], ll_neg(centre));
        const ll_geometry *g = ll_geometry_of(w, shape, &circle);
        ll_mass m = ll_shape_mass(g, shape->density);
        b->inertia += m.inertia + m.mass * ll_dot(m.centre, m.centre);
        b->extent = ll_max(b->extent, ll_shape_extent(g));
        b->core = ll_min(b->core, shape->core);
    }
    ll_pose *pose = &ll_poses(w)[body];
    ll_vec2 moved = ll_rotate(pose->q, centre);
    pose->p = ll_add(pose->p, moved);
    ll_solver_body *motion = &ll_solver_bodies(w)[body];
    motion->v = ll_add(motion->v, ll_cross_sv(motion->w, moved));
    b->origin = ll_sub(b->origin, centre);
    b->margin = ll_min(LL_MARGIN_SHARE, b->core > 0 ? 0.25 * b->core : LL_MARGIN_SHARE);
    set_inverses(w, body);
}

ll_status ll_rigid_set_mass(ll_rigid *w, ll_body_id id, double mass, double inertia)
{
    int32_t slot;
    LL_TRY(ll_body_slot(w, id, &slot));
    if (!(mass > 0 && mass <= 1e15))
        return ll_field_error(LL_BAD_INPUT, "mass", "mass: must be above 0 and at most 1e15 kg; got %g.",
                              mass);
    if (!(inertia > 0 && inertia <= 1e24))
        return ll_field_error(LL_BAD_INPUT, "inertia",
                              "inertia: must be above 0 and at most 1e24 kg m^2; got %g.", inertia);
    ll_bodies(w)[slot].mass = mass;
    ll_bodies(w)[slot].inertia = inertia;
    set_inverses(w, slot);
    return ll_ok();
}

/* ---- shapes ---- */

static ll_status check_material(const ll_material *m, bool needs_mass)
{
    if (!(m->density >= 0 && m->density <= 1e9) || (needs_mass && m->density <= 0))
        return ll_field_error(LL_BAD_INPUT, "density", "density: must be %s and at most 1e9 kg/m^2; got %g.",
                              needs_mass ? "above 0 (a dynamic body needs a mass)" : "at least 0",
                              m->density);
    if (!(m->friction >= 0 && m->friction <= 1e3))
        return ll_field_error(LL_BAD_INPUT, "friction", "friction: must be 0 to 1000; got %g.", m->friction);
    if (!(m->restitution >= 0 && m->restitution <= 1))
        return ll_field_error(LL_BAD_INPUT, "restitution", "restitution: must be 0 to 1; got %g.",
                              m->restitution);
    return ll_ok();
}

static int32_t take_hull(ll_rigid *w)
{
    if (w->free_hull == LL_NONE)
        return w->hull_end++;
    int32_t i = w->free_hull;
    w->free_hull = ll_hulls(w)[i].count;
    return i;
}

static ll_status room_for_shape(const ll_rigid *w, const ll_geometry *g)
{
    if (w->free_shape == LL_NONE && w->shape_end == w->limits.shapes)
        return ll_error(LL_LIMIT, "world: full; its limit is %d shapes.", w->limits.shapes);
    if (g->kind != LL_SHAPE_CIRCLE && w->free_hull == LL_NONE && w->hull_end == w->limits.hulls)
        return ll_error(LL_LIMIT, "world: full; its limit is %d shapes other than circles.", w->limits.hulls);
    return ll_ok();
}

ll_status ll_rigid_add_shape(ll_rigid *w, ll_body_id id, const ll_geometry *g, const ll_material *m)
{
    int32_t body;
    LL_TRY(ll_body_slot(w, id, &body));
    ll_body *b = &ll_bodies(w)[body];
    LL_TRY(check_material(m, b->type == LL_BODY_DYNAMIC && ll_shape_is_solid((ll_shape_kind)g->kind)));
    LL_TRY(room_for_shape(w, g));
    int32_t s = w->free_shape;
    if (s == LL_NONE)
        s = w->shape_end++;
    else
        w->free_shape = ll_shapes(w)[s].next;
    ll_shape *shape = &ll_shapes(w)[s];
    *shape = (ll_shape){.radius = g->radius,
                        .friction = m->friction,
                        .restitution = m->restitution,
                        .density = m->density,
                        .core = ll_shape_core(g),
                        .centre = ll_add(g->centre, b->origin),
                        .body = body,
                        .next = b->shape,
                        .hull = LL_NONE,
                        .category = m->category,
                        .mask = m->mask,
                        .group = m->group};
    if (g->kind != LL_SHAPE_CIRCLE) {
        shape->hull = take_hull(w);
        ll_hulls(w)[shape->hull] = *g;
        ll_shape_shift(&ll_hulls(w)[shape->hull], b->origin);
    }
    b->shape = s;
    sum_mass(w, body);
    if (w->limits.volumes)
        ll_bound_shapes(w, body);
    ll_boxes(w)[s] = ll_tight_box(w, shape, ll_poses(w)[body]);
    ll_broad_of(w)->insert(ll_broad_state(w), ll_boxes(w), s);
    ll_refresh_boxes(w, body);
    return ll_ok();
}

/* Stores the bounding volumes that do not depend on the rotation. */
void ll_bound_shapes(ll_rigid *w, int32_t body)
{
    ll_geometry circle;
    for (int32_t s = ll_bodies(w)[body].shape; s != LL_NONE; s = ll_shapes(w)[s].next) {
        memset(&ll_bounds(w)[s], 0, sizeof(ll_geometry));
        if (w->params.bounding_volume == LL_VOLUME_SPHERE || w->params.bounding_volume == LL_VOLUME_OBB)
            ll_bounds(w)[s] = ll_bound_of((ll_volume)w->params.bounding_volume,
                                          ll_geometry_of(w, &ll_shapes(w)[s], &circle), (ll_rot){1, 0});
    }
}

ll_status ll_rigid_add_chain(ll_rigid *w, ll_body_id id, const ll_vec2 *points, int count, bool loop,
                             const ll_material *material)
{
    if (count < 4)
        return ll_error(LL_BAD_INPUT, "points: a chain must have at least 4 points; got %d.", count);
    int first = loop ? 0 : 1, last = loop ? count : count - 2;
    for (int i = first; i < last; i++) {
        ll_geometry g;
        LL_TRY(ll_shape_chain_segment(points[(i + count - 1) % count], points[i], points[(i + 1) % count],
                                      points[(i + 2) % count], &g));
        LL_TRY(ll_rigid_add_shape(w, id, &g, material));
    }
    return ll_ok();
}

/* ---- state ---- */

ll_status ll_rigid_get_body(const ll_rigid *w, ll_body_id id, ll_body_state *out)
{
    int32_t i;
    LL_TRY(ll_body_slot(w, id, &i));
    const ll_body *b = &ll_bodies(w)[i];
    const ll_solver_body *m = &ll_solver_bodies(w)[i];
    *out = (ll_body_state){.position = ll_to_world(ll_poses(w)[i], b->origin),
                           .angle = b->angle,
                           .velocity = m->v,
                           .angular_velocity = m->w,
                           .centre = ll_poses(w)[i].p,
                           .mass = b->mass,
                           .inertia = b->inertia,
                           .type = b->type,
                           .awake = b->awake != LL_NONE};
    return ll_ok();
}

/* ---- the list of bodies that are awake ---- */

void ll_put_in_awake_list(ll_rigid *w, int32_t body)
{
    ll_bodies(w)[body].awake = w->awake;
    ll_awake_bodies(w)[w->awake++] = body;
}

void ll_take_from_awake_list(ll_rigid *w, int32_t body)
{
    int32_t *list = ll_awake_bodies(w), last = list[--w->awake], place = ll_bodies(w)[body].awake;
    list[place] = last;
    ll_bodies(w)[last].awake = place;
    ll_bodies(w)[body].awake = LL_NONE;
}
