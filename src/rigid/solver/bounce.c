/* Impacts, resolved before a (sub)step moves anything. Contacts that would meet within it, faster than
 * restitution_threshold, are reversed one after the other until none approaches any more (the sequential law
 * of Smith, Kaufman, Vouga, Tamstorf, Grinspun, "Reflections on simultaneous impact", 2012). So an impact
 * runs through a row of bodies within the step, and the solver then finds only separating contacts. If
 * restitution were applied at the end of the step, the solver would first have shared out the momentum
 * without it.
 *
 * Bodies meet within the step, not at its beginning. Energy conservation gives the speed at the surface from
 * the speed here, and the speed here from the one after the rebound. Velocities are half a step behind the
 * positions (a falling body moves by v += a h, p += v h), so half of a h is added and subtracted again. A
 * ball of restitution 1 then rises as high as before, for every step size. */
#include "rigid/solver/solver.h"

/* `recycled` of a listed contact: its place in the list, LISTED, and the bit that was there. */
enum { LISTED = 2, PLACE_SHIFT = 2 };

/* A row of n bodies hit at its far end takes n sweeps. When more than `crowd` contacts may bounce at once the
 * bodies are not in rows but stirred together: the sweeps would not end, and cost fifty times the rest of the
 * step. Each of these contacts then bounces at most once per substep, and passes nothing on in that step. */
enum { most_sweeps = 64, crowd = 1024 };

/* What decides whether a contact approaches: a copy, since the contacts are not in the cache. Rows are in the
 * order of the list, and each movable body has a list of its rows, except in a crowd. */
struct ll_bounce_row {
    ll_vec2 n;
    double na[2], nb[2], fall[2]; /* as in toi_event; an absent second point is as the first */
    int32_t body[2];
    int32_t next[2]; /* in the lists of both bodies: place times 2 plus the side, or LL_NONE */
};

typedef struct toi_event { /* points of a contact, from the current velocities and positions */
    const ll_contact *c;
    ll_solver_body *a, *b;
    double ma, ia, mb, ib;   /* inverse masses and moments */
    double na[2], nb[2];     /* lever arms of the normal */
    double gap[2], speed[2]; /* separation, normal velocity */
    double fall[2];          /* normal acceleration */
} toi_event;

static const ll_body_step *body_step_of(const ll_rigid *w, int32_t body, double inv_mass)
{
    static const ll_body_step none;
    return inv_mass > 0 ? &ll_body_steps(w)[body] : &none;
}

/* All but the gaps: most contacts do not approach, and need no more. Inline, so that a caller computes only
 * what it reads. */
static inline __attribute__((always_inline)) toi_event approach_of(const ll_rigid *w, const ll_contact *c)
{
    const ll_body_sim *ta = &ll_body_sims(w)[c->body[0]], *tb = &ll_body_sims(w)[c->body[1]];
    const ll_body_step *da = body_step_of(w, c->body[0], ta->inv_mass);
    const ll_body_step *db = body_step_of(w, c->body[1], tb->inv_mass);
    toi_event m;
    m.c = c;
    m.a = &ll_solver_bodies(w)[c->body[0]];
    m.b = &ll_solver_bodies(w)[c->body[1]];
    m.ma = ta->inv_mass;
    m.ia = ta->inv_inertia;
    m.mb = tb->inv_mass;
    m.ib = tb->inv_inertia;
    ll_vec2 n = c->normal;
    double along = ll_dot(ll_sub(m.b->v, m.a->v), n), fall = ll_dot(ll_sub(db->a, da->a), n);
    for (int k = 0; k < 2; k++) { /* an unused point is zero */
        const ll_contact_point *p = &c->at[k];
        m.na[k] = ll_cross(p->a, n);
        m.nb[k] = ll_cross(p->b, n);
        m.speed[k] = along + (m.b->w * m.nb[k] - m.a->w * m.na[k]);
        m.fall[k] = fall + (db->angular_acceleration * m.nb[k] - da->angular_acceleration * m.na[k]);
    }
    return m;
}

