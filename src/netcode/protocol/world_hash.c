#include "netcode/protocol/world_hash.h"

#include "base/hash.h"

uint32_t ll_world_hash(const ll_world *world)
{
    return (uint32_t)ll_hash(0, world, ll_world_size(world));
}
