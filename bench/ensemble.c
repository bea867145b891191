/* How many steps a second an ensemble of oscillators makes: ensemble ROUNDS
 *
 * Prints CSV, a line per method: 1,024 members that differ in start and stiffness, in blocks of steps that
 * are timed by the process' CPU clock. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "ode/core/ensemble.h"

enum { MEMBERS = 1024, STEPS = 50000 };

static double cpu_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static double run(void (*advance)(const ll_ensemble *, double, int64_t))
{
    static double k[MEMBERS], x[MEMBERS], v[MEMBERS], a[MEMBERS];
    ll_ensemble e = {.count = MEMBERS, .k = k, .x = x, .v = v, .a = a};
    for (int i = 0; i < MEMBERS; i++) {
        k[i] = 1 + i / 1024.;
        x[i] = 1;
        v[i] = i / 1024.;
    }
    ll_ensemble_accelerate(&e);
    double begin = cpu_now();
    advance(&e, 0.01, STEPS);
    return cpu_now() - begin;
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        void (*advance)(const ll_ensemble *, double, int64_t);
    } methods[] = {{"semi_implicit_euler", ll_ensemble_semi_implicit_euler},
                   {"velocity_verlet", ll_ensemble_velocity_verlet}};
    int rounds = argc > 1 ? atoi(argv[1]) : 5;
    puts("method,round,members,steps,cpu_s");
    for (int round = 0; round < rounds; round++)
        for (int i = 0; i < 2; i++)
            printf("%s,%d,%d,%d,%.6g\n", methods[i].name, round, MEMBERS, STEPS, run(methods[i].advance));
    return 0;
}
