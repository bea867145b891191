#include <string.h>

#include "base/assert.h"
#include "base/hash.h"
#include "rigid/solver/solver.h"
#include "rigid/world/continuous.h"

const char *const ll_rigid_phase_names[LL_PHASES + 1] = {"broad",      "narrow", "solve",
                                                         "continuous", "finish", NULL};

/* ---- the block ---- */

static ll_status check_limit(const char *field, int32_t value, int32_t least, int32_t most)
{
    if (value >= least && value <= most)
        return ll_ok();
    return ll_field_error(LL_BAD_INPUT, field, "%s: must be %d to %d; got %d.", field, least, most, value);
}

ll_status ll_rigid_check(const ll_rigid_limits *l)
{
    static const char *const fields[] = {"bodies", "shapes", "hulls",   "contacts",
                                         "joints", "broad",  "volumes", "broads"};
    const int32_t values[] = {l->bodies, l->shapes, l->hulls,   l->contacts,
                              l->joints, l->broad,  l->volumes, l->broads};
    const int32_t least[] = {1, 1, 0, 1, 0, 0, 0, 0};
    const int32_t most[] = {1 << 20, 1 << 21, 1 << 21, 1 << 23, 1 << 21, LL_BROADS - 1, 1, 1};
    for (int i = 0; i < 8; i++) {
        LL_TRY(check_limit(fields[i], values[i], least[i], most[i]));
    }
    return ll_ok();
}

static int32_t pair_set_size(int32_t contacts)
{
    int32_t n = 16;
    while (n < 2 * contacts)
        n *= 2;
    return n;
}

static size_t place(size_t *end, size_t count, size_t size)
{
    size_t at = *end;
    *end = (at + count * size + 63) & ~(size_t)63;
    return at;
}

static size_t broad_size(const ll_rigid_limits *l)
{
    size_t size = ll_broad_phases[l->broad]->size(l->shapes);
    for (int i = 0; l->broads && i < LL_BROADS; i++)
        if (ll_broad_phases[i]->size(l->shapes) > size)
            size = ll_broad_phases[i]->size(l->shapes);
    return size;
}

static ll_rigid_layout layout_of(const ll_rigid_limits *l)
{
    size_t bodies = (size_t)l->bodies, shapes = (size_t)l->shapes, contacts = (size_t)l->contacts;
    size_t end = 0, solver = ll_toi_events_size(l);
    ll_rigid_layout at = {0};
    place(&end, 1, sizeof(ll_rigid));
    at.pose =
        place(&end, bodies + 1, sizeof(ll_pose)); /* the last slots belong to no body: for empty lanes */
    at.solver_body = place(&end, bodies + 1, sizeof(ll_solver_body));
    at.body_sim = place(&end, bodies + 1, sizeof(ll_body_sim));
    at.body = place(&end, bodies + 1, sizeof(ll_body));
    at.shape = place(&end, shapes, sizeof(ll_shape));
    at.box = place(&end, shapes, sizeof(ll_aabb));
    at.hull = place(&end, (size_t)l->hulls, sizeof(ll_geometry));
    at.bound = place(&end, l->volumes ? shapes : 0, sizeof(ll_geometry));
    at.contact = place(&end, contacts, sizeof(ll_contact));
    at.joint = place(&end, (size_t)l->joints, sizeof(ll_joint));
    at.moved = place(&end, shapes, 1);
    at.moved_list = place(&end, shapes, sizeof(int32_t));
    at.pair_set = place(&end, (size_t)pair_set_size(l->contacts), sizeof(ll_pair_entry));
    at.awake = place(&end, bodies, sizeof(int32_t));
    at.awake_contact = place(&end, contacts, sizeof(int32_t));
    at.broad = place(&end, broad_size(l), 1);
    at.state_end = end;
    for (int i = 0; i < LL_SOLVERS; i++)
        if (ll_solvers[i]->size(l) > solver)
            solver = ll_solvers[i]->size(l);
    at.sink = place(&end, LL_TEAM_PARTS_MAX, sizeof(ll_solver_body));
    at.body_step = place(&end, bodies, sizeof(ll_body_step));
    at.order = place(&end, contacts, sizeof(int32_t));
    at.bounce_mark = place(&end, contacts / 32 + 1, sizeof(uint32_t));
    size_t most = contacts > 3 * bodies ? contacts : 3 * bodies;
    at.scratch = place(&end, most > (size_t)l->joints ? most : (size_t)l->joints, sizeof(int32_t));
    at.group = place(&end, ll_groups_size(l), 1);
    at.revolute = place(&end, (size_t)l->joints, ll_revolute_sim_size());
    at.revolute_limits = place(&end, (size_t)l->joints, ll_revolute_limits_size());
    /* Pairs are no longer needed when the solver begins, nor edges when it prepares its contacts. */
    size_t pairs = (contacts * sizeof(ll_proxy_pair) + 63) & ~(size_t)63;
    size_t links = (contacts + (size_t)l->joints) * sizeof(ll_island_edge),
           shared = solver > pairs ? solver : pairs;
    at.pair = at.island_edge = at.solver = place(&end, shared > links ? shared : links, 1);
    at.end = end;
    return at;
}

