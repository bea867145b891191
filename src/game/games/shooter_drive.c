/* Scripts of the shooter: they depend only on what their client draws.
 *
 *   varied  strafes in slots of 0.7 +- 0.4 s, shoots at any body in sight, with an error of up to `spread`
 *   steady  moves up and down, shoots at the centre of any body in sight
 *   peek    in slots of 2.4 +- 0.8 s leaves cover for 0.9 to 1.3 s, shoots at players, and hides
 *           again, at 0.85 to 1 of its lift's speed
 *   hold    stands just above its wall and shoots at players
 *   react   as peek, but shoots only at players who have been in sight for 180 to 300 ms, as a person does
 *   turn    as react, and turns its aim to the target as a person does, ever slower, and shoots when it is
 * there idle    does nothing
 *
 * The first body to aim at is random in slots of 0.6 +- 0.4 s, the weapon in slots of 0.25 +- 0.15 s;
 * `steady` has these random choices too. */
#include "base/detmath.h"
#include "game/core/script.h"
#include "game/games/shooter.h"
#include "game/weapons/drag_flight.h"

#define LOOKOUT (LL_SHOOTER_WALL + 1.5) /* m: above its own wall */
#define HIDEOUT (LL_SHOOTER_WALL - 2.5)

enum { OWN_WAY = LL_SCRIPT_OWN, OWN_OUT, OWN_PACE, OWN_BODY, OWN_WEAPON, OWN_SCATTER, OWN_REACTION };

/* The script's player and time. */
typedef struct asked {
    uint64_t seed;
    int player;
    ll_script script;
    ll_time t;
} asked;

static ll_slot slot_of(const asked *a, int purpose, int mean_ms, int spread_ms)
{
    return ll_script_slot(a->seed, a->player, purpose, a->t, mean_ms * LL_MS, spread_ms * LL_MS);
}

static uint64_t draw(const asked *a, int purpose, int64_t counter)
{
    return ll_script_draw(a->seed, a->player, purpose, counter);
}

/* ---- the lift ---- */

static float towards(double y, double goal)
{
    return goal > y + 0.05 ? 1.0f : goal < y - 0.05 ? -1.0f : 0.0f;
}

/* At a random fraction of the lift's speed, so that it does not come into sight at the same phase of a step
 * each time. */
static float peek(const ll_entity *own, const asked *a)
{
    ll_slot slot = slot_of(a, LL_SCRIPT_SLOTS, 2400, 800);
    ll_time out = 900 * LL_MS + ll_script_time(a->seed, a->player, OWN_OUT, slot.number, 400 * LL_MS);
    double pace = 0.85 + 0.15 * ll_script_unit(a->seed, a->player, OWN_PACE, slot.number);
    return (float)pace * towards(own->y, slot.since < out ? LOOKOUT : HIDEOUT);
}

static float strafe(const ll_entity *own, const asked *a)
{
    static const float ways[] = {1, -1, 1, -1, 0};
    switch (a->script) {
    case LL_SCRIPT_STEADY:
        if (own->y <= LL_SHOOTER_LIFT_LOW || own->y >= LL_SHOOTER_LIFT_HIGH)
            return own->y <= LL_SHOOTER_LIFT_LOW ? 1 : -1;
        return own->vy < 0 ? -1 : 1;
    case LL_SCRIPT_PEEK:
    case LL_SCRIPT_REACT:
    case LL_SCRIPT_TURN:
        return peek(own, a);
    case LL_SCRIPT_HOLD:
        return towards(own->y, LOOKOUT);
    default:
        return ways[draw(a, OWN_WAY, slot_of(a, LL_SCRIPT_SLOTS, 700, 400).number) % 5];
    }
}

/* ---- the aim ---- */

/* Whether a body in sight would have been so for a person's reaction time too, had both moved as they now do:
 * a script remembers nothing. */
static __attribute__((noinline)) bool noticed(const ll_arena *arena, const ll_entity *own, const ll_entity *e,
                                              const asked *a)
{
    int64_t slot = slot_of(a, LL_SCRIPT_SLOTS, 2400, 800).number;
    double s = 0.18 + 0.12 * ll_script_unit(a->seed, a->player, OWN_REACTION, slot);
    return ll_arena_sees(arena, (ll_point){own->x - own->vx * s, own->y - own->vy * s},
                         (ll_point){e->x - e->vx * s, e->y - e->vy * s});
}

/* First body in sight, starting from one that changes every now and then. */
static int choose(const ll_arena *arena, const ll_world *world, const asked *a)
{
    const ll_entity *own = &world->entity[a->player];
    bool as_person = a->script == LL_SCRIPT_REACT || a->script == LL_SCRIPT_TURN;
    bool players_only = as_person || a->script == LL_SCRIPT_PEEK || a->script == LL_SCRIPT_HOLD;
    int bodies = players_only ? arena->players : arena->bodies;
    int first = (int)(draw(a, OWN_BODY, slot_of(a, LL_SCRIPT_AIM_SLOTS, 600, 400).number) % (uint64_t)bodies);
    for (int k = 0; k < bodies; k++) {
        int i = (first + k) % bodies;
        const ll_entity *e = &world->entity[i];
        if (ll_arena_enemies(arena, a->player, i) &&
            ll_arena_sees(arena, (ll_point){own->x, own->y}, (ll_point){e->x, e->y}) &&
            (!as_person || noticed(arena, own, e, a)))
            return i;
    }
    return LL_NOBODY;
}

/* Vector to the target from the own position; `forward` is towards the other tower. */
typedef struct way {
    double forward, up;
} way;

