/* Named kinds of links: presets of other tools and papers, and our own. */
#pragma once

#include "link/stages/parameters.h"

typedef struct ll_link_preset {
    const char *name;
    const char *source;
    double delay_ms, jitter_ms, loss_pct; /* of each direction */
    int32_t distribution;                 /* ll_distribution */
    void (*more)(ll_link_params *way);    /* further settings of each direction; NULL: none */
} ll_link_preset;

extern const ll_link_preset ll_link_presets[];   /* `custom` first; terminated by a NULL name */
extern const char *const ll_link_preset_names[]; /* in that order, NULL-terminated */

/* Sets every row of both directions by the preset, rows that it does not name to their defaults; `custom`
 * sets nothing. */
void ll_link_preset_apply(int preset, ll_link_params *up, ll_link_params *down);
