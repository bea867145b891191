#include "netcode/spectate/spectator.h"

#include <string.h>

#include "base/assert.h"

static ll_controls *inputs_of(ll_spectator *s, int64_t tick)
{
    return &s->inputs[(tick & (LL_SPECTATOR_RING - 1)) * s->players];
}

size_t ll_spectator_size(int players, size_t world_size)
{
    return sizeof(ll_spectator) + (size_t)players * LL_SPECTATOR_RING * sizeof(ll_controls) + world_size;
}

void ll_spectator_start(ll_spectator *s, const ll_world *world, uint16_t epoch, int64_t step, ll_clock ticks)
{
    memset(s, 0, ll_spectator_size(world->players, 0));
    s->players = world->players;
    s->epoch = epoch;
    s->ticks = ticks;
    s->tick = s->known = step;
    memcpy(ll_spectator_world(s), world, ll_world_size(world));
}

/* ---- packets ---- */

static void fall_out(ll_spectator *s)
{
    s->out = 1;
    s->falls++;
    s->asked = -1;
}

static void take_world(ll_spectator *s, const ll_feed_message *m)
{
    memcpy(ll_spectator_world(s), m + 1, ll_world_size(ll_spectator_world(s)));
    s->tick = s->known = m->tick - 1;
    s->out = 0;
    s->worlds++;
}

static void take_inputs(ll_spectator *s, const ll_feed_message *m)
{
    const char *at = (const char *)(m + 1);
    for (int p = 0; p < s->players; p++) {
        const uint32_t *runs = (const uint32_t *)(const void *)at;
        const ll_input_run *run = (const ll_input_run *)(runs + 1), *end = run + *runs;
        int64_t tick = m->tick;
        for (; run < end; run++)
            for (uint32_t i = 0; i < run->count; i++, tick++)
                if (tick > s->known) /* earlier ones repeat */
                    inputs_of(s, tick)[p] = run->input;
        at = (const char *)end;
    }
    s->known = m->tick + m->count - 1;
}

void ll_spectator_receive(ll_spectator *s, const ll_spectator_params *params, const void *packet)
{
    const ll_feed_message *m = packet;
    if (m->head.epoch != s->epoch)
        return;
    s->heard = 1;
    if (m->world != 0) {
        if (s->out && m->tick > s->tick) /* of a sender who knows less, what was shown would come again */
            take_world(s, m);
        return;
    }
    const int64_t last = (int64_t)m->tick + m->count - 1;
    if (s->out || last <= s->known)
        return;
    if (m->tick > s->known + 1 || last - s->tick > params->buffer_ticks)
        fall_out(s);
    else
        take_inputs(s, m);
}

bool ll_spectator_compose(ll_spectator *s, ll_watch_message *m)
{
    bool asks = s->out && (s->asked < 0 || s->number - s->asked >= LL_SPECTATOR_ASKS);
    if (!asks && (s->out || !s->heard))
        return false;
    s->heard = 0;
    s->asked = asks ? s->number : s->asked;
    *m = (ll_watch_message){.head = {LL_MESSAGE_PING, 0, s->epoch, 0},
                            .known = (int32_t)s->known,
                            .request = asks ? (uint32_t)s->falls : 0};
    return true;
}

/* ---- a tick ---- */

static void step(ll_spectator *s, const ll_game *game, const ll_game_env *env)
{
    ll_action actions[LL_PLAYERS_MAX];
    const ll_controls *inputs = inputs_of(s, ++s->tick);
    LL_ASSERT(s->tick <= s->known); /* nothing is guessed */
    for (int p = 0; p < s->players; p++)
        actions[p] = (ll_action){{inputs[p].axis[0], inputs[p].axis[1]}, inputs[p].buttons, 0};
    game->step(ll_spectator_world(s), env, actions, ll_clock_time(&s->ticks, s->tick), NULL);
}

int ll_spectator_tick(ll_spectator *s, const ll_spectator_params *params, const ll_game *game,
                      const ll_game_env *env)
{
    s->number++;
    s->out_ticks += s->out;
    if (s->out)
        return 0;
    const int64_t ahead = s->known - s->tick;
    const int ticks = ahead > params->behind_ticks && ahead > 1 ? 2 : ahead > 0;
    s->waits += ticks == 0;
    s->made += ticks;
    s->catch_up += ticks == 2;
    for (int i = 0; i < ticks; i++)
        step(s, game, env);
    return ticks;
}