size_t ll_rigid_size(const ll_rigid_limits *limits)
{
    return layout_of(limits).end;
}

size_t ll_rigid_state_size(const ll_rigid *w)
{
    return w->at.state_end;
}

ll_rigid *ll_rigid_init(void *block, const ll_rigid_limits *limits, const ll_rigid_params *params)
{
    ll_rigid *w = block;
    ll_rigid_layout at = layout_of(limits);
    memset(block, 0, at.state_end);
    w->limits = *limits;
    w->params = *params;
    w->at = at;
    w->free_body = w->free_shape = w->free_hull = w->free_contact = w->free_joint = LL_NONE;
    w->pair_set_mask = pair_set_size(limits->contacts) - 1;
    memset(ll_pair_entries(w), 0xff, (size_t)(w->pair_set_mask + 1) * sizeof(ll_pair_entry));
    ll_broad_of(w)->init(ll_broad_state(w), limits->shapes);
    ll_poses(w)[limits->bodies] = (ll_pose){{0, 0}, {1, 0}};
    ll_solver_bodies(w)[limits->bodies] = (ll_solver_body){.q = {1, 0}};
    return w;
}

const ll_rigid_params *ll_rigid_get_params(const ll_rigid *w)
{
    return &w->params;
}

ll_status ll_rigid_set_params(ll_rigid *w, const ll_rigid_params *p)
{
    if (p->bounding_volume != LL_VOLUME_EXACT && !w->limits.volumes)
        return ll_field_error(
            LL_CONFLICT, "bounding_volume",
            "bounding_volume: must be exact in a world without room for bounding volumes; got %s.",
            ll_volume_names[p->bounding_volume]);
    ll_rigid_params old = w->params;
    w->params = *p;
    bool reshaped = old.bounding_volume != p->bounding_volume;
    if (!reshaped && old.continuous == p->continuous && old.gravity_x == p->gravity_x &&
        old.gravity_y == p->gravity_y && old.sleep == p->sleep)
        return ll_ok();
    for (int32_t i = 0; i < w->body_end; i++) {
        if (ll_bodies(w)[i].type == LL_NONE)
            continue;
        ll_wake(w, i);
        if (reshaped)
            ll_bound_shapes(w, i);
        if (reshaped || old.continuous != p->continuous)
            ll_refresh_boxes(w, i);
    }
    if (reshaped) /* their anchors belong to other surfaces */
        for (int32_t i = 0; i < w->awake_contacts; i++)
            ll_contacts(w)[ll_awake_contacts(w)[i]].rel.x = INFINITY;
    return ll_ok();
}

/* ---- a step ---- */

static bool sound(const ll_rigid *w, int32_t body)
{
    ll_pose p = ll_poses(w)[body];
    const ll_solver_body *m = &ll_solver_bodies(w)[body];
    double most = LL_WORLD_MAX;
    return fabs(p.p.x) <= most && fabs(p.p.y) <= most && fabs(m->v.x) <= most && fabs(m->v.y) <= most &&
           fabs(m->w) <= most && p.q.c * p.q.c + p.q.s * p.q.s > 0.5;
}

