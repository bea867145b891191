/* Rendered views of a player's own entity, each compared with the truth at its tick.
 *
 * A view of a tick that the server has made is compared at once. A view ahead of the server is kept and
 * compared when the server makes its tick; of several views of one tick the last counts. A view of a tick
 * that is never made, because its epoch is over, is void. */
#pragma once

#include <stdint.h>

#include "base/histogram.h"
#include "base/vtime.h"
#include "netcode/protocol/running_stats.h"

#define LL_RENDERED_VIEWS_RING 256 /* ticks that a view may be ahead; an overwritten view is void */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef struct ll_rendered_view {
    int64_t key;   /* tick, or the sequence number of an input where inputs are applied on arrival; 0: none */
    ll_time shown; /* time of the display */
    double x, y;
} ll_rendered_view;

typedef struct ll_rendered_views {
    int64_t voided;            /* of those that count */
    double error_m;            /* of the view compared last */
    double lead_ms;            /* of the same: server time of its tick - time of its display */
    ll_running_stats leads_ms; /* of all */
    ll_rendered_view truth;    /* the truth compared with last; `shown`: when the server was there */
    int64_t skipped;           /* earlier keys are not kept */
    ll_rendered_view ring[LL_RENDERED_VIEWS_RING];
} ll_rendered_views;

#pragma GCC diagnostic pop

/* Adds errors, in m, of displays from `from` on to `errors`. */

void ll_rendered_views_keep(ll_rendered_views *rendered_views, const ll_rendered_view *view,
                            ll_time from); /* ahead of the server */

/* Compares with the truth of the same key; its `shown` is when the server was there. */
void ll_rendered_views_compare(ll_rendered_views *rendered_views, ll_histogram *errors,
                               const ll_rendered_view *view, const ll_rendered_view *truth, ll_time from);

/* The same for the view kept of the truth's key, if there is one. */
void ll_rendered_views_made(ll_rendered_views *rendered_views, ll_histogram *errors,
                            const ll_rendered_view *truth, ll_time from);

/* Views of keys before `key` cannot be compared: no state was of exactly that input. */
void ll_rendered_views_skip(ll_rendered_views *rendered_views, int64_t key);

void ll_rendered_views_void(ll_rendered_views *rendered_views,
                            ll_time from); /* kept views are of ticks that will not be made */
