/* Named kinds of links: what other tools and papers simulate, and a few of our own. */
#pragma once

#include "link/stages/parameters.h"

typedef struct ll_link_preset {
    const char *name;
    const char *source;
    double delay_ms, jitter_ms, loss_pct; /* of each direction */
    int32_t distribution;                 /* ll_distribution */
    void (*more)(ll_link_params *way);    /* what else each direction has; NULL when nothing */
} ll_link_preset;

extern const ll_link_preset ll_link_presets[];   /* `custom` first; a NULL name at the end */
extern const char *const ll_link_preset_names[]; /* in that order, NULL at the end */

/* Sets every row of both directions by the preset, those that it does not tell to their defaults; `custom`
 * sets nothing. */
void ll_link_preset_apply(int preset, ll_link_params *up, ll_link_params *down);
