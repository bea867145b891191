#include "fluid/core/rows.h"

/* A cell takes about 1 ns in the shortest job, the threads a microsecond to meet. */
enum { CELLS_LEAST = 4096 };

typedef struct shared_rows {
    ll_rows_job *job;
    void *context;
    int32_t count;
} shared_rows;

static void do_part(void *context, int part, int parts)
{
    const shared_rows *s = context;
    s->job(s->context, ll_share_of(s->count, part, parts), part);
}

int ll_rows_run(ll_team *team, int32_t count, int64_t width, ll_rows_job *job, void *context)
{
    if (ll_team_parts(team) == 1 || count * width < CELLS_LEAST) {
        job(context, (ll_share){0, count}, 0);
        return 1;
    }
    shared_rows s = {job, context, count};
    ll_team_run(team, count, 1, do_part, &s);
    return team->parts;
}
