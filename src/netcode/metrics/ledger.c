#include "netcode/metrics/ledger.h"

const char *const ll_cause_names[LL_CAUSES] = {"refused", "late", "loss", "contact", "other"};

const char *const ll_input_verdict_names[LL_INPUT_VERDICTS] = {"open", "applied", "refused", "late", "lost"};

static void decide(ll_ledger *ledger, ll_ledger_input *input, ll_input_verdict verdict)
{
    ledger->count[input->verdict]--;
    ledger->count[verdict]++;
    input->verdict = (uint8_t)verdict;
}

/* What was refused may have come again until now. */
static void give_up(ll_ledger *ledger, ll_ledger_input *input)
{
    bool refused = (input->marks & LL_LEDGER_REFUSED) && !(input->marks & LL_LEDGER_IN_TIME);
    decide(ledger, input, refused ? LL_INPUT_WAS_REFUSED : LL_INPUT_WAS_LOST);
}

static bool is_open(ll_ledger *ledger, uint32_t seq)
{
    const ll_ledger_input *input = ll_ledger_find(ledger, seq);
    return input && input->verdict == LL_INPUT_IS_OPEN;
}

static void pass_decided(ll_ledger *ledger)
{
    while (ledger->open <= ledger->newest && !is_open(ledger, ledger->open))
        ledger->open++;
}

/* What a step makes of an input whose time it was. */
static ll_input_verdict verdict_of(const ll_ledger_input *input)
{
    return input->marks & LL_LEDGER_IN_TIME   ? LL_INPUT_WAS_APPLIED
           : input->marks & LL_LEDGER_REFUSED ? LL_INPUT_WAS_REFUSED
           : input->marks & LL_LEDGER_LATE    ? LL_INPUT_CAME_LATE
                                              : LL_INPUT_WAS_LOST;
}

void ll_ledger_made(ll_ledger *ledger, uint32_t seq, int64_t tick)
{
    ll_ledger_input *input = &ledger->input[seq & (LL_LEDGER_RING - 1)];
    if (input->seq != 0 && input->verdict == LL_INPUT_IS_OPEN)
        give_up(ledger, input);
    *input = (ll_ledger_input){.tick = tick, .seq = seq};
    if (tick == LL_NEVER)
        *input = (ll_ledger_input){.seq = seq, .marks = LL_LEDGER_AS_IT_COMES};
    ledger->newest = seq;
    ledger->made++;
    ledger->count[LL_INPUT_IS_OPEN]++;
    pass_decided(ledger);
}

void ll_ledger_went(ll_ledger *ledger, uint32_t first, uint32_t count, ll_time due)
{
    for (uint32_t seq = first; seq - first < count; seq++) {
        ll_ledger_input *input = ll_ledger_find(ledger, seq);
        if (!input)
            continue;
        input->marks |= LL_LEDGER_WENT;
        if ((input->marks & LL_LEDGER_AS_IT_COMES) && input->verdict == LL_INPUT_IS_OPEN && due > input->tick)
            input->tick = due;
    }
}

/* One that was given up and comes all the same where it is applied as it comes is open again. */
void ll_ledger_judged(ll_ledger *ledger, uint32_t seq, ll_ledger_mark mark)
{
    ll_ledger_input *input = ll_ledger_find(ledger, seq);
    if (!input)
        return;
    input->marks |= (uint8_t)mark;
    if (input->verdict != LL_INPUT_WAS_LOST)
        return;
    decide(ledger, input,
           mark == LL_LEDGER_IN_TIME   ? LL_INPUT_IS_OPEN
           : mark == LL_LEDGER_REFUSED ? LL_INPUT_WAS_REFUSED
                                       : LL_INPUT_CAME_LATE);
    if (mark == LL_LEDGER_IN_TIME && seq < ledger->open)
        ledger->open = seq;
}

void ll_ledger_stepped(ll_ledger *ledger, int64_t step)
{
    for (uint32_t seq = ledger->open; seq <= ledger->newest; seq++) {
        ll_ledger_input *input = ll_ledger_find(ledger, seq);
        if (!input || input->verdict != LL_INPUT_IS_OPEN)
            continue;
        if (input->tick > step)
            break; /* ticks go up with the numbers */
        decide(ledger, input, verdict_of(input));
    }
    pass_decided(ledger);
}

void ll_ledger_drained(ll_ledger *ledger, int64_t step, uint32_t unsent_from, ll_time now)
{
    for (uint32_t seq = ledger->open; seq <= ledger->newest; seq++) {
        ll_ledger_input *input = ll_ledger_find(ledger, seq);
        if (!input || input->verdict != LL_INPUT_IS_OPEN)
            continue;
        bool came = input->marks & LL_LEDGER_IN_TIME;
        if (!came && (seq >= unsent_from || ((input->marks & LL_LEDGER_WENT) && input->tick > now)))
            continue;
        input->tick = step;
        decide(ledger, input, verdict_of(input));
    }
    pass_decided(ledger);
}

void ll_ledger_never(ll_ledger *ledger, uint32_t first, uint32_t last)
{
    first = first < ledger->open ? ledger->open : first;
    for (uint32_t seq = first; seq <= last && seq <= ledger->newest; seq++)
        if (is_open(ledger, seq))
            give_up(ledger, ll_ledger_find(ledger, seq));
    pass_decided(ledger);
}

void ll_ledger_meet(ll_ledger *ledger)
{
    ll_ledger_never(ledger, 1, ledger->newest);
    for (int i = 0; i < LL_LEDGER_RING; i++)
        ledger->input[i] = (ll_ledger_input){0};
    ledger->newest = 0;
    ledger->open = 1;
}

bool ll_ledger_includes(ll_ledger *ledger, uint32_t seq, int64_t tick)
{
    const ll_ledger_input *input = ll_ledger_find(ledger, seq);
    return input && input->verdict == LL_INPUT_WAS_APPLIED && input->tick <= tick;
}

void ll_ledger_closed(ll_ledger *ledger, uint32_t seq, bool applied, int64_t tick)
{
    ledger->applied += applied;
    ledger->skipped += !applied;
    ledger->wrong += applied && !ll_ledger_includes(ledger, seq, tick);
}

static ll_cause blame(uint8_t fate)
{
    if (fate & LL_LEDGER_REFUSED)
        return LL_CAUSE_REFUSED;
    if (fate & LL_LEDGER_IN_TIME)
        return LL_CAUSE_OTHER;
    return fate & (LL_LEDGER_LATE | LL_LEDGER_WENT) ? LL_CAUSE_LATE : LL_CAUSE_LOSS;
}

ll_cause ll_ledger_blame(ll_ledger *ledger, uint32_t first, uint32_t last)
{
    ll_cause worst = LL_CAUSE_OTHER;
    if (last - first >= LL_LEDGER_RING && last > first)
        first = last - LL_LEDGER_RING + 1;
    for (uint32_t seq = first; seq <= last; seq++) {
        const ll_ledger_input *input = ll_ledger_find(ledger, seq);
        ll_cause cause = input ? blame(input->marks) : LL_CAUSE_LATE; /* a clock that snapped made none */
        worst = cause < worst ? cause : worst;
    }
    return worst;
}

void ll_ledger_correction(ll_ledger *ledger, ll_cause cause, double size)
{
    ledger->corrections[cause].count++;
    ledger->corrections[cause].sum += size;
    if (size > ledger->corrections[cause].max)
        ledger->corrections[cause].max = size;
}
