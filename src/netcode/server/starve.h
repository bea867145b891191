/* Starvation policies: the replacement of an input that has not arrived at its step.
 * Presses are never repeated.
 *
 * Source: Quake III freezes, Source repeats up to 24 commands, Quantum repeats inputs marked repeatable,
 * netfox lets the axes decay. */
#pragma once

#include <stdint.h>

#include "game/core/game.h"

/* How long the last applied input remains in effect. */
typedef struct ll_starve_config {
    double tau;    /* duration of decay, steps */
    int64_t steps; /* number of ticks that repeat_n repeats for */
} ll_starve_config;

typedef struct ll_starve {
    /* `last` was applied `age` steps ago: 1 in the first starved step. Cost: negligible. */
    ll_action (*act)(const ll_action *last, int64_t age, const ll_starve_config *config);
} ll_starve;

extern const ll_starve *const ll_starves[]; /* NULL-terminated; the index is the choice `starved` */
extern const char *const ll_starve_names[];
