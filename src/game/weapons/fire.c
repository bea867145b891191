#include "game/core/weapons.h"

#include "base/detmath.h"

static void tell(const ll_field *field, const ll_hit_result *hit_result)
{
    if (field->past && field->past->witness)
        field->past->witness(field->past->context, hit_result);
}

static const ll_hitscan_policy *policy_of(const ll_field *field)
{
    return &ll_hitscan_policies[field->past ? field->past->rules->hitscan : 0];
}

static const ll_projectile_family *family_of(const ll_field *field)
{
    return &ll_projectile_families[field->past ? field->past->rules->projectile : 0];
}

static bool looks_back(const ll_field *field, int weapon)
{
    return weapon == LL_HITSCAN ? policy_of(field)->rewinds : family_of(field)->looks_back;
}

/* The shooter's view time, limited by the rules, for an input of the step that ends at `now`. The view's age
 * counts from there; the rewind counts from the world that the shot is judged in, a step earlier. */
static void look_back(ll_shot *shot, const ll_field *field, ll_weapon weapon, uint32_t view_age_ns,
                      ll_time now)
{
    const ll_past *past = field->past;
    const ll_hitscan_policy *policy = policy_of(field);
    ll_time age = ll_view_age(past, shot->shooter, view_age_ns, &shot->view_time_rejected);
    ll_time start = ll_history_time(past->history, 0), seen = now - age;
    ll_time earliest = shot->now - ll_ms(past->rules->max_rewind_ms);
    if (weapon == LL_HITSCAN && policy->share && seen < shot->now) {
        double share = policy->share(past->params, age);
        seen = shot->now - (ll_time)(share * (double)(shot->now - seen));
        shot->clamped = share < 1;
    }
    shot->clamped = shot->looks_back && (shot->clamped || seen < earliest);
    if (seen < earliest)
        seen = earliest;
    shot->seen = seen < start ? start : seen > shot->now ? shot->now : seen;
}

static void fire_hitscan(ll_weapon_state *arms, const ll_field *field, const ll_shot *shot)
{
    const ll_hitscan_policy *policy = policy_of(field);
    int body = policy->judge(field, shot);
    bool vetoed = body != LL_NOBODY && policy->stands && !policy->stands(field, shot, body);
    if (vetoed)
        body = LL_NOBODY;
    arms->shots[LL_HITSCAN]++;
    arms->hits[LL_HITSCAN] += body != LL_NOBODY;
    tell(field, &(ll_hit_result){.kind = LL_HIT_RESULT_HITSCAN,
                                 .shooter = shot->shooter,
                                 .number = (uint32_t)arms->shots[LL_HITSCAN],
                                 .body = body,
                                 .vetoed = vetoed,
                                 .shot = shot,
                                 .rewound_to = policy->rewinds ? shot->seen : shot->now});
}

static ll_flight flight_of(const ll_projectile *projectile, const ll_arena *arena)
{
    return (ll_flight){projectile->from, projectile->velocity, arena->gravity, arena->projectile_drag};
}

/* `rewound_to`: time of the bodies that the projectile hit; LL_NEVER: that of its end. */
static void strike(ll_weapon_state *arms, ll_projectile *projectile, const ll_field *field, int shooter,
                   ll_flight_hit m, ll_time rewound_to)
{
    ll_flight flight = flight_of(projectile, field->arena);
    projectile->end = projectile->start + (ll_time)(m.s * 1e9 + 0.5);
    projectile->body = (int16_t)m.body;
    arms->hits[LL_PROJECTILE] += m.body != LL_NOBODY;
    tell(field, &(ll_hit_result){.kind = LL_HIT_RESULT_IMPACT,
                                 .shooter = shooter,
                                 .number = projectile->number,
                                 .body = m.body,
                                 .rewound_to = rewound_to == LL_NEVER ? projectile->end : rewound_to,
                                 .start = projectile->start,
                                 .end = projectile->end,
                                 .at = ll_flight_at(&flight, m.s)});
}

/* Distance between the tested path at the launch and the flight. A chord is farthest off in the middle; a
 * flight without drag, at the end. */
static double trace_error(const ll_field *field, const ll_flight *flight, double s)
{
    ll_flight traced = ll_traced(field->past, flight, s);
    bool neglects = field->past && field->past->rules->projectile_trace == LL_TRACE_DRAG_NEGLECTED;
    double farthest = neglects ? s : s / 2;
    ll_point a = ll_flight_at(&traced, farthest), b = ll_flight_at(flight, farthest);
    return ll_sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
}