static void count_rest(ll_rigid *w, ll_body *b, const ll_solver_body *m)
{
    double speed = ll_length(m->v) + fabs(m->w) * b->extent;
    bool kinematic = b->type == LL_BODY_KINEMATIC;
    if (!b->may_sleep || speed > (kinematic ? 0 : w->params.sleep_threshold))
        b->sleep_time = 0;
    else
        b->sleep_time += w->dt;
}

/* The end of a step, in parts. A part lists the bodies whose boxes must be renewed in its own part of
 * `left`. */
typedef struct finishing {
    ll_rigid *w;
    int32_t *left;
    struct {
        int32_t bad, begin, count, pad; /* bad: its first unsound body in the order of slots, or LL_NONE */
    } part[LL_TEAM_PARTS_MAX];
} finishing;

static int32_t first_of(int32_t bad, int32_t body)
{
    return body != LL_NONE && (bad == LL_NONE || body < bad) ? body : bad;
}

static void write_pose(ll_rigid *w, int32_t k)
{
    ll_body *b = &ll_bodies(w)[k];
    ll_solver_body *m = &ll_solver_bodies(w)[k];
    ll_pose *pose = &ll_poses(w)[k];
    double moved = fabs(m->d.x) + fabs(m->d.y) + fabs(m->turn) * b->extent;
    pose->p = ll_add(pose->p, m->d);
    pose->q = ll_rot_normalised(ll_rot_mul(pose->q, m->q));
    b->angle += m->turn;
    b->force = ll_vec(0, 0);
    b->torque = 0;
    b->drift += moved;
    m->d = ll_vec(0, 0);
    m->q = (ll_rot){1, 0};
    m->turn = 0;
    count_rest(w, b, m);
}

static void finish_part(void *context, int part, int parts)
{
    finishing *f = context;
    ll_share of = ll_share_of(f->w->awake, part, parts);
    int32_t bad = LL_NONE, count = 0;
    for (int32_t i = of.begin; i < of.end; i++) {
        int32_t k = ll_awake_bodies(f->w)[i];
        write_pose(f->w, k);
        if (!sound(f->w, k))
            bad = first_of(bad, k);
        else if (ll_bodies(f->w)[k].drift > ll_bodies(f->w)[k].slack) {
            ll_renew_boxes(f->w, k);
            f->left[of.begin + count++] = k;
        }
    }
    f->part[part].bad = bad;
    f->part[part].begin = of.begin;
    f->part[part].count = count;
}

/* Writes the poses. Returns the first body that is not finite or out of the world, or LL_NONE. */
static int32_t finish(ll_rigid *w, ll_team *team)
{
    enum { least = 512 }; /* a body takes about 20 ns */
    finishing f;
    f.w = w;
    f.left = ll_scratch(w);
    int32_t bad = LL_NONE;
    int parts = ll_team_parts_of(team, w->awake, least);
    ll_team_run(team, w->awake, least, finish_part, &f);
    for (int i = 0; i < parts; i++) {
        bad = first_of(bad, f.part[i].bad);
        for (int32_t k = 0; k < f.part[i].count; k++)
            ll_place_boxes(w, f.left[f.part[i].begin + k]);
    }
    return bad;
}

static void ended(const ll_rigid_probe *probe, ll_rigid_phase phase)
{
    if (probe != NULL)
        probe->ended(probe->context, phase);
}

/* Speculative boxes reach as far as a body moves in a step of this length. */
static void take_dt(ll_rigid *w, double dt)
{
    bool changed = w->dt != dt;
    w->dt = dt;
    if (changed && w->params.continuous == LL_CONTINUOUS_SPECULATIVE)
        for (int32_t i = 0; i < w->awake; i++)
            ll_refresh_boxes(w, ll_awake_bodies(w)[i]);
}

static ll_status diverged(const ll_rigid *w, int32_t body)
{
    ll_pose pose = ll_poses(w)[body];
    ll_vec2 v = ll_solver_bodies(w)[body].v;
    return ll_error(LL_DIVERGED, "%s diverged in step %lld: body %d is at (%g, %g) with velocity (%g, %g).",
                    ll_rigid_solver_names[w->params.solver], (long long)w->stats.step, body + 1, pose.p.x,
                    pose.p.y, v.x, v.y);
}

