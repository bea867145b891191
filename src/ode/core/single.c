#include "ode/core/single.h"

#include <stdint.h>
#include <string.h>

void ll_single_clock_add(float *t, float *lost, float dt)
{
    float add = lost != NULL ? dt - *lost : dt, sum = *t + add;
    if (lost != NULL)
        *lost = (sum - *t) - add;
    *t = sum;
}

float ll_single_spacing(float x)
{
    uint32_t bits;
    float size = x < 0 ? -x : x, next;
    memcpy(&bits, &size, sizeof bits);
    bits++;
    memcpy(&next, &bits, sizeof next);
    return next - size;
}
