/* Streamed rows of a simulation of rigid bodies. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/run_status.h"
#include "sim/rigid/records.h"

enum { SHAPES_MOST = 65535, CONTACTS_MOST = 8192, JOINTS_MOST = 8192 };
/* ---- filling the rows ---- */

/* Geometries and islands found so far, while the shapes are read. */
typedef struct look {
    const ll_rigid_sim *sim;
    ll_row_set *rows;
    ll_geometry *geometries; /* distinct geometries */
    int32_t *known;          /* hash table of them: index + 1 */
    int32_t *parent;         /* of a body: towards the root of its island */
    uint32_t known_mask;
    int geometry_count, shape_count;
} look;

/* ---- islands: bodies that contacts and joints connect ---- */

static int32_t root_of(int32_t *parent, int32_t i)
{
    for (; parent[i] != i; i = parent[i])
        parent[i] = parent[parent[i]];
    return i;
}

static bool can_move(const ll_rigid *w, ll_body_id id)
{
    ll_body_state b;
    ll_status status = ll_rigid_get_body(w, id, &b);
    return !ll_failed(&status) && b.type == LL_BODY_DYNAMIC;
}

static void join(look *p, const ll_rigid *w, ll_body_id a, ll_body_id b)
{
    if (!can_move(w, a) || !can_move(w, b))
        return;
    int32_t i = root_of(p->parent, a.index - 1), k = root_of(p->parent, b.index - 1);
    p->parent[i > k ? i : k] = i > k ? k : i;
}

static void find_islands(look *p, const ll_rigid *w)
{
    for (int32_t i = 0; i < ll_rigid_body_end(w); i++)
        p->parent[i] = i;
    for (int32_t i = 0; i < ll_rigid_contact_end(w); i++) {
        ll_contact_view c;
        if (ll_rigid_contact_at(w, i, &c))
            join(p, w, c.a, c.b);
    }
    for (int32_t i = 0; i < ll_rigid_joint_end(w); i++) {
        ll_joint_view j;
        if (ll_rigid_joint_at(w, i, &j))
            join(p, w, j.a, j.b);
    }
}

/* ---- distinct geometries ---- */

static void add_geometry(look *p, const ll_geometry *g)
{
    const ll_rot upright = {1, 0};
    ll_geometry circle = ll_bound_of(LL_VOLUME_SPHERE, g, upright),
                obb = ll_bound_of(LL_VOLUME_OBB, g, upright);
    const ll_vec2 *corner = obb.vertex;
    geometry_row row = {.kind = (uint8_t)g->kind,
                        .radius = (float)g->radius,
                        .circle_x = (float)circle.centre.x,
                        .circle_y = (float)circle.centre.y,
                        .circle_radius = (float)circle.radius,
                        .obb_x0 = (float)corner[0].x,
                        .obb_y0 = (float)corner[0].y,
                        .obb_x1 = (float)corner[1].x,
                        .obb_y1 = (float)corner[1].y,
                        .obb_x2 = (float)corner[2].x,
                        .obb_y2 = (float)corner[2].y,
                        .obb_x3 = (float)corner[3].x,
                        .obb_y3 = (float)corner[3].y};
    ll_row_set_put(p->rows, &ll_rigid_geometry_record, &row, 1);
    for (int i = 0; i < g->count; i++) {
        vertex_row vertex = {(uint16_t)p->geometry_count, (float)g->vertex[i].x, (float)g->vertex[i].y};
        ll_row_set_put(p->rows, &ll_rigid_vertex_record, &vertex, 1);
    }
}

static bool same(const ll_geometry *a, const ll_geometry *b)
{
    return a->kind == b->kind && a->count == b->count && a->radius == b->radius &&
           memcmp(a->vertex, b->vertex, (size_t)a->count * sizeof a->vertex[0]) == 0;
}

static uint16_t number_of(look *p, const ll_geometry *g)
{
    uint64_t hash = ll_hash((uint64_t)g->kind, g->vertex, (size_t)g->count * sizeof g->vertex[0]);
    uint32_t at = (uint32_t)ll_hash(hash, &g->radius, sizeof g->radius) & p->known_mask;
    for (; p->known[at] != 0; at = (at + 1) & p->known_mask)
        if (same(&p->geometries[p->known[at] - 1], g))
            return (uint16_t)(p->known[at] - 1);
    add_geometry(p, g);
    p->geometries[p->geometry_count] = *g;
    p->known[at] = ++p->geometry_count;
    return (uint16_t)(p->geometry_count - 1);
}

