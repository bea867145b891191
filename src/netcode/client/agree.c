/* Difference that rounding explains, per axis: half a grid step of the snapshot, plus half a grid step of the
 * snapshot that the prediction started from, plus half a velocity step times the predicted time. The last
 * part grows with time: a prediction that drifts without limit would be worse than the received snapshot, so
 * it stops at LL_DRIFT_MAX_S. A contact passes on a part of the others' error, in the race at most half. So
 * the own entity gets the same allowance once another entity may have touched it. */
#include "netcode/client/agree.h"

#include <string.h>

#include "base/detmath.h"

/* Difference that rounding alone can cause. */
typedef struct slack {
    double m, mps, rad, radps;
} slack;

static slack slack_of(const ll_agreement *a, int entity)
{
    const ll_quantization *then = &a->begun, *now = &a->state;
    double drift_s = a->drift_s < LL_DRIFT_MAX_S ? a->drift_s : LL_DRIFT_MAX_S;
    if (entity == a->exact)
        return (slack){0};
    return (slack){
        .m = ((double)then->m + (double)now->m + (double)then->mps * drift_s) / 2,
        .mps = ((double)then->mps + (double)now->mps) / 2,
        .rad = ((double)then->rad + (double)now->rad + (double)then->radps * drift_s) / 2,
        .radps = ((double)then->radps + (double)now->radps) / 2,
    };
}

/* NaN stays NaN. */
static double excess(double a, double b, double free)
{
    double d = a > b ? a - b : b - a;
    return d <= free ? 0 : d - free;
}

static double length(double x, double y)
{
    return ll_sqrt(x * x + y * y);
}

static bool entity_agrees(const ll_agreement *a, int i, const ll_entity *p, const ll_entity *q)
{
    slack s = slack_of(a, i);
    if (p->flags != q->flags)
        return false;
    double place = length(excess(p->x, q->x, s.m), excess(p->y, q->y, s.m));
    double velocity = length(excess(p->vx, q->vx, s.mps), excess(p->vy, q->vy, s.mps));
    double angle = excess(p->angle, q->angle, s.rad),
           spin = excess(p->angular_velocity, q->angular_velocity, s.radps);
    return place + a->horizon_s * velocity <= a->tolerance_m && angle + a->horizon_s * spin <= a->tolerance_m;
}

static bool same(const ll_entity *a, const ll_entity *b)
{
    return memcmp(a, b, sizeof *a) == 0;
}

bool ll_same_in(const ll_world *a, const ll_world *b, const ll_entity_set *set)
{
    const int end = ll_set_end(a);
    for (int i = ll_entity_set_next(set, 0, end); i < end; i = ll_entity_set_next(set, i + 1, end))
        if (!same(&a->entity[i], &b->entity[i]))
            return false;
    return true;
}

bool ll_agrees_in(const ll_agreement *agreement, const ll_world *predicted, const ll_world *state,
                  const ll_entity_set *set)
{
    const int end = ll_set_end(state);
    for (int i = ll_entity_set_next(set, 0, end); i < end; i = ll_entity_set_next(set, i + 1, end)) {
        const ll_entity *p = &predicted->entity[i], *q = &state->entity[i];
        bool exact = agreement->tolerance_m == 0 &&
                     (i == agreement->exact || (agreement->begun.m == 0 && agreement->state.m == 0));
        if (!same(p, q) && (exact || !entity_agrees(agreement, i, p, q)))
            return false;
    }
    return true;
}
