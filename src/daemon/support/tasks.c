#include "daemon/support/tasks.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "base/assert.h"
#include "threads/clock.h"

enum {
    SLICE_NS = 10000000,   /* of processor time: on a busy machine turns are as fair as on an idle one */
    OVERDUE_NS = 50000000, /* after that processor time without a yield a task loses its turn */
    STUCK_NS = 1000000000, /* and after that time, in which it waits for something */
    LOOK_NS = 20000000,
    MOST = 512,           /* tasks, started or not, of clients with many */
    MOST_OF_CLIENT = 128, /* of one client */
    FEW_OF_CLIENT = 4,    /* of one client, which it may have, and start, although others have all */
    STARTED = 128,        /* tasks with a thread, and so with memory */
    STARTED_OF_CLIENT = 64,
    STARTED_OF_SESSION = 4,
    LOWER = 10, /* nice value: below the threads that answer, above experiments */
};

/* Last turn of a client, or of a session of a client. Kept while it has tasks. */
typedef struct account {
    struct account *next;
    const struct account *of; /* client of a session; NULL: this is a client */
    char name[65];
    int tasks, started;
    uint64_t turn; /* serial of its last turn */
} account;

typedef enum task_state {
    WAITING,  /* for its turn */
    STARTING, /* has its first turn, but no thread yet */
    RUNNING,
    OVERDUE, /* runs without a turn until it yields */
} task_state;

struct ll_task {
    ll_tasks *tasks;
    ll_task *next;
    ll_task_spec order;
    account *client, *session;
    task_state state;
    bool started; /* has a thread, or a thread is being made for it */
    uint64_t turn;
    int64_t since;      /* when it began to wait, or its slice began */
    int64_t cpu_from;   /* processor time of its thread at the start of the task */
    int64_t slice_from; /* and of the slice */
    clockid_t clock;    /* of that time */
    pthread_cond_t its_turn;
    atomic_int ending;
};

struct ll_tasks {
    pthread_mutex_t lock; /* guards all members below, and the tasks except `ending` */
    pthread_cond_t work, over, watch;
    pthread_t watcher;
    ll_task *first;
    account *accounts;
    int turns, running, overdue, starting, count, started, threads, idle;
    uint64_t serial;
    int64_t last_turn; /* when the last turn was given */
    bool draining, ended;
    uint64_t done, broken, refused;
};

/* ---- accounts; locked ---- */

static account *get_account(ll_tasks *p, const account *of, const char *name)
{
    account *a = p->accounts;
    uint64_t least = UINT64_MAX;
    for (account *other = p->accounts; other; other = other->next)
        if (other->of == of && other->turn < least)
            least = other->turn;
    while (a && !(a->of == of && strcmp(a->name, name) == 0))
        a = a->next;
    if (!a) {
        a = calloc(1, sizeof *a);
        if (!a)
            return NULL;
        snprintf(a->name, sizeof a->name, "%s", name);
        a->of = of;
        /* Not before those that wait, otherwise a client that comes repeatedly would always be first. */
        a->turn = least == UINT64_MAX ? p->serial : least;
        a->next = p->accounts;
        p->accounts = a;
    }
    a->tasks++;
    return a;
}

static void close_account(ll_tasks *p, account *a)
{
    LL_ASSERT(!a || a->tasks > 0);
    if (!a || --a->tasks > 0)
        return;
    LL_ASSERT(a->started == 0); /* its tasks are over */
    account **link = &p->accounts;
    while (*link != a)
        link = &(*link)->next;
    *link = a->next;
    free(a);
}

/* ---- turns; locked ---- */

static bool comes_before(const ll_task *a, const ll_task *b)
{
    if (a->client->turn != b->client->turn)
        return a->client->turn < b->client->turn;
    if (a->session->turn != b->session->turn)
        return a->session->turn < b->session->turn;
    return a->turn < b->turn;
}

static bool may_start(const ll_tasks *p, const ll_task *t)
{
    return t->started || t->order.own ||
           ((p->started < STARTED || t->client->started < FEW_OF_CLIENT) &&
            t->client->started < STARTED_OF_CLIENT && t->session->started < STARTED_OF_SESSION);
}

