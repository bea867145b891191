#include "ode/core/paper.h"

#include <stdio.h>

int ll_ode_listing_next(ll_ode_listing *l, double duration, char *line, size_t size)
{
    if (!((double)l->t <= duration))
        return 0;
    snprintf(line, size, "t = %f, velocity = %f, displacement = %f\n", (double)l->t, (double)l->velocity,
             (double)l->displacement);
    l->velocity = l->velocity + l->acceleration * l->dt;
    l->displacement = l->displacement + l->velocity * l->dt;
    l->t += l->dt;
    return 1;
}