static void add_gaps(const ll_rigid *w, toi_event *m)
{
    const ll_contact *c = m->c;
    ll_relative_motion since = ll_relative_motion_of(w, c);
    double moved = ll_dot(ll_sub(m->b->d, m->a->d), c->normal);
    for (int k = 0; k < c->count; k++)
        m->gap[k] = c->at[k].separation + ll_dot(ll_point_gap(&c->at[k], &since), c->normal) + moved +
                    (m->b->turn * m->nb[k] - m->a->turn * m->na[k]);
}

static double speed_here(const toi_event *m, int k, double h)
{
    return m->speed[k] + 0.5 * h * m->fall[k];
}

/* Required change of the normal velocity. */
static double change(const toi_event *m, int k, double h)
{
    double in = speed_here(m, k, h), e = m->c->restitution, height = 2 * m->fall[k] * m->gap[k];
    double square = e * e * ll_max(in * in - height, 0) + height;
    double out = height == 0 ? -e * in : square > 0 ? sqrt(square) : 0;
    return out - in;
}

/* Impulses that change both normal velocities as required. One point only, if two would have to pull. */
static void impulses(const toi_event *m, const bool meets[2], const double by[2], double out[2])
{
    double k00 = m->ma + m->mb + m->ia * m->na[0] * m->na[0] + m->ib * m->nb[0] * m->nb[0];
    double k11 = m->ma + m->mb + m->ia * m->na[1] * m->na[1] + m->ib * m->nb[1] * m->nb[1];
    double k01 = m->ma + m->mb + m->ia * m->na[0] * m->na[1] + m->ib * m->nb[0] * m->nb[1];
    double one[2] = {meets[0] && k00 > 0 ? by[0] / k00 : 0, meets[1] && k11 > 0 ? by[1] / k11 : 0};
    double determinant = k00 * k11 - k01 * k01;
    out[0] = one[0];
    out[1] = one[1];
    if (!meets[0] || !meets[1])
        return;
    if (determinant > 1e-9 * k00 * k11) {
        out[0] = (k11 * by[0] - k01 * by[1]) / determinant;
        out[1] = (k00 * by[1] - k01 * by[0]) / determinant;
    } else {
        out[0] = 0.5 * one[0];
        out[1] = 0.5 * one[1];
    }
    if (out[0] < 0) {
        out[0] = 0;
        out[1] = one[1];
    } else if (out[1] < 0) {
        out[0] = one[0];
        out[1] = 0;
    }
}

/* Lever arms of the tangent at a and b. */
typedef struct tangent_arms {
    double a[2], b[2];
} tangent_arms;

static tangent_arms tangent_arms_of(const ll_contact *c)
{
    ll_vec2 t = ll_right(c->normal);
    tangent_arms arms;
    for (int k = 0; k < 2; k++) {
        arms.a[k] = ll_cross(c->at[k].a, t);
        arms.b[k] = ll_cross(c->at[k].b, t);
    }
    return arms;
}

static void push(const toi_event *m, const tangent_arms *arms, const double normal[2],
                 const double tangent[2])
{
    double along = normal[0] + normal[1], across = tangent[0] + tangent[1];
    ll_vec2 impulse = ll_madd(ll_scale(along, m->c->normal), across, ll_right(m->c->normal));
    m->a->v = ll_madd(m->a->v, -m->ma, impulse);
    m->b->v = ll_madd(m->b->v, m->mb, impulse);
    m->a->w -= m->ia * ((m->na[0] * normal[0] + m->na[1] * normal[1]) +
                        (arms->a[0] * tangent[0] + arms->a[1] * tangent[1]));
    m->b->w += m->ib * ((m->nb[0] * normal[0] + m->nb[1] * normal[1]) +
                        (arms->b[0] * tangent[0] + arms->b[1] * tangent[1]));
}

/* Friction of the impact: at most the coefficient times the normal impulses. */
static void apply_friction(const toi_event *m, const tangent_arms *arms, const double normal[2])
{
    ll_vec2 t = ll_right(m->c->normal);
    double across = ll_dot(ll_sub(m->b->v, m->a->v), t), v[2] = {0}, mass[2] = {0}, sum[2] = {0};
    double low[2] = {0}, high[2] = {0};
    for (int k = 0; k < m->c->count; k++) {
        double share = m->ma + m->mb + m->ia * arms->a[k] * arms->a[k] + m->ib * arms->b[k] * arms->b[k];
        mass[k] = share > 0 ? 1 / share : 0;
        v[k] = across + (m->b->w * arms->b[k] - m->a->w * arms->a[k]);
        high[k] = m->c->friction * normal[k];
        low[k] = -high[k];
    }
    double coupling = m->ma + m->mb + m->ia * arms->a[0] * arms->a[1] + m->ib * arms->b[0] * arms->b[1];
    ll_solve_both(v, mass, coupling, low, high, sum);
    push(m, arms, (const double[2]){0, 0}, sum);
}

