/* A head, the states of all directions, then the profiles one after the other. */
#include "link/line/profile_shelf.h"

#include "base/assert.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

struct ll_profile_shelf {
    int64_t at[LL_PROFILES_MAX]; /* of a profile, from the start of the shelf; 0: there is none */
    int64_t ways;
    int64_t bottleneck; /* the queues up and down, likewise */
};

#pragma GCC diagnostic pop

static ll_profile_state *state_of(const ll_profile_shelf *s, int way)
{
    return (ll_profile_state *)(s + 1) + way;
}

static ll_link_profile *profile_of(const ll_profile_shelf *s, int number)
{
    return (ll_link_profile *)((char *)s + s->at[number]);
}

static ll_bottleneck *queue_of(const ll_profile_shelf *s, int way)
{
    return (ll_bottleneck *)((char *)s + s->bottleneck) + way % 2;
}

static bool shares(const ll_shelf_setup *setup)
{
    return setup->bottleneck->rate_kbps > 0;
}

size_t ll_profile_shelf_size(const ll_shelf_setup *setup)
{
    size_t bytes = sizeof(ll_profile_shelf) + (size_t)setup->ways * sizeof(ll_profile_state);
    for (int i = 0; i < setup->count; i++)
        bytes += ll_profile_size(&setup->profiles[i]);
    bytes += shares(setup) ? 2 * sizeof(ll_bottleneck) : 0;
    return setup->count > 0 || shares(setup) ? bytes : 0;
}

#define FIRST_STREAM (UINT64_C(1) << 32) /* beyond those of links */

void ll_profile_shelf_init(ll_profile_shelf *s, const ll_shelf_setup *setup)
{
    size_t end = sizeof *s + (size_t)setup->ways * sizeof(ll_profile_state);
    *s = (ll_profile_shelf){.ways = setup->ways};
    for (int i = 0; i < setup->ways; i++)
        ll_profile_state_init(state_of(s, i));
    for (int i = 0; i < setup->count; i++) {
        s->at[i] = (int64_t)end;
        ll_profile_init(profile_of(s, i), &setup->profiles[i]);
        end += ll_profile_size(&setup->profiles[i]);
    }
    s->bottleneck = shares(setup) ? (int64_t)end : 0;
    for (int way = 0; s->bottleneck > 0 && way < 2; way++)
        ll_bottleneck_init(queue_of(s, way), setup->bottleneck, setup->seed,
                           FIRST_STREAM + 2 * (uint64_t)way);
}

void ll_profile_shelf_restart_stats(ll_profile_shelf *s)
{
    for (int i = 0; i < s->ways; i++)
        state_of(s, i)->marked = state_of(s, i)->trace_lost = 0;
}

ll_link_plan ll_profile_shelf_plan(ll_profile_shelf *s, int way, const ll_link_params *params, double lag_ms)
{
    if (!s)
        return ll_link_plan_of(params, lag_ms);
    const int number = params->profile - 1;
    LL_ASSERT(way < s->ways && (number < 0 || s->at[number] > 0));
    ll_link_plan plan = number < 0
                            ? ll_link_plan_of(params, lag_ms)
                            : ll_link_plan_with(params, lag_ms, profile_of(s, number), state_of(s, way));
    if (s->bottleneck > 0)
        ll_link_plan_share(&plan, queue_of(s, way), state_of(s, way));
    return plan;
}

const ll_profile_state *ll_profile_shelf_state(const ll_profile_shelf *s, int way)
{
    return state_of(s, way);
}
