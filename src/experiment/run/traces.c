#include "experiment/run/traces.h"

#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { THREADS_MAX = 256 };

typedef struct traces {
    const ll_experiment *experiment;
    const char *folder;
    _Atomic int64_t next;
    int64_t to;
    pthread_mutex_t lock; /* guards the first error */
    ll_status error;
} traces;

static void put(void *file, const char *text, size_t length)
{
    fwrite(text, 1, length, file);
}

static ll_status write_one(const traces *t, int64_t run)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/run%lld.csv", t->folder, (long long)run);
    FILE *file = fopen(path, "wb");
    if (!file)
        return ll_error(LL_IO, "cannot write %.200s: %s", path, strerror(errno));
    ll_status status = ll_experiment_trace(t->experiment, run, NULL, put, file);
    bool bad = ferror(file) != 0;
    bad |= fclose(file) != 0;
    if (ll_failed(&status))
        unlink(path);
    if (status.code == LL_BAD_INPUT) /* a refused run has a row with the reason, and no trace */
        return ll_ok();
    return !ll_failed(&status) && bad ? ll_error(LL_IO, "cannot write %.200s", path) : status;
}

static void *work(void *context)
{
    traces *t = context;
    int64_t run;
    while ((run = atomic_fetch_add(&t->next, 1)) < t->to) {
        ll_status status = write_one(t, run);
        if (!ll_failed(&status))
            continue;
        atomic_store(&t->next, t->to);
        pthread_mutex_lock(&t->lock);
        if (!ll_failed(&t->error))
            t->error = status;
        pthread_mutex_unlock(&t->lock);
    }
    return NULL;
}

ll_status ll_traces_write(const ll_experiment *experiment, int64_t from, int64_t to, const char *folder,
                          int threads)
{
    traces t = {.experiment = experiment, .folder = folder, .next = from, .to = to, .error = ll_ok()};
    pthread_t others[THREADS_MAX];
    int started = 0;
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return ll_error(LL_IO, "cannot create folder %.200s: %s", folder, strerror(errno));
    pthread_mutex_init(&t.lock, NULL);
    while (started < threads - 1 && started < THREADS_MAX &&
           pthread_create(&others[started], NULL, work, &t) == 0)
        started++;
    work(&t);
    while (started > 0)
        pthread_join(others[--started], NULL);
    pthread_mutex_destroy(&t.lock);
    return t.error;
}
