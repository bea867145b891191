/* Values of controls: of a game's player, or of a person's pointer in other simulations. */
#pragma once

#include <stdint.h>

#define LL_PLAYERS_MAX 64
#define LL_PEERS_MAX 16 /* of a game that is not `many`, and where clients step others' entities */

/* Controls of one player, by a person or a script. Axes in [-1, 1]; the game defines their meaning. */
typedef struct ll_action {
    float axis[2];
    uint32_t buttons;     /* LL_BUTTON_*, and the target that a client claims to hit: ll_claim */
    uint32_t view_age_ns; /* age of the player's view at the step of this action; at most 4.29 s */
} ll_action;

enum { LL_BUTTON_FIRE = 1, LL_BUTTON_CANNON = 2, LL_BUTTONS = 255 };
