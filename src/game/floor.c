#include "game/floor.h"

#include "base/assert.h"
#include "base/detmath.h"
#include "game/floor_contact.h"
#include "game/games.h"

#define SWEEPS 16     /* over all contacts of a substep: a push is passed on along so many bodies and more */
#define SHIFTS 4      /* sweeps that take overlap away */
#define SLOP 0.002    /* m: overlap that may stay, so that what lies together comes to rest */
#define CONTACTS 2048 /* of a substep; a dense heap of 255 boxes has about 1000 */
#define BUCKETS 512   /* of the grid; a power of two */
#define CELLS_MAX 65535 /* along a side */

typedef struct contact {
    int32_t a, b; /* bodies; b may be LL_FLOOR_WALL */
    ll_floor_point at;
    double ax, ay, bx, by; /* from the bodies' centres to the point */
    double mass;           /* that an impulse along the normal meets */
    double impulse;
} contact;

/* What a substep knows of a body beyond the body. */
typedef struct state {
    ll_floor_frame frame; /* at the start of the substep */
    double angle;
    double floor_x, floor_y, floor_spin; /* what the floor has changed of velocity and spin */
    int32_t cell_x, cell_y;
    int16_t next; /* in its bucket; -1: the last */
    bool framed;  /* `frame` is up to date */
    bool reached; /* moves, or may be pressed */
    bool done;    /* its neighbours have been looked at */
    bool changed; /* by a contact, since the floor was asked last */
} state;

typedef struct work {
    const ll_floor *floor;
    ll_floor_body *body;
    int count, contacts, reached;
    double h;      /* s: of a substep */
    double margin; /* m: bodies that are so near may touch in it */
    int16_t bucket[BUCKETS];
    int16_t order[LL_ENTITIES_MAX]; /* of those that are reached */
    state state[LL_ENTITIES_MAX];
    contact contact[CONTACTS];
} work;

/* ---- who is near ---- */

static unsigned bucket_of(int32_t x, int32_t y)
{
    return ((unsigned)x * 73856093u ^ (unsigned)y * 19349663u) & (BUCKETS - 1);
}

static int32_t cell_of(double x, double width)
{
    return (int32_t)ll_clamp(x / width, 0, CELLS_MAX);
}

/* Cells are so wide that who is near lies in the same or the next. */
static void sort_into_cells(work *w)
{
    double width = 2 * 1.4142135623730951 * w->floor->half_max + w->margin;
    for (int i = 0; i < BUCKETS; i++)
        w->bucket[i] = -1;
    for (int i = w->count - 1; i >= 0; i--) {
        state *s = &w->state[i];
        s->cell_x = cell_of(w->body[i].x, width);
        s->cell_y = cell_of(w->body[i].y, width);
        int16_t *bucket = &w->bucket[bucket_of(s->cell_x, s->cell_y)];
        s->next = *bucket;
        *bucket = (int16_t)i;
    }
}

static const ll_floor_frame *frame_of(work *w, int i)
{
    state *s = &w->state[i];
    const ll_floor_body *b = &w->body[i];
    if (!s->framed)
        s->frame =
            (ll_floor_frame){b->x, b->y, b->round ? 1 : ll_cos(b->angle), b->round ? 0 : ll_sin(b->angle)};
    s->framed = true;
    return &s->frame;
}

/* ---- contacts ---- */

static void reach(work *w, int i)
{
    if (w->state[i].reached)
        return;
    w->state[i].reached = true;
    w->order[w->reached++] = (int16_t)i;
}

static double turning(const ll_floor_body *b, double x, double y, const ll_floor_point *at)
{
    double arm = x * at->ny - y * at->nx;
    return b->inverse_inertia * arm * arm;
}

static void add_contact(work *w, int a, int b, const ll_floor_point *at)
{
    if (w->contacts == CONTACTS)
        return;
    contact *c = &w->contact[w->contacts++];
    const ll_floor_body *first = &w->body[a], *second = b == LL_FLOOR_WALL ? NULL : &w->body[b];
    *c = (contact){.a = a, .b = b, .at = *at, .ax = at->x - first->x, .ay = at->y - first->y};
    double inverse = first->inverse_mass + turning(first, c->ax, c->ay, at);
    if (second) {
        c->bx = at->x - second->x;
        c->by = at->y - second->y;
        inverse += second->inverse_mass + turning(second, c->bx, c->by, at);
    }
    c->mass = 1 / inverse;
}

