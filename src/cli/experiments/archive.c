/* `laglab export` and `laglab verify`: an experiment as one file, and whether another machine gets the same.
 */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>

#include "cli/arguments.h"
#include "cli/output.h"
#include "cli/verbs.h"
#include "experiment/archive/archive.h"

/* ---- export ---- */

typedef struct only {
    char id[LL_EXPERIMENT_ID_MAX + 1];
    int count;
} only;

static void note(void *context, const ll_experiment_record *record)
{
    only *o = context;
    snprintf(o->id, sizeof o->id, "%s", record->id);
    o->count++;
}

/* `id`, or that of the only experiment of the store. */
static ll_status find_id(ll_result_store *store, const char *id, only *found)
{
    if (id) {
        snprintf(found->id, sizeof found->id, "%s", id);
        return ll_ok();
    }
    LL_TRY(store->kind->list(store, note, found));
    if (found->count == 1)
        return ll_ok();
    return ll_error(
        LL_BAD_INPUT,
        "--experiment: required, since the store has %d experiments; laglab store list shows them",
        found->count);
}

int ll_verb_export(int argc, char **argv)
{
    const char *archive = NULL, *url = NULL, *id = NULL, *container = NULL;
    const ll_option options[] = {
        {"--store", "URL", "sqlite:FILE or postgresql://USER@HOST/DATABASE; default: $LAGLAB_STORE.",
         .value = &url},
        {"--experiment", "ID", "The experiment, as laglab store list shows it; default: the only one.",
         .value = &id},
        {"--container", "sha256:DIGEST", "Digest of the container image that made the rows.",
         .value = &container},
        {0}};
    ll_result_store *store = NULL;
    only found = {.count = 0};
    ll_status status = ll_arguments_one("export ARCHIVE.tar [OPTION]...: write an experiment of a store, "
                                        "with its specification, rows, report and "
                                        "digests, as one file that another machine verifies",
                                        argc, argv, options, &archive);
    url = ll_result_store_url(url);
    if (!ll_failed(&status) && !archive)
        status = ll_error(LL_BAD_INPUT, "export: needs the name of the archive");
    if (!ll_failed(&status) && !url)
        status = ll_error(LL_BAD_INPUT, "--store: required, or set LAGLAB_STORE");
    if (!ll_failed(&status) && container)
        status = ll_archive_container("--container", container);
    LL_THEN(status, ll_result_store_open(url, &store));
    LL_THEN(status, find_id(store, id, &found));
    LL_THEN(status, ll_archive_write(store, found.id, container, archive));
    ll_result_store_close(store);
    return ll_failed(&status) ? ll_argument_fail(&status) : 0;
}

/* ---- verify ---- */

static void print_difference(void *context, const char *difference)
{
    (void)context;
    fprintf(stderr, "laglab: %s\n", difference);
}

static void print_answer(const ll_archive_check *check, const ll_archive_result *r)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "made_by", r->version);
    cJSON_AddStringToObject(o, "version", ll_version);
    cJSON_AddItemToObject(o, "container",
                          r->container[0] ? cJSON_CreateString(r->container) : cJSON_CreateNull());
    cJSON_AddNumberToObject(o, "rows", (double)r->rows);
    cJSON_AddNumberToObject(o, "compared", (double)r->compared);
    cJSON_AddNumberToObject(o, "equal", (double)r->equal);
    cJSON_AddNumberToObject(o, "skipped", (double)r->skipped);
    cJSON_AddNumberToObject(o, "measured_metrics", (double)r->measured);
    cJSON_AddNumberToObject(o, "seed", (double)check->seed);
    cJSON_AddBoolToObject(o, "report_compared", r->report_compared);
    cJSON_AddNumberToObject(o, "differences", r->differences);
    ll_print_json(o);
}

/* Another choice each time: who changes an archive must not know it. */
static uint64_t random_seed(void)
{
    uint32_t seed = 0;
    return getrandom(&seed, sizeof seed, 0) == (ssize_t)sizeof seed ? seed : 0;
}

int ll_verb_verify(int argc, char **argv)
{
    const char *archive = NULL, *rows = NULL, *seed = NULL;
    bool all = false, any_version = false;
    const ll_option options[] = {
        {"--rows", "N", "How many rows to run again, chosen at random. Default: 20.", .value = &rows},
        {"--all", .help = "Run all rows again.", .flag = &all},
        {"--seed", "N", "Seed of the choice, as the answer names it; default: another each time.",
         .value = &seed},
        {"--any-version", .help = "An archive of another version of laglab is no difference by itself.",
         .flag = &any_version},
        {0}};
    int64_t wanted = 20, chosen = 0;
    ll_archive_result result;
    ll_status status = ll_arguments_one("verify ARCHIVE.tar [OPTION]...: check the digests and the version "
                                        "of an archive, and run rows again; exit 1 "
                                        "where something differs, 2 where the archive is damaged",
                                        argc, argv, options, &archive);
    if (!ll_failed(&status) && !archive)
        status = ll_error(LL_BAD_INPUT, "verify: needs an archive");
    if (!ll_failed(&status) && rows)
        status = ll_argument_whole("--rows", rows, 1, LL_EXPERIMENT_RUNS_MAX, &wanted);
    if (!ll_failed(&status) && seed)
        status = ll_argument_whole("--seed", seed, 0, UINT32_MAX, &chosen);
    if (!ll_failed(&status) && all && rows)
        status = ll_error(LL_BAD_INPUT, "--all, --rows: must not be given together");
    ll_archive_check check = {.rows = all ? 0 : wanted,
                              .seed = seed ? (uint64_t)chosen : random_seed(),
                              .any_version = any_version,
                              .tell = print_difference};
    LL_THEN(status, ll_archive_verify(archive, &check, &result));
    if (ll_failed(&status))
        return ll_argument_fail(&status);
    print_answer(&check, &result);
    return result.differences > 0;
}
