#include "ode/core/single.h"

#include <string.h>

void ll_single_clock_add(float *t, float *lost, float dt)
{
    float add = lost != NULL ? dt - *lost : dt, sum = *t + add;
    if (lost != NULL)
        *lost = (sum - *t) - add;
    *t = sum;
}

float ll_single_clock(float dt, int64_t ticks)
{
    float t = 0;
    for (int64_t i = 0; i < ticks; i++)
        ll_single_clock_add(&t, NULL, dt);
    return t;
}

float ll_single_clock_compensated(float dt, int64_t ticks)
{
    float t = 0, lost = 0;
    for (int64_t i = 0; i < ticks; i++)
        ll_single_clock_add(&t, &lost, dt);
    return t;
}

float ll_single_clock_stall(float dt)
{
    float t = 1;
    while (t + dt == t) /* at or below the first power of two that stops it */
        t /= 2;
    while (t + dt != t)
        t *= 2;
    return t;
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

double ll_single_least_speed(float x, double dt)
{
    return (double)ll_single_spacing(x) / 2 / dt;
}

double ll_single_fall(float origin, float dt, int64_t steps)
{
    float x = origin, v = 0;
    for (int64_t i = 0; i < steps; i++) {
        v += 10 * dt;
        x += v * dt;
    }
    return (double)x - (double)origin;
}

double ll_single_oscillator_energy(float origin, float dt, int64_t steps)
{
    const double turn = 6.283185307179586;
    float k = (float)(turn * turn), x = origin + 1, v = 0;
    for (int64_t i = 0; i < steps; i++) {
        v += -k * (x - origin) * dt / 2;
        x += v * dt;
        v += -k * (x - origin) * dt / 2;
    }
    double q = (double)(x - origin), p = (double)v;
    return q * q + p * p / (double)k;
}