static void touch_bodies(work *w, int i)
{
    const state *s = &w->state[i];
    ll_floor_point points[2];
    for (int32_t dy = -1; dy <= 1; dy++)
        for (int32_t dx = -1; dx <= 1; dx++) {
            int32_t x = s->cell_x + dx, y = s->cell_y + dy;
            for (int j = w->bucket[bucket_of(x, y)]; j >= 0; j = w->state[j].next) {
                const state *t = &w->state[j];
                const ll_floor_body *a = &w->body[i], *b = &w->body[j];
                if (t->cell_x != x || t->cell_y != y || t->done || j == i ||
                    (a->inverse_mass == 0 && b->inverse_mass == 0))
                    continue;
                int n = ll_floor_touch(a, frame_of(w, i), b, frame_of(w, j), w->margin, points);
                for (int k = 0; k < n; k++)
                    add_contact(w, i, j, &points[k]);
                if (n > 0)
                    reach(w, j);
            }
        }
}

static void touch_walls(work *w, int i)
{
    static const double normals[4][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}};
    const ll_floor_body *b = &w->body[i];
    ll_floor_point points[2];
    for (int k = 0; k < 4 && b->inverse_mass > 0; k++) {
        double nx = normals[k][0], ny = normals[k][1],
               wall = nx > 0   ? w->floor->width
                      : ny > 0 ? w->floor->depth
                               : 0;
        double beyond = wall - (b->x * nx + b->y * ny) - ll_floor_bound(b);
        if (beyond > w->margin)
            continue;
        int n = ll_floor_touch_wall(b, frame_of(w, i), nx, ny, wall, w->margin, points);
        for (int j = 0; j < n; j++)
            add_contact(w, i, LL_FLOOR_WALL, &points[j]);
    }
}

static bool moves(const ll_floor_body *b)
{
    return b->inverse_mass > 0 && (b->vx != 0 || b->vy != 0 || b->spin != 0 || b->wanted_vx != 0 ||
                                   b->wanted_vy != 0 || b->unsettled);
}

/* Contacts of those that move, of those that these may press, and so on. */
static void find_contacts(work *w)
{
    w->contacts = w->reached = 0;
    for (int i = 0; i < w->count; i++) {
        state *s = &w->state[i];
        s->framed = s->reached = s->done = false;
        s->floor_x = s->floor_y = s->floor_spin = 0;
        s->changed = true;
        if (moves(&w->body[i]))
            reach(w, i);
    }
    if (w->reached == 0)
        return;
    sort_into_cells(w);
    for (int k = 0; k < w->reached; k++) {
        int i = w->order[k];
        touch_bodies(w, i);
        touch_walls(w, i);
        w->state[i].done = true;
    }
}

/* ---- velocities ---- */

/* Brings the body to what it wants, as far as the floor holds. The projection onto a disc is exact, since the
 * floor meets the same mass in every direction. */
static void hold(work *w, int i)
{
    state *s = &w->state[i];
    ll_floor_body *b = &w->body[i];
    double most = b->grip * w->h, most_spin = b->grip_spin * w->h;
    double dx = s->floor_x + b->wanted_vx - b->vx, dy = s->floor_y + b->wanted_vy - b->vy;
    double size2 = dx * dx + dy * dy;
    s->changed = false;
    if (size2 <= most * most) {
        b->vx = b->wanted_vx;
        b->vy = b->wanted_vy;
    } else {
        double share = most / ll_sqrt(size2);
        dx *= share;
        dy *= share;
        b->vx += dx - s->floor_x;
        b->vy += dy - s->floor_y;
    }
    s->floor_x = dx;
    s->floor_y = dy;
    double turn = s->floor_spin - b->spin, held = ll_clamp(turn, -most_spin, most_spin);
    b->spin = held == turn ? 0 : b->spin + held - s->floor_spin;
    s->floor_spin = held;
}

static double approach(const work *w, const contact *c)
{
    const ll_floor_body *a = &w->body[c->a];
    double vx = -(a->vx - a->spin * c->ay), vy = -(a->vy + a->spin * c->ax);
    if (c->b != LL_FLOOR_WALL) {
        const ll_floor_body *b = &w->body[c->b];
        vx += b->vx - b->spin * c->by;
        vy += b->vy + b->spin * c->bx;
    }
    return vx * c->at.nx + vy * c->at.ny;
}

static void push(ll_floor_body *b, double x, double y, const contact *c, double impulse)
{
    b->vx += b->inverse_mass * impulse * c->at.nx;
    b->vy += b->inverse_mass * impulse * c->at.ny;
    b->spin += b->inverse_inertia * impulse * (x * c->at.ny - y * c->at.nx);
}

/* No faster towards one another than the gap allows. */
static void press(work *w, contact *c)
{
    double room = c->at.gap > 0 ? c->at.gap / w->h : 0;
    double impulse = c->impulse - c->mass * (approach(w, c) + room);
    impulse = impulse > 0 ? impulse : 0;
    double more = impulse - c->impulse;
    if (more == 0)
        return;
    c->impulse = impulse;
    push(&w->body[c->a], c->ax, c->ay, c, -more);
    w->state[c->a].changed = true;
    if (c->b == LL_FLOOR_WALL)
        return;
    push(&w->body[c->b], c->bx, c->by, c, more);
    w->state[c->b].changed = true;
}

