#include "link/bottleneck/bottleneck.h"

ll_time ll_bottleneck_transmission(const ll_bottleneck_params *params, int64_t bytes)
{
    const double most_ms =
        1e9; /* longer than any limit and any run; at rates near 0 it was no number of ns */
    double ms = 8.0 * (double)bytes / params->rate_kbps;
    return ll_ms(ms < most_ms ? ms : most_ms);
}

#define NAMED(KIND, NAME) #NAME,
static const char *const disciplines[] = {LL_DISCIPLINES(NAMED) NULL};

#define AT(NAME) .name = #NAME, .offset = offsetof(ll_bottleneck_params, NAME)
#define REAL(NAME) AT(NAME), .type = LL_PARAM_REAL

static const ll_param rows[] = {
    {REAL(rate_kbps), .max = 1000000, .unit = "kbit/s",
     .help = "Rate of the queue of each direction, which all players share: they are before it, at one "
             "access line. "
             "0: there is none."},
    {REAL(limit_ms), .min = 1, .max = 1250, .default_value = 200, .unit = "ms",
     .help = "Packets that would leave the queue later than this are dropped."},
    {AT(discipline), .type = LL_PARAM_CHOICE, .choices = disciplines,
     .help =
         "What is dropped before the limit. tail_drop: nothing. codel: some of those that wait longer than "
         "codel_target_ms, once they have for codel_interval_ms. red: at random, more the longer the average "
         "wait is."},
    {REAL(cross_load_pct), .max = 99, .unit = "%",
     .help = "Cross traffic: share of the rate that packets of others take, which come at random times."},
    {AT(cross_bytes), .type = LL_PARAM_INT, .min = 40, .max = 9000, .default_value = 1500, .unit = "B",
     .help = "Size of a packet of the cross traffic, headers included."},
    {REAL(codel_target_ms), .min = 0.1, .max = 100, .default_value = 5, .unit = "ms",
     .help = "codel: wait that is not yet too long."},
    {REAL(codel_interval_ms), .min = 1, .max = 1000, .default_value = 100, .unit = "ms",
     .help = "codel: time above the target until the first drop; the n-th follows after this over the root "
             "of n."},
    {REAL(red_min_ms), .min = 0.1, .max = 400, .default_value = 20, .unit = "ms",
     .help = "red: average wait from which packets are dropped; at three times this all are."},
    {REAL(red_drop_pct), .min = 0.1, .max = 100, .default_value = 10, .unit = "%",
     .help = "red: share that is dropped at an average wait of three times red_min_ms."},
    {AT(ecn), .type = LL_PARAM_BOOL,
     .help = "ECN: codel and red mark packets of transports that react to marks (tcp, quic) instead of "
             "dropping them."},
};

const ll_param_table ll_bottleneck_table = {.name = "bottleneck",
                                            .help = "A queue in each direction that all players share.",
                                            .rows = rows,
                                            .count = sizeof rows / sizeof rows[0],
                                            .size = sizeof(ll_bottleneck_params)};