ll_status ll_rigid_step(ll_rigid *w, double dt, const ll_rigid_probe *probe)
{
    return ll_rigid_step_by_team(w, dt, probe, NULL);
}

ll_status ll_rigid_step_by_team(ll_rigid *w, double dt, const ll_rigid_probe *probe, ll_team *team)
{
    if (!(dt >= 1e-5 && dt <= 1))
        return ll_field_error(LL_BAD_INPUT, "dt", "dt: must be 1e-5 to 1 s; got %g.", dt);
    w->stats.step++;
    if (w->awake == 0 && w->moved == 0)
        return ll_ok();
    bool overflowed = false;
    take_dt(w, dt);
    ll_find_pairs(w, team, &overflowed);
    ended(probe, LL_PHASE_BROAD);
    ll_update_contacts(w, team);
    ended(probe, LL_PHASE_NARROW);
    w->stats.touching = w->stats.points = w->stats.overflow = 0;
    w->colours = 0;
    ll_solvers[w->params.solver]->solve(w, team);
    ended(probe, LL_PHASE_SOLVE);
    ll_solve_continuous(w, team);
    ended(probe, LL_PHASE_CONTINUOUS);
    int32_t bad = finish(w, team);
    if (bad != LL_NONE)
        return diverged(w, bad);
    ll_put_to_sleep(w);
    ended(probe, LL_PHASE_FINISH);
    LL_VALIDATE(ll_rigid_valid(w));
    if (overflowed)
        return ll_error(LL_LIMIT, "contacts: step %lld needs more than the limit of %d.",
                        (long long)w->stats.step, w->limits.contacts);
    return ll_ok();
}

/* ---- queries ---- */

uint64_t ll_rigid_hash(const ll_rigid *w)
{
    uint64_t h = ll_hash_u64((uint64_t)w->stats.step, (uint64_t)w->awake);
    h = ll_hash(h, ll_poses(w), (size_t)w->body_end * sizeof(ll_pose));
    h = ll_hash(h, ll_solver_bodies(w), (size_t)w->body_end * sizeof(ll_solver_body));
    h = ll_hash(h, ll_bodies(w), (size_t)w->body_end * sizeof(ll_body));
    h = ll_hash(h, ll_contacts(w), (size_t)w->contact_end * sizeof(ll_contact));
    return ll_hash(h, ll_joints(w), (size_t)w->joint_end * sizeof(ll_joint));
}

ll_rigid_stats ll_rigid_get_stats(const ll_rigid *w)
{
    ll_rigid_stats s = w->stats;
    s.bodies = w->bodies;
    s.awake = w->awake;
    s.joints = w->joints;
    s.pairs = w->contacts;
    s.colours = __builtin_popcountll(w->colours);
    return s;
}

int32_t ll_rigid_contact_end(const ll_rigid *w)
{
    return w->contact_end;
}

bool ll_rigid_contact_at(const ll_rigid *w, int32_t index, ll_contact_view *out)
{
    const ll_contact *c = &ll_contacts(w)[index];
    if (c->shape[0] == LL_NONE || c->count == 0)
        return false;
    ll_relative_motion since = ll_relative_motion_of(w, c);
    ll_vec2 a = ll_poses(w)[c->body[0]].p;
    *out = (ll_contact_view){.a = ll_rigid_body_at(w, c->body[0]),
                             .b = ll_rigid_body_at(w, c->body[1]),
                             .normal = c->normal,
                             .count = c->count,
                             .recycled = c->recycled};
    for (int i = 0; i < c->count; i++) {
        ll_vec2 gap = ll_point_gap(&c->at[i], &since);
        out->at[i].point = ll_madd(ll_add(a, ll_rotate(since.a, c->at[i].a)), 0.5, gap);
        out->at[i].separation = ll_dot(gap, c->normal) + c->at[i].separation;
        out->at[i].impulse = c->at[i].normal_impulse;
        out->at[i].friction_impulse = c->at[i].tangent_impulse;
    }
    return true;
}

int32_t ll_rigid_shape_end(const ll_rigid *w)
{
    return w->shape_end;
}

