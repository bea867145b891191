/* The hash of a world as it is sent. */
#pragma once

#include "game/core/game.h"

uint32_t ll_world_hash(const ll_world *world);
