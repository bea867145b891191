/* A world of a game at its start. */
#pragma once

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "game/games/games.h"

/* All players start on lane 0. The test frees it; `env` has what its steps need. */
static inline ll_world *world_open(const ll_game *game, const void *params, int players, double dt,
                                   ll_game_env *env)
{
    const int32_t lanes[LL_PLAYERS_MAX] = {0};
    ll_extent extent = game->extent(params, players);
    ll_world *world = calloc(1, ll_extent_size(extent));
    assert_non_null(world);
    world->players = players;
    world->entities = extent.entities;
    world->tail = extent.tail;
    env->dt = dt;
    env->dt_ns = (ll_time)(dt * 1e9);
    game->prepare(env, params);
    game->init(world, env, lanes);
    return world;
}

static inline ll_world *world_copy(const ll_world *world)
{
    ll_world *copy = malloc(ll_world_size(world));
    assert_non_null(copy);
    return memcpy(copy, world, ll_world_size(world));
}
