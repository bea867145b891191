#include "threads/team.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>

#include "base/assert.h"

/* Polls before a thread sleeps (a helper) or lets others run (the caller). */
enum { POLLS = 4096 };

typedef struct helper {
    _Alignas(64) atomic_uint done; /* turns that it has finished: a cache line that the caller polls */
    struct crew *crew;
    pthread_t thread;
    int part;
} helper;

typedef struct crew {
    ll_team team; /* the first member */
    /* A job goes to another core as one cache line, and comes back as one: each costs 0.1 to 0.2 us, a job
     * some. */
    _Alignas(64) atomic_uint turn; /* counts the jobs; the last one ends the threads */
    bool ended;
    ll_team_job *job;
    void *context;
    _Alignas(64) atomic_int asleep;
    pthread_mutex_t lock; /* of sleeping only */
    pthread_cond_t wake;
    int helpers; /* threads that were started */
    helper helper[LL_TEAM_PARTS_MAX];
} crew;

static inline void pause_briefly(void)
{
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
}

/* The number of asleep helpers is raised before the turn is read again, and the turn before their number is
 * read: one of the two sees the other. */
static void sleep_until_next(crew *c, unsigned seen)
{
    pthread_mutex_lock(&c->lock);
    atomic_fetch_add(&c->asleep, 1);
    while (atomic_load(&c->turn) == seen)
        pthread_cond_wait(&c->wake, &c->lock);
    atomic_fetch_sub(&c->asleep, 1);
    pthread_mutex_unlock(&c->lock);
}

static void next_turn(crew *c)
{
    atomic_fetch_add(&c->turn, 1);
    if (atomic_load(&c->asleep) == 0)
        return;
    pthread_mutex_lock(&c->lock);
    pthread_cond_broadcast(&c->wake);
    pthread_mutex_unlock(&c->lock);
}

static void *help(void *argument)
{
    helper *h = argument;
    crew *c = h->crew;
    for (unsigned seen = 0;; seen++) {
        for (int i = 0; i < POLLS && atomic_load_explicit(&c->turn, memory_order_acquire) == seen; i++)
            pause_briefly();
        if (atomic_load(&c->turn) == seen)
            sleep_until_next(c, seen);
        if (c->ended)
            return NULL;
        c->job(c->context, h->part, c->team.parts);
        atomic_store_explicit(&h->done, seen + 1, memory_order_release);
    }
}

static void wait_for(helper *h, unsigned turn)
{
    for (int i = 0; atomic_load_explicit(&h->done, memory_order_acquire) != turn; i++)
        if (i < POLLS)
            pause_briefly();
        else
            sched_yield(); /* the helper has lost its processor */
}

static void run(ll_team *team, ll_team_job *job, void *context)
{
    crew *c = (crew *)team;
    c->job = job;
    c->context = context;
    next_turn(c);
    unsigned turn = atomic_load_explicit(&c->turn, memory_order_relaxed);
    job(context, 0, team->parts);
    for (int k = 0; k < c->helpers; k++)
        wait_for(&c->helper[k], turn);
    LL_ASSERT(atomic_load_explicit(&c->turn, memory_order_relaxed) ==
              turn); /* one job at a time, from one thread */
}

ll_status ll_team_make(int parts, ll_team **out)
{
    *out = NULL;
    if (parts < 1 || parts > LL_TEAM_PARTS_MAX)
        return ll_field_error(LL_BAD_INPUT, "threads", "threads: must be 1 to %d; got %d.", LL_TEAM_PARTS_MAX,
                              parts);
    crew *c = aligned_alloc(64, (sizeof *c + 63) & ~(size_t)63);
    if (c == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory: threads");
    *c = (crew){.team = {.parts = parts, .run = run}};
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->wake, NULL);
    for (; c->helpers < parts - 1; c->helpers++) {
        helper *h = &c->helper[c->helpers];
        h->crew = c;
        h->part = c->helpers + 1;
        if (pthread_create(&h->thread, NULL, help, h) != 0) {
            ll_team_free(&c->team);
            return ll_error(LL_NO_MEMORY, "threads: cannot start %d.", parts);
        }
    }
    *out = &c->team;
    return ll_ok();
}

void ll_team_free(ll_team *team)
{
    crew *c = (crew *)team;
    if (c == NULL)
        return;
    c->ended = true;
    next_turn(c);
    for (int i = 0; i < c->helpers; i++)
        pthread_join(c->helper[i].thread, NULL);
    pthread_mutex_destroy(&c->lock);
    pthread_cond_destroy(&c->wake);
    free(c);
}
