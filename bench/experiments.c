/* Bare runs of an experiment, one after the other, without a store: experiments RUNS SCENARIOS
 * <experiment.json
 *
 * What `laglab sweep` takes beyond this is what its store costs. Prints wall and CPU time of the runs as
 * JSON. */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "cli/input.h"

static double now(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static void check(ll_status status)
{
    if (ll_failed(&status)) {
        fprintf(stderr, "experiments: %s\n", status.text);
        exit(1);
    }
}

int main(int argc, char **argv)
{
    ll_experiment *experiment;
    int64_t runs = argc > 1 ? atoll(argv[1]) : 1;
    check(ll_experiment_load("-", argc > 2 ? argv[2] : NULL, &experiment));
    double wall = now(CLOCK_MONOTONIC), cpu = now(CLOCK_PROCESS_CPUTIME_ID);
    ll_kept_block kept = {0};
    for (int64_t run = 0; run < runs; run++) {
        ll_row row;
        check(ll_experiment_run(experiment, run % experiment->runs, NULL, &kept, &row));
    }
    printf("{\"wall_s\":%.6f,\"cpu_s\":%.6f}\n", now(CLOCK_MONOTONIC) - wall,
           now(CLOCK_PROCESS_CPUTIME_ID) - cpu);
    ll_kept_block_free(&kept);
    ll_experiment_free(experiment);
    return 0;
}
