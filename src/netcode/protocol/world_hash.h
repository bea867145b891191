/* A world's hash as it travels. */
#pragma once

#include "game/core/game.h"

uint32_t ll_world_hash(const ll_world *world);
