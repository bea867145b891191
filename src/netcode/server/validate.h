/* The server's rules on inputs. A refused input is not applied and is answered with the rule that refused it;
 * the last two refuse a part of an input, are found in the game's step (game/core/weapons.h) and are counted
 * only.
 */
#pragma once

#include <stdint.h>

#include "base/vtime.h"
#include "game/core/game.h"
#include "netcode/protocol/limits.h"

/* Where inputs count as they come: of no more time than has passed, and a burst. */
#define LL_RATE_BURST 80.0        /* inputs that may come at once, at least; */
#define LL_RATE_BURST_S (4.0 / 3) /* and those of so many seconds: a link may stall for one */
#define LL_RATE_FACTOR                                                                                       \
    2.25 /* inputs per client tick in the long run: a client that catches up makes two a frame */

typedef enum ll_rule {
    LL_RULE_NONE = 0,
    LL_RULE_MAGNITUDE, /* an axis outside of [-1, 1], or not a number */
    LL_RULE_RATE,      /* more inputs than time allows */
    LL_RULE_BUDGET,    /* an input of time that has not passed yet: for a step too far ahead, or beyond the
                          account */
    LL_RULE_FIRE_RATE, /* a press before the weapon was ready: it is void */
    LL_RULE_REWIND,    /* a view whose stated age is too far beyond the measured one, which then counts */
    LL_RULES,
} ll_rule;

extern const char *const ll_rule_names[LL_RULES];

/* A bucket that fills with time: the long-run rate that a client may send at. */
typedef struct ll_rate_limiter {
    double tokens;
    ll_time filled;
} ll_rate_limiter;

/* The tokens of a full bucket. */
double ll_rate_burst(ll_freq client_freq);

/* Input time against time that passed, where inputs count as they come (Source's budget of user commands): so
 * many ticks more have been processed than passed. At most a full bucket, so that a link may stall. */
typedef struct ll_time_budget {
    double ticks; /* at `at`; it runs down to 0 with time */
    ll_time at;
} ll_time_budget;

/* The share of the budget that would be in use with this input too, which lasts a tick or as long as it says.
 */
double ll_time_use(const ll_time_budget *account, const ll_action *action, ll_freq client_freq, ll_time now);
void ll_time_spend(ll_time_budget *account, const ll_action *action, ll_freq client_freq, ll_time now);

/* `budget_use`: the share of the time budget that would be in use; above 1 is refused. */
ll_rule ll_validate(const ll_action *action, double budget_use, ll_rate_limiter *allowance,
                    ll_freq client_freq, ll_time now);