static bool hold_all(work *w)
{
    bool any = false;
    for (int k = 0; k < w->reached; k++) {
        int i = w->order[k];
        if (!w->state[i].changed || w->body[i].inverse_mass == 0)
            continue;
        hold(w, i);
        any = true;
    }
    return any;
}

/* The floor has the last word, so that what it can hold is at rest to the bit. */
static void solve(work *w)
{
    hold_all(w);
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        for (int k = 0; k < w->contacts; k++)
            press(w, &w->contact[k]);
        if (!hold_all(w))
            break;
    }
}

static void note_pressed(work *w)
{
    for (int k = 0; k < w->contacts; k++) {
        const contact *c = &w->contact[k];
        if (c->impulse == 0 || c->b == LL_FLOOR_WALL)
            continue;
        if (c->a < 32)
            w->body[c->b].pressed_by |= UINT32_C(1) << c->a;
        if (c->b < 32)
            w->body[c->a].pressed_by |= UINT32_C(1) << c->b;
    }
}

/* ---- places ---- */

static void move(work *w, const ll_game_env *env)
{
    for (int k = 0; k < w->reached; k++) {
        int i = w->order[k];
        ll_floor_body *b = &w->body[i];
        double top = w->floor->top_speed, speed2 = b->vx * b->vx + b->vy * b->vy;
        double top_spin = top / ll_floor_bound(b);
        if (speed2 > top * top) {
            double share = top / ll_sqrt(speed2);
            b->vx *= share;
            b->vy *= share;
        }
        b->spin = ll_clamp(b->spin, -top_spin, top_spin);
        w->state[i].frame.x = b->x;
        w->state[i].frame.y = b->y;
        w->state[i].angle = b->angle;
        b->x = ll_mul_add(env, b->vx, w->h, b->x);
        b->y = ll_mul_add(env, b->vy, w->h, b->y);
        b->angle = ll_mul_add(env, b->spin, w->h, b->angle);
    }
}

/* How far a point of a body has come along the normal in this substep. */
static double shifted(const work *w, int i, double x, double y, const contact *c)
{
    const ll_floor_body *b = &w->body[i];
    const state *s = &w->state[i];
    double turn = b->angle - s->angle;
    return (b->x - s->frame.x - turn * y) * c->at.nx + (b->y - s->frame.y + turn * x) * c->at.ny;
}

static void shift(ll_floor_body *b, double x, double y, const contact *c, double by)
{
    b->x += b->inverse_mass * by * c->at.nx;
    b->y += b->inverse_mass * by * c->at.ny;
    b->angle += b->inverse_inertia * by * (x * c->at.ny - y * c->at.nx);
    b->unsettled = true;
}

/* Moves bodies apart that overlap by more than the slop, to less than it: so it ends, and they rest. */
static void part(work *w, const contact *c)
{
    double gap = c->at.gap - shifted(w, c->a, c->ax, c->ay, c);
    if (c->b != LL_FLOOR_WALL)
        gap += shifted(w, c->b, c->bx, c->by, c);
    if (gap >= -SLOP)
        return;
    double by = 0.5 * c->mass * (-gap - 0.5 * SLOP);
    shift(&w->body[c->a], c->ax, c->ay, c, -by);
    if (c->b != LL_FLOOR_WALL)
        shift(&w->body[c->b], c->bx, c->by, c, by);
}

static void part_all(work *w)
{
    for (int k = 0; k < w->reached; k++)
        w->body[w->order[k]].unsettled = false;
    for (int sweep = 0; sweep < SHIFTS; sweep++)
        for (int k = 0; k < w->contacts; k++)
            part(w, &w->contact[k]);
}

/* ---- a step ---- */

int ll_floor_substeps(double dt, double top_speed, double half_min)
{
    double n = dt * top_speed / (0.5 * half_min);
    return 1 + (int)n;
}

double ll_floor_margin(const ll_game_env *env, const ll_floor *floor)
{
    return 2 * floor->top_speed * env->dt / floor->substeps + SLOP;
}

void ll_floor_step(const ll_game_env *env, const ll_floor *floor, ll_floor_body *bodies, int count)
{
    work w;
    LL_ASSERT(count >= 0 && count <= LL_ENTITIES_MAX);
    w.floor = floor;
    w.body = bodies;
    w.count = count;
    w.h = env->dt / floor->substeps;
    w.margin = ll_floor_margin(env, floor);
    for (int i = 0; i < count; i++)
        bodies[i].pressed_by = 0;
    for (int k = 0; k < floor->substeps; k++) {
        find_contacts(&w);
        solve(&w);
        note_pressed(&w);
        move(&w, env);
        part_all(&w);
    }
}
