/* Work that may take long: seeks, waking, traces, dry runs, advice, results.
 *
 * Each piece of work is a task: it belongs to a client and a session, may use so much processor time, and can
 * be ended from outside. Tasks run on threads of their own, of less priority than those that answer and
 * stream, and at most as many at once as there are turns. A task asks ll_task_yield every millisecond or so;
 * when its slice is over and others wait, it waits there for its next turn. One that does not ask for long
 * loses its turn and runs on beside the others. Turns go round over the clients that have work, within a
 * client over its sessions, and within a session over its tasks: who has much to do waits for himself.
 *
 * It is ended by its budget, by its client's leaving, by whoever ordered it, or because the daemon stops:
 * then ll_task_yield is false, and ll_task_end_reason says why in a sentence. A task holds no lock while it
 * asks.
 *
 * Any thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "base/status.h"

typedef struct ll_tasks ll_tasks;
typedef struct ll_task ll_task; /* lives until its `run` has returned */

typedef enum ll_task_end {
    LL_TASK_RUNNING,
    LL_TASK_OVER_BUDGET, /* its budget */
    LL_TASK_CLIENT_GONE, /* its client is gone */
    LL_TASK_CANCELLED,   /* by who ordered it */
    LL_TASK_STOPPED,     /* with the daemon */
} ll_task_end;

typedef struct ll_task_spec {
    char client[48];  /* an address */
    char session[65]; /* or an experiment, or empty */
    double budget_s;  /* of processor time; 0: none */
    bool own;         /* the daemon's, not a request's: however many wait */
    /* Called once, also when it was ended before its first turn. */
    void (*run)(void *context, ll_task *task);
    void *context;
} ll_task_spec;

typedef struct ll_tasks_stats {
    int running, waiting; /* waiting: for their next turn */
    double longest_s; /* that one of them has waited by now; not for others of its own session or client */
    uint64_t done, ended; /* since the start; ended before they were done */
    uint64_t refused;
} ll_tasks_stats;

ll_status ll_tasks_start(int turns, ll_tasks **tasks); /* turns: that run at once; 0: one per core */

/* LL_LIMIT: too many wait, of this client or of all; LL_UNAVAILABLE: the daemon stops. `task` may be NULL; it
 * may have ended when this returns, so that it can be used only under a lock that `run` takes at its end. */
ll_status ll_tasks_add(ll_tasks *tasks, const ll_task_spec *order, ll_task **task);

void ll_task_stop(ll_task *task, ll_task_end why); /* the first reason stays */

/* ---- inside of a task ---- */

bool ll_task_yield(ll_task *task); /* may wait for the next turn */
ll_task_end ll_task_end_reason(const ll_task *task);
double ll_task_used_s(const ll_task *task); /* processor time so far */
/* What to answer when it was ended: `how_far` is a sentence part, as of an LL_INTERRUPTED. */
ll_status ll_task_error(const ll_task *task, const char *how_far);
ll_interrupt ll_task_interrupt(ll_task *task);

/* ---- the end ---- */

void ll_tasks_drain(ll_tasks *tasks); /* ends all and takes no more; returns at once */
ll_tasks_stats ll_tasks_get_stats(ll_tasks *tasks);
void ll_tasks_free(ll_tasks *tasks); /* drains, and waits for what runs */