static void fire_cannon(ll_weapon_state *arms, const ll_field *field, const ll_shot *shot)
{
    const ll_projectile_family *family = family_of(field);
    uint32_t number = (uint32_t)arms->shots[LL_PROJECTILE] + 1;
    ll_projectile *projectile = &arms->projectiles[number % LL_PROJECTILES];
    double speed = field->arena->projectile_speed;
    if (projectile->number > 0 && projectile->end == LL_NEVER)
        return;
    *projectile = (ll_projectile){.end = LL_NEVER,
                                  .from = shot->from,
                                  .velocity = {speed * shot->direction.x, speed * shot->direction.y},
                                  .number = number,
                                  .body = LL_NOBODY,
                                  .tag = shot->tag};
    ll_flight flight = flight_of(projectile, field->arena);
    arms->shots[LL_PROJECTILE]++;
    ll_flight_hit m = family->launch(field, shot, &flight, &projectile->start);
    tell(field, &(ll_hit_result){.kind = LL_HIT_RESULT_LAUNCH,
                                 .shooter = shot->shooter,
                                 .number = number,
                                 .body = LL_NOBODY,
                                 .shot = shot,
                                 .start = projectile->start,
                                 .trace_error_m =
                                     trace_error(field, &flight, ll_to_s(shot->now - projectile->start))});
    if (m.met != LL_MET_NOTHING)
        strike(arms, projectile, field, shot->shooter, m, family->rewinds ? LL_NEVER : shot->now);
}

/* With client authority: the projectile that the client names has hit what it reports. */
static void take_claim(ll_weapon_state *arms, const ll_field *field, int shooter, const ll_action *action,
                       ll_time now)
{
    int body = ll_claim(action, LL_PROJECTILE);
    for (int i = 0; i < LL_PROJECTILES && ll_arena_enemies(field->arena, shooter, body); i++) {
        ll_projectile *projectile = &arms->projectiles[i];
        ll_flight_hit m = {ll_to_s(now - projectile->start), LL_MET_BODY, body};
        if (projectile->number > 0 && projectile->end == LL_NEVER && projectile->tag == ll_tag(action))
            strike(arms, projectile, field, shooter, m, now);
    }
}

/* ns: steps are on whole nanoseconds, so that a number of them may be shorter than an interval */
#define SLOP 1000

/* Whether the weapon is ready; if so, reloading starts. */
static bool load(ll_weapon_state *arms, const ll_field *field, int shooter, int weapon, ll_time now)
{
    if (now + SLOP < arms->ready[weapon]) {
        tell(field, &(ll_hit_result){.kind = LL_HIT_RESULT_VOID, .shooter = shooter, .body = LL_NOBODY});
        return false;
    }
    arms->ready[weapon] = now + (ll_time)(field->arena->interval_s[weapon] * 1e9);
    return true;
}

void ll_weapons_fire(ll_weapon_state *arms, const ll_field *field, int shooter, const ll_action *action,
                     ll_aim aim, ll_time before, ll_time now)
{
    static void (*const fire[])(ll_weapon_state *, const ll_field *, const ll_shot *) = {fire_hitscan,
                                                                                         fire_cannon};
    if (family_of(field)->claims)
        take_claim(arms, field, shooter, action, before);
    for (int w = 0; w < LL_WEAPONS; w++) {
        bool carried = field->arena->interval_s[w] > 0, pressed = action->buttons >> w & 1;
        if (!carried || !pressed || !load(arms, field, shooter, w, now))
            continue;
        ll_shot shot = {.shooter = shooter,
                        .claim = (int16_t)ll_claim(action, (ll_weapon)w),
                        .tag = ll_tag(action),
                        .from = aim.from,
                        .direction = aim.direction,
                        .now = before,
                        .seen = before,
                        .looks_back = looks_back(field, w)};
        if (field->past)
            look_back(&shot, field, (ll_weapon)w, action->view_age_ns, now);
        fire[w](arms, field, &shot);
    }
}

#define CLAIM_GRACE_S 1.0 /* s after its end at which a projectile can still be claimed */

/* A client-authoritative projectile ends without a claim a time after it has left the arena. */
static bool unclaimed(const ll_field *field, const ll_flight *flight, double s)
{
    const ll_box *b = &field->arena->bounds;
    ll_point p = ll_flight_at(flight, s - CLAIM_GRACE_S);
    return s > CLAIM_GRACE_S && (p.x < b->x_min || p.x > b->x_max || p.y < b->y_min);
}

static ll_flight_hit meet(const ll_field *field, int shooter, const ll_flight *flight, double s0, double s1,
                          const ll_point *after)
{
    if (!field->past || field->past->rules->projectile_trace != LL_TRACE_STRAIGHT)
        return ll_arena_flight(field->arena, shooter, flight, s0, s1, field->present, after);
    ll_flight chord = ll_flight_chord(flight, s0, s1);
    ll_flight_hit m = ll_arena_flight(field->arena, shooter, &chord, 0, s1 - s0, field->present, after);
    m.s += s0;
    return m;
}

void ll_weapons_fly(ll_weapon_state *arms, const ll_field *field, int shooter, const ll_point *after,
                    ll_time before, ll_time now)
{
    for (int i = 0; i < LL_PROJECTILES; i++) {
        ll_projectile *projectile = &arms->projectiles[i];
        if (projectile->number == 0 || projectile->end != LL_NEVER)
            continue;
        ll_flight flight = flight_of(projectile, field->arena);
        double s0 = ll_to_s(before - projectile->start), s1 = ll_to_s(now - projectile->start);
        ll_flight_hit m = {s1, LL_MET_NOTHING, LL_NOBODY};
        if (!family_of(field)->claims)
            m = meet(field, shooter, &flight, s0, s1, after);
        else if (unclaimed(field, &flight, s1))
            m.met = LL_MET_BOUNDS;
        if (m.met != LL_MET_NOTHING)
            strike(arms, projectile, field, shooter, m, LL_NEVER);
    }
}