/* ---- rows ---- */

static void add_shape(look *p, int world, const ll_shape_view *v)
{
    ll_body_state b;
    ll_status status = ll_rigid_get_body(ll_rigid_sim_world(p->sim, world), v->body, &b);
    if (ll_failed(&status))
        return;
    ll_vec2 at = v->pose.p;
    shape_row row = {.world = (uint8_t)world,
                     .body = (uint32_t)v->body.index,
                     .geometry = number_of(p, &v->geometry),
                     .flags = (uint8_t)((b.type == LL_BODY_DYNAMIC ? LL_SHAPE_DYNAMIC : 0) |
                                        (b.type == LL_BODY_KINEMATIC ? LL_SHAPE_KINEMATIC : 0) |
                                        (b.awake ? LL_SHAPE_AWAKE : 0)),
                     .x = at.x,
                     .y = at.y,
                     .angle = (float)b.angle,
                     .vx = (float)b.velocity.x,
                     .vy = (float)b.velocity.y,
                     .angular_velocity = (float)b.angular_velocity,
                     .left = (float)(v->box.lower.x - at.x),
                     .bottom = (float)(v->box.lower.y - at.y),
                     .right = (float)(v->box.upper.x - at.x),
                     .top = (float)(v->box.upper.y - at.y),
                     .island =
                         b.type == LL_BODY_DYNAMIC ? (uint32_t)root_of(p->parent, v->body.index - 1) + 1 : 0};
    ll_row_set_put(p->rows, &ll_rigid_shape_record, &row, 1);
    p->shape_count++;
}

static contact_row contact_of(int world, ll_body_id a, ll_body_id b, const ll_contact_view *c)
{
    const double none = NAN;
    contact_row row = {.world = (uint8_t)world,
                       .a = (uint32_t)a.index,
                       .b = (uint32_t)b.index,
                       .nx = NAN,
                       .ny = NAN,
                       .x0 = none,
                       .y0 = none,
                       .separation0 = none,
                       .impulse0 = none,
                       .x1 = none,
                       .y1 = none,
                       .separation1 = none,
                       .impulse1 = none};
    if (c == NULL)
        return row;
    row.count = (uint8_t)c->count;
    row.recycled = c->recycled != 0;
    row.nx = (float)c->normal.x;
    row.ny = (float)c->normal.y;
    if (c->count > 0) {
        row.x0 = c->at[0].point.x;
        row.y0 = c->at[0].point.y;
        row.separation0 = c->at[0].separation;
        row.impulse0 = c->at[0].impulse;
    }
    if (c->count > 1) {
        row.x1 = c->at[1].point.x;
        row.y1 = c->at[1].point.y;
        row.separation1 = c->at[1].separation;
        row.impulse1 = c->at[1].impulse;
    }
    return row;
}

static void fill_contacts(const ll_rigid_sim *s, ll_row_set *rows)
{
    int most = CONTACTS_MOST;
    for (int i = 0; i < ll_rigid_sim_worlds(&s->setup); i++) {
        const ll_rigid *w = ll_rigid_sim_world(s, i);
        for (int32_t k = 0; k < ll_rigid_contact_end(w) && most > 0; k++) {
            ll_body_id a, b;
            ll_contact_view c;
            if (!ll_rigid_pair_at(w, k, &a, &b))
                continue;
            contact_row row = contact_of(i, a, b, ll_rigid_contact_at(w, k, &c) ? &c : NULL);
            ll_row_set_put(rows, &ll_rigid_contact_record, &row, 1);
            most--;
        }
    }
}

static void fill_joints(const ll_rigid_sim *s, ll_row_set *rows)
{
    int most = JOINTS_MOST;
    for (int i = 0; i < ll_rigid_sim_worlds(&s->setup); i++) {
        const ll_rigid *w = ll_rigid_sim_world(s, i);
        for (int32_t k = 0; k < ll_rigid_joint_end(w) && most > 0; k++) {
            ll_joint_view j;
            if (!ll_rigid_joint_at(w, k, &j))
                continue;
            joint_row row = {.world = (uint8_t)i,
                             .type = (uint8_t)j.type,
                             .a = (uint32_t)j.a.index,
                             .b = (uint32_t)j.b.index,
                             .ax = j.anchor_a.x,
                             .ay = j.anchor_a.y,
                             .bx = j.anchor_b.x,
                             .by = j.anchor_b.y};
            ll_row_set_put(rows, &ll_rigid_joint_record, &row, 1);
            most--;
        }
    }
}

