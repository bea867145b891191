#include "netcode/metrics/input_history.h"

#include "base/assert.h"

const char *const ll_cause_names[LL_CAUSES] = {"refused", "late", "loss", "contact", "other"};

/* Where input `seq`, which is not 0, is or was. */
static ll_input_history_entry *entry_of(ll_input_history *input_history, uint32_t seq)
{
    return &input_history->input[seq & (LL_INPUT_HISTORY_RING - 1)];
}

static void decide(ll_input_history *input_history, ll_input_history_entry *input,
                   ll_input_result_kind result)
{
    LL_ASSERT(input_history->count[input->result] > 0); /* made = open + applied + refused + late + lost */
    input_history->count[input->result]--;
    input_history->count[result]++;
    input->result = (uint8_t)result;
}

/* Ends the wait for a refused input, which the client could have sent again until now. */
static void give_up(ll_input_history *input_history, ll_input_history_entry *input)
{
    bool refused = (input->flags & LL_INPUT_HISTORY_REFUSED) && !(input->flags & LL_INPUT_HISTORY_IN_TIME);
    decide(input_history, input, refused ? LL_INPUT_WAS_REFUSED : LL_INPUT_WAS_LOST);
}

static bool is_open(ll_input_history *input_history, uint32_t seq)
{
    const ll_input_history_entry *input = ll_input_history_find(input_history, seq);
    return input && input->result == LL_INPUT_IS_OPEN;
}

static void pass_decided(ll_input_history *input_history)
{
    while (input_history->open <= input_history->newest && !is_open(input_history, input_history->open))
        input_history->open++;
}

/* Result of an input whose step is over. */
static ll_input_result_kind input_result_of(const ll_input_history_entry *input)
{
    return input->flags & LL_INPUT_HISTORY_IN_TIME   ? LL_INPUT_WAS_APPLIED
           : input->flags & LL_INPUT_HISTORY_REFUSED ? LL_INPUT_WAS_REFUSED
           : input->flags & LL_INPUT_HISTORY_LATE    ? LL_INPUT_CAME_LATE
                                                     : LL_INPUT_WAS_LOST;
}

void ll_input_history_made(ll_input_history *input_history, uint32_t seq, int64_t tick)
{
    _Static_assert((LL_INPUT_HISTORY_RING & (LL_INPUT_HISTORY_RING - 1)) == 0, "a mask finds the place");
    ll_input_history_entry *input = &input_history->input[seq & (LL_INPUT_HISTORY_RING - 1)];
    const bool given_up = input->seq != 0 && input->result == LL_INPUT_IS_OPEN;
    const bool next = seq == input_history->newest + 1;
    if (given_up)
        give_up(input_history, input);
    *input = (ll_input_history_entry){.tick = tick, .seq = seq};
    if (tick == LL_NEVER)
        *input = (ll_input_history_entry){.seq = seq, .flags = LL_INPUT_HISTORY_ON_ARRIVAL};
    input_history->newest = seq;
    input_history->count[LL_INPUT_IS_OPEN]++;
    if (given_up || !next)
        pass_decided(input_history);
}

void ll_input_history_sent(ll_input_history *input_history, uint32_t first, uint32_t count, ll_time due)
{
    for (uint32_t seq = first; seq - first < count; seq++) {
        ll_input_history_entry *input = entry_of(input_history, seq);
        if (input->seq != seq)
            continue;
        input->flags |= LL_INPUT_HISTORY_SENT;
        if ((input->flags & LL_INPUT_HISTORY_ON_ARRIVAL) && input->result == LL_INPUT_IS_OPEN &&
            due > input->tick)
            input->tick = due;
    }
}

/* Where inputs are applied on arrival, an input that was given up and still arrives is open again. */
void ll_input_history_received(ll_input_history *input_history, uint32_t seq, ll_input_history_flag flag)
{
    ll_input_history_entry *input = ll_input_history_find(input_history, seq);
    if (!input)
        return;
    input->flags |= (uint8_t)flag;
    if (input->result != LL_INPUT_WAS_LOST)
        return;
    decide(input_history, input,
           flag == LL_INPUT_HISTORY_IN_TIME   ? LL_INPUT_IS_OPEN
           : flag == LL_INPUT_HISTORY_REFUSED ? LL_INPUT_WAS_REFUSED
                                              : LL_INPUT_CAME_LATE);
    if (flag == LL_INPUT_HISTORY_IN_TIME && seq < input_history->open)
        input_history->open = seq;
}

