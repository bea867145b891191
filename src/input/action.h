/* What controls say: of a game's player, or of a person's hand on another simulation. */
#pragma once

#include <stdint.h>

#define LL_PLAYERS_MAX 16

/* What a person or a script does to one player's controls. Axes in [-1, 1]; the game says what they mean. */
typedef struct ll_action {
    float axis[2];
    uint32_t buttons;     /* LL_BUTTON_*, and what the client says that it hit: ll_claim */
    uint32_t view_age_ns; /* what the player saw when it acted: so long before the step that this is for; at
                             most 4.29 s */
} ll_action;

enum { LL_BUTTON_FIRE = 1, LL_BUTTON_CANNON = 2, LL_BUTTONS = 255 };
