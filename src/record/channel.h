/* Channels: groups of records that are drawn together. A viewer subscribes to each channel at a rate of its
 * own. */
#pragma once

#include <stdint.h>

typedef enum ll_channel {
    LL_CHANNEL_SESSION,
    LL_CHANNEL_CLOCK,
    LL_CHANNEL_SCENE,
    LL_CHANNEL_LANES,
    LL_CHANNEL_GAUGES,
    LL_CHANNEL_INPUT_HISTORY,
    LL_CHANNEL_BUFFERED,
    LL_CHANNEL_SHOTS,
    LL_CHANNEL_TRAFFIC,
    LL_CHANNEL_MOTION,
    LL_CHANNEL_BODIES,
    LL_CHANNEL_CONTACTS,
    LL_CHANNEL_JOINTS,
    LL_CHANNEL_FIELD,
    LL_CHANNEL_POINTS,
    LL_CHANNELS
} ll_channel;

typedef struct ll_channel_info {
    const char *name;
    const char *help;
} ll_channel_info;

extern const ll_channel_info ll_channels[LL_CHANNELS];

/* LL_CHANNELS: no channel has this name. */
ll_channel ll_channel_named(const char *name);