void ll_input_history_stepped(ll_input_history *input_history, int64_t step)
{
    uint32_t seq = input_history->open;
    for (; seq <= input_history->newest; seq++) {
        ll_input_history_entry *input = entry_of(input_history, seq);
        if (input->seq != seq || input->result != LL_INPUT_IS_OPEN)
            continue;
        if (input->tick > step)
            break; /* ticks increase with sequence numbers */
        decide(input_history, input, input_result_of(input));
    }
    input_history->open = seq; /* all before it are decided */
}

void ll_input_history_applied(ll_input_history *input_history, int64_t step, uint32_t unsent_from,
                              ll_time now)
{
    for (uint32_t seq = input_history->open; seq <= input_history->newest; seq++) {
        ll_input_history_entry *input = ll_input_history_find(input_history, seq);
        if (!input || input->result != LL_INPUT_IS_OPEN)
            continue;
        bool came = input->flags & LL_INPUT_HISTORY_IN_TIME;
        if (!came && (seq >= unsent_from || ((input->flags & LL_INPUT_HISTORY_SENT) && input->tick > now)))
            continue;
        input->tick = step;
        decide(input_history, input, input_result_of(input));
    }
    pass_decided(input_history);
}

void ll_input_history_never(ll_input_history *input_history, uint32_t first, uint32_t last)
{
    first = first < input_history->open ? input_history->open : first;
    for (uint32_t seq = first; seq <= last && seq <= input_history->newest; seq++)
        if (is_open(input_history, seq))
            give_up(input_history, ll_input_history_find(input_history, seq));
    pass_decided(input_history);
}

void ll_input_history_resync(ll_input_history *input_history)
{
    ll_input_history_never(input_history, 1, input_history->newest);
    for (int i = 0; i < LL_INPUT_HISTORY_RING; i++)
        input_history->input[i] = (ll_input_history_entry){0};
    input_history->newest = 0;
    input_history->open = 1;
}

bool ll_input_history_includes(ll_input_history *input_history, uint32_t seq, int64_t tick)
{
    const ll_input_history_entry *input = ll_input_history_find(input_history, seq);
    return input && input->result == LL_INPUT_WAS_APPLIED && input->tick <= tick;
}

void ll_input_history_closed(ll_input_history *input_history, uint32_t seq, bool applied, int64_t tick)
{
    input_history->applied += applied;
    input_history->skipped += !applied;
    input_history->wrong += applied && !ll_input_history_includes(input_history, seq, tick);
}

static ll_cause blame(uint8_t fate)
{
    if (fate & LL_INPUT_HISTORY_REFUSED)
        return LL_CAUSE_REFUSED;
    if (fate & LL_INPUT_HISTORY_IN_TIME)
        return LL_CAUSE_OTHER;
    return fate & (LL_INPUT_HISTORY_LATE | LL_INPUT_HISTORY_SENT) ? LL_CAUSE_LATE : LL_CAUSE_LOSS;
}

ll_cause ll_input_history_blame(ll_input_history *input_history, uint32_t first, uint32_t last)
{
    ll_cause worst = LL_CAUSE_OTHER;
    if (last - first >= LL_INPUT_HISTORY_RING && last > first)
        first = last - LL_INPUT_HISTORY_RING + 1;
    for (uint32_t seq = first; seq <= last; seq++) {
        const ll_input_history_entry *input = ll_input_history_find(input_history, seq);
        ll_cause cause = input ? blame(input->flags) : LL_CAUSE_LATE; /* a clock that snapped made no input */
        worst = cause < worst ? cause : worst;
    }
    return worst;
}

void ll_input_history_correction(ll_input_history *input_history, ll_cause cause, double size)
{
    input_history->corrections[cause].count++;
    input_history->corrections[cause].sum += size;
    if (size > input_history->corrections[cause].max)
        input_history->corrections[cause].max = size;
}
