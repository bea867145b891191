/* Weapon prediction of a client: when it may fire, what it predicts to hit, and its own projectiles as it
 * draws them.
 *
 * A shot leaves the muzzle in the rendered view that the player acted on. A hitscan shot is judged in that
 * view at once; a projectile flies on in the time of the views that follow. So both are what the shooter
 * sees, and what a client claims where the server is client-authoritative. Part of a simulation's block, in
 * games with weapons only: no pointers. */
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
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef struct ll_predicted_projectile {
    ll_point from, velocity; /* at launch */
    double gravity;
    ll_time start; /* render time, by the server's clock */
    int64_t tick;  /* the step that its input was meant for */
    int32_t state; /* ll_weapon_prediction_state */
    int32_t body;
} ll_predicted_projectile;

typedef struct ll_weapon_prediction {
    ll_arena arena;                                      /* the game's */
    ll_time drawn_time;                                  /* of the view below */
    int64_t ready[LL_WEAPONS];                           /* the first step in which it may fire again */
    int64_t fired;                                       /* projectiles */
    ll_predicted_projectile projectiles[LL_PROJECTILES]; /* by number modulo the ring */
    ll_point drawn[LL_BODIES_MAX];                       /* bodies in the last rendered view */
} ll_weapon_prediction;

#pragma GCC diagnostic pop

static inline ll_flight ll_predicted_flight(const ll_weapon_prediction *weapon_prediction,
                                            const ll_predicted_projectile *projectile)
{
    return (ll_flight){projectile->from, projectile->velocity, projectile->gravity,
                       weapon_prediction->arena.projectile_drag};
}

/* Starts with what the client draws; projectiles in flight are dropped. */
void ll_weapon_prediction_start(const struct ll_client *client, const struct ll_client_setup *setup);

/* Completes an input that was made on a view of time `seen`: removes presses before a weapon is ready, and
 * adds the predicted hit. */
void ll_weapon_prediction_input(struct ll_client *client, const struct ll_client_setup *setup,
                                struct ll_pending_input *input, ll_time seen, ll_time now);

/* After a view was rendered: moves the own projectiles to its time. */
void ll_weapon_prediction_frame(const struct ll_client *client, const struct ll_client_setup *setup);