static ll_task *choose(ll_tasks *p)
{
    ll_task *best = NULL;
    for (ll_task *t = p->first; t; t = t->next)
        if (t->state == WAITING && may_start(p, t) && (!best || comes_before(t, best)))
            best = t;
    return best;
}

static void *run_tasks(void *argument);

/* Makes threads for tasks with their first turn. If that fails, another task's thread runs them later. */
static void find_thread(ll_tasks *p)
{
    pthread_t thread;
    if (p->starting > p->idle && pthread_create(&thread, NULL, run_tasks, p) == 0) {
        pthread_detach(thread);
        p->threads++;
    }
    pthread_cond_signal(&p->work);
}

static void give_turns(ll_tasks *p)
{
    while (p->running < p->turns) {
        ll_task *t = choose(p);
        if (!t)
            return;
        t->state = t->started ? RUNNING : STARTING;
        LL_ASSERT(t->session->of == t->client); /* an account of this client */
        t->turn = t->session->turn = t->client->turn = ++p->serial;
        t->since = p->last_turn = ll_now_ns();
        p->running++;
        if (t->started) {
            pthread_cond_signal(&t->its_turn);
            continue;
        }
        t->started = true;
        t->client->started++;
        t->session->started++;
        p->started++;
        p->starting++;
        find_thread(p);
    }
}

static ll_task *take(ll_tasks *p)
{
    ll_task *t = p->first;
    while (t && t->state != STARTING)
        t = t->next;
    if (!t)
        return NULL;
    t->state = RUNNING;
    t->cpu_from = t->slice_from = ll_thread_cpu_ns();
    pthread_getcpuclockid(pthread_self(), &t->clock);
    LL_ASSERT(p->starting > 0);
    p->starting--;
    return t;
}

/* Ends its turn, also if it has lost it already. */
static void end_turn(ll_tasks *p, const ll_task *t)
{
    if (t->state == OVERDUE)
        p->overdue--;
    else
        p->running--;
    LL_ASSERT(p->running >= 0 && p->overdue >= 0 && p->running <= p->turns);
}

static void remove_task(ll_tasks *p, ll_task *t)
{
    ll_task **link = &p->first;
    while (*link != t)
        link = &(*link)->next;
    *link = t->next;
    p->count--;
    p->started--;
    LL_ASSERT(p->count >= 0 && p->started >= 0 && p->started <= p->count);
    end_turn(p, t);
    t->client->started--;
    t->session->started--;
    close_account(p, t->session);
    close_account(p, t->client);
}

/* ---- threads ---- */

