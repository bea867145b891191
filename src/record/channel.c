#include "record/channel.h"

#include <string.h>

const ll_channel_info ll_channels[LL_CHANNELS] = {
    [LL_CHANNEL_SESSION] = {"session", "Status and clock of the session: sent whenever it changes."},
    [LL_CHANNEL_CLOCK] = {"clock", "The daemon's clock."},
    [LL_CHANNEL_SCENE] = {"scene", "The drawn scene of a netgame."},
    [LL_CHANNEL_LANES] = {"lanes", "Messages and other events."},
    [LL_CHANNEL_GAUGES] = {"gauges", "Buffers, metrics and peers."},
    [LL_CHANNEL_INPUT_HISTORY] = {"input_history", "The last inputs of players with reconciliation."},
    [LL_CHANNEL_BUFFERED] = {"buffered", "Snapshots in the interpolation buffers."},
    [LL_CHANNEL_SHOTS] = {"shots", "The last shots, as evaluated by each side."},
    [LL_CHANNEL_TRAFFIC] = {"traffic", "Messages by type, losses and round trips of each player."},
    [LL_CHANNEL_MOTION] = {"motion", "A motion, integrated by each method."},
    [LL_CHANNEL_BODIES] = {"bodies", "Rigid bodies."},
    [LL_CHANNEL_CONTACTS] = {"contacts", "Contacts of rigid bodies."},
    [LL_CHANNEL_JOINTS] = {"joints", "Joints of rigid bodies."},
    [LL_CHANNEL_FIELD] = {"field", "A fluid: its numbers and the displayed field."},
    [LL_CHANNEL_POINTS] = {"points", "Particles of a fluid."},
};

ll_channel ll_channel_named(const char *name)
{
    ll_channel channel = 0;
    while (channel < LL_CHANNELS && strcmp(ll_channels[channel].name, name) != 0)
        channel++;
    return channel;
}
