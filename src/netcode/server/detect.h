/* Detection of cheats by statistics: what no single input shows, many inputs together do. Two tests for
 * each player, both on what the server knows by itself; they only raise alarms.
 *
 * - Rate: a CUSUM of the inputs that arrive, S = max(-credit, S - hz dt (1 + slack)) + inputs. The slack is
 * more than a clock's drift. A silent client gathers credit for what a stalled link may deliver at once, up
 * to the burst that the rules allow. Alarm at 80 inputs. Repeated inputs, and lost ones, do not count.
 * - Reactions: a sequential probability ratio test (Wald, 1945) of shots at what has just come in sight. Of
 * an honest player's reactions one in a thousand is faster than 100 ms, of an aim bot's at least one in ten.
 * False alarms: at most 1e-4 of the tests, missed cheats at most 0.01. On average a decision takes 46 shots
 * of an honest player and 25 of a cheat of one in ten.
 *
 * After a decision the next test begins. Part of a simulation's block: no pointers. */
#pragma once

#include "game/core/arena.h"
#include "game/core/weapons.h"

#define LL_RATE_SLACK 1e-3
#define LL_RATE_ALARM 80.0 /* inputs */

#define LL_REACTION_FAST (100 * LL_MS)     /* faster ones are hits of the test */
#define LL_REACTION_WITHIN LL_SECOND       /* a later shot is no reaction */
#define LL_REACTION_HIDDEN (LL_SECOND / 2) /* a body that was hidden for less has not come in sight */

#define LL_SPRT_HIT 4.605170185988092       /* log(0.1 / 0.001) */
#define LL_SPRT_MISS (-0.10436001532424276) /* log(0.9 / 0.999) */
#define LL_SPRT_ALARM 9.20029003612268      /* log((1 - 0.01) / 1e-4) */
#define LL_SPRT_CLEAR (-4.605070180987758)  /* log(0.01 / (1 - 1e-4)) */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef struct ll_alarms {
    int64_t count;
    int64_t mistaken; /* while the player did not cheat, as the observer knows */
    ll_time first;    /* LL_NEVER: none */
} ll_alarms;

typedef struct ll_rate_watch {
    ll_alarms alarms;
    double sum, most; /* S, and its largest value */
    ll_time at;       /* of S */
    uint64_t seen;    /* bits: input newest - i has come */
    uint32_t newest;
    uint16_t epoch; /* 0: none */
    uint16_t reserved;
} ll_rate_watch;

typedef struct ll_reaction_watch {
    ll_alarms alarms;
    double sum;                   /* the logarithm of the ratio */
    int64_t shots, fast;          /* trials, and those faster than LL_REACTION_FAST */
    int64_t cleared;              /* tests that found the player honest */
    uint64_t in_sight, tried;     /* bits, by body: in the player's view; no further shot at it is a trial */
    ll_time since[LL_BODIES_MAX]; /* it is in sight, or is not: the earliest time possible */
    ll_time last, ready;          /* the step of the last input; when the weapon could fire again */
    int64_t fired;                /* hitscan shots */
} ll_reaction_watch;

typedef struct ll_detection {
    ll_rate_watch rate;
    ll_reaction_watch reaction;
} ll_detection;

#pragma GCC diagnostic pop

void ll_detection_init(ll_detection *detection);

/* A packet of `count` inputs from number `first` on has arrived. True: an alarm. */
bool ll_rate_take(ll_rate_watch *watch, uint16_t epoch, uint32_t first, int count, ll_freq client_freq,
                  ll_time now);

/* One trial of the test. True: an alarm. */
bool ll_reaction_try(ll_reaction_watch *watch, bool fast);

/* An input of `player` in the step that ends at `now`, made on a view in which bodies are at `bodies`, its
 * own entity as before the step; `shot`: a hitscan shot that it fired, or NULL. Returns the reaction time if
 * the shot is a trial, at most LL_REACTION_WITHIN, else -1. It is the longest one possible: from the input
 * before the one in whose view the body was in sight first. */
ll_time ll_reaction_see(ll_reaction_watch *watch, const ll_arena *arena, int player, const ll_point *bodies,
                        const ll_aim *shot, ll_time now);
