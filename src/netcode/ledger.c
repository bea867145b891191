#include "netcode/ledger.h"

const char *const ll_cause_names[LL_CAUSES] = {"refused", "late", "loss", "contact", "other"};

void ll_ledger_closed(ll_ledger *ledger, uint32_t seq, bool applied, int64_t tick)
{
    int16_t since = (int16_t)((uint16_t)tick - ledger->step[seq & (LL_LEDGER_RING - 1)]);
    bool included = (*ll_ledger_fate(ledger, seq) & LL_LEDGER_IN_TIME) && since >= 0;
    ledger->applied += applied;
    ledger->skipped += !applied;
    ledger->wrong += applied && !included;
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
        ll_cause cause = blame(*ll_ledger_fate(ledger, seq));
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
