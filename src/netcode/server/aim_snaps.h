/* Detection of aim bots by how the aim arrives at its target. A person's aim slows down before it is there; a
 * bot's is there within one input, from anywhere.
 *
 * A trial is the first hitscan shot at a body within a second after the aim came onto it from outside. The
 * rate of the turn is how far from its middle the aim of the input before passed, in radii of the body, less
 * the one at its edge, over the time between both inputs. Above LL_AIM_FAST it is a snap. No trial: the aim
 * was on the body all along, as on a corner from which it comes, or the input before is missing.
 *
 * A sequential probability ratio test (Wald, 1945) of the share of snaps: 1 % of an honest player's, 30 % of
 * a bot's, whose aim is often near its target by chance. Errors as of the test of reactions (detect.h).
 *
 * Kept behind the other parts of a simulation's block, as it changes nothing: no pointers. */
#pragma once

#include "netcode/server/detect.h"

#define LL_AIM_FAST 40.0           /* 1/s, in radii of the target */
#define LL_AIM_INPUTS (50 * LL_MS) /* two inputs farther apart say nothing */
#define LL_AIM_WITHIN LL_SECOND    /* a later shot is no trial */

#define LL_AIM_SNAP 3.4011973816621555     /* log(0.3 / 0.01) */
#define LL_AIM_TURN (-0.34662460808523093) /* log(0.7 / 0.99) */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded"

typedef struct ll_aim_watch {
    ll_alarms alarms;
    double sum;           /* the logarithm of the ratio */
    double rate;          /* 1/s: at which the aim came onto `body` */
    int64_t shots, snaps; /* trials, and those that were snaps */
    int64_t cleared;      /* tests that found the player honest */
    ll_point direction;   /* of the last aim */
    ll_time at, onto;     /* its step; when the aim came onto `body`. 0: none yet */
    int32_t body;         /* that the aim is on, or LL_NOBODY */
    int32_t open;         /* the next shot at it is a trial */
} ll_aim_watch;

#pragma GCC diagnostic pop

void ll_aim_watch_init(ll_aim_watch *watch);

/* An input of `player` in the step that ends at `now`, with this aim, on a view in which bodies are at
 * `bodies`; `shoots`: it fires a hitscan shot. Returns the rate of the turn in 1/s if the shot is a trial,
 * else a negative number. */
double ll_aim_see(ll_aim_watch *watch, const ll_arena *arena, int player, const ll_point *bodies,
                  const ll_aim *aim, bool shoots, ll_time now);

/* One trial of the test. True: an alarm. */
bool ll_aim_try(ll_aim_watch *watch, bool snap);
