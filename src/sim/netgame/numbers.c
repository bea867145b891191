/* Numbers of the metrics: null where nothing was counted. */
#include <math.h>

#include "sim/netgame/netgame.h"

double ll_netgame_ratio(double part, double whole)
{
    return whole != 0 ? part / whole : NAN;
}

double ll_netgame_measured_s(const ll_netgame *g, const ll_client_metrics *in)
{
    return g->now > in->from ? ll_to_s(g->now - in->from) : 0;
}

ll_metric_reading ll_netgame_latency(ll_summary s, int64_t lost)
{
    return (ll_metric_reading){.parts = {s.mean, s.rms, s.p50, s.p95, s.p99, s.max, (double)s.count,
                                         ll_netgame_ratio((double)lost, (double)s.count)}};
}

ll_metric_reading ll_netgame_distribution(ll_summary summary)
{
    return ll_netgame_latency(summary, 0);
}

ll_metric_reading ll_netgame_gauge(const ll_running_stats *g, double scale)
{
    return (ll_metric_reading){.parts = {scale * ll_netgame_ratio(g->sum, (double)g->count),
                                         g->count > 0 ? scale * g->min : NAN,
                                         g->count > 0 ? scale * g->max : NAN, (double)g->count}};
}
