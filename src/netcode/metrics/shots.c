#include "netcode/metrics/shots.h"

#include <math.h>
#include <string.h>

#include "base/detmath.h"

/* longer than any delay from player to player: openings further apart are no pair */
#define PEEK_WINDOW (3 * LL_SECOND)
#define STOOD LL_SECOND /* an entity without motion for this long is standing */

typedef float seen_body[2];

static size_t seen_size(int players, int bodies)
{
    return (size_t)players * LL_SHOTS_KEPT * (size_t)bodies * sizeof(seen_body);
}

size_t ll_shots_size(int players, int bodies)
{
    return sizeof(ll_shots) + (size_t)players * sizeof(ll_shot_stats) + seen_size(players, bodies);
}

void ll_shots_init(ll_shots *shots, const ll_arena *arena, ll_time from)
{
    memset(shots, 0, ll_shots_size(arena->players, arena->bodies));
    shots->from = from;
    shots->arena = *arena;
    for (int i = 0; i < arena->players; i++) {
        ll_shot_stats *m = &shots->shot_stats[i];
        for (int w = 0; w < LL_WEAPONS; w++)
            m->last[w] = -1;
        ll_histogram_init(&m->rollback, 0.001);
        ll_histogram_init(&m->rewind, 0.1);
        ll_histogram_init(&m->trace_error, 0.0001);
        ll_histogram_init(&m->peek[0], 0.1);
        ll_histogram_init(&m->peek[1], 0.1);
        m->moved = -STOOD; /* no player has moved yet */
    }
}

static const seen_body *seen_of(const ll_shots *shots, int player, int64_t index)
{
    const seen_body *all = (const seen_body *)&shots->shot_stats[shots->arena.players];
    return all + (player * LL_SHOTS_KEPT + (index & (LL_SHOTS_KEPT - 1))) * shots->arena.bodies;
}

static ll_shot_record *record_at(ll_shot_stats *m, int64_t index)
{
    return &m->records[index & (LL_SHOTS_KEPT - 1)];
}

/* ---- judges ---- */

enum { ALL_JUDGES = (1 << LL_JUDGES) - 1 };

static double distance(ll_point a, ll_point b)
{
    return ll_sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
}

static void count(ll_shot_tally *t, const ll_shots *shots, const ll_shot_record *r)
{
    int view = r->body[LL_JUDGE_VIEW], server = r->body[LL_JUDGE_SERVER];
    bool within = (r->flags & (LL_SHOT_REWOUND | LL_SHOT_CLAMPED)) == LL_SHOT_REWOUND;
    t->shots++;
    for (int j = 0; j < LL_JUDGES; j++)
        t->hits[j] += r->body[j] != LL_NOBODY;
    t->agreed += view == server;
    t->within += within;
    t->within_agreed += within && view == server;
    t->false_hits += server != LL_NOBODY && view != server;
    t->false_misses += view != LL_NOBODY && view != server;
    t->kept += view != LL_NOBODY && view == server;
    t->on_players += server != LL_NOBODY && server < shots->arena.players;
    t->behind_cover += (r->flags & LL_SHOT_BEHIND_COVER) != 0;
    t->clamped += (r->flags & LL_SHOT_CLAMPED) != 0;
    t->view_time_rejected += (r->flags & LL_SHOT_VIEW_TIME_REJECTED) != 0;
}

static void speak(ll_shots *shots, int player, ll_shot_record *r, ll_judge judge, int body)
{

    if (r->decided >> judge & 1)
        return;
    r->body[judge] = (int16_t)body;
    r->decided |= (uint8_t)(1 << judge);
    if (r->decided == ALL_JUDGES && r->pressed >= shots->from)
        count(&shots->shot_stats[player].tally[r->weapon], shots, r);
}

static ll_shot_record *find(ll_shot_stats *m, int weapon, int64_t tick)
{
    for (int i = 0; i < LL_SHOTS_KEPT; i++)
        if (m->records[i].tick == tick && m->records[i].weapon == weapon)
            return &m->records[i];
    return NULL;
}

