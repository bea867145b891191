#include "netcode/validate.h"

const char *const ll_rule_names[LL_RULES] = {"none", "magnitude", "rate", "budget", "fire_rate", "rewind"};

/* Written so that a NaN fails too. */
static int within(float axis)
{
    return axis >= -1 && axis <= 1;
}

double ll_rate_burst(ll_freq client_freq)
{
    double burst = (double)client_freq / 1e3 * LL_RATE_BURST_S;
    return burst > LL_RATE_BURST ? burst : LL_RATE_BURST;
}

ll_rule ll_validate(const ll_action *action, int64_t ticks_ahead, ll_allowance *allowance,
                    ll_freq client_freq, ll_time now)
{
    if (!within(action->axis[0]) || !within(action->axis[1]))
        return LL_RULE_MAGNITUDE;
    if (ticks_ahead >= LL_BUDGET_TICKS)
        return LL_RULE_BUDGET;
    double per_ns = (double)client_freq / 1e12 * LL_RATE_FACTOR;
    allowance->tokens += (double)(now - allowance->filled) * per_ns;
    allowance->filled = now;
    double burst = ll_rate_burst(client_freq);
    if (allowance->tokens > burst)
        allowance->tokens = burst;
    if (allowance->tokens < 1)
        return LL_RULE_RATE;
    allowance->tokens -= 1;
    return LL_RULE_NONE;
}