static void *run_tasks(void *argument)
{
    ll_tasks *p = argument;
    pthread_setname_np(pthread_self(), "task");
    setpriority(PRIO_PROCESS, (id_t)gettid(), LOWER); /* on Linux: of this thread */
    pthread_mutex_lock(&p->lock);
    for (;;) {
        ll_task *t = take(p);
        if (!t && p->ended)
            break;
        if (!t) {
            p->idle++;
            pthread_cond_wait(&p->work, &p->lock);
            p->idle--;
            continue;
        }
        pthread_mutex_unlock(&p->lock);
        t->order.run(t->order.context, t);
        pthread_mutex_lock(&p->lock);
        p->done++;
        p->broken += atomic_load(&t->ending) != LL_TASK_RUNNING;
        remove_task(p, t);
        pthread_cond_destroy(&t->its_turn);
        free(t);
        give_turns(p);
        pthread_cond_broadcast(&p->over);
    }
    p->threads--;
    pthread_cond_broadcast(&p->over);
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

/* Only a task that computes, or waits for something, is overdue: not one from which a busy machine took the
 * processor. */
static bool is_overdue(const ll_task *t, int64_t now)
{
    struct timespec used;
    if (t->state != RUNNING || now - t->since < OVERDUE_NS)
        return false;
    return now - t->since > STUCK_NS || clock_gettime(t->clock, &used) != 0 ||
           used.tv_sec * INT64_C(1000000000) + used.tv_nsec - t->slice_from > OVERDUE_NS;
}

/* A task that does not yield for longer than a slice, as in a tick of a large grid, loses its turn, so that
 * others can run: it continues in parallel, and the system shares the processors. */
static void *watch_slices(void *argument)
{
    ll_tasks *p = argument;
    pthread_setname_np(pthread_self(), "task watcher");
    pthread_mutex_lock(&p->lock);
    while (!p->ended) {
        int64_t now = ll_now_ns();
        struct timespec deadline = ll_deadline(CLOCK_MONOTONIC, LOOK_NS);
        for (ll_task *t = p->first; t; t = t->next) {
            if (!is_overdue(t, now))
                continue;
            end_turn(p, t);
            t->state = OVERDUE;
            p->overdue++;
        }
        give_turns(p);
        if (p->count > p->running + p->overdue)
            pthread_cond_timedwait(&p->watch, &p->lock, &deadline);
        else if (!p->ended)
            pthread_cond_wait(&p->watch, &p->lock);
    }
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

static void wait_for_turn(ll_task *t)
{
    ll_tasks *p = t->tasks;
    pthread_mutex_lock(&p->lock);
    if (t->state == OVERDUE || p->count > p->running + p->overdue) { /* another task waits */
        end_turn(p, t);
        t->state = WAITING;
        t->since = ll_now_ns();
        pthread_cond_signal(&p->watch);
        give_turns(p);
        while (t->state == WAITING)
            pthread_cond_wait(&t->its_turn, &p->lock);
    }
    t->since = ll_now_ns();
    t->slice_from = ll_thread_cpu_ns();
    pthread_mutex_unlock(&p->lock);
}

/* Processor time so far. */
static double used_s(const ll_task *t)
{
    return (double)(ll_thread_cpu_ns() - t->cpu_from) * 1e-9;
}

bool ll_task_yield(ll_task *t)
{
    if (t->order.budget_s > 0 && used_s(t) > t->order.budget_s)
        ll_task_stop(t, LL_TASK_OVER_BUDGET);
    if (ll_task_end_reason(t) != LL_TASK_RUNNING)
        return false;
    if (ll_thread_cpu_ns() - t->slice_from > SLICE_NS)
        wait_for_turn(t);
    return ll_task_end_reason(t) == LL_TASK_RUNNING;
}

ll_task_end ll_task_end_reason(const ll_task *t)
{
    return (ll_task_end)atomic_load(&t->ending);
}

void ll_task_stop(ll_task *t, ll_task_end why)
{
    int none = LL_TASK_RUNNING;
    atomic_compare_exchange_strong(&t->ending, &none, (int)why);
}

ll_status ll_task_error(const ll_task *t, const char *how_far)
{
    static const char *const whys[] = {
        [LL_TASK_RUNNING] = "Interrupted",
        [LL_TASK_CLIENT_GONE] = "The client disconnected",
        [LL_TASK_CANCELLED] = "Cancelled",
        [LL_TASK_STOPPED] = "The daemon is stopping",
    };
    ll_task_end end = ll_task_end_reason(t);
    if (end == LL_TASK_OVER_BUDGET)
        return ll_error(LL_INTERRUPTED, "Limit of %g s of processor time reached: %s.", t->order.budget_s,
                        how_far);
    return ll_error(LL_INTERRUPTED, "%s: %s.", whys[end], how_far);
}

static bool yield_task(void *task)
{
    return ll_task_yield(task);
}

ll_interrupt ll_task_interrupt(ll_task *t)
{
    return (ll_interrupt){yield_task, ll_now_ns, t};
}

/* ---- adding tasks ---- */

static ll_status check(ll_tasks *p, const ll_task_spec *order)
{
    int of_client = 0;
    for (const account *a = p->accounts; a; a = a->next)
        if (!a->of && strcmp(a->name, order->client) == 0)
            of_client = a->tasks;
    if (p->draining)
        return ll_error(LL_UNAVAILABLE, "The daemon is stopping.");
    if (order->own)
        return ll_ok();
    if (of_client >= MOST_OF_CLIENT)
        return ll_error(LL_LIMIT, "Limit of %d long requests of one client reached.", of_client);
    if (p->count >= MOST && of_client >= FEW_OF_CLIENT)
        return ll_error(LL_UNAVAILABLE, "Limit of long requests reached.");
    return ll_ok();
}

ll_status ll_tasks_add(ll_tasks *p, const ll_task_spec *order, ll_task **task)
{
    ll_task *t = calloc(1, sizeof *t);
    if (!t)
        return ll_error(LL_NO_MEMORY, "out of memory: request");
    t->tasks = p;
    t->order = *order;
    pthread_cond_init(&t->its_turn, NULL);
    pthread_mutex_lock(&p->lock);
    ll_status status = check(p, order);
    if (!ll_failed(&status)) {
        t->client = get_account(p, NULL, order->client);
        t->session = t->client ? get_account(p, t->client, order->session) : NULL;
        if (!t->session) {
            close_account(p, t->client);
            status = ll_error(LL_NO_MEMORY, "out of memory: request");
        }
    }
    if (ll_failed(&status)) {
        p->refused++;
        pthread_mutex_unlock(&p->lock);
        pthread_cond_destroy(&t->its_turn);
        free(t);
        return status;
    }
    t->turn = ++p->serial;
    t->since = ll_now_ns();
    ll_task **link = &p->first;
    while (*link)
        link = &(*link)->next;
    *link = t;
    p->count++;
    pthread_cond_signal(&p->watch);
    if (task)
        *task = t;
    give_turns(p);
    pthread_mutex_unlock(&p->lock);
    return ll_ok();
}

/* ---- start and stop ---- */

ll_status ll_tasks_start(int turns, ll_tasks **tasks)
{
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    ll_tasks *p = *tasks = calloc(1, sizeof *p);
    if (!p)
        return ll_error(LL_NO_MEMORY, "out of memory: tasks");
    p->turns = turns > 0 ? turns : cores > 0 ? (int)cores : 1;
    pthread_mutex_init(&p->lock, NULL);
    pthread_cond_init(&p->work, NULL);
    pthread_cond_init(&p->over, NULL);
    ll_cond_init(&p->watch);
    if (pthread_create(&p->watcher, NULL, watch_slices, p) == 0)
        return ll_ok();
    free(p);
    *tasks = NULL;
    return ll_error(LL_NO_MEMORY, "cannot start task watcher thread");
}

void ll_tasks_drain(ll_tasks *p)
{
    pthread_mutex_lock(&p->lock);
    p->draining = true;
    for (ll_task *t = p->first; t; t = t->next)
        ll_task_stop(t, LL_TASK_STOPPED);
    pthread_mutex_unlock(&p->lock);
}

ll_tasks_stats ll_tasks_get_stats(ll_tasks *p)
{
    int64_t now = ll_now_ns(), longest = 0;
    pthread_mutex_lock(&p->lock);
    for (const ll_task *t = p->first; t; t = t->next)
        if (t->state == WAITING && may_start(p, t) && now - t->since > longest)
            longest = now - t->since;
    int64_t stalled = now - p->last_turn < longest ? now - p->last_turn : longest;
    int running = p->running + p->overdue;
    ll_tasks_stats stats = {.running = running,
                            .waiting = p->count - running,
                            .longest_s = (double)longest * 1e-9,
                            .stalled_s = (double)stalled * 1e-9,
                            .done = p->done,
                            .ended = p->broken,
                            .refused = p->refused};
    pthread_mutex_unlock(&p->lock);
    return stats;
}

void ll_tasks_free(ll_tasks *p)
{
    if (!p)
        return;
    ll_tasks_drain(p);
    pthread_mutex_lock(&p->lock);
    while (p->count > 0 || p->threads > 0 || !p->ended) {
        p->ended = p->count == 0;
        if (p->ended) {
            pthread_cond_broadcast(&p->work);
            pthread_cond_signal(&p->watch);
        }
        if (p->count > 0 || p->threads > 0)
            pthread_cond_wait(&p->over, &p->lock);
    }
    pthread_mutex_unlock(&p->lock);
    pthread_join(p->watcher, NULL);
    pthread_cond_destroy(&p->watch);
    pthread_cond_destroy(&p->work);
    pthread_cond_destroy(&p->over);
    pthread_mutex_destroy(&p->lock);
    free(p);
}
