/* Scripts of the shooter: they act on what their client draws, and on nothing else.
 *
 *   varied  strafes by chance, shoots at whatever it sees, off the middle by up to `spread`
 *   steady  rides up and down, shoots at the middle of whatever it sees
 *   peek    comes out of cover every other second, shoots at players, and hides again
 *   hold    stands just above its wall and shoots at players
 *   idle    does nothing */
#include "base/detmath.h"
#include "base/rng.h"
#include "game/shooter.h"

#define LOOKOUT (LL_SHOOTER_WALL + 1.5) /* m: over the own wall */
#define HIDEOUT (LL_SHOOTER_WALL - 2.5)
#define PEEK (24 * LL_SECOND / 10)
#define PEEK_OUT (LL_SECOND)

static uint64_t draw(int player, int what, ll_time t, ll_time slot)
{
    return ll_rng_u64(0x73686f6f, (uint64_t)(player * 4 + what), (uint64_t)(t / slot));
}

/* ---- the lift ---- */

static float towards(double y, double goal)
{
    return goal > y + 0.05 ? 1.0f : goal < y - 0.05 ? -1.0f : 0.0f;
}

static float strafe(const ll_entity *own, int player, ll_script script, ll_time t)
{
    static const float ways[] = {1, -1, 1, -1, 0};
    switch (script) {
    case LL_SCRIPT_STEADY:
        if (own->y <= LL_SHOOTER_LIFT_LOW || own->y >= LL_SHOOTER_LIFT_HIGH)
            return own->y <= LL_SHOOTER_LIFT_LOW ? 1 : -1;
        return own->vy < 0 ? -1 : 1;
    case LL_SCRIPT_PEEK:
        return towards(own->y, (t + player * 700 * LL_MS) % PEEK < PEEK_OUT ? LOOKOUT : HIDEOUT);
    case LL_SCRIPT_HOLD:
        return towards(own->y, LOOKOUT);
    default:
        return ways[draw(player, 0, t, LL_SECOND * 7 / 10) % 5];
    }
}

/* ---- the aim ---- */

/* The first body in sight, from one on that changes every now and then. */
static int choose(const ll_arena *arena, const ll_world *world, int player, bool players_only, ll_time t)
{
    const ll_entity *own = &world->entity[player];
    int bodies = players_only ? arena->players : arena->bodies;
    int first = (int)(draw(player, 1, t, LL_SECOND * 6 / 10) % (uint64_t)bodies);
    for (int k = 0; k < bodies; k++) {
        int i = (first + k) % bodies;
        const ll_entity *e = &world->entity[i];
        if (ll_arena_enemies(arena, player, i) &&
            ll_arena_sees(arena, (ll_point){own->x, own->y}, (ll_point){e->x, e->y}))
            return i;
    }
    return LL_NOBODY;
}

/* The way to what is aimed at, from the own place on: `forward` is towards the other tower. */
typedef struct way {
    double forward, up;
} way;

/* The lower of the two elevations by which a shell passes through a place; false when it is out of reach. */
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

/* With the lead that the flight takes, found by going there a few times in thought. */
static bool lay_cannon(const ll_shooter_params *p, way to, way velocity, double *elevation)
{
    double seconds = 0;
    for (int i = 0; i < 5; i++) {
        way led = {to.forward + velocity.forward * seconds, to.up + velocity.up * seconds};
        if (!elevation_to(led, p->shell_speed, p->gravity, elevation, &seconds))
            return false;
    }
    return true;
}

/* Off the middle, across the line of fire. */
static way scatter(way to, double radius, int player, ll_time t)
{
    double length = ll_sqrt(to.forward * to.forward + to.up * to.up);
    double off = radius * (2 * ll_rng_unit(0x73707264, (uint64_t)player, (uint64_t)(t / (50 * LL_MS))) - 1);
    return (way){to.forward - off * to.up / length, to.up + off * to.forward / length};
}

static ll_weapon weapon_at(const ll_shooter_params *p, ll_time t)
{
    if (p->weapons == LL_SHOOTER_BOTH)
        return t / (LL_SECOND / 4) % 4 == 0 ? LL_CANNON : LL_RIFLE;
    return p->weapons == LL_SHOOTER_CANNON ? LL_CANNON : LL_RIFLE;
}

ll_action ll_shooter_drive(const ll_world *world, const ll_game_env *env, int player, ll_script script,
                           ll_time t)
{
    const ll_shooter_params *p = ll_shooter_params_of(env);
    const ll_entity *own = &world->entity[player];
    ll_action a = {0};
    if (script == LL_SCRIPT_IDLE)
        return a;
    a.axis[0] = strafe(own, player, script, t);
    ll_arena arena;
    ll_shooter_arena(env, world->players, &arena);
    int body = choose(&arena, world, player, script == LL_SCRIPT_PEEK || script == LL_SCRIPT_HOLD, t);
    if (body == LL_NOBODY)
        return a;
    const ll_entity *e = &world->entity[body];
    double facing = ll_shooter_facing(player), elevation;
    way to = {facing * (e->x - own->x), e->y - own->y};
    if (script != LL_SCRIPT_STEADY)
        to = scatter(to, p->spread * ll_arena_radius(&arena, body), player, t);
    ll_weapon weapon = weapon_at(p, t);
    if (weapon == LL_RIFLE)
        elevation = ll_atan2(to.up, to.forward);
    else if (!lay_cannon(p, to, (way){facing * e->vx, e->vy}, &elevation))
        return a;
    a.axis[1] = (float)ll_clamp(elevation / LL_SHOOTER_QUARTER, -1, 1);
    a.buttons = UINT32_C(1) << weapon;
    return a;
}
