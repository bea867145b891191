/* A team of threads that do a job in parts at the same time, and meet at its end.
 *
 * The pure rooms know this interface only; src/threads/team.h makes a team. A result must not depend on the
 * number of parts: the parts of a job write to different memory, and what depends on an order is done after
 * the job. */
#pragma once

#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { LL_TEAM_PARTS_MAX = 16 };

typedef void ll_team_job(void *context, int part, int parts);

typedef struct ll_team ll_team;
struct ll_team {
    int parts; /* threads, the caller's included: 1 to LL_TEAM_PARTS_MAX */
    /* Calls the job once for each part, one of them on the caller's thread, and returns when all have
     * returned. */
    void (*run)(ll_team *team, ll_team_job *job, void *context);
};

/* The indices that a part of a job does: from `begin`, and before `end`. */
typedef struct ll_share {
    int32_t begin, end;
} ll_share;

static inline ll_share ll_share_of(int32_t count, int part, int parts)
{
    return (ll_share){(int32_t)((int64_t)count * part / parts),
                      (int32_t)((int64_t)count * (part + 1) / parts)};
}

static inline int ll_team_parts(const ll_team *team)
{
    return team == NULL ? 1 : team->parts;
}

/* The parts that `count` elements are done in: one without a team, and when there are fewer than `least`,
 * which the caller chooses so that a part takes longer than the threads need to meet, about a microsecond. */
static inline int ll_team_parts_of(const ll_team *team, int32_t count, int32_t least)
{
    return team == NULL || count < least ? 1 : team->parts;
}

/* Runs a job over `count` elements in these parts. */
static inline void ll_team_run(ll_team *team, int32_t count, int32_t least, ll_team_job *job, void *context)
{
    if (ll_team_parts_of(team, count, least) == 1)
        job(context, 0, 1);
    else
        team->run(team, job, context);
}

/* Joins the lists of a job's parts: each has written its elements to `at` from the beginning of its share on,
 * and `wrote` has from where to where; a part that did not run has zeros. Returns the count of all. */
static inline int32_t ll_team_join(const ll_share wrote[LL_TEAM_PARTS_MAX], void *at, size_t size)
{
    int32_t count = wrote[0].end;
    for (int k = 1; k < LL_TEAM_PARTS_MAX; k++) {
        int32_t more = wrote[k].end - wrote[k].begin;
        memmove((char *)at + (size_t)count * size, (char *)at + (size_t)wrote[k].begin * size,
                (size_t)more * size);
        count += more;
    }
    return count;
}
