#include "link/link.h"

static const char *const distributions[] = {"uniform", "normal", NULL};
static const char *const orders[] = {"free", "fifo", NULL};

static const ll_param rows[] = {
    {.name = "delay_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_link_params, delay_ms),
     .max = 1000,
     .unit = "ms",
     .live = true,
     .help = "Delay of this direction, added to the player's lag_ms."},
    {.name = "jitter_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_link_params, jitter_ms),
     .max = 500,
     .unit = "ms",
     .live = true,
     .help =
         "Variation of the delay: half-width of the uniform, standard deviation of the normal distribution."},
    {.name = "distribution",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_link_params, distribution),
     .choices = distributions,
     .live = true,
     .help = "How the delay varies."},
    {.name = "order",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_link_params, order),
     .choices = orders,
     .live = true,
     .help = "free lets a packet overtake an earlier one; fifo holds it until the earlier one is through."},
    {.name = "loss_pct",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_link_params, loss_pct),
     .max = 100,
     .unit = "%",
     .live = true,
     .help = "Packets that are lost, each by itself."},
    {.name = "duplicate_pct",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_link_params, duplicate_pct),
     .max = 100,
     .unit = "%",
     .live = true,
     .help = "Packets that arrive twice; the copy has a delay of its own."},
};

const ll_param_table ll_link_table = {.name = "link",
                                      .help = "One direction of a network path, in netem's terms.",
                                      .rows = rows,
                                      .count = sizeof rows / sizeof rows[0],
                                      .size = sizeof(ll_link_params)};
