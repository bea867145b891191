#include "netcode/metrics/smoothness.h"

#include <stdbool.h>
#include <stddef.h>

#include "base/detmath.h"
#include "base/pair.h"

#define SIDE_BY_SIDE(first, second)                                                                          \
    _Static_assert(offsetof(ll_smoothness, second) == offsetof(ll_smoothness, first) + sizeof(double),       \
                   "a pair")

SIDE_BY_SIDE(acceleration, jerk);
SIDE_BY_SIDE(seconds, truth_step_sum);

/* Two numbers that lie side by side. */
static inline ll_pair pair_at(const double *first)
{
    return *(const ll_pair *)(const void *)first;
}

static inline void put_pair(double *first, ll_pair pair)
{
    *(ll_pair *)(void *)first = pair;
}

static inline double length(ll_pair a)
{
    return ll_sqrt(a[0] * a[0] + a[1] * a[1]);
}

/* |a|^2 and |b|^2 */
static inline ll_pair squares(ll_pair a, ll_pair b)
{
    a *= a;
    b *= b;
    return __builtin_shufflevector(a, b, 0, 2) + __builtin_shufflevector(a, b, 1, 3);
}

typedef struct lengths {
    double step, truth, off;
} lengths;

/* On a line, all y 0, each is exactly the root without one. */
static inline lengths lengths_of(ll_pair step, ll_pair truth, ll_pair off)
{
    const ll_pair a = ll_pair_fabs(step), b = ll_pair_fabs(truth), c = ll_pair_fabs(off);
    if ((a + b + c)[1] == 0)
        return (lengths){a[0], b[0], c[0]};
    return (lengths){step[1] == 0 ? a[0] : length(step), truth[1] == 0 ? b[0] : length(truth),
                     off[1] == 0 ? c[0] : length(off)};
}

static inline void count(ll_smoothness *s, ll_pair step, ll_pair acceleration, const lengths *far, double dt)
{
    const ll_pair jerk = (acceleration - pair_at(&s->ax)) / dt, along = step * pair_at(&s->step_x);
    put_pair(&s->acceleration, pair_at(&s->acceleration) + squares(acceleration, jerk));
    put_pair(&s->seconds, pair_at(&s->seconds) + (ll_pair){dt, far->truth});
    s->frames++;
    if (far->step > s->step_max)
        s->step_max = far->step;
    if (far->truth > 0) {
        s->moving++;
        if (far->step == 0)
            s->frozen++;
    }
    if (along[0] + along[1] < 0)
        s->reversals++;
}

/* A hitch is counted once, at its first frame above the limit. */
static inline void count_still(ll_smoothness *s, ll_pair step, double far, ll_pair truth, bool first)
{
    if (far > 0 || step[0] != 0 || step[1] != 0 || first) {
        put_pair(&s->moved_x, truth);
        s->still = 0;
        return;
    }
    s->still += truth[0] != s->moved_x || truth[1] != s->moved_y;
    s->hitches += s->still == LL_HITCH_FRAMES + 1;
    if (s->still > LL_HITCH_FRAMES)
        s->still = LL_HITCH_FRAMES + 2;
}

/* x and y at once. */
double ll_smoothness_add(ll_smoothness *s, const ll_entity *drawn, const double *truth, double dt)
{
    const ll_pair at = pair_at(&drawn->x), real = pair_at(truth);
    const ll_pair step = at - pair_at(&s->x), speed = step / dt;
    const ll_pair acceleration = (speed - pair_at(&s->vx)) / dt;
    const int64_t before = s->samples++;
    const lengths far = lengths_of(step, real - pair_at(&s->truth_x), step - pair_at(&drawn->vx) * dt);
    count_still(s, step, far.step, real, before == 0);
    if (before >= 3)
        count(s, step, acceleration, &far, dt);
    put_pair(&s->x, at);
    put_pair(&s->truth_x, real);
    put_pair(&s->step_x, step);
    put_pair(&s->vx, speed);
    put_pair(&s->ax, acceleration);
    return before == 0 ? -1 : far.off;
}