/* The lower of the two elevations at which a projectile passes through a point; false: out of reach. */
static bool elevation_to(way to, double speed, double gravity, double *elevation, double *seconds)
{
    double v2 = speed * speed;
    double within = v2 * v2 - gravity * (gravity * to.forward * to.forward + 2 * to.up * v2);
    if (within < 0 || to.forward <= 0)
        return false;
    *elevation = ll_atan2(v2 - ll_sqrt(within), gravity * to.forward);
    *seconds = to.forward / (speed * ll_cos(*elevation));
    return true;
}

#define FLIGHT_S 20 /* a longer flight is not waited for */

/* With drag: by aiming at a point above the target by what the last flight came too low. */
static __attribute__((noinline)) bool lay_against_drag(const ll_shooter_params *p, way to, way velocity,
                                                       double *elevation)
{
    double seconds = 0, raised = 0;
    for (int i = 0; i < 8; i++) {
        way led = {to.forward + velocity.forward * seconds, to.up + velocity.up * seconds};
        way above = {led.forward, led.up + raised};
        if (!elevation_to(above, p->shell_speed, p->gravity, elevation, &seconds))
            return false;
        const ll_flight f = {
            .velocity = {p->shell_speed * ll_cos(*elevation), p->shell_speed * ll_sin(*elevation)},
            .gravity = p->gravity,
            .drag = p->drag};
        seconds = ll_drag_flight_covers(&f, led.forward, FLIGHT_S);
        if (seconds < 0)
            return false;
        raised += led.up - ll_drag_flight_at(&f, seconds).y;
    }
    return true;
}

/* With lead for the time of flight, found by iteration. */
static bool lay_cannon(const ll_shooter_params *p, way to, way velocity, double *elevation)
{
    double seconds = 0;
    if (p->drag > 0)
        return lay_against_drag(p, to, velocity, elevation);
    for (int i = 0; i < 5; i++) {
        way led = {to.forward + velocity.forward * seconds, to.up + velocity.up * seconds};
        if (!elevation_to(led, p->shell_speed, p->gravity, elevation, &seconds))
            return false;
    }
    return true;
}

/* Random error across the line of fire. */
static way scatter(way to, double radius, const asked *a)
{
    double length = ll_sqrt(to.forward * to.forward + to.up * to.up);
    double off = radius * (2 * ll_script_unit(a->seed, a->player, OWN_SCATTER, a->t / (50 * LL_MS)) - 1);
    return (way){to.forward - off * to.up / length, to.up + off * to.forward / length};
}

#define TURN_S 0.06 /* the rest of a turn falls to 1/e; then a tenth of it remains after 0.14 s */

/* The aim turns from where its client draws it, by a share of what remains. True: it is within the body. */
static bool turn_to(const ll_entity *own, const ll_game_env *env, int player, double within,
                    double *elevation)
{
    double now = player % 2 == 0 ? own->angle : 2 * LL_SHOOTER_QUARTER - own->angle, goal = *elevation;
    *elevation = now + (goal - now) * (1 - ll_exp(-env->dt / TURN_S));
    return *elevation > goal - within && *elevation < goal + within;
}

static ll_weapon weapon_of(const ll_shooter_params *p, const asked *a)
{
    if (p->weapons == LL_SHOOTER_BOTH)
        return draw(a, OWN_WEAPON, slot_of(a, LL_SCRIPT_WEAPON_SLOTS, 250, 150).number) % 4 == 0
                   ? LL_PROJECTILE
                   : LL_HITSCAN;
    return p->weapons == LL_SHOOTER_CANNON ? LL_PROJECTILE : LL_HITSCAN;
}

ll_action ll_shooter_drive(const ll_world *world, const ll_game_env *env, uint64_t seed, int player,
                           ll_script script, ll_time t)
{
    const ll_shooter_params *p = ll_shooter_params_of(env);
    const asked who = {seed, player, script, t};
    const ll_entity *own = &world->entity[player];
    ll_action a = {0};
    if (script == LL_SCRIPT_IDLE)
        return a;
    a.axis[0] = strafe(own, &who);
    ll_arena arena;
    ll_shooter_arena(env, world->players, &arena);
    int body = choose(&arena, world, &who);
    double level = 0;
    if (body == LL_NOBODY && script == LL_SCRIPT_TURN) {
        turn_to(own, env, player, 0, &level);
        a.axis[1] = (float)ll_clamp(level / LL_SHOOTER_QUARTER, -1, 1);
    }
    if (body == LL_NOBODY)
        return a;
    const ll_entity *e = &world->entity[body];
    double facing = ll_shooter_facing(player), elevation;
    way to = {facing * (e->x - own->x), e->y - own->y};
    if (script != LL_SCRIPT_STEADY)
        to = scatter(to, p->spread * ll_arena_radius(&arena, body), &who);
    ll_weapon weapon = weapon_of(p, &who);
    if (weapon == LL_HITSCAN)
        elevation = ll_atan2(to.up, to.forward);
    else if (!lay_cannon(p, to, (way){facing * e->vx, e->vy}, &elevation))
        return a;
    bool there = true;
    if (script == LL_SCRIPT_TURN)
        there = turn_to(own, env, player, ll_arena_radius(&arena, body) / LL_SHOOTER_WIDTH, &elevation);
    a.axis[1] = (float)ll_clamp(elevation / LL_SHOOTER_QUARTER, -1, 1);
    a.buttons = there ? UINT32_C(1) << weapon : 0;
    return a;
}
