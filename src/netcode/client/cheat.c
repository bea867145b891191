#include "netcode/client/cheat.h"

#include "netcode/state/client.h"

#define LEAP_S 2 /* between two leaps */
#define LEAP 1000.0f

#define HOLD                                                                                                 \
    (3 * LL_SECOND) /* longer than a server may take for a stall of the link; of every two such times */

typedef struct cheat {
    void (*tamper)(ll_action *action, int64_t frame, int64_t frames_per_s);
    int every;  /* one extra input every this many frames; 0: none */
    bool holds; /* holds its packets back for HOLD out of every 2 HOLD */
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

/* The long-run rate limit allows twice as many inputs: it has to leave room for clients that catch up. */
static const cheat cheats[LL_CHEATS] = {
    [LL_CHEAT_MAGNITUDE] = {.tamper = enlarge}, [LL_CHEAT_RATE] = {.every = 1},
    [LL_CHEAT_BUDGET] = {.every = 5},           [LL_CHEAT_TELEPORT] = {.tamper = leap},
    [LL_CHEAT_LAG_SWITCH] = {.holds = true},
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
