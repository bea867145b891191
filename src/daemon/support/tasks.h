/* Tasks: work that may take long, as seeks, waking, traces, dry runs, advice, results.
 *
 * A task belongs to a client and a session, has a budget of processor time, and can be stopped from outside.
 * Tasks run on threads of their own, at a lower priority than the threads that answer and stream, and only as
 * many at once as there are turns. A task calls ll_task_yield every millisecond or so. When its slice, of
 * processor time, is over and others wait, it waits there for its next turn. A task that does not yield for
 * long loses its turn and continues in parallel. Turns rotate over the clients with tasks, within a client
 * over its sessions, and within a session over its tasks, so that a client with many tasks delays only
 * itself. A client with few tasks is never refused or kept waiting because others have many.
 *
 * A task is stopped by its budget, when its client disconnects, by the code that added it, or when the daemon
 * stops: then ll_task_yield is false, and ll_task_end_reason has the reason. A task must hold no lock when it
 * yields.
 *
 * Any thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "base/status.h"

typedef struct ll_tasks ll_tasks;
typedef struct ll_task ll_task; /* freed when its `run` has returned */

typedef enum ll_task_end {
    LL_TASK_RUNNING,
    LL_TASK_OVER_BUDGET, /* used up its budget */
    LL_TASK_CLIENT_GONE, /* its client disconnected */
    LL_TASK_CANCELLED,   /* by the code that added it */
    LL_TASK_STOPPED,     /* the daemon stops */
} ll_task_end;

typedef struct ll_task_spec {
    char client[48];  /* an address */
    char session[65]; /* what its client's turns rotate over: a session and what is asked of it, or empty */
    double budget_s;  /* processor time; 0: no limit */
    bool own;         /* of the daemon, not of a request: exempt from the limits */
    /* Called once, also when the task was stopped before its first turn. */
    void (*run)(void *context, ll_task *task);
    void *context;
} ll_task_spec;

typedef struct ll_tasks_stats {
    int running, waiting; /* waiting: for their next turn */
    double longest_s;     /* longest present wait of a task for tasks of other clients */
    double stalled_s;     /* since tasks wait and none got a turn; 0 while turns go round */
    uint64_t done, ended; /* since the start; ended: before they were done */
    uint64_t refused;
} ll_tasks_stats;

ll_status ll_tasks_start(int turns, ll_tasks **tasks); /* turns: tasks that run at once; 0: one per core */

/* LL_LIMIT: too many tasks wait, of this client or in total; LL_UNAVAILABLE: the daemon stops. `task` may be
 * NULL. It may have ended when this returns, so use it only under a lock that `run` takes at its end. */
ll_status ll_tasks_add(ll_tasks *tasks, const ll_task_spec *order, ll_task **task);

void ll_task_stop(ll_task *task, ll_task_end why); /* keeps the first reason */

/* ---- called by the task ---- */

bool ll_task_yield(ll_task *task); /* may wait for the next turn */
ll_task_end ll_task_end_reason(const ll_task *task);
/* The error to answer with when it was stopped; `how_far` is the progress, as in the text of
 * LL_INTERRUPTED. */
ll_status ll_task_error(const ll_task *task, const char *how_far);
ll_interrupt ll_task_interrupt(ll_task *task);

/* ---- stopping ---- */

void ll_tasks_drain(ll_tasks *tasks); /* stops all tasks and accepts no more; returns at once */
ll_tasks_stats ll_tasks_get_stats(ll_tasks *tasks);
void ll_tasks_free(ll_tasks *tasks); /* drains, and waits for running tasks */
