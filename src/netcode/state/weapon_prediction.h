/* A client's weapons: when it may fire, whom it believes that it hits, and its own shells as it draws them.
 *
 * A shot leaves the muzzle in the picture that the player acted on: a rifle's is judged in it at once, a
 * shell flies on in the time of the pictures that follow. So both are what the shooter sees, and what a
 * client claims where the server takes its word. Part of a simulation's block, in games with weapons only: no
 * pointers. */
#pragma once

#include "game/core/weapons.h"

struct ll_client;
struct ll_client_setup;
struct ll_pending_input;

typedef enum ll_weapon_prediction_state {
    LL_WEAPON_PREDICTION_ENDED,
    LL_WEAPON_PREDICTION_FLYING,
    LL_WEAPON_PREDICTION_HIT, /* to be claimed by the next input */
} ll_weapon_prediction_state;

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

typedef struct ll_weapon_prediction_shell {
    ll_flight flight;
    ll_time start; /* of the drawn time, by the server's clock */
    int64_t tick;  /* the step that its input was meant for */
    int32_t state; /* ll_weapon_prediction_state */
    int32_t body;
} ll_weapon_prediction_shell;

typedef struct ll_weapon_prediction {
    ll_arena arena;                               /* the game's */
    ll_time drawn_time;                           /* of the picture below */
    int64_t ready[LL_WEAPONS];                    /* the first step that may be fired in again */
    int64_t fired;                                /* shells */
    ll_weapon_prediction_shell shells[LL_SHELLS]; /* by number modulo the ring */
    ll_point drawn[LL_BODIES_MAX];                /* the bodies of the last picture */
} ll_weapon_prediction;

#pragma GCC diagnostic pop

/* Begins with what the client draws; what flies is forgotten. */
void ll_weapon_prediction_start(const struct ll_client *client, const struct ll_client_setup *setup);

/* Completes an input that was made upon a picture of `seen`: presses before a weapon is ready are taken out,
 * and what the client believes that it hits is put in. */
void ll_weapon_prediction_input(struct ll_client *client, const struct ll_client_setup *setup,
                                struct ll_pending_input *input, ll_time seen, ll_time now);

/* After a picture was drawn: flies the own shells to it. */
void ll_weapon_prediction_frame(const struct ll_client *client, const struct ll_client_setup *setup);