static world_row world_of(const ll_rigid_sim *s, int i)
{
    const ll_rigid_record *r = &s->record[i];
    const ll_rigid_metrics *m = &r->now;
    ll_rigid_stats t = ll_rigid_get_stats(ll_rigid_sim_world(s, i));
    return (world_row){.status = r->diverged_at >= 0 ? LL_RUN_DIVERGED : LL_RUN_OK,
                       .solver = (uint8_t)ll_rigid_sim_params(&s->setup, i).solver,
                       .dragging = r->mouse.index != 0,
                       .bodies = (uint32_t)t.bodies,
                       .awake = (uint32_t)t.awake,
                       .pairs = (uint32_t)t.pairs,
                       .touching = (uint32_t)t.touching,
                       .points = (uint32_t)t.points,
                       .recycled = (uint32_t)t.recycled,
                       .tested = (uint32_t)t.tested,
                       .islands = (uint32_t)t.islands,
                       .tunnelled = (uint32_t)m->passed,
                       .stopped = (uint32_t)r->stopped,
                       .joints = (uint32_t)t.joints,
                       .energy = m->kinetic_energy + m->potential_energy,
                       .energy_start = r->energy_start,
                       .kinetic = m->kinetic_energy,
                       .penetration = m->penetration_max,
                       .penetration_worst = r->penetration_worst,
                       .sag = m->sag_max,
                       .drift = m->drift_max,
                       .tilt = m->tilt_max,
                       .joint_error = m->joint_error,
                       .speed_max = m->speed_max,
                       .momentum_x = m->momentum.x,
                       .momentum_y = m->momentum.y,
                       .swept = (uint32_t)t.swept,
                       .dynamic = (uint32_t)m->bodies};
}

static void fill_volumes(const ll_rigid_sim *s, int world, ll_row_set *rows)
{
    for (int v = 0; v < LL_VOLUMES && s->setup.compare_volumes; v++) {
        const ll_volume_record *r = &s->record[world].volume[v];
        volume_row row = {.world = (uint8_t)world,
                          .volume = (uint8_t)v,
                          .tests = r->tests,
                          .hits = r->hits,
                          .false_hits = r->false_hits,
                          .missed_hits = r->missed_hits,
                          .gap_mean = r->false_hits > 0 ? r->gap_sum / (double)r->false_hits : 0,
                          .gap_max = r->gap_max};
        ll_row_set_put(rows, &ll_rigid_volume_record, &row, 1);
    }
}

static void fill_shapes(look *p, int world)
{
    const ll_rigid *w = ll_rigid_sim_world(p->sim, world);
    find_islands(p, w);
    for (int32_t k = 0; k < ll_rigid_shape_end(w) && p->shape_count < SHAPES_MOST; k++) {
        ll_shape_view v;
        if (ll_rigid_shape_at(w, k, &v))
            add_shape(p, world, &v);
    }
}

static void fill_bodies(const ll_rigid_sim *s, ll_row_set *rows)
{
    size_t shapes = 1, bodies = 1, table = 16;
    int worlds = ll_rigid_sim_worlds(&s->setup);
    for (int i = 0; i < worlds; i++) {
        shapes += (size_t)ll_rigid_shape_end(ll_rigid_sim_world(s, i));
        bodies += (size_t)ll_rigid_body_end(ll_rigid_sim_world(s, i));
    }
    while (table < 2 * shapes)
        table *= 2;
    look p = {.sim = s,
              .rows = rows,
              .known_mask = (uint32_t)table - 1,
              .geometries = malloc(shapes * sizeof *p.geometries),
              .known = calloc(table, sizeof *p.known),
              .parent = malloc(bodies * sizeof *p.parent)};
    rows->failed = rows->failed || !p.geometries || !p.known || !p.parent;
    for (int i = 0; i < worlds && !rows->failed; i++) {
        world_row row = world_of(s, i);
        ll_row_set_put(rows, &ll_rigid_world_record, &row, 1);
        fill_shapes(&p, i);
        fill_volumes(s, i, rows);
    }
    free(p.geometries);
    free(p.known);
    free(p.parent);
}

void ll_rigid_sim_fill(const void *block, ll_row_set *rows)
{
    if (ll_row_set_wants(rows, &ll_rigid_world_record))
        fill_bodies(block, rows);
    if (ll_row_set_wants(rows, &ll_rigid_contact_record))
        fill_contacts(block, rows);
    if (ll_row_set_wants(rows, &ll_rigid_joint_record))
        fill_joints(block, rows);
}
