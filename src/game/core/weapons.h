/* Weapons: their description by a game, their state in a world, and their part of a step.
 *
 * Hitscan shots are judged at once. A projectile is stored as its launch, which determines its position at
 * any time. So it is not stepped, and a client can draw it at its own view time. */
#pragma once

#include "game/core/compensate.h"

#define LL_PROJECTILES 3 /* per player in flight; further presses are void */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef struct ll_projectile {
    ll_time start, end;      /* server time; `end` is LL_NEVER while it flies */
    ll_point from, velocity; /* at launch */
    uint32_t number;         /* per owner, from 1; 0: none yet */
    int16_t body;            /* that it has hit, or LL_NOBODY */
    uint16_t tag;            /* names it in a client's claim */
} ll_projectile;

/* State of one player's weapons in a world. */
typedef struct ll_weapon_state {
    int32_t shots[LL_WEAPONS], hits[LL_WEAPONS];
    ll_time ready[LL_WEAPONS];                 /* earlier presses are void */
    ll_projectile projectiles[LL_PROJECTILES]; /* by number modulo the ring */
} ll_weapon_state;

#pragma GCC diagnostic pop

typedef struct ll_aim {
    ll_point from, direction; /* of the muzzle; a unit vector */
} ll_aim;

typedef struct ll_weapons {
    void (*arena)(const ll_game_env *env, int players, ll_arena *arena);
    ll_aim (*aim)(const ll_world *world, const ll_game_env *env, int player, const ll_action *action);
    const ll_weapon_state *(*arms)(const ll_world *world, int player);
} ll_weapons;

/* What a client claims to hit with an input: a body or LL_NOBODY; for a cannon, with the projectile that the
 * tag names. */
static inline int ll_claim(const ll_action *action, ll_weapon weapon)
{
    return (int)(action->buttons >> (8 + 8 * weapon) & 255) - 1;
}

static inline void ll_set_claim(ll_action *action, ll_weapon weapon, int body)
{
    int shift = 8 + 8 * (int)weapon;
    action->buttons = (action->buttons & ~(UINT32_C(255) << shift)) | (uint32_t)(body + 1) << shift;
}

static inline uint16_t ll_tag(const ll_action *action)
{
    return (uint16_t)(action->buttons >> 24);
}

static inline void ll_set_tag(ll_action *action, int64_t tag)
{
    action->buttons = (action->buttons & 0xffffff) | (uint32_t)(tag & 255) << 24;
}

typedef enum ll_hit_result_kind {
    LL_HIT_RESULT_VOID,    /* a press before the weapon was ready */
    LL_HIT_RESULT_HITSCAN, /* a hitscan shot */
    LL_HIT_RESULT_LAUNCH,  /* a projectile was launched */
    LL_HIT_RESULT_IMPACT,  /* a projectile ended */
} ll_hit_result_kind;

/* Reported to an observer. */
typedef struct ll_hit_result {
    ll_hit_result_kind kind;
    int32_t shooter;
    uint32_t number;      /* of the shooter's shots with the weapon */
    int32_t body;         /* that is hit, or LL_NOBODY */
    bool vetoed;          /* the policy did not count the hit of a hitscan shot */
    const ll_shot *shot;  /* of a hitscan shot and of a launch */
    ll_time rewound_to;   /* time of the bodies that it was judged against */
    ll_time start, end;   /* of the flight; `end` at an impact */
    ll_point at;          /* of the impact */
    double trace_error_m; /* at a launch: largest distance between the tested path and the flight */
} ll_hit_result;

/* Fires the weapons of `action` in the step that ends at `now`; the field's present is the world before it,
 * at time `before`. */
void ll_weapons_fire(ll_weapon_state *arms, const ll_field *field, int shooter, const ll_action *action,
                     ll_aim aim, ll_time before, ll_time now);

/* Flies a player's projectiles over a step in which the bodies move from the field's present to `after`. */
void ll_weapons_fly(ll_weapon_state *arms, const ll_field *field, int shooter, const ll_point *after,
                    ll_time before, ll_time now);
