/* The clocks of the system. */
#pragma once

#include <pthread.h>
#include <stdint.h>
#include <time.h>

static inline int64_t ll_clock_ns(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

static inline int64_t ll_now_ns(void) /* since some moment in the past; never goes back */
{
    return ll_clock_ns(CLOCK_MONOTONIC);
}

static inline int64_t ll_unix_ms(void)
{
    return ll_clock_ns(CLOCK_REALTIME) / 1000000;
}

static inline int64_t ll_thread_cpu_ns(void) /* processor time of this thread */
{
    return ll_clock_ns(CLOCK_THREAD_CPUTIME_ID);
}

static inline int64_t ll_process_cpu_ns(void)
{
    return ll_clock_ns(CLOCK_PROCESS_CPUTIME_ID);
}

/* `ns` from now on `clock`, as pthread_cond_timedwait takes it. */
static inline struct timespec ll_deadline(clockid_t clock, int64_t ns)
{
    const int64_t until = ll_clock_ns(clock) + ns;
    return (struct timespec){until / 1000000000, until % 1000000000};
}

/* A condition that waits until moments of CLOCK_MONOTONIC: not affected by changes of the date. */
static inline void ll_cond_init(pthread_cond_t *condition)
{
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(condition, &monotonic);
    pthread_condattr_destroy(&monotonic);
}
