/* What stands in for an input that has not come for its step: one row per policy. Presses are never repeated.
 *
 * Source: Quake III freezes, Source repeats up to 24 commands, Quantum repeats what is marked repeatable,
 * netfox lets the axes decay. */
#pragma once

#include <stdint.h>

#include "game/core/game.h"

/* How long what was applied last goes on to count. */
typedef struct ll_starve_config {
    double tau;    /* steps, that decay takes */
    int64_t steps; /* that repeat_n repeats for */
} ll_starve_config;

typedef struct ll_starve {
    const char *name;
    const char *help;

    /* `last` was applied `age` steps ago: 1 in the first step that starves. Cost: none to speak of. */
    ll_action (*act)(const ll_action *last, int64_t age, const ll_starve_config *config);
} ll_starve;

extern const ll_starve ll_starve_decay;
extern const ll_starve ll_starve_repeat;
extern const ll_starve ll_starve_repeat_n;
extern const ll_starve ll_starve_neutral;

extern const ll_starve *const ll_starves[]; /* NULL-terminated; the index is the choice `starved` */
extern const char *const ll_starve_names[];
