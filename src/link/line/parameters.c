#include "link/line/link.h"

#include <stdio.h>

#define NAMED(KIND, NAME) #NAME,
static const char *const distributions[] = {LL_DELAY_MODELS(NAMED) NULL};
static const char *const orders[] = {"unordered", "fifo", NULL};
static const char *const loss_models[] = {LL_LOSS_MODELS(NAMED) NULL};

#define REAL(NAME)                                                                                           \
    .name = #NAME, .type = LL_PARAM_REAL, .offset = offsetof(ll_link_params, NAME), .live = true
#define INT(NAME) .name = #NAME, .type = LL_PARAM_INT, .offset = offsetof(ll_link_params, NAME), .live = true
#define CHOICE(NAME)                                                                                         \
    .name = #NAME, .type = LL_PARAM_CHOICE, .offset = offsetof(ll_link_params, NAME), .live = true
#define PERCENT .max = 100, .unit = "%"
#define CORRELATION .max = 99, .unit = "%"
#define HOUR .max = 3600000, .unit = "ms"

static const ll_param rows[] = {
    {REAL(delay_ms), .max = 1000, .unit = "ms",
     .help = "Delay of this direction, added to the player's lag_ms."},
    {REAL(jitter_ms), .max = 500, .unit = "ms",
     .help =
         "Variation of the delay: half-width of the uniform, standard deviation of the other distributions."},
    {CHOICE(distribution), .choices = distributions,
     .help = "Distribution of the delay. Its largest value is 1, 4.0, 12.1 or 10.5 times the jitter above "
             "the centre."},
    {REAL(delay_corr_pct), CORRELATION, .help = "Correlation of the delays of successive packets."},
    {CHOICE(order), .choices = orders,
     .help = "Order of delivery. free: a packet may overtake an earlier one; fifo: it waits for earlier "
             "ones."},
    {CHOICE(loss_model), .choices = loss_models,
     .help = "Loss model. random: loss_pct; gemodel: Gilbert-Elliott, rows ge_; state: netem's four states, "
             "rows p13 to p14. Rows of other models are ignored."},
    {REAL(loss_pct), PERCENT, .help = "Packet loss (random)."},
    {REAL(loss_corr_pct), CORRELATION,
     .help = "Correlation of the losses of successive packets: above 0 they come in bursts (random)."},
    {REAL(ge_p_pct), PERCENT, .help = "gemodel's p: from the good state to the bad one, per packet."},
    {REAL(ge_r_pct), PERCENT, .default_value = 100,
     .help = "gemodel's r: from the bad state back; a bad period lasts 100 / r packets."},
    {REAL(ge_1h_pct), PERCENT, .default_value = 100, .help = "gemodel's 1-h: loss in the bad state."},
    {REAL(ge_1k_pct), PERCENT, .help = "gemodel's 1-k: loss in the good state."},
    {REAL(p13_pct), PERCENT, .help = "state: from good reception to the losses of a burst, per packet."},
    {REAL(p31_pct), PERCENT, .default_value = 100,
     .help = "state: from the losses of a burst back to good reception."},
    {REAL(p32_pct), PERCENT, .help = "state: from the losses of a burst to good reception within it."},
    {REAL(p23_pct), PERCENT, .default_value = 100,
     .help = "state: from good reception within a burst to its losses."},
    {REAL(p14_pct), PERCENT, .help = "state: from good reception to an isolated loss."},
    {REAL(blackout_at_ms), HOUR, .help = "Start of the first blackout, in simulated time."},
    {REAL(blackout_every_ms), HOUR, .help = "Time between the starts of two blackouts; 0: only one."},
    {REAL(blackout_length_ms), HOUR,
     .help = "Duration of a blackout, in which every packet is lost; 0: none."},
    {REAL(duplicate_pct), PERCENT, .help = "Duplicated packets; each copy is lost or delayed independently."},
    {REAL(duplicate_corr_pct), CORRELATION, .help = "Correlation of the duplication of successive packets."},
    {REAL(spike_at_ms), HOUR, .help = "Start of the first delay spike, in simulated time."},
    {REAL(spike_every_ms), HOUR, .help = "Time between the starts of two spikes; 0: only one."},
    {REAL(spike_length_ms), HOUR, .help = "Duration of a spike; 0: none."},
    {REAL(spike_add_ms), .max = 1000, .unit = "ms", .help = "Delay added to packets sent within a spike."},
    {REAL(rate_kbps), .max = 1000000, .unit = "kbit/s",
     .help = "Rate of the link: after the delay packets leave one by one, in the order of sending; 0: no "
             "limit and no queue."},
    {REAL(limit_ms), .min = 1, .max = 1250, .default_value = 500, .unit = "ms",
     .help = "Queue limit in time: packets that would leave the rate later than this after sending, without "
             "delays, are dropped."},
    {INT(limit_packets), .min = 1, .max = 1000, .default_value = 1000,
     .help = "Queue limit in packets: packets that find it full are dropped."},
    {INT(packet_overhead_bytes), .max = 1000, .default_value = 28, .unit = "B",
     .help = "Bytes added to a packet's size in the queue: 28 are the headers of IPv4 and UDP."},
    {INT(mtu_bytes), .max = 65507, .default_value = 1200, .unit = "B",
     .help = "Longest message in one packet: longer ones are split into fragments, and are lost with any of "
             "them; 0: never split, otherwise at least 64."},
    {REAL(reorder_pct), PERCENT,
     .help = "Packets that are reordered ahead, past the rate's queue and without the link's delay except "
             "lag_ms."},
    {REAL(reorder_corr_pct), CORRELATION, .help = "Correlation of the reordering of successive packets."},
    {INT(reorder_gap), .min = 1, .max = 1000, .default_value = 1,
     .help =
         "At most one packet in reorder_gap is reordered ahead; with reorder_pct 100, every such packet."},
    {REAL(corrupt_pct), PERCENT,
     .help = "Packets that arrive corrupted: the receiver's checksum drops them."},
    {REAL(corrupt_corr_pct), CORRELATION, .help = "Correlation of the corruption of successive packets."},
    {CHOICE(profile), .choices = ll_profile_names,
     .help = "One of the scenario's profiles: a trace, slots, cells, ECN, a table of delays, a distance."},
};

