/* Loops over rows of cells, or over any other numbered parts, that a team of threads shares.
 *
 * A row is done whole by one thread. A job's rows write to different memory and read nothing that another of
 * its rows writes, so that the bits are the same for any number of threads. */
#pragma once

#include "base/interrupt.h"
#include "base/team.h"

/* How a step is computed: changes no bit of its result. */
typedef struct ll_fluid_run {
    ll_pace *pace; /* may break the step off; NULL: nothing does */
    ll_team *team; /* NULL: one thread */
} ll_fluid_run;

/* Does the rows `rows.begin` to `rows.end` - 1; `part`: its number among those that run at the same time. */
typedef void ll_rows_job(void *context, ll_share rows, int part);

/* Does rows 0 to `count` - 1 of `width` cells each; alone when they are so few that threads would need longer
 * to meet than to compute. Returns the number of parts. */
int ll_rows_run(ll_team *team, int32_t count, int64_t width, ll_rows_job *job, void *context);

/* The largest of what parts found: at most LL_TEAM_PARTS_MAX values from 0. A value that is not a number does
 * not count, so that the order does not matter. */
static inline double ll_rows_larger(double most, double value)
{
    return value > most ? value : most;
}

static inline double ll_rows_largest(const double *of_part, int parts)
{
    double most = 0;
    for (int i = 0; i < parts; i++)
        most = ll_rows_larger(most, of_part[i]);
    return most;
}
