#include "netcode/metrics/changes.h"

#include "base/assert.h"

static ll_change *change_at(ll_changes *c, int64_t i)
{
    _Static_assert((LL_CHANGES_RING & (LL_CHANGES_RING - 1)) == 0, "a mask finds the place");
    LL_VALIDATE(i >= c->first && i - c->first <= LL_CHANGES_RING);
    return &c->ring[i & (LL_CHANGES_RING - 1)];
}

static bool counted(const ll_change *change, ll_latency which)
{
    return change->counted >> which & 1;
}

static void add(ll_change *change, ll_histogram *latency, ll_latency which)
{
    LL_ASSERT(change->at[which] >= change->made &&
              !counted(change, which)); /* once, not before it was made */
    ll_histogram_add(&latency[which], ll_to_ms(change->at[which] - change->made));
    change->counted |= (uint8_t)(1 << which);
}

static void add_never(ll_changes *c, ll_change *change, ll_histogram *latency, bool lost)
{
    for (ll_latency which = LL_LATENCY_FELT; which <= LL_LATENCY_SURE; which++) {
        if (counted(change, which))
            continue;
        ll_histogram_add_never(&latency[which]);
        c->lost[which] += lost;
    }
    for (uint32_t left = c->others & ~change->seen; left != 0; left &= left - 1) {
        ll_histogram_add_never(&latency[LL_LATENCY_SEEN]);
        c->lost[LL_LATENCY_SEEN] += lost;
    }
    change->counted = 1 << LL_LATENCY_FELT | 1 << LL_LATENCY_SURE;
    change->seen = c->others;
}

static bool complete(const ll_changes *c, const ll_change *change)
{
    return counted(change, LL_LATENCY_FELT) && counted(change, LL_LATENCY_SURE) && change->seen == c->others;
}

static void pass_complete(ll_changes *c)
{
    while (c->first < c->made && complete(c, change_at(c, c->first)))
        c->first++;
}

static bool moved(float a, float b)
{
    if (a == b)
        return false;
    double by = (double)a - (double)b;
    return !(by <= LL_CHANGE_EPSILON && by >= -LL_CHANGE_EPSILON); /* the NaN of a cheat is a change too */
}

/* Stores the controls; false if they have not changed. */
static bool take_controls(ll_changes *c, const ll_action *a)
{
    uint32_t buttons = a->buttons & LL_BUTTONS;
    bool other = moved(a->axis[0], c->axis[0]) || moved(a->axis[1], c->axis[1]) || buttons != c->buttons;
    c->axis[0] = a->axis[0];
    c->axis[1] = a->axis[1];
    c->buttons = buttons;
    return other;
}

void ll_changes_missed(ll_changes *c, ll_histogram *latency, const ll_action *a, bool counts)
{
    ll_change missed = {.seen = 0};
    if (take_controls(c, a) && counts)
        add_never(c, &missed, latency, true);
}

void ll_changes_made(ll_changes *c, ll_histogram *latency, const ll_made_input *input)
{
    if (!take_controls(c, input->controls) || !input->counts)
        return;
    ll_change *change = change_at(c, c->made);
    if (c->made - c->first == LL_CHANGES_RING) {
        if (change->decided)
            add_never(c, change, latency, false);
        c->first++;
    }
    *change = (ll_change){
        .made = input->touched, .at = {LL_NEVER, LL_NEVER}, .tick = input->tick, .seq = input->seq};
    c->made++;
}

void ll_changes_idle(ll_changes *c)
{
    c->axis[0] = c->axis[1] = 0;
    c->buttons = 0;
}

void ll_changes_resync(ll_changes *c)
{
    for (int64_t i = c->first; i < c->made; i++)
        change_at(c, i)->seq = UINT32_MAX;
    ll_changes_idle(c);
}

/* Counts the displays before the input's result was known. */
static void decide(ll_changes *c, ll_change *change, ll_histogram *latency,
                   const ll_input_history_entry *input)
{
    if (input && input->result == LL_INPUT_IS_OPEN)
        return;
    change->decided = input ? input->result : LL_INPUT_WAS_LOST;
    if (change->decided != LL_INPUT_WAS_APPLIED) {
        add_never(c, change, latency, true);
        return;
    }
    change->tick = input->tick;
    for (ll_latency which = LL_LATENCY_FELT; which <= LL_LATENCY_SURE; which++)
        if (change->at[which] != LL_NEVER)
            add(change, latency, which);
}

void ll_changes_decide(ll_changes *c, ll_histogram *latency, ll_input_history *input_history)
{
    for (int64_t i = c->first; i < c->made; i++) {
        ll_change *change = change_at(c, i);
        if (!change->decided)
            decide(c, change, latency, ll_input_history_find(input_history, change->seq));
    }
    pass_complete(c);
}

void ll_changes_shown(ll_changes *c, ll_histogram *latency, const ll_included *in, ll_time now)
{
    for (int64_t i = c->first; i < c->made; i++) {
        ll_change *change = change_at(c, i);
        bool has = change->seq <= in->seq || change->tick <= in->tick;
        if (change->at[LL_LATENCY_FELT] == LL_NEVER && has)
            change->at[LL_LATENCY_FELT] = now;
        if (change->at[LL_LATENCY_SURE] == LL_NEVER && change->tick <= in->sure_tick)
            change->at[LL_LATENCY_SURE] = now;
        for (ll_latency which = LL_LATENCY_FELT; change->decided && which <= LL_LATENCY_SURE; which++)
            if (change->at[which] != LL_NEVER && !counted(change, which))
                add(change, latency, which);
    }
    pass_complete(c);
}

/* A client may receive an input, and draw its tick, before the server has made that tick. */
void ll_changes_seen(ll_changes *c, ll_histogram *latency, ll_input_history *input_history, int other,
                     int64_t tick, ll_time now)
{
    if (other >= LL_CHANGE_VIEWERS)
        return;
    const uint32_t bit = UINT32_C(1) << other;
    bool seen = false;
    for (int64_t i = c->first; i < c->made; i++) {
        ll_change *change = change_at(c, i);
        if ((change->seen & bit) || change->tick > tick)
            continue;
        if (!change->decided &&
            !(ll_input_history_flags(input_history, change->seq) & LL_INPUT_HISTORY_IN_TIME))
            continue;
        ll_histogram_add(&latency[LL_LATENCY_SEEN], ll_to_ms(now - change->made));
        change->seen |= bit;
        seen = true;
    }
    if (seen)
        pass_complete(c);
}