/* Returns whether the contact bounced. */
static bool meet(ll_rigid *w, const ll_contact *c, double h, double reach)
{
    toi_event m = approach_of(w, c);
    double slowest = -w->params.restitution_threshold, by[2] = {0}, p[2], nearest = INFINITY;
    bool meets[2] = {false, false}, fast = false;
    for (int k = 0; k < c->count; k++)
        fast |= speed_here(&m, k, h) < slowest;
    if (!fast)
        return false;
    add_gaps(w, &m);
    for (int k = 0; k < c->count; k++)
        if (speed_here(&m, k, h) < slowest && m.gap[k] + reach * (m.speed[k] + h * m.fall[k]) <= 0)
            nearest = ll_min(nearest, m.gap[k]);
    if (nearest == INFINITY)
        return false;
    /* Both points of a flat side bounce together, though rounding may make one of them a step late. */
    for (int k = 0; k < c->count; k++) {
        meets[k] = speed_here(&m, k, h) < slowest && m.gap[k] <= nearest + 0.1 * LL_LINEAR_SLOP;
        by[k] = meets[k] ? change(&m, k, h) : 0;
    }
    tangent_arms arms = tangent_arms_of(c);
    impulses(&m, meets, by, p);
    push(&m, &arms, p, (const double[2]){0, 0});
    apply_friction(&m, &arms, p);
    return true;
}

/* ---- the list of contacts that may meet in this step ---- */

static bool may_bounce(const ll_contact *c)
{
    return c->restitution != 0 && c->count != 0;
}

/* The contact is tried in this sweep, or where its place has been passed in the next. */
static void mark(ll_bounces *b, int32_t place)
{
    b->marked[place >> 5] |= UINT32_C(1) << (place & 31);
}

static void fill_row(const ll_rigid *w, ll_bounce_row *row, int32_t contact)
{
    const ll_contact *c = &ll_contacts(w)[contact];
    toi_event m = approach_of(w, c);
    row->n = c->normal;
    for (int k = 0; k < 2; k++) {
        int from = k < c->count ? k : 0;
        row->na[k] = m.na[from];
        row->nb[k] = m.nb[from];
        row->fall[k] = m.fall[from];
        row->body[k] = c->body[k];
    }
}

/* `rows` of a body: the first row of its list plus one, times 2, plus 1 when all its contacts are listed. */
static int32_t first_row(const ll_body_step *d)
{
    return (d->rows >> 1) - 1;
}

static void link_row(ll_rigid *w, ll_bounces *b, int32_t place)
{
    ll_bounce_row *row = &b->rows[place];
    for (int side = 0; side < 2; side++) {
        if (ll_body_sims(w)[row->body[side]].inv_mass == 0)
            continue;
        ll_body_step *d = &ll_body_steps(w)[row->body[side]];
        row->next[side] = first_row(d);
        d->rows = (2 * place + side + 1) << 1 | (d->rows & 1);
    }
}

static bool list(ll_rigid *w, ll_bounces *b, int32_t contact)
{
    ll_contact *c = &ll_contacts(w)[contact];
    if (!may_bounce(c) || (c->recycled & LISTED))
        return false;
    if ((b->count & 31) == 0)
        b->marked[b->count >> 5] = 0;
    c->recycled |= LISTED | b->count << PLACE_SHIFT;
    b->at[b->count++] = contact;
    if (b->count > b->room)
        b->rows = NULL; /* the contacts themselves are read instead */
    return true;
}

/* Lists the contacts that approach fast enough. */
typedef struct search {
    ll_rigid *w;
    ll_index_list contacts;
    int32_t *found;
    ll_share wrote[LL_TEAM_PARTS_MAX]; /* for ll_team_join */
} search;

