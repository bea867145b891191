#include "base/detmath.h"
#include "game/games/games.h"

ll_drag ll_drag_over(double drag_per_s, double dt)
{
    double c = drag_per_s;
    double z = c * dt;
    ll_drag d;
    d.e = ll_exp(-z);
    if (z > 1) {
        d.f = (1 - d.e) / c;
        d.g = (dt - d.f) / c;
        return d;
    }
    /* The quotients lose digits as c goes to zero; their series in z do not. Twenty-two terms leave less than
     * 1 ulp up to z = 1. */
    double f = 0, g = 0;
    for (int n = 22; n >= 1; n--) {
        f = 1 - f * z / (n + 1);
        g = 1 - g * z / (n + 2);
    }
    d.f = dt * f;
    d.g = dt * dt / 2 * g;
    return d;
}