void ll_shots_press(ll_shots *shots, int player, ll_weapon weapon, const ll_press *p, const ll_point *bodies)
{
    ll_shot_stats *m = &shots->shot_stats[player];
    seen_body *seen = (seen_body *)seen_of(shots, player, m->presses);
    ll_shot_record *r = record_at(m, m->presses++);
    *r = (ll_shot_record){
        .tick = p->tick, .pressed = p->pressed, .seen = p->seen, .aim = p->aim, .weapon = (int32_t)weapon};
    for (int i = 0; i < shots->arena.bodies; i++) {
        seen[i][0] = (float)bodies[i].x;
        seen[i][1] = (float)bodies[i].y;
    }
    if (weapon == LL_HITSCAN)
        speak(shots, player, r, LL_JUDGE_VIEW, p->body);
}

void ll_shots_seen(ll_shots *shots, int player, int64_t tick, int body)
{
    ll_shot_record *r = find(&shots->shot_stats[player], LL_PROJECTILE, tick);
    if (r)
        speak(shots, player, r, LL_JUDGE_VIEW, body);
}

/* The server has evaluated the shot. */
static void take(ll_shot_stats *m, ll_shot_record *r, const ll_hit_result *j)
{
    m->last[r->weapon] = (int64_t)(r - m->records);
    r->evaluated_at = j->shot->now;
    r->muzzle = j->shot->from;
    r->number = j->number;
    r->flags |= (uint8_t)(LL_SHOT_TAKEN | (j->shot->looks_back ? LL_SHOT_REWOUND : 0) |
                          (j->shot->clamped ? LL_SHOT_CLAMPED : 0) |
                          (j->shot->view_time_rejected ? LL_SHOT_VIEW_TIME_REJECTED : 0));
}

static void measure_rollback(const ll_shots *shots, ll_shot_stats *m, const ll_shot_record *r, int body,
                             const ll_history *history, const ll_point *present)
{
    ll_point then[LL_BODIES_MAX];
    if (body == LL_NOBODY || r->rewound_to >= r->evaluated_at || r->pressed < shots->from)
        return;
    ll_bodies_at(&shots->arena, history, r->rewound_to, then);
    ll_histogram_add(&m->rollback, distance(then[body], present[body]));
}

static bool behind_cover(const ll_shots *shots, const ll_sight *victim, int shooter)
{
    const ll_entity *own = &victim->shown->entity[victim->self], *other = &victim->shown->entity[shooter];
    return !ll_arena_sees(&shots->arena, (ll_point){own->x, own->y}, (ll_point){other->x, other->y});
}

static void judge_hitscan(ll_shots *shots, const ll_hit_result *j, ll_shot_record *r,
                          const ll_history *history, const ll_point *present, const ll_sight *victim)
{
    ll_shot_stats *m = &shots->shot_stats[j->shooter];
    const ll_arena *arena = &shots->arena;
    ll_point then[LL_BODIES_MAX];
    take(m, r, j);
    r->rewound_to = j->rewound_to;
    if (victim && behind_cover(shots, victim, j->shooter))
        r->flags |= LL_SHOT_BEHIND_COVER;
    if (r->rewound_to < r->evaluated_at && r->pressed >= shots->from)
        ll_histogram_add(&m->rewind, ll_to_ms(r->evaluated_at - r->rewound_to));
    int seen = r->body[LL_JUDGE_VIEW];
    measure_rollback(shots, m, r, seen != LL_NOBODY ? seen : j->body, history, present);
    ll_bodies_at(arena, history, r->pressed, then);
    speak(shots, j->shooter, r, LL_JUDGE_NOW,
          ll_arena_ray(arena, j->shooter, j->shot->from, j->shot->direction, present));
    speak(shots, j->shooter, r, LL_JUDGE_PERFECT,
          ll_arena_ray(arena, j->shooter, r->aim.from, r->aim.direction, then));
    speak(shots, j->shooter, r, LL_JUDGE_SERVER, j->body);
}

static void judge_launch(const ll_shots *shots, ll_shot_stats *m, const ll_hit_result *j, ll_shot_record *r)
{
    take(m, r, j);
    r->rewound_to = j->start;
    if (r->pressed < shots->from)
        return;
    if (r->rewound_to < r->evaluated_at)
        ll_histogram_add(&m->rewind, ll_to_ms(r->evaluated_at - r->rewound_to));
    ll_histogram_add(&m->trace_error, j->trace_error_m);
}