static void search_part(void *context, int part, int parts)
{
    search *s = context;
    ll_rigid *w = s->w;
    ll_share of = ll_share_of(s->contacts.count, part, parts);
    int32_t end = of.begin;
    for (int32_t i = of.begin; i < of.end; i++) {
        const ll_contact *c = &ll_contacts(w)[s->contacts.at[i]];
        if (i + 6 < of.end)
            ll_prefetch_contact(&ll_contacts(w)[s->contacts.at[i + 6]]);
        if (!may_bounce(c))
            continue;
        toi_event m = approach_of(w, c);
        bool fast = false;
        for (int k = 0; k < c->count; k++)
            fast |= m.speed[k] - w->dt * fabs(m.fall[k]) < -w->params.restitution_threshold;
        if (fast)
            s->found[end++] = s->contacts.at[i];
    }
    s->wrote[part] = (ll_share){of.begin, end};
}

/* Into `order`; returns the count. */
static int32_t approaching(ll_rigid *w, ll_team *team, ll_index_list contacts)
{
    enum { least = 512 }; /* a contact takes about 20 ns */
    search s = {.w = w, .contacts = contacts, .found = ll_orders(w)};
    ll_team_run(team, contacts.count, least, search_part, &s);
    return ll_team_join(s.wrote, s.found, sizeof *s.found);
}

static void fill_rows(void *context, int part, int parts)
{
    const ll_bounces *b = context;
    ll_share of = ll_share_of(b->count, part, parts);
    for (int32_t i = of.begin; i < of.end; i++) {
        if (i + 6 < of.end)
            ll_prefetch_contact(&ll_contacts(b->world)[b->at[i + 6]]);
        fill_row(b->world, &b->rows[i], b->at[i]);
    }
}

ll_bounces ll_begin_bounces(ll_rigid *w, ll_team *team, ll_index_list contacts, void *memory, size_t bytes)
{
    enum { least = 128 }; /* a row takes about 50 ns */
    ll_bounces b = {.world = w,
                    .team = team,
                    .at = ll_orders(w),
                    .marked = ll_bounce_marks(w),
                    .rows = memory,
                    .room = (int32_t)ll_min((double)(bytes / sizeof(ll_bounce_row)), INT32_MAX)};
    if (w->bouncing == 0)
        return b;
    int32_t found = approaching(w, team, contacts);
    for (int32_t i = 0; i < found; i++) /* its own list, in place */
        list(w, &b, b.at[i]);
    b.crowded = b.count > crowd;
    if (b.rows != NULL)
        ll_team_run(team, b.count, least, fill_rows, &b);
    for (int32_t i = 0; i < b.count && b.rows != NULL && !b.crowded; i++)
        link_row(w, &b, i);
    return b;
}

bool ll_bounces_crowded(ll_rigid *w, double h)
{
    if (w->bouncing <= crowd)
        return false;
    ll_prepare_body_steps(w, (ll_index_list){.at = ll_awake_bodies(w), .count = w->awake}, h);
    ll_index_list contacts = {.at = ll_awake_contacts(w), .count = w->awake_contacts};
    return approaching(w, NULL, contacts) > crowd;
}

static void list_contacts_of(ll_rigid *w, ll_bounces *b, int32_t body)
{
    ll_body_steps(w)[body].rows |= 1;
    for (int32_t e = ll_bodies(w)[body].contact; e != LL_NONE; e = ll_contacts(w)[e >> 1].next[e & 1])
        if (list(w, b, e >> 1) && b->rows != NULL) {
            fill_row(w, &b->rows[b->count - 1], e >> 1);
            link_row(w, b, b->count - 1);
        }
}

/* The velocities of the body have changed: its contacts are tried again. They are listed once per step. */
static void note_hit(ll_rigid *w, ll_bounces *b, int32_t body)
{
    if (ll_body_sims(w)[body].inv_mass == 0)
        return;
    if ((ll_body_steps(w)[body].rows & 1) == 0)
        list_contacts_of(w, b, body);
    if (b->rows != NULL) {
        for (int32_t e = first_row(&ll_body_steps(w)[body]); e != LL_NONE; e = b->rows[e >> 1].next[e & 1])
            mark(b, e >> 1);
        return;
    }
    for (int32_t e = ll_bodies(w)[body].contact; e != LL_NONE; e = ll_contacts(w)[e >> 1].next[e & 1])
        if (ll_contacts(w)[e >> 1].recycled & LISTED)
            mark(b, ll_contacts(w)[e >> 1].recycled >> PLACE_SHIFT);
}

