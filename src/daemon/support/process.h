/* The process of a daemon: its signals, limits and files. */
#pragma once

#include <signal.h>

void ll_process_ending(sigset_t *signals); /* those that end it: SIGTERM, SIGINT, SIGHUP */

/* Before the first thread: blocks the ending signals, which a thread then waits for (`signals` gets them),
 * ignores those of broken pipes and full disks, raises the limit of open files, and makes files that only
 * their owner can read. */
void ll_process_prepare(sigset_t *signals);

const char *ll_process_signal_name(int ending);