static ll_shot_record *find_projectile(ll_shot_stats *m, uint32_t number)
{
    for (int i = 0; i < LL_SHOTS_KEPT; i++) {
        ll_shot_record *r = &m->records[i];
        if (r->weapon == LL_PROJECTILE && r->number == number && r->flags & LL_SHOT_TAKEN)
            return r;
    }
    return NULL;
}

static void judge_impact(ll_shots *shots, const ll_hit_result *j, const ll_history *history,
                         const ll_point *present)
{
    ll_shot_stats *m = &shots->shot_stats[j->shooter];
    ll_shot_record *r = find_projectile(m, j->number);
    if (!r)
        return;
    if (j->end < r->evaluated_at) { /* evaluated at a past time */
        r->rewound_to = j->rewound_to;
        measure_rollback(shots, m, r, j->body, history, present);
    }
    speak(shots, j->shooter, r, LL_JUDGE_SERVER, j->body);
}

void ll_shots_judge(ll_shots *shots, const ll_hit_result *j, int64_t tick, const ll_history *history,
                    const ll_world *world, const ll_sight *victim)
{
    ll_shot_stats *m = &shots->shot_stats[j->shooter];
    ll_point present[LL_BODIES_MAX];
    ll_bodies_now(&shots->arena, world, present);
    if (j->kind == LL_HIT_RESULT_IMPACT) {
        judge_impact(shots, j, history, present);
        return;
    }
    ll_shot_record *r = find(m, j->kind == LL_HIT_RESULT_HITSCAN ? LL_HITSCAN : LL_PROJECTILE, tick);
    if (r && j->kind == LL_HIT_RESULT_HITSCAN)
        judge_hitscan(shots, j, r, history, present, victim);
    else if (r && j->kind == LL_HIT_RESULT_LAUNCH)
        judge_launch(shots, m, j, r);
}

/* ---- steps ---- */

/* The server's last step, of all bodies. */
typedef struct slice {
    const ll_history *history;
    int64_t tick;
    ll_time begin, end;
    ll_point before[LL_BODIES_MAX], after[LL_BODIES_MAX];
} slice;

/* A projectile in the true world that only this judge flies, from `start` on. */
static void shadow(ll_shots *shots, int player, ll_shot_record *r, ll_judge judge, ll_point from,
                   ll_time start, const slice *step)
{
    const ll_arena *arena = &shots->arena;
    double speed = arena->projectile_speed;
    ll_flight flight = {from,
                        {speed * r->aim.direction.x, speed * r->aim.direction.y},
                        arena->gravity,
                        arena->projectile_drag};
    ll_flight_hit m;
    if (r->decided >> judge & 1 || start >= step->end)
        return;
    if (start > step->begin)
        m = ll_flight_through(arena, step->history, player, &flight, start, start, step->end);
    else
        m = ll_arena_flight(arena, player, &flight, ll_to_s(step->begin - start), ll_to_s(step->end - start),
                            step->before, step->after);
    if (m.met != LL_MET_NOTHING)
        speak(shots, player, r, judge, m.body);
}

static bool is_settled(const ll_shot_record *r)
{
    return r->flags & LL_SHOT_LOST || r->decided == ALL_JUDGES;
}

static void step_record(ll_shots *shots, int player, ll_shot_record *r, const slice *step)
{
    if (is_settled(r))
        return;
    if (r->tick <= step->tick && !(r->flags & LL_SHOT_TAKEN)) {
        r->flags |= LL_SHOT_LOST;
        shots->shot_stats[player].tally[r->weapon].lost += r->pressed >= shots->from;
        return;
    }
    if (r->weapon != LL_PROJECTILE)
        return;
    shadow(shots, player, r, LL_JUDGE_PERFECT, r->aim.from, r->pressed, step);
    if (r->flags & LL_SHOT_TAKEN)
        shadow(shots, player, r, LL_JUDGE_NOW, r->muzzle, r->evaluated_at, step);
}

