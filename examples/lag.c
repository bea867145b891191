/* Lag against what a player feels and sees, with liblaglab:
 *
 *   cc -o lag lag.c $(pkg-config --cflags --libs laglab)
 *   ./lag $(pkg-config --variable=scenarios laglab) */
#include <inttypes.h>
#include <laglab.h>
#include <stdio.h>

/* Runs the race to its end and prints a line of CSV. Returns 0, or 1 after an error. */
static int measure(const char *folder, int lag_ms, const char *prediction)
{
    char lag[40], predict[40];
    snprintf(lag, sizeof lag, "players.0.lag_ms=%d", lag_ms);
    snprintf(predict, sizeof predict, "players.0.prediction=%s", prediction);
    const char *const sets[] = {lag, predict, "duration_s=10", NULL};

    laglab_run *run;
    double latency_ms, error_m;
    int failed = laglab_open_named(folder, "race", sets, &run) != LAGLAB_OK ||
                 laglab_run_to(run, laglab_end_tick(run)) != LAGLAB_OK ||
                 laglab_metric(run, "players.0.input_latency_ms.mean", &latency_ms) != LAGLAB_OK ||
                 laglab_metric(run, "players.0.remote_error_m.mean", &error_m) != LAGLAB_OK;
    if (failed)
        fprintf(stderr, "%s\n", laglab_error(run));
    else
        printf("%d,%s,%.17g,%.17g,%016" PRIx64 "\n", lag_ms, prediction, latency_ms, error_m,
               laglab_hash(run));
    laglab_close(run);
    return failed;
}

int main(int argc, char **argv)
{
    static const int lags_ms[] = {0, 50, 100, 200};
    int failed = 0;
    if (argc != 2) {
        fprintf(stderr, "usage: lag FOLDER: the folder of scenarios\n");
        return 2;
    }
    puts("lag_ms,prediction,input_latency_ms,remote_error_m,hash");
    for (size_t i = 0; i < sizeof lags_ms / sizeof *lags_ms && !failed; i++)
        failed = measure(argv[1], lags_ms[i], "false") || measure(argv[1], lags_ms[i], "true");
    return failed;
}
