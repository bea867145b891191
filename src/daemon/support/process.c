#include "daemon/support/process.h"

#include <pthread.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "daemon/support/memory.h"

void ll_process_ending(sigset_t *signals)
{
    sigemptyset(signals);
    sigaddset(signals, SIGTERM);
    sigaddset(signals, SIGINT);
    sigaddset(signals, SIGHUP);
}

void ll_process_prepare(sigset_t *signals)
{
    ll_memory_prepare();
    umask(077); /* a session's id permits reading it, so files are readable by their owner only */
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ,
           SIG_IGN); /* a file that may not grow is reported as an error of the store, like a full disk */
    ll_process_ending(signals);
    pthread_sigmask(SIG_BLOCK, signals, NULL); /* before threads are made, which inherit it */
    struct rlimit files;
    if (getrlimit(RLIMIT_NOFILE, &files) == 0 && files.rlim_cur < files.rlim_max) {
        files.rlim_cur = files.rlim_max;
        setrlimit(RLIMIT_NOFILE, &files);
    }
}

const char *ll_process_signal_name(int ending)
{
    return ending == SIGTERM ? "SIGTERM" : ending == SIGINT ? "SIGINT" : "SIGHUP";
}
