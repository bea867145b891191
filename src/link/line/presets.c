#include "link/line/presets.h"

/* A busy wireless cell: a delay distribution with a tail of retransmissions, and losses in bursts of four. */
static void wifi_busy(ll_link_params *way)
{
    way->loss_model = LL_LOSS_GEMODEL;
    way->ge_p_pct = 1;
    way->ge_r_pct = 25;
    way->ge_1h_pct = 60;
}

/* A handover: every packet is late for some time. */
static void handover(ll_link_params *way)
{
    way->spike_at_ms = way->spike_every_ms = 10000;
    way->spike_length_ms = 400;
    way->spike_add_ms = 300;
}

static void tunnel(ll_link_params *way)
{
    way->blackout_at_ms = way->blackout_every_ms = 20000;
    way->blackout_length_ms = 2000;
}

/* Less than what a race of two sends (44 kbit/s up, 53 down), behind a long queue. */
static void bufferbloat(ll_link_params *way)
{
    way->rate_kbps = 32;
    way->limit_ms = 400;
}

#define UNITY "Unity Multiplayer Tools 2.2.10: "
#define NFE "Unity Netcode for Entities 1.13, broadband: "
#define UNREAL "Unreal Engine, network emulation profile: "
#define LIGHTYEAR "lightyear 0.29, link conditioner: "

/* Name, source; delay, jitter in ms and loss in % of each direction; distribution; further settings. */
#define PRESETS(PRESET)                                                                                      \
    PRESET("custom", "the rows of up and down", 0, 0, 0, UNIFORM, NULL)                                      \
    PRESET("home_broadband", UNITY "Home Broadband", 32, 12, 2, UNIFORM, NULL)                               \
    PRESET("fiber", UNITY "Fiber", 10, 1, 0, UNIFORM, NULL)                                                  \
    PRESET("cable", UNITY "Cable", 25, 5, 0, UNIFORM, NULL)                                                  \
    PRESET("dsl", UNITY "DSL", 30, 10, 0, UNIFORM, NULL)                                                     \
    PRESET("satellite_leo", UNITY "LEO Satellite", 100, 10, 0, UNIFORM, NULL)                                \
    PRESET("congested", UNITY "Congested", 50, 50, 1, UNIFORM, NULL)                                         \
    PRESET("gsm_2g", UNITY "2G", 520, 50, 7, UNIFORM, NULL)                                                  \
    PRESET("gprs_2_5g", UNITY "2.5G", 480, 40, 7, UNIFORM, NULL)                                             \
    PRESET("edge_2_75g", UNITY "2.75G", 440, 40, 7, UNIFORM, NULL)                                           \
    PRESET("umts_3g", UNITY "3G", 360, 30, 7, UNIFORM, NULL)                                                 \
    PRESET("hsdpa_3_5g", UNITY "3.5G", 160, 30, 6, UNIFORM, NULL)                                            \
    PRESET("hspa_3_75g", UNITY "3.75G", 130, 30, 6, UNIFORM, NULL)                                           \
    PRESET("lte_4g", UNITY "4G", 100, 20, 4, UNIFORM, NULL)                                                  \
    PRESET("lte_4_5g", UNITY "4.5G", 80, 20, 4, UNIFORM, NULL)                                               \
    PRESET("nr_5g", UNITY "5G", 30, 20, 4, UNIFORM, NULL)                                                    \
    PRESET("nfe_regional_p5", NFE "Regional [5th percentile]", 1 + 9, 1 + 1, 1 + 1, UNIFORM, NULL)           \
    PRESET("nfe_regional_p25", NFE "Regional [25th percentile]", 1 + 15, 1 + 5, 1 + 1, UNIFORM, NULL)        \
    PRESET("nfe_regional_p50", NFE "Regional [50th percentile]", 1 + 65, 1 + 10, 1 + 2, UNIFORM, NULL)       \
    PRESET("nfe_regional_p95", NFE "Regional [95th percentile]", 1 + 150, 1 + 10, 1 + 3, UNIFORM, NULL)      \
    PRESET("nfe_international_p25", NFE "International [25th percentile]", 1 + 60, 1 + 5, 1 + 2, UNIFORM,    \
           NULL)                                                                                             \
    PRESET("nfe_international_p50", NFE "International [50th percentile]", 1 + 120, 1 + 10, 1 + 2, UNIFORM,  \
           NULL)                                                                                             \
    PRESET("nfe_international_p95", NFE "International [95th percentile]", 1 + 200, 1 + 15, 1 + 5, UNIFORM,  \
           NULL)                                                                                             \
    PRESET("unreal_average", UNREAL "Average, 30 to 60 ms", 45, 15, 1, UNIFORM, NULL)                        \
    PRESET("unreal_bad", UNREAL "Bad, 100 to 200 ms", 150, 50, 5, UNIFORM, NULL)                             \
    PRESET("lightyear_good", LIGHTYEAR "good", 40, 6, 0.2, UNIFORM, NULL)                                    \
    PRESET("lightyear_average", LIGHTYEAR "average", 100, 15, 2, UNIFORM, NULL)                              \
    PRESET("lightyear_poor", LIGHTYEAR "poor", 200, 30, 10, UNIFORM, NULL)                                   \
    PRESET("paper", "the paper: 10 to 500 ms, uniform", 255, 245, 0, UNIFORM, NULL)                          \
    PRESET("wifi_busy", "laglab: a skewed delay and bursts of losses", 15, 8, 0, PARETONORMAL, wifi_busy)    \
    PRESET("satellite_geo", "laglab: 35,786 km up and down are 239 ms", 260, 10, 0.5, NORMAL, NULL)          \
    PRESET("handover", "laglab: 300 ms more for 400 ms, every 10 s", 50, 10, 1, NORMAL, handover)            \
    PRESET("tunnel", "laglab: nothing for 2 s, every 20 s", 50, 10, 1, NORMAL, tunnel)                       \
    PRESET("bufferbloat", "laglab: 32 kbit/s behind a queue of 400 ms", 20, 2, 0, UNIFORM, bufferbloat)

#define ROW(name, source, delay, jitter, loss, distribution, more)                                           \
    {name, source, delay, jitter, loss, LL_DISTRIBUTION_##distribution, more},
#define NAME(name, ...) name,

const ll_link_preset ll_link_presets[] = {PRESETS(ROW){NULL, NULL, 0, 0, 0, 0, NULL}};
const char *const ll_link_preset_names[] = {PRESETS(NAME) NULL};

static void set_way(const ll_link_preset *preset, ll_link_params *way)
{
    ll_param_defaults(&ll_link_table, way);
    way->delay_ms = preset->delay_ms;
    way->jitter_ms = preset->jitter_ms;
    way->loss_pct = preset->loss_pct;
    way->distribution = preset->distribution;
    if (preset->more)
        preset->more(way);
}

void ll_link_preset_apply(int preset, ll_link_params *up, ll_link_params *down)
{
    if (preset == 0)
        return;
    set_way(&ll_link_presets[preset], up);
    set_way(&ll_link_presets[preset], down);
}
