/* `laglab merge`: from the rows of all shards of an experiment what `sweep` gives of its runs. */
#include <stdio.h>

#include "cli/arguments.h"
#include "cli/experiments/results.h"
#include "cli/input.h"
#include "cli/verbs.h"
#include "experiment/format/csv_rows.h"

static ll_status merge(const ll_results *results, const ll_experiment *e, const char *const *paths, int count)
{
    ll_csv_rows rows;
    ll_print_notices(ll_experiment_notices(e));
    ll_status status = ll_csv_rows_open(&rows, e);
    for (int i = 0; i < count && !ll_failed(&status); i++)
        status = ll_csv_rows_read(&rows, paths[i]);
    LL_THEN(status, ll_csv_rows_check_whole(&rows));
    LL_THEN(status, ll_results_write(results, e,
                                     &(ll_results_rows){.next = ll_csv_rows_next,
                                                        .seek = ll_csv_rows_seek,
                                                        .context = &rows,
                                                        .version = rows.version}));
    ll_csv_rows_close(&rows);
    return status;
}

int ll_verb_merge(int argc, char **argv)
{
    ll_results results = {0};
    ll_experiment *experiment = NULL;
    const char *scenarios = NULL, *positional[LL_POSITIONAL_MAX];
    const ll_option options[] = {LL_RESULTS_OPTIONS(&results),
                                 {"--scenarios", "DIR",
                                  "Folder of the scenario library; default: next to the program.",
                                  .value = &scenarios},
                                 {0}};
    int count;
    ll_status status =
        ll_arguments("merge EXPERIMENT SHARD.csv... [OPTION]...: put the rows of an experiment's shards "
                     "together; gives what sweep gives",
                     argc, argv, options, positional, &count);
    LL_THEN(status, ll_experiment_load(count ? positional[0] : NULL, scenarios, &experiment));
    LL_THEN(status, ll_results_check(&results, experiment, positional, count));
    LL_THEN(status, merge(&results, experiment, positional + 1, count - 1));
    ll_experiment_free(experiment);
    return ll_failed(&status) ? ll_argument_fail(&status) : 0;
}
