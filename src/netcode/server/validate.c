#include "netcode/server/validate.h"

const char *const ll_rule_names[LL_RULES] = {"none", "magnitude", "rate", "budget", "fire_rate", "rewind"};

/* False for NaN too. */
static int within(float axis)
{
    return axis >= -1 && axis <= 1;
}

double ll_rate_burst(ll_freq client_freq)
{
    double burst = (double)client_freq / 1e3 * LL_RATE_BURST_S;
    return burst > LL_RATE_BURST ? burst : LL_RATE_BURST;
}

static double magnitude(float axis)
{
    return axis < 0 ? -(double)axis : (double)axis;
}

static double ticks_with(const ll_time_budget *account, const ll_action *action, ll_freq client_freq,
                         ll_time now)
{
    double left = account->ticks - (double)(now - account->at) * (double)client_freq / 1e12;
    double a = magnitude(action->axis[0]), b = magnitude(action->axis[1]), longest = a > b ? a : b;
    return (left > 0 ? left : 0) + (longest > 1 ? longest : 1);
}

double ll_time_use(const ll_time_budget *account, const ll_action *action, ll_freq client_freq, ll_time now)
{
    return ticks_with(account, action, client_freq, now) / ll_rate_burst(client_freq);
}

void ll_time_spend(ll_time_budget *account, const ll_action *action, ll_freq client_freq, ll_time now)
{
    account->ticks = ticks_with(account, action, client_freq, now);
    account->at = now;
}

ll_rule ll_validate(const ll_action *action, double budget_use, ll_rate_limiter *allowance,
                    ll_freq client_freq, ll_time now)
{
    if (!within(action->axis[0]) || !within(action->axis[1]))
        return LL_RULE_MAGNITUDE;
    if (budget_use > 1)
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
