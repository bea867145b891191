/* Shards: an experiment over machines that share nothing. Each takes a part of the runs and writes rows; the
 * parts are merged. */
#pragma once

#include "base/status.h"

#include <stdint.h>

/* `I/N` (I from 1), `auto` (the array index that Slurm, Kubernetes, SGE or AWS Batch gave this process), or
 * NULL for all: the runs from..to-1 of that part. */
ll_status ll_shard(const char *shard, int64_t runs, int64_t *from, int64_t *to);

/* What `auto` finds with these variables of the environment. */
ll_status ll_shard_from(const char *(*variable)(const char *name), int64_t *index, int64_t *count);
