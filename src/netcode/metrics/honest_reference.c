#include "netcode/metrics/honest_reference.h"

#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"

static ll_honest_input *input_at(ll_honest_reference *t, int64_t number)
{
    _Static_assert((LL_HONEST_RING & (LL_HONEST_RING - 1)) == 0, "a mask finds the place");
    return &t->inputs[number & (LL_HONEST_RING - 1)];
}

static bool holds(const ll_honest_reference *t, int64_t number)
{
    return number <= t->newest && number > t->newest - LL_HONEST_RING;
}

void ll_honest_resync(ll_honest_reference *t, int64_t tick)
{
    t->newest = t->taken = tick;
    *input_at(t, tick) = (ll_honest_input){0};
}

void ll_honest_frame(ll_honest_reference *t, int64_t tick, ll_time due)
{
    if (tick - t->newest > LL_HONEST_RING)
        t->newest = tick - LL_HONEST_RING;
    while (t->newest < tick)
        *input_at(t, ++t->newest) = (ll_honest_input){due, {t->axis[0], t->axis[1]}};
}

/* The reference is never ahead of the client: the client has made that input too. */
void ll_honest_frame_once(ll_honest_reference *t, int64_t tick, ll_time due)
{
    ll_honest_frame(t, t->newest + 1 < tick ? t->newest + 1 : tick, due);
}

static bool next_is_due(ll_honest_reference *t, ll_time now)
{
    if (!holds(t, t->taken))
        t->taken = t->newest - LL_HONEST_RING + 1;
    return t->taken < t->newest && input_at(t, t->taken + 1)->due <= now;
}

void ll_honest_watch(ll_honest_reference *t, const ll_entity *e, ll_time now)
{
    while (next_is_due(t, now))
        t->taken++;
    t->entity = *e;
    t->x = e->x;
    t->y = e->y;
    t->ahead = 0;
}

static double distance(double x, double y)
{
    return ll_sqrt(x * x + y * y);
}

/* The game steps the reference in a copy of the server's world that differs only in this entity. */
static void move(ll_honest_reference *t, const ll_game *game, const ll_game_env *env, const ll_world *world,
                 int player, const ll_honest_input *input)
{
    _Alignas(8) char bytes[LL_GAME_WORLD_MAX];
    ll_world *own = (ll_world *)(void *)bytes;
    LL_ASSERT(ll_world_size(world) <= sizeof bytes && player < world->players);
    const ll_action action = {.axis = {input->axis[0], input->axis[1]}};
    memcpy(own, world, ll_world_size(world));
    own->entity[player] = t->entity;
    game->step_own(own, env, player, &action);
    const ll_entity *e = &own->entity[player];
    t->ahead -= distance(e->x - t->entity.x, e->y - t->entity.y);
    t->entity = *e;
}

/* By steps: the input of this step; if the client has made none yet, the one before. */
static void step_by_number(ll_honest_reference *t, const ll_game *game, const ll_game_env *env,
                           const ll_world *world, int player, int64_t step)
{
    if (holds(t, step))
        t->taken = step;
    else if (!holds(t, t->taken))
        t->taken = t->newest;
    move(t, game, env, world, player, input_at(t, t->taken));
}

static void step_by_time(ll_honest_reference *t, const ll_game *game, const ll_game_env *env,
                         const ll_world *world, int player, ll_time now)
{
    while (next_is_due(t, now))
        move(t, game, env, world, player, input_at(t, ++t->taken));
}

void ll_honest_step(ll_honest_reference *t, const ll_game *game, const ll_game_env *env, int player,
                    const ll_honest_stepped *stepped)
{
    const ll_world *world = stepped->world;
    const ll_entity *e = &world->entity[player];
    if (!game->farthest)
        return;
    t->ahead += distance(e->x - t->x, e->y - t->y);
    t->x = e->x;
    t->y = e->y;
    if (stepped->drains)
        step_by_time(t, game, env, world, player, stepped->now);
    else
        step_by_number(t, game, env, world, player, stepped->step);
    t->most = t->ahead > t->most ? t->ahead : t->most;
}