void ll_shots_step(ll_shots *shots, int64_t tick, const ll_history *history)
{
    slice step = {
        .history = history, .tick = tick, .begin = shots->stepped, .end = ll_history_newest(history)};
    ll_bodies_at(&shots->arena, history, step.begin, step.before);
    ll_bodies_at(&shots->arena, history, step.end, step.after);
    for (int i = 0; i < shots->arena.players; i++) {
        ll_shot_stats *m = &shots->shot_stats[i];
        if (m->settled < m->presses - LL_SHOTS_KEPT)
            m->settled = m->presses - LL_SHOTS_KEPT;
        for (int64_t k = m->settled; k < m->presses; k++)
            step_record(shots, i, record_at(m, k), &step);
        while (m->settled < m->presses && is_settled(record_at(m, m->settled)))
            m->settled++;
    }
    shots->stepped = step.end;
}

/* ---- line of sight ---- */

/* The line of sight is open for both: finds which of the two moved, and which saw the other first. */
static void match(ll_shots *shots, int a, int b)
{
    ll_shot_stats *m = &shots->shot_stats[a], *n = &shots->shot_stats[b];
    ll_time advantage = n->opened[a] - m->opened[b];
    if (!(m->peeking >> b & 1) || !(n->awaiting >> a & 1) || advantage > PEEK_WINDOW ||
        -advantage > PEEK_WINDOW)
        return;
    m->peeking &= ~(UINT32_C(1) << b);
    n->awaiting &= ~(UINT32_C(1) << a);
    if (n->opened[a] >= shots->from)
        ll_histogram_add(&m->peek[advantage < 0], ll_to_ms(advantage < 0 ? -advantage : advantage));
}

static void notice(ll_shots *shots, int self, int other, bool sees, ll_time now)
{
    ll_shot_stats *m = &shots->shot_stats[self];
    uint32_t bit = UINT32_C(1) << other;
    if (sees == ((m->sees & bit) != 0))
        return;
    m->sees ^= bit;
    m->peeking = (m->peeking & ~bit) | (sees && m->moved == now ? bit : 0);
    m->awaiting = (m->awaiting & ~bit) | (sees && now - m->moved >= STOOD ? bit : 0);
    m->opened[other] = now;
    match(shots, self, other);
    match(shots, other, self);
}

void ll_shots_frame(ll_shots *shots, const ll_sight *sight, ll_time now)
{
    int self = sight->self;
    const ll_entity *own = &sight->shown->entity[self];
    if (own->vx != 0 || own->vy != 0)
        shots->shot_stats[self].moved = now;
    for (int i = 0; i < shots->arena.players; i++) {
        const ll_entity *e = &sight->shown->entity[i];
        if (ll_arena_enemies(&shots->arena, self, i))
            notice(shots, self, i,
                   ll_arena_sees(&shots->arena, (ll_point){own->x, own->y}, (ll_point){e->x, e->y}), now);
    }
}

/* The value of a 1-based rank in two histograms: magnitudes below zero, and values from zero on. */
static double ranked(const ll_histogram *below, const ll_histogram *from_zero, int64_t rank)
{
    if (rank <= below->count)
        return -ll_histogram_quantile(below, (double)(below->count - rank + 1) / (double)below->count);
    return ll_histogram_quantile(from_zero, (double)(rank - below->count) / (double)from_zero->count);
}

ll_summary ll_shots_peeks(const ll_shot_stats *m)
{
    static const double shares[] = {0.5, 0.95, 0.99, 1};
    const ll_histogram *from_zero = &m->peek[0], *below = &m->peek[1];
    int64_t count = from_zero->count + below->count;
    double n = (double)count, at[4];
    if (count == 0)
        return (ll_summary){0};
    for (int i = 0; i < 4; i++)
        at[i] = ranked(below, from_zero, (int64_t)ceil(shares[i] * n - 1e-9));
    return (ll_summary){.mean = (from_zero->sum - below->sum) / n,
                        .rms = ll_sqrt((from_zero->sum_squares + below->sum_squares) / n),
                        .p50 = at[0],
                        .p95 = at[1],
                        .p99 = at[2],
                        .max = at[3],
                        .count = count};
}

const ll_shot_record *ll_shots_last(const ll_shots *shots, int player, ll_weapon weapon,
                                    const float (**seen)[2])
{
    const ll_shot_stats *m = &shots->shot_stats[player];
    int64_t last = m->last[weapon];
    if (last < 0 || m->records[last].weapon != (int32_t)weapon || !(m->records[last].flags & LL_SHOT_TAKEN))
        return NULL; /* none, or another shot overwrote it in the ring */
    *seen = seen_of(shots, player, last);
    return &m->records[last];
}
