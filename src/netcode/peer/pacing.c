/* Pacing of a peer by fractions of a tick: it lengthens its frames while it is ahead, and adapts its input
 * delay to the measured delays. */
#include "netcode/state/peer.h"

/* Frames are longer by at most this part, from a lead of this many ticks on, until the lead is gone. */
#define STRETCH_MAX 0.1
#define LEAD_MIN 0.5

#define CHECK_EVERY 32 /* frames between two checks of the input delay, and fewest samples for one */
/* The input delay falls when each of LOWER_AFTER checks finds it TOO_LONG ticks longer than wanted, or more,
 * and to one tick more than wanted: so it does not go to and fro where the quantile lies between two ticks.
 */
#define TOO_LONG 2
#define LOWER_AFTER 16
#define QUANTILE 0.95
#define SETTLES LL_ADAPTIVE_DELAY_MAX /* ticks after a change whose inputs are not made one by one */

#define UNIT 256.0 /* a lead in a packet is in parts of a tick */
#define UNKNOWN INT16_MIN
#define OLD (4 * LL_PEER_RING) /* ticks; of a player who reports none for so long no samples count */

static double ticks_since(const ll_client *c, ll_time then, ll_time now)
{
    return (double)(now - then) / (double)c->ticks.period;
}

/* The tick that the client has made, and the part of the next that has passed. */
static double position(const ll_client *c, ll_time now)
{
    double part = ticks_since(c, c->ticks.last, now);
    return (double)ll_client_peer(c)->tick + (part < 1 ? part : 1);
}

/* The same as if it did not wait for inputs. */
static double wanted_position(const ll_client *c, ll_time now)
{
    const ll_peer *peer = ll_client_peer(c);
    return peer->waiting ? (double)peer->tick + ticks_since(c, peer->stepped, now) : position(c, now);
}

static int16_t in_units(double ticks)
{
    double units = ticks * UNIT;
    units = units > INT16_MAX ? INT16_MAX : units < INT16_MIN + 1 ? INT16_MIN + 1 : units;
    int16_t whole = (int16_t)units;
    return (int16_t)(whole + (units > whole)); /* rounded up */
}

void ll_pacing_start(const ll_client_setup *s)
{
    ll_peer_choices *choices = s->choices;
    choices->delay = s->config->input_delay_ticks < LL_ADAPTIVE_DELAY_MAX ? s->config->input_delay_ticks
                                                                          : LL_ADAPTIVE_DELAY_MAX;
    choices->changed_at = INT32_MIN;
    choices->want = choices->checks = 0;
    choices->stretched = 0;
    choices->stretching = 0;
    for (int i = 0; i < LL_PEER_RING; i++)
        choices->stretched_at[i] = 0;
    for (int p = 0; p < LL_PEERS_MAX; p++)
        choices->way[p].lead = choices->way[p].latest = UNKNOWN;
}

void ll_pacing_forget_lead(const ll_client_setup *s, int player)
{
    s->choices->way[player].lead = UNKNOWN;
}

/* ---- what is measured, and reported ---- */

void ll_pacing_inputs_came(const ll_client *c, const ll_client_setup *s, int player, int64_t first,
                           ll_time now)
{
    ll_peer_way *way = &s->choices->way[player];
    int16_t late = in_units(wanted_position(c, now) - (double)first);
    way->latest = way->reported || late > way->latest ? late : way->latest;
    way->reported = 0;
}

int32_t ll_pacing_report(const ll_client_setup *s, int player)
{
    ll_peer_way *way = &s->choices->way[player];
    way->reported = 1;
    return (int32_t)((uint32_t)(uint16_t)way->lead | (uint32_t)(uint16_t)way->latest << 16);
}

/* How many ticks a guess for an input of this client reaches back at `player`, as if there were no input
 * delay: the one-way delay in ticks, rounded up. */
static void add_way(ll_peer_choices *choices, int player, int16_t latest)
{
    ll_peer_way *way = &choices->way[player];
    const int64_t units = (int64_t)UNIT, back = latest + choices->delay * units;
    int64_t ticks = back < 0 ? 0 : (back + units - 1) / units;
    uint8_t value = (uint8_t)(ticks < LL_WAY_TICKS ? ticks : LL_WAY_TICKS - 1);
    uint8_t *slot = &way->window[way->samples % LL_WAY_WINDOW];
    if (way->samples++ >= LL_WAY_WINDOW)
        way->counts[*slot]--;
    *slot = value;
    way->counts[value]++;
}

/* By how much frames had been lengthened when `tick` was made. */
static double stretched_at(const ll_peer *peer, const ll_peer_choices *choices, int64_t tick)
{
    tick = tick < peer->tick - LL_PEER_RING + 1 ? peer->tick - LL_PEER_RING + 1 : tick;
    return tick < peer->tick ? choices->stretched_at[tick & (LL_PEER_RING - 1)] : choices->stretched;
}

