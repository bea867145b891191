/* Rows as bytes, little-endian: i64 run, u32 status, u32 bytes of the error, u64 hash, f64 t_s, an f64 for
 * each metric, the error. All bits are kept; every missing metric is the same NaN. */
#pragma once

#include <stdio.h>

#include "experiment/spec/experiment.h"

void ll_archive_put_row(FILE *file, const ll_row *row, int metrics);

/* `left`: bytes that the file has left for rows; reduced. LL_BAD_INPUT: they are no row. */
ll_status ll_archive_get_row(FILE *file, int metrics, int64_t *left, ll_row *row);

uint64_t ll_archive_bits(double value);
