#include "experiment/spec/shard.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"

enum { SHARDS_MAX = 1000000 };

/* Environment variables with a task's index and the number of tasks, by engine. */
static const struct engine {
    const char *name, *index, *count, *first, *step; /* `first` NULL: indices are 0, 1, 2 and so on */
    bool last;                                       /* `count` is the last index */
} engines[] = {
    {"Slurm", "SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MIN",
     "SLURM_ARRAY_TASK_STEP", false},
    {"Kubernetes", "JOB_COMPLETION_INDEX", "LAGLAB_SHARDS", NULL, NULL, false},
    {"AWS Batch", "AWS_BATCH_JOB_ARRAY_INDEX", "LAGLAB_SHARDS", NULL, NULL, false},
    {"SGE", "SGE_TASK_ID", "SGE_TASK_LAST", "SGE_TASK_FIRST", "SGE_TASK_STEPSIZE", true},
};

static bool whole(const char *text, int64_t *value)
{
    char *end;
    errno = 0;
    *value = text ? strtoll(text, &end, 10) : 0;
    return text && end != text && *end == '\0' && errno == 0;
}

ll_status ll_shard_from(const char *(*variable)(const char *name), int64_t *index, int64_t *count)
{
    for (size_t i = 0; i < sizeof engines / sizeof engines[0]; i++) {
        const struct engine *e = &engines[i];
        int64_t first = 0, step = 1;
        if (!whole(variable(e->index), index))
            continue;
        if (!whole(variable(e->count), count) || *count < 1)
            return ll_error(LL_BAD_INPUT, "%s: has %s but not the number of tasks; set %s", e->name, e->index,
                            e->count);
        if (e->first && !whole(variable(e->first), &first))
            first = 0;
        if (e->step && (!whole(variable(e->step), &step) || step < 1))
            step = 1;
        *index = (*index - first) / step + 1;
        if (e->last)
            *count = (*count - first) / step + 1;
        return ll_ok();
    }
    return ll_error(LL_BAD_INPUT,
                    "--shard auto: no array index found; SLURM_ARRAY_TASK_ID, JOB_COMPLETION_INDEX, "
                    "AWS_BATCH_JOB_ARRAY_INDEX or SGE_TASK_ID must be set");
}

static const char *environment(const char *name)
{
    return getenv(name);
}

ll_status ll_shard(const char *shard, int64_t runs, int64_t *from, int64_t *to)
{
    int64_t index = 1, count = 1;
    if (shard && strcmp(shard, "auto") == 0) {
        LL_TRY(ll_shard_from(environment, &index, &count));
    } else if (shard) {
        char first[32];
        const char *slash = strchr(shard, '/');
        snprintf(first, sizeof first, "%.*s", slash ? (int)(slash - shard) : 0, shard);
        if (!slash || !whole(first, &index) || !whole(slash + 1, &count))
            return ll_error(LL_BAD_INPUT, "--shard: must be I/N, such as 3/8, or auto; got %.60s", shard);
    }
    if (count < 1 || count > SHARDS_MAX || index < 1 || index > count)
        return ll_error(LL_BAD_INPUT, "--shard: must be 1/N to N/N, N at most 1000000; got %lld/%lld",
                        (long long)index, (long long)count);
    *from = runs * (index - 1) / count;
    *to = runs * index / count;
    LL_ASSERT(*from >= 0 && *from <= *to && *to <= runs); /* the shards' parts follow each other */
    return ll_ok();
}
