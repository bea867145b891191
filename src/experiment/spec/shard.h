/* Shards: an experiment on machines that share nothing. Each machine runs a part of the runs and writes rows,
 * which are merged later. */
#pragma once

#include "base/status.h"

#include <stdint.h>

/* Parses `I/N` (I from 1) or `auto` (the array index that Slurm, Kubernetes, SGE or AWS Batch gave this
 * process); NULL: all. The result are the runs from..to-1. */
ll_status ll_shard(const char *shard, int64_t runs, int64_t *from, int64_t *to);

/* The index of `auto` by these environment variables. */
ll_status ll_shard_from(const char *(*variable)(const char *name), int64_t *index, int64_t *count);