static bool approaches(const ll_rigid *w, const ll_bounce_row *row, double h)
{
    const ll_solver_body *a = &ll_solver_bodies(w)[row->body[0]], *b = &ll_solver_bodies(w)[row->body[1]];
    double along = ll_dot(ll_sub(b->v, a->v), row->n), slowest = -w->params.restitution_threshold;
    double first = along + (b->w * row->nb[0] - a->w * row->na[0]) + 0.5 * h * row->fall[0];
    double second = along + (b->w * row->nb[1] - a->w * row->na[1]) + 0.5 * h * row->fall[1];
    return (first < slowest) | (second < slowest);
}

typedef struct marking {
    const ll_bounces *bounces;
    double h;
} marking;

/* Marks those that approach fast enough; without rows, all. A part has its own words. */
static void mark_part(void *context, int part, int parts)
{
    const marking *m = context;
    const ll_bounces *b = m->bounces;
    ll_share of = ll_share_of((b->count + 31) / 32, part, parts);
    for (int32_t word = of.begin; word < of.end; word++) {
        int32_t count = b->count - 32 * word < 32 ? b->count - 32 * word : 32;
        uint32_t bits = 0;
        for (int32_t k = 0; k < count; k++)
            bits |= (uint32_t)(b->rows == NULL || approaches(b->world, &b->rows[32 * word + k], m->h)) << k;
        b->marked[word] = bits;
    }
}

/* Tries those that are marked, in the order of the list, and takes their marks. Returns whether any has
 * bounced. */
static bool sweep(ll_rigid *w, ll_bounces *b, double h, double reach)
{
    bool met = false;
    for (int32_t word = 0; word << 5 < b->count; word++) { /* the list may grow in this loop */
        for (uint32_t ahead = UINT32_MAX; b->marked[word] & ahead;) {
            int bit = __builtin_ctz(b->marked[word] & ahead);
            int32_t place = word << 5 | bit;
            ahead = bit == 31 ? 0 : UINT32_MAX << (bit + 1);
            b->marked[word] &= ~(UINT32_C(1) << bit);
            if (b->marked[word] & ahead)
                ll_prefetch_contact(
                    &ll_contacts(w)[b->at[word << 5 | __builtin_ctz(b->marked[word] & ahead)]]);
            if (b->rows != NULL && !approaches(w, &b->rows[place], h))
                continue;
            const ll_contact *c = &ll_contacts(w)[b->at[place]];
            if (!meet(w, c, h, reach))
                continue;
            met = true;
            note_hit(w, b, c->body[0]);
            note_hit(w, b, c->body[1]);
        }
    }
    return met;
}

/* Tries each once, in the order of the list. */
static void sweep_crowd(ll_rigid *w, const ll_bounces *b, double h, double reach)
{
    for (int32_t i = 0; i < b->count; i++) {
        if (b->rows == NULL && i + 4 < b->count)
            ll_prefetch_contact(&ll_contacts(w)[b->at[i + 4]]);
        if (b->rows == NULL || approaches(w, &b->rows[i], h))
            meet(w, &ll_contacts(w)[b->at[i]], h, reach);
    }
}

/* A contact that did not approach or meet does not in a later sweep either, unless one of its bodies was hit
 * in between. So the parts of a team may look first at all of them. */
void ll_bounce(ll_rigid *w, ll_bounces *b, double h, double reach)
{
    enum { least = 8 }; /* words: a row takes about 5 ns */
    if (b->crowded) {
        sweep_crowd(w, b, h, reach);
        return;
    }
    marking m = {b, h};
    ll_team_run(b->team, (b->count + 31) / 32, least, mark_part, &m);
    for (int k = 0; k < most_sweeps && sweep(w, b, h, reach); k++) {
    }
}

void ll_end_bounces(ll_rigid *w, const ll_bounces *b)
{
    for (int32_t i = 0; i < b->count; i++)
        ll_contacts(w)[b->at[i]].recycled &= LISTED - 1;
}
