#include "record/channel.h"

#include <string.h>

const ll_channel_info ll_channels[LL_CHANNELS] = {
    [LL_CHANNEL_SESSION] = {"session", "Where the session stands: sent whenever it changes."},
    [LL_CHANNEL_CLOCK] = {"clock", "The daemon's clock."},
    [LL_CHANNEL_SCENE] = {"scene", "What is drawn of a netgame."},
    [LL_CHANNEL_LANES] = {"lanes", "Messages and what else happened."},
    [LL_CHANNEL_GAUGES] = {"gauges", "Buffers, measures and peers."},
    [LL_CHANNEL_INPUT_HISTORY] = {"input_history", "The last inputs of players who reconcile."},
    [LL_CHANNEL_BUFFERED] = {"buffered", "States in the buffers."},
    [LL_CHANNEL_SHOTS] = {"shots", "The last shots, as each side judges them."},
    [LL_CHANNEL_MOTION] = {"motion", "A motion by each method."},
    [LL_CHANNEL_BODIES] = {"bodies", "Rigid bodies."},
    [LL_CHANNEL_CONTACTS] = {"contacts", "Where they touch."},
    [LL_CHANNEL_JOINTS] = {"joints", "What holds them together."},
    [LL_CHANNEL_FIELD] = {"field", "A fluid, its numbers and the field that is shown."},
    [LL_CHANNEL_POINTS] = {"points", "Points of a fluid."},
};

ll_channel ll_channel_named(const char *name)
{
    ll_channel channel = 0;
    while (channel < LL_CHANNELS && strcmp(ll_channels[channel].name, name) != 0)
        channel++;
    return channel;
}
