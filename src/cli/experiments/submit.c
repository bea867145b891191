/* `laglab submit`: puts an experiment into a store and starts workers on a cluster. The cluster's engine only
 * starts processes; the store distributes the runs, each once. */
#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cli/arguments.h"
#include "cli/input.h"
#include "cli/verbs.h"
#include "experiment/run/work.h"

enum { WORKERS_MAX = 100000 };

typedef struct job {
    char program[PATH_MAX];
    const char *store_url; /* NULL: tasks have it in their environment, which Slurm passes on */
    char id[LL_EXPERIMENT_ID_MAX + 1];
    int64_t workers, threads, lease_s;
} job;

/* ---- engines ---- */

/* Quotes a word for the shell. */
static void write_word(FILE *file, const char *word)
{
    fputc('\'', file);
    for (; *word; word++)
        fputs(*word == '\'' ? "'\\''" : (char[]){*word, '\0'}, file);
    fputc('\'', file);
}

/* A job array, whose tasks start one by one when nodes are free, and not an allocation, which waits for all
 * nodes. */
static void write_slurm(FILE *file, const job *j)
{
    fprintf(file, "#!/bin/sh\n#SBATCH --job-name=laglab\n#SBATCH --array=1-%" PRId64 "\n", j->workers);
    fprintf(file, "#SBATCH --ntasks=1\n#SBATCH --cpus-per-task=%" PRId64 "\n#SBATCH --requeue\n", j->threads);
    fputs("exec ", file);
    write_word(file, j->program);
    fputs(" worker", file);
    if (j->store_url) {
        fputs(" --store ", file);
        write_word(file, j->store_url);
    }
    fprintf(file, " --experiment %s --drain --jobs %" PRId64, j->id, j->threads);
    if (j->lease_s > 0)
        fprintf(file, " --lease-s %" PRId64, j->lease_s);
    fputc('\n', file);
}

typedef struct engine {
    const char *name;
    const char *command; /* reads the script from standard input */
    void (*write)(FILE *file, const job *j);
} engine;

static const engine engines[] = {
    {"slurm", "sbatch", write_slurm},
};

static ll_status find_engine(const char *name, const engine **found)
{
    char known[80] = "";
    for (size_t i = 0; i < sizeof engines / sizeof engines[0]; i++) {
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", i ? ", " : "", engines[i].name);
        if (name && strcmp(name, engines[i].name) == 0) {
            *found = &engines[i];
            return ll_ok();
        }
    }
    return ll_error(LL_BAD_INPUT, "--engine: must be one of %s; got %.40s", known, name ? name : "none");
}

static ll_status submit_job(const engine *e, const job *j)
{
    fflush(stdout);
    FILE *pipe = popen(e->command, "w");
    if (!pipe)
        return ll_error(LL_IO, "cannot start %s: %s", e->command, strerror(errno));
    e->write(pipe, j);
    int how = pclose(pipe);
    if (WIFEXITED(how) && WEXITSTATUS(how) == 0)
        return ll_ok();
    return ll_error(LL_IO, "%s rejected the job (exit status %d); --print shows the script", e->command,
                    WIFEXITED(how) ? WEXITSTATUS(how) : -1);
}

/* ---- the verb ---- */

typedef struct submit {
    const char *engine_name, *workers, *jobs, *lease, *scenarios, *experiment;
    bool print, anew;
    const engine *engine;
    job job;
} submit;

static ll_status parse(submit *s, int argc, char **argv)
{
    const ll_option options[] = {
        {"--engine", "NAME", "Engine that starts the workers: slurm.", .value = &s->engine_name},
        {"-n", "N", "Workers; default: 1.", .value = &s->workers},
        {"--jobs", "N", "Threads, and cores, of each worker; default: 1.", .value = &s->jobs},
        {"--lease-s", "N", "Passed to the workers.", .value = &s->lease},
        {"--store", "URL",
         "Store that workers on all machines can reach: postgresql://USER@HOST/DATABASE; default: "
         "$LAGLAB_STORE, which is not in the script.",
         .value = &s->job.store_url},
        {"--scenarios", "DIR", "Folder of the scenario library; default: next to the program.",
         .value = &s->scenarios},
        {"--anew", .help = "Also if another version of laglab has started it.", .flag = &s->anew},
        {"--print",
         .help = "Print the script and do not submit it. The experiment is put into the store in any case.",
         .flag = &s->print},
        {0}};
    const char *positional[LL_POSITIONAL_MAX];
    int count;
    s->job.workers = s->job.threads = 1;
    ll_status status = ll_arguments("submit EXPERIMENT --engine NAME [OPTION]...: start workers on a cluster",
                                    argc, argv, options, positional, &count);
    if (!ll_failed(&status) && count > 1)
        status = ll_error(LL_BAD_INPUT, "unexpected argument %.100s", positional[1]);
    LL_THEN(status, find_engine(s->engine_name, &s->engine));
    if (!ll_failed(&status) && !ll_result_store_url(s->job.store_url))
        status = ll_error(LL_BAD_INPUT,
                          "--store: required, or set LAGLAB_STORE; workers on other machines must reach it");
    if (!ll_failed(&status) && s->workers)
        status = ll_argument_whole("-n", s->workers, 1, WORKERS_MAX, &s->job.workers);
    if (!ll_failed(&status) && s->jobs)
        status = ll_argument_whole("--jobs", s->jobs, 1, 256, &s->job.threads);
    if (!ll_failed(&status) && s->lease)
        status = ll_argument_whole("--lease-s", s->lease, 1, LL_LEASE_MAX_S, &s->job.lease_s);
    s->experiment = count > 0 ? positional[0] : NULL;
    return status;
}

static ll_status find_program(char path[PATH_MAX])
{
    ssize_t length = readlink("/proc/self/exe", path, PATH_MAX - 1);
    if (length < 0)
        return ll_error(LL_IO, "cannot find the path of this program: %s", strerror(errno));
    path[length] = '\0';
    return ll_ok();
}

static ll_status put_into_store(submit *s)
{
    ll_experiment *experiment = NULL;
    ll_result_store *store = NULL;
    double run_s;
    ll_status status = ll_experiment_load(s->experiment, s->scenarios, &experiment);
    LL_THEN(status, ll_result_store_open(ll_result_store_url(s->job.store_url), &store));
    if (!ll_failed(&status) && !s->anew)
        status = ll_experiment_check_version(store, experiment, 0, experiment->runs);
    LL_THEN(status, ll_experiment_time(experiment, 0, &run_s));
    LL_THEN(status, ll_experiment_register(store, experiment, 0, experiment->runs, run_s, s->job.id));
    ll_result_store_close(store);
    ll_experiment_free(experiment);
    return status;
}

int ll_verb_submit(int argc, char **argv)
{
    submit s = {0};
    ll_status status = parse(&s, argc, argv);
    LL_THEN(status, find_program(s.job.program));
    LL_THEN(status, put_into_store(&s));
    if (!ll_failed(&status) && s.print)
        s.engine->write(stdout, &s.job);
    else if (!ll_failed(&status))
        status = submit_job(s.engine, &s.job);
    return ll_failed(&status) ? ll_argument_fail(&status) : 0;
}
