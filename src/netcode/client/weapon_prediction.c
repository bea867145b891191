#include "netcode/state/weapon_prediction.h"

#include <string.h>

#include "netcode/metrics/shots.h"
#include "netcode/state/client.h"

void ll_weapon_prediction_start(const ll_client *c, const ll_client_setup *s)
{
    ll_weapon_prediction *weapon_prediction = s->weapon_prediction;
    const ll_world *shown = ll_client_rendered_const(c);
    memset(weapon_prediction, 0, sizeof *weapon_prediction);
    s->game->weapons->arena(s->env, shown->players, &weapon_prediction->arena);
    ll_bodies_now(&weapon_prediction->arena, shown, weapon_prediction->drawn);
    weapon_prediction->drawn_time = c->drawing.view_time;
}

/* Smallest number of steps that is at least an interval. */
static int64_t steps_of(double interval_s, ll_freq freq)
{
    ll_time interval = (ll_time)(interval_s * 1e9);
    int64_t steps = ll_tick_at(interval, freq);
    return ll_tick_time(steps, freq) < interval ? steps + 1 : steps;
}

/* The body that a cheating client claims to hit. */
static int claimed_body(const ll_arena *arena, int self)
{
    int body = 0;
    while (body < arena->bodies && !ll_arena_enemies(arena, self, body))
        body++;
    return body < arena->bodies ? body : LL_NOBODY;
}

static void fire_cannon(ll_weapon_prediction *weapon_prediction, int64_t tick, ll_aim aim)
{
    const ll_arena *arena = &weapon_prediction->arena;
    ll_predicted_projectile *projectile =
        &weapon_prediction->projectiles[++weapon_prediction->fired % LL_PROJECTILES];
    double speed = arena->projectile_speed;
    projectile->from = aim.from;
    projectile->velocity = (ll_point){speed * aim.direction.x, speed * aim.direction.y};
    projectile->gravity = arena->gravity;
    projectile->start = weapon_prediction->drawn_time;
    projectile->tick = tick;
    projectile->state = LL_WEAPON_PREDICTION_FLYING;
    projectile->body = LL_NOBODY;
}

/* Claims the oldest hit of a projectile that was not claimed yet. */
static void claim_projectile(ll_weapon_prediction *weapon_prediction, ll_action *a)
{
    int64_t first =
        weapon_prediction->fired >= LL_PROJECTILES ? weapon_prediction->fired - LL_PROJECTILES + 1 : 1;
    for (int64_t number = first; number <= weapon_prediction->fired; number++) {
        ll_predicted_projectile *projectile = &weapon_prediction->projectiles[number % LL_PROJECTILES];
        if (projectile->state != LL_WEAPON_PREDICTION_HIT)
            continue;
        ll_set_claim(a, LL_PROJECTILE, projectile->body);
        ll_set_tag(a, number);
        projectile->state = LL_WEAPON_PREDICTION_ENDED;
        return;
    }
}

/* Whether a press counts. */
static bool may_fire(const ll_client_setup *s, int weapon, int64_t tick)
{
    const ll_weapon_prediction *weapon_prediction = s->weapon_prediction;
    bool full = weapon_prediction->projectiles[(weapon_prediction->fired + 1) % LL_PROJECTILES].state !=
                LL_WEAPON_PREDICTION_ENDED;
    if (weapon_prediction->arena.interval_s[weapon] == 0 || (weapon == LL_PROJECTILE && full))
        return false;
    return tick >= weapon_prediction->ready[weapon] || s->config->cheat == LL_CHEAT_FIRE_RATE;
}

/* Returns the body that a hitscan shot hits in the rendered view. */
static int fire(const ll_client *c, const ll_client_setup *s, int weapon, ll_aim aim, ll_action *a)
{
    ll_weapon_prediction *weapon_prediction = s->weapon_prediction;
    const ll_arena *arena = &weapon_prediction->arena;
    weapon_prediction->ready[weapon] =
        c->inputs.tick + steps_of(arena->interval_s[weapon], c->ticks.clock.freq);
    if (weapon == LL_PROJECTILE) {
        fire_cannon(weapon_prediction, c->inputs.tick, aim);
        ll_set_tag(a, weapon_prediction->fired);
        return LL_NOBODY;
    }
    int body = ll_arena_ray(arena, c->self, aim.from, aim.direction, weapon_prediction->drawn);
    ll_set_claim(a, LL_HITSCAN, s->config->cheat == LL_CHEAT_CLAIM ? claimed_body(arena, c->self) : body);
    return body;
}

void ll_weapon_prediction_input(ll_client *c, const ll_client_setup *s, ll_pending_input *input, ll_time seen,
                                ll_time now)
{
    ll_action *a = &input->action;
    a->buttons &= LL_BUTTONS;
    for (int w = 0; w < LL_WEAPONS; w++) {
        uint32_t button = UINT32_C(1) << w;
        if (!(a->buttons & button))
            continue;
        if (!may_fire(s, w, c->inputs.tick)) {
            a->buttons &= ~button;
            continue;
        }
        ll_aim aim = s->game->weapons->aim(ll_client_rendered(c), s->env, c->self, a);
        ll_press press = {c->inputs.tick, now, seen, aim, fire(c, s, w, aim, a)};
        ll_shots_press(s->shots, c->self, (ll_weapon)w, &press, s->weapon_prediction->drawn);
    }
    if (!(a->buttons & LL_BUTTON_CANNON))
        claim_projectile(s->weapon_prediction, a);
}

/* Moves a projectile from the last rendered view to this one, `drawn`. */
static void move_projectile(ll_predicted_projectile *projectile, const ll_client *c, const ll_client_setup *s,
                            const ll_point *drawn)
{
    const ll_weapon_prediction *weapon_prediction = s->weapon_prediction;
    double from = ll_to_s(weapon_prediction->drawn_time - projectile->start),
           to = ll_to_s(c->drawing.view_time - projectile->start);
    const ll_flight flight = ll_predicted_flight(weapon_prediction, projectile);
    ll_flight_hit m = ll_arena_flight(&weapon_prediction->arena, c->self, &flight, from, to,
                                      weapon_prediction->drawn, drawn);
    if (m.met == LL_MET_NOTHING)
        return;
    projectile->body = m.body;
    projectile->state = m.body == LL_NOBODY ? LL_WEAPON_PREDICTION_ENDED : LL_WEAPON_PREDICTION_HIT;
    ll_shots_seen(s->shots, c->self, projectile->tick, m.body);
}

void ll_weapon_prediction_frame(const ll_client *c, const ll_client_setup *s)
{
    ll_weapon_prediction *weapon_prediction = s->weapon_prediction;
    ll_point drawn[LL_BODIES_MAX];
    ll_bodies_now(&weapon_prediction->arena, ll_client_rendered_const(c), drawn);
    for (int i = 0; i < LL_PROJECTILES; i++)
        if (weapon_prediction->projectiles[i].state == LL_WEAPON_PREDICTION_FLYING &&
            c->drawing.view_time > weapon_prediction->drawn_time)
            move_projectile(&weapon_prediction->projectiles[i], c, s, drawn);
    memcpy(weapon_prediction->drawn, drawn, (size_t)weapon_prediction->arena.bodies * sizeof drawn[0]);
    weapon_prediction->drawn_time = c->drawing.view_time;
}
