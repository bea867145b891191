#include "netcode/metrics/input_history.h"

const char *const ll_cause_names[LL_CAUSES] = {"refused", "late", "loss", "contact", "other"};

static void decide(ll_input_history *input_history, ll_input_history_entry *input,
                   ll_input_result_kind verdict)
{
    input_history->count[input->verdict]--;
    input_history->count[verdict]++;
    input->verdict = (uint8_t)verdict;
}

/* What was refused may have come again until now. */
static void give_up(ll_input_history *input_history, ll_input_history_entry *input)
{
    bool refused = (input->marks & LL_INPUT_HISTORY_REFUSED) && !(input->marks & LL_INPUT_HISTORY_IN_TIME);
    decide(input_history, input, refused ? LL_INPUT_WAS_REFUSED : LL_INPUT_WAS_LOST);
}

static bool is_open(ll_input_history *input_history, uint32_t seq)
{
    const ll_input_history_entry *input = ll_input_history_find(input_history, seq);
    return input && input->verdict == LL_INPUT_IS_OPEN;
}

static void pass_decided(ll_input_history *input_history)
{
    while (input_history->open <= input_history->newest && !is_open(input_history, input_history->open))
        input_history->open++;
}

/* What a step makes of an input whose time it was. */
static ll_input_result_kind input_result_of(const ll_input_history_entry *input)
{
    return input->marks & LL_INPUT_HISTORY_IN_TIME   ? LL_INPUT_WAS_APPLIED
           : input->marks & LL_INPUT_HISTORY_REFUSED ? LL_INPUT_WAS_REFUSED
           : input->marks & LL_INPUT_HISTORY_LATE    ? LL_INPUT_CAME_LATE
                                                     : LL_INPUT_WAS_LOST;
}

void ll_input_history_made(ll_input_history *input_history, uint32_t seq, int64_t tick)
{
    ll_input_history_entry *input = &input_history->input[seq & (LL_INPUT_HISTORY_RING - 1)];
    if (input->seq != 0 && input->verdict == LL_INPUT_IS_OPEN)
        give_up(input_history, input);
    *input = (ll_input_history_entry){.tick = tick, .seq = seq};
    if (tick == LL_NEVER)
        *input = (ll_input_history_entry){.seq = seq, .marks = LL_INPUT_HISTORY_AS_IT_COMES};
    input_history->newest = seq;
    input_history->made++;
    input_history->count[LL_INPUT_IS_OPEN]++;
    pass_decided(input_history);
}

void ll_input_history_went(ll_input_history *input_history, uint32_t first, uint32_t count, ll_time due)
{
    for (uint32_t seq = first; seq - first < count; seq++) {
        ll_input_history_entry *input = ll_input_history_find(input_history, seq);
        if (!input)
            continue;
        input->marks |= LL_INPUT_HISTORY_WENT;
        if ((input->marks & LL_INPUT_HISTORY_AS_IT_COMES) && input->verdict == LL_INPUT_IS_OPEN &&
            due > input->tick)
            input->tick = due;
    }
}

/* One that was given up and comes all the same where it is applied as it comes is open again. */
void ll_input_history_judged(ll_input_history *input_history, uint32_t seq, ll_input_history_mark mark)
{
    ll_input_history_entry *input = ll_input_history_find(input_history, seq);
    if (!input)
        return;
    input->marks |= (uint8_t)mark;
    if (input->verdict != LL_INPUT_WAS_LOST)
        return;
    decide(input_history, input,
           mark == LL_INPUT_HISTORY_IN_TIME   ? LL_INPUT_IS_OPEN
           : mark == LL_INPUT_HISTORY_REFUSED ? LL_INPUT_WAS_REFUSED
                                              : LL_INPUT_CAME_LATE);
    if (mark == LL_INPUT_HISTORY_IN_TIME && seq < input_history->open)
        input_history->open = seq;
}

void ll_input_history_stepped(ll_input_history *input_history, int64_t step)
{
    for (uint32_t seq = input_history->open; seq <= input_history->newest; seq++) {
        ll_input_history_entry *input = ll_input_history_find(input_history, seq);
        if (!input || input->verdict != LL_INPUT_IS_OPEN)
            continue;
        if (input->tick > step)
            break; /* ticks go up with the numbers */
        decide(input_history, input, input_result_of(input));
    }
    pass_decided(input_history);
}

void ll_input_history_drained(ll_input_history *input_history, int64_t step, uint32_t unsent_from,
                              ll_time now)
{
    for (uint32_t seq = input_history->open; seq <= input_history->newest; seq++) {
        ll_input_history_entry *input = ll_input_history_find(input_history, seq);
        if (!input || input->verdict != LL_INPUT_IS_OPEN)
            continue;
        bool came = input->marks & LL_INPUT_HISTORY_IN_TIME;
        if (!came && (seq >= unsent_from || ((input->marks & LL_INPUT_HISTORY_WENT) && input->tick > now)))
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

void ll_input_history_meet(ll_input_history *input_history)
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
    return input && input->verdict == LL_INPUT_WAS_APPLIED && input->tick <= tick;
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
    return fate & (LL_INPUT_HISTORY_LATE | LL_INPUT_HISTORY_WENT) ? LL_CAUSE_LATE : LL_CAUSE_LOSS;
}

ll_cause ll_input_history_blame(ll_input_history *input_history, uint32_t first, uint32_t last)
{
    ll_cause worst = LL_CAUSE_OTHER;
    if (last - first >= LL_INPUT_HISTORY_RING && last > first)
        first = last - LL_INPUT_HISTORY_RING + 1;
    for (uint32_t seq = first; seq <= last; seq++) {
        const ll_input_history_entry *input = ll_input_history_find(input_history, seq);
        ll_cause cause = input ? blame(input->marks) : LL_CAUSE_LATE; /* a clock that snapped made none */
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
