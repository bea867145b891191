/* Client-authoritative movement with server validation: what a client reports of its own entity.
 *
 * Part of a simulation's block where a player has `authority` position; else there is none of it. */
#pragma once

#include <stdint.h>

#include "game/core/game.h"

/* The state of an entity, as it travels. */
typedef struct ll_motion {
    double x, y, vx, vy;
    double angle, angular_velocity;
} ll_motion;

/* What a client knows of the server's answers to its reports. Numbers are those of inputs; 0: none. */
typedef struct ll_reporter {
    uint32_t refused;   /* the newest whose report the server refused */
    uint32_t corrected; /* the newest when the client last took the server's state: later reports follow from
                           that */
} ll_reporter;

static inline ll_motion ll_motion_of(const ll_entity *e)
{
    return (ll_motion){e->x, e->y, e->vx, e->vy, e->angle, e->angular_velocity};
}

static inline void ll_motion_set(ll_entity *e, const ll_motion *m)
{
    *e = (ll_entity){m->x, m->y, m->vx, m->vy, m->angle, m->angular_velocity, e->flags};
}