bool ll_rigid_shape_at(const ll_rigid *w, int32_t index, ll_shape_view *out)
{
    const ll_shape *s = &ll_shapes(w)[index];
    if (s->body == LL_NONE)
        return false;
    ll_geometry circle = {0};
    *out = (ll_shape_view){.body = ll_rigid_body_at(w, s->body),
                           .geometry = *ll_geometry_of(w, s, &circle),
                           .pose = ll_poses(w)[s->body],
                           .box = ll_boxes(w)[index]};
    return true;
}

typedef struct picking {
    const ll_rigid *world;
    ll_geometry point;
    ll_vec2 at;
    int32_t body;
} picking;

static void pick(void *context, int32_t shape)
{
    picking *p = context;
    const ll_shape *s = &ll_shapes(p->world)[shape];
    ll_geometry circle;
    if (ll_bodies(p->world)[s->body].type != LL_BODY_DYNAMIC || (p->body != LL_NONE && p->body < s->body))
        return;
    ll_manifold m = ll_collide(ll_geometry_of(p->world, s, &circle), &p->point,
                               ll_pose_between(ll_poses(p->world)[s->body], (ll_pose){p->at, {1, 0}}), 0);
    if (m.count > 0)
        p->body = s->body;
}

ll_body_id ll_rigid_pick(const ll_rigid *w, ll_vec2 at)
{
    picking p = {.world = w, .point = {.kind = LL_SHAPE_CIRCLE, .count = 1}, .at = at, .body = LL_NONE};
    ll_broad_of(w)->query(ll_broad_state(w), ll_boxes(w), (ll_aabb){at, at}, pick, &p);
    return p.body == LL_NONE ? (ll_body_id){0, 0} : ll_rigid_body_at(w, p.body);
}

/* ---- invariants ---- */

static bool contact_valid(const ll_rigid *w, int32_t i)
{
    const ll_contact *c = &ll_contacts(w)[i];
    bool awake = ll_bodies(w)[c->body[0]].awake != LL_NONE || ll_bodies(w)[c->body[1]].awake != LL_NONE;
    if ((c->awake != LL_NONE) != awake || (awake && ll_awake_contacts(w)[c->awake] != i))
        return false;
    if ((c->count > 0) != (c->colour != LL_NONE) || !ll_pair_exists(w, c->shape[0], c->shape[1]))
        return false;
    if (c->colour == LL_NONE || c->colour >= LL_COLOURS)
        return true;
    for (int side = 0; side < 2; side++) {
        const ll_body *b = &ll_bodies(w)[c->body[side]];
        if (b->type == LL_BODY_DYNAMIC && !(b->colours >> c->colour & 1))
            return false;
    }
    return true;
}

static bool body_valid(const ll_rigid *w, int32_t i)
{
    const ll_body *b = &ll_bodies(w)[i];
    if (b->awake != LL_NONE && ll_awake_bodies(w)[b->awake] != i)
        return false;
    uint64_t colours = 0;
    for (int32_t e = b->contact; e != LL_NONE; e = ll_contacts(w)[e >> 1].next[e & 1]) {
        const ll_contact *c = &ll_contacts(w)[e >> 1];
        if (c->body[e & 1] != i)
            return false;
        if (b->type != LL_BODY_DYNAMIC || c->colour == LL_NONE || c->colour >= LL_COLOURS)
            continue;
        if (colours >> c->colour & 1) /* two contacts of one colour */
            return false;
        colours |= UINT64_C(1) << c->colour;
    }
    return colours == b->colours;
}

bool ll_rigid_valid(const ll_rigid *w)
{
    int32_t bodies = 0, contacts = 0;
    for (int32_t i = 0; i < w->body_end; i++) {
        if (ll_bodies(w)[i].type == LL_NONE)
            continue;
        bodies++;
        if (!body_valid(w, i))
            return false;
    }
    for (int32_t i = 0; i < w->contact_end; i++) {
        if (ll_contacts(w)[i].shape[0] == LL_NONE)
            continue;
        contacts++;
        if (!contact_valid(w, i))
            return false;
    }
    return bodies == w->bodies && contacts == w->contacts;
}
