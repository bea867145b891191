/* The divisor by which all rates of a viewer are divided, from how many of its frames it missed.
 *
 * The least divisor is sought with which the viewer misses few frames. It is raised when a window of 2 s has
 * too many misses, to the rate that the viewer had in it, at most to twice the divisor; it is lowered by one
 * step after windows with hardly any. When the viewer does not keep up with a higher rate, the next attempt
 * is made after twice as many such windows, so that one at its limit is disturbed seldom and one that was
 * slow for a moment, as a page that still loads, is slow for a few seconds. */
#ifndef LL_DAEMON_STREAM_PACE_H
#define LL_DAEMON_STREAM_PACE_H

#include <stdbool.h>
#include <stdint.h>

#define LL_WS_PACE_WINDOW_NS INT64_C(2000000000)
#define LL_WS_PACE_MEMORY_NS INT64_C(20000000000)

/* All zero: a new viewer, with all of its frames. */
typedef struct ll_ws_pace {
    int step;         /* index of the divisor */
    int due, missed;  /* frames of this window */
    int64_t since_ns; /* start of this window; 0: none has begun */
    int windows;      /* whole ones since the last change */
    int good;         /* windows in a row with hardly any misses */
    int patience;     /* number of them, less one, that are waited for before a higher rate is tried */
    bool tried;       /* the last change was to a higher rate */
    int worst;        /* index of the largest divisor of the last LL_WS_PACE_MEMORY_NS */
    int64_t worst_ns; /* when it was last had */
} ll_ws_pace;

/* 1 to 16. */
int ll_ws_pace_divisor(const ll_ws_pace *pace);

/* The largest of the last LL_WS_PACE_MEMORY_NS: what limits the viewer, a slow line above all, is not over
 * when a higher rate is tried. */
int ll_ws_pace_worst_divisor(const ll_ws_pace *pace);

/* A frame was due at this time. Returns whether the divisor has changed. */
bool ll_ws_pace_count(ll_ws_pace *pace, bool missed, int64_t now_ns);

#endif