/* Means are of what would be without lengthened frames, which are subtracted again: so a correction shows at
 * once, not when the means and the other's reports have followed. */
void ll_pacing_take(ll_client *c, const ll_client_setup *s, const ll_relay_part *part, ll_time now)
{
    ll_peer *peer = ll_client_peer(c);
    ll_peer_choices *choices = s->choices;
    ll_peer_player *from = &peer->player[part->player];
    const int16_t lead = (int16_t)(uint16_t)((uint32_t)part->ahead & UINT16_MAX),
                  latest = (int16_t)(uint16_t)((uint32_t)part->ahead >> 16);
    const double ahead = position(c, now) - part->at, behind = lead / UNIT;
    choices->way[part->player].lead = in_units(ahead);
    from->samples = from->at < 0 ? 0 : from->samples;
    from->at = part->at;
    if (lead == UNKNOWN)
        return;
    const int64_t basis = part->at - (int64_t)behind; /* own tick that the report is about */
    if (latest != UNKNOWN && basis > choices->changed_at + SETTLES)
        add_way(choices, part->player, latest);
    from->samples += from->samples < LL_LEAD_SAMPLES;
    const double share = 1.0 / from->samples;
    from->ahead += share * (ahead + choices->stretched - from->ahead);
    from->behind += share * (behind - stretched_at(peer, choices, basis) - from->behind);
}

/* ---- what follows from it ---- */

double ll_pacing_lead(const ll_client *c, const ll_peer_choices *choices)
{
    const ll_peer *peer = ll_client_peer(c);
    double most = 0;
    for (int p = 0; p < ll_client_rendered_const(c)->players; p++) {
        const ll_peer_player *other = &peer->player[p];
        double lead = (other->ahead - other->behind) / 2 - choices->stretched;
        if (p != c->self && other->at >= 0 && other->samples > 0 && lead > most)
            most = lead;
    }
    return most;
}

void ll_pacing_stretch(ll_client *c, const ll_client_setup *s)
{
    ll_peer *peer = ll_client_peer(c);
    ll_peer_choices *choices = s->choices;
    double lead = ll_pacing_lead(c, choices);
    choices->stretched_at[peer->tick & (LL_PEER_RING - 1)] = choices->stretched;
    choices->stretching = lead >= LEAD_MIN || (choices->stretching && lead > 0);
    choices->longer = 0;
    if (!choices->stretching)
        return;
    lead = lead < STRETCH_MAX ? lead : STRETCH_MAX;
    choices->longer = (ll_time)(lead * (double)c->ticks.period);
    choices->stretched += lead;
    c->ticks.clock.epoch += choices->longer;
}

/* The number of ticks that a guess reaches back at most in QUANTILE of the samples. */
static int64_t quantile(const ll_peer_way *way)
{
    const int64_t count = way->samples < LL_WAY_WINDOW ? way->samples : LL_WAY_WINDOW;
    int64_t below = 0, ticks = 0;
    for (; ticks < LL_WAY_TICKS - 1; ticks++) {
        below += way->counts[ticks];
        if ((double)below >= QUANTILE * (double)count)
            break;
    }
    return ticks;
}

static void set_delay(const ll_client *c, const ll_client_setup *s, int64_t delay, ll_time now)
{
    ll_peer_choices *choices = s->choices;
    choices->want = choices->checks = 0;
    if (delay == choices->delay)
        return;
    choices->changed_at = ll_client_peer(c)->tick;
    choices->delay_changes += now >= s->client_metrics->from;
    choices->delay = delay;
}

void ll_pacing_adapt_delay(ll_client *c, const ll_client_setup *s, ll_time now)
{
    const ll_peer *peer = ll_client_peer(c);
    ll_peer_choices *choices = s->choices;
    int64_t most = -1;
    if (c->ticks.number % CHECK_EVERY != 0)
        return;
    for (int p = 0; p < ll_client_rendered(c)->players; p++) {
        const ll_peer_way *way = &choices->way[p];
        bool counts = p != c->self && way->samples >= CHECK_EVERY && peer->tick - peer->player[p].at < OLD;
        int64_t ticks = counts ? quantile(way) : -1;
        most = ticks > most ? ticks : most;
    }
    if (most < 0)
        return;
    int64_t want = most - (s->sync->guesses ? choices->budget : 0);
    want = want < 0 ? 0 : want > LL_ADAPTIVE_DELAY_MAX ? LL_ADAPTIVE_DELAY_MAX : want;
    choices->want = want > choices->want ? want : choices->want;
    if (want > choices->delay)
        set_delay(c, s, want, now);
    else if (++choices->checks == LOWER_AFTER)
        set_delay(c, s, choices->want + TOO_LONG <= choices->delay ? choices->want + 1 : choices->delay, now);
}
