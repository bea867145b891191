/* The server's rules on inputs. A refused input is not applied and is answered with the rule that refused it.
 * The last two rules refuse a part of an input; the game's step (game/core/weapons.h) applies them, and they
 * are only counted. */
#pragma once

#include <stdint.h>

#include "base/vtime.h"
#include "game/core/game.h"
#include "netcode/protocol/limits.h"

/* Where inputs are applied on arrival: inputs of no more time than has passed, plus a burst. */
#define LL_RATE_BURST 80.0        /* minimum number of inputs that may arrive at once, */
#define LL_RATE_BURST_S (4.0 / 3) /* and the inputs of this time: a link may stall for 1 s */
/* inputs per client tick in the long run: a client that catches up makes two per frame */
#define LL_RATE_FACTOR 2.25

typedef enum ll_rule {
    LL_RULE_NONE = 0,
    LL_RULE_MAGNITUDE, /* an axis outside of [-1, 1], or not a number */
    LL_RULE_RATE,      /* more inputs than time allows */
    LL_RULE_BUDGET, /* an input of time that has not passed yet: for a step too far ahead, or beyond the time
                       budget */
    LL_RULE_FIRE_RATE, /* a press before the weapon was ready: it has no effect */
    LL_RULE_REWIND, /* a view whose stated age exceeds the measured one by too much, which counts instead */
    LL_RULES,
} ll_rule;

extern const char *const ll_rule_names[LL_RULES];

/* A token bucket: limits the long-run rate of a client's inputs. */
typedef struct ll_rate_limiter {
    double tokens;
    ll_time filled;
} ll_rate_limiter;

/* The tokens of a full bucket. */
double ll_rate_burst(ll_freq client_freq);

/* Time budget: input time against elapsed time, where inputs are applied on arrival (Source's budget of user
 * commands). Holds the ticks by which processed time exceeds elapsed time. At most a full bucket, so that a
 * link may stall. */
typedef struct ll_time_budget {
    double ticks; /* at `at`; decreases to 0 with time */
    ll_time at;
} ll_time_budget;

/* The share of the budget in use including this input, which lasts a tick or its stated duration. */
double ll_time_use(const ll_time_budget *account, const ll_action *action, ll_freq client_freq, ll_time now);
void ll_time_spend(ll_time_budget *account, const ll_action *action, ll_freq client_freq, ll_time now);

/* `budget_use`: the share of the time budget including this input; above 1 the input is refused. */
ll_rule ll_validate(const ll_action *action, double budget_use, ll_rate_limiter *allowance,
                    ll_freq client_freq, ll_time now);
