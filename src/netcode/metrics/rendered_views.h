/* The pictures of a player's own entity, each held against the truth at the tick that it is of.
 *
 * A picture of a tick that the server has made is compared at once. One that is ahead of the server is kept
 * and compared when the server makes its tick; of several of one tick the last counts. A tick that is never
 * made, its epoch being over, leaves its picture void. */
#pragma once

#include <stdint.h>

#include "base/histogram.h"
#include "base/vtime.h"
#include "netcode/protocol/running_stats.h"

#define LL_RENDERED_VIEWS_RING 256 /* ticks that a picture may be ahead; one that is overwritten is void */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

typedef struct ll_rendered_view {
    int64_t key;   /* tick, or where inputs are applied as they come the number of an input; 0: none */
    ll_time shown; /* the display */
    double x, y;
} ll_rendered_view;

typedef struct ll_rendered_views {
    int64_t voided;            /* of those that count */
    double error_m;            /* of the picture that was compared last */
    double lead_ms;            /* of the same: server time of its tick - time of its display */
    ll_running_stats leads_ms; /* of all */
    ll_rendered_view truth;    /* that was compared with last; `shown`: when the server was there */
    int64_t skipped;           /* keys before this one are not kept */
    ll_rendered_view ring[LL_RENDERED_VIEWS_RING];
} ll_rendered_views;

#pragma GCC diagnostic pop

/* Errors go into `errors`, in m, of displays from `from` on. */

void ll_rendered_views_keep(ll_rendered_views *pictures, const ll_rendered_view *picture,
                            ll_time from); /* ahead of the server */

/* The truth was at (x, y) at the server's time `made`. */
void ll_rendered_views_compare(ll_rendered_views *pictures, ll_histogram *errors,
                               const ll_rendered_view *picture, double x, double y, ll_time made,
                               ll_time from);

/* The same of the picture that is kept of `key`, if there is one. */
void ll_rendered_views_made(ll_rendered_views *pictures, ll_histogram *errors, int64_t key, double x,
                            double y, ll_time made, ll_time from);

/* Pictures of keys before `key` cannot be compared: there was no state of just that. */
void ll_rendered_views_skip(ll_rendered_views *pictures, int64_t key);

void ll_rendered_views_void(ll_rendered_views *pictures,
                            ll_time from); /* what is kept is of ticks that will not be */