/* ---- rules between values ---- */

typedef struct field {
    char name[64];
} field;

static field field_of(const char *path, const char *name)
{
    field f;
    snprintf(f.name, sizeof f.name, "%s%s", path, name);
    return f;
}

static ll_status check_reorder(const ll_link_params *p, const char *path)
{
    field pct = field_of(path, "reorder_pct"), gap = field_of(path, "reorder_gap");
    if (p->reorder_pct > 0 && !(p->delay_ms > 0 || p->jitter_ms > 0 || p->rate_kbps > 0))
        return ll_field_error(LL_BAD_INPUT, pct.name,
                              "%s: must be 0 where delay_ms, jitter_ms and rate_kbps are 0, since a "
                              "reordered packet goes without that delay; got %g",
                              pct.name, p->reorder_pct);
    if (p->reorder_pct > 0 && p->order == LL_ORDER_FIFO)
        return ll_field_error(LL_BAD_INPUT, pct.name, "%s: must be 0 where order is fifo; got %g", pct.name,
                              p->reorder_pct);
    if (p->reorder_pct <= 0 && p->reorder_gap > 1)
        return ll_field_error(LL_BAD_INPUT, gap.name, "%s: must be 1 where reorder_pct is 0; got %lld",
                              gap.name, (long long)p->reorder_gap);
    return ll_ok();
}

/* The transitions out of a state add up to at most 100 %. */
static ll_status check_sum(const char *path, const char *a, double pa, const char *b, double pb)
{
    field f = field_of(path, b);
    if (pa + pb <= 100)
        return ll_ok();
    return ll_field_error(LL_BAD_INPUT, f.name, "%s: must be at most 100 %% together with %s, %g %%; got %g",
                          f.name, a, pa, pb);
}

static ll_status check_states(const ll_link_params *p, const char *path)
{
    if (p->loss_model != LL_LOSS_STATE)
        return ll_ok();
    ll_status status = check_sum(path, "p13_pct", p->p13_pct, "p14_pct", p->p14_pct);
    return ll_failed(&status) ? status : check_sum(path, "p31_pct", p->p31_pct, "p32_pct", p->p32_pct);
}

static ll_status check_mtu(const ll_link_params *p, const char *path)
{
    field f = field_of(path, "mtu_bytes");
    if (p->mtu_bytes == 0 || p->mtu_bytes >= LL_MTU_MIN)
        return ll_ok();
    return ll_field_error(LL_BAD_INPUT, f.name, "%s: must be 0 or %d to 65507 B; got %lld", f.name,
                          LL_MTU_MIN, (long long)p->mtu_bytes);
}

static ll_status check_window(const char *path, const char *kind, double every_ms, double length_ms)
{
    char name[32];
    snprintf(name, sizeof name, "%s_length_ms", kind);
    field f = field_of(path, name);
    if (every_ms <= 0 || length_ms <= every_ms)
        return ll_ok();
    return ll_field_error(LL_BAD_INPUT, f.name, "%s: must be at most %s_every_ms, %g ms; got %g", f.name,
                          kind, every_ms, length_ms);
}

static ll_status check(const void *object, const char *path)
{
    const ll_link_params *p = object;
    LL_TRY(check_reorder(p, path));
    LL_TRY(check_states(p, path));
    LL_TRY(check_mtu(p, path));
    LL_TRY(check_window(path, "spike", p->spike_every_ms, p->spike_length_ms));
    return check_window(path, "blackout", p->blackout_every_ms, p->blackout_length_ms);
}

const ll_param_table ll_link_table = {.name = "link",
                                      .help = "One direction of a network path, in netem's terms.",
                                      LL_PARAM_ROWS(rows, ll_link_params),
                                      .check = check};
