/* Parameters of who watches a game of the peer-to-peer syncs. */
#include <stddef.h>

#include "netcode/protocol/config.h"

static const ll_param rows[] = {
    {.name = "lag_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_spectator_params, lag_ms),
     .max = 1000,
     .unit = "ms",
     .live = true,
     .help = "One-way delay between the sender and the spectator, in each direction."},
    {.name = "link",
     .type = LL_PARAM_OBJECT,
     .offset = offsetof(ll_spectator_params, link),
     .child = &ll_link_pair_table,
     .live = true,
     .help = "Impairments of each direction. down: from the sender. No player shares this link."},
    {.name = "player",
     .type = LL_PARAM_INT,
     .offset = offsetof(ll_spectator_params, player),
     .min = -1,
     .max = LL_PEERS_MAX - 1,
     .help =
         "Index of the player whose client sends the inputs to the spectator, at each tick those that are "
         "settled and not acknowledged. -1: the server sends them, with each update."},
    {.name = "buffer_ticks",
     .type = LL_PARAM_INT,
     .offset = offsetof(ll_spectator_params, buffer_ticks),
     .min = 1,
     .max = LL_SPECTATOR_BUFFER_MAX,
     .default_value = LL_SPECTATOR_BUFFER_MAX,
     .unit = "ticks",
     .help = "Ticks whose inputs the spectator keeps until it shows them. When more have come it has fallen "
             "out: it shows no newer tick until the sender has sent it a whole world."},
    {.name = "behind_ticks",
     .type = LL_PARAM_INT,
     .offset = offsetof(ll_spectator_params, behind_ticks),
     .max = LL_SPECTATOR_BUFFER_MAX,
     .default_value = 10,
     .unit = "ticks",
     .help = "With inputs for more ticks than this the spectator makes two ticks at once, until they are no "
             "more."},
};

const ll_param_table ll_spectator_table = {.name = "spectator",
                                           .help = "A spectator, and its link to who sends it the inputs.",
                                           .rows = rows,
                                           .count = sizeof rows / sizeof rows[0],
                                           .size = sizeof(ll_spectator_params)};
