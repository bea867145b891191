/* A message on a link whose parameters may change from one to the next. */
#pragma once

#include "link/line/link.h"

static inline ll_sending link_send(ll_link *link, const ll_link_params *params, double lag_ms, ll_time now,
                                   const void *bytes, int size)
{
    const ll_link_plan plan = ll_link_plan_of(params, lag_ms);
    return ll_link_send_by(link, &plan, now, bytes, size);
}
