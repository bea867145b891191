#include "netcode/client/cheat.h"

#include "netcode/state/client.h"

#define LEAP_S 2 /* between two leaps */
#define LEAP 1000.0f

#define HASTE 0.5 /* of the distance of a step, in addition */
#define AHEAD_M 10

/* longer than a server may take for a stall of the link; of every two such times */
#define HOLD (3 * LL_SECOND)

typedef struct cheat {
    void (*tamper)(ll_action *action, int64_t frame, int64_t frames_per_s);
    int every;  /* one extra input every this many frames; 0: none */
    bool holds; /* holds its packets back for HOLD out of every 2 HOLD */
    void (*move)(ll_entity *own, double dt, int64_t tick, int64_t ticks_per_s);
} cheat;

static void enlarge(ll_action *a, int64_t frame, int64_t frames_per_s)
{
    (void)frame;
    (void)frames_per_s;
    a->axis[0] *= 1.5f;
}

static void leap(ll_action *a, int64_t frame, int64_t frames_per_s)
{
    if (frame % (LEAP_S * frames_per_s) == frames_per_s)
        a->axis[0] = LEAP;
}

static void hurry(ll_entity *own, double dt, int64_t tick, int64_t ticks_per_s)
{
    (void)tick;
    (void)ticks_per_s;
    own->x += HASTE * dt * own->vx;
    own->y += HASTE * dt * own->vy;
}

static void get_ahead(ll_entity *own, double dt, int64_t tick, int64_t ticks_per_s)
{
    (void)dt;
    if (tick % (LEAP_S * ticks_per_s) == ticks_per_s)
        own->x += AHEAD_M;
}

/* The long-run rate limit allows twice as many inputs: it has to leave room for clients that catch up. */
static const cheat cheats[LL_CHEATS] = {
    [LL_CHEAT_MAGNITUDE] = {.tamper = enlarge}, [LL_CHEAT_RATE] = {.every = 1},
    [LL_CHEAT_BUDGET] = {.every = 5},           [LL_CHEAT_TELEPORT] = {.tamper = leap},
    [LL_CHEAT_LAG_SWITCH] = {.holds = true},    [LL_CHEAT_SPEED] = {.move = hurry},
    [LL_CHEAT_LEAP] = {.move = get_ahead},
};

static const cheat *cheat_of(const ll_client_setup *s)
{
    return &cheats[s->config->cheat];
}

void ll_cheat_action(const ll_client *c, const ll_client_setup *s, ll_action *action)
{
    if (cheat_of(s)->tamper)
        cheat_of(s)->tamper(action, c->ticks.number, (c->ticks.clock.freq + 500) / 1000);
}

void ll_cheat_move(const ll_client *c, const ll_client_setup *s, ll_entity *own, int64_t tick)
{
    cheat_of(s)->move(own, s->env->dt, tick, (c->ticks.clock.freq + 500) / 1000);
}

void ll_cheat_aim(const ll_client *c, const ll_client_setup *s, const ll_world *seen, ll_time t,
                  ll_action *action)
{
    if (!s->weapon_prediction)
        return;
    const ll_action bot = s->game->drive(seen, s->env, s->seed, c->self, LL_SCRIPT_STEADY, t);
    action->axis[1] = bot.axis[1];
    action->buttons = bot.buttons;
}

int ll_cheat_extra(const ll_client *c, const ll_client_setup *s)
{
    int every = cheat_of(s)->every;
    return every > 0 && c->ticks.number % every == 0;
}

bool ll_cheat_minds(const ll_client_setup *s)
{
    return cheat_of(s)->every == 0 && !cheat_of(s)->holds;
}

bool ll_cheat_holds(const ll_client_setup *s, ll_time now)
{
    return cheat_of(s)->holds && now / HOLD % 2 == 1;
}
