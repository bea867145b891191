/* Counters, and the queue of commands to the stream threads. */
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>

#include "daemon/stream/internal.h"

void ll_ws_count(atomic_ullong *counter, uint64_t n)
{
    atomic_fetch_add_explicit(counter, n, memory_order_relaxed);
}

/* The thread processes its queue after it has cleared `wake_pending`. */
void ll_ws_wake(ws_thread *thread)
{
    if (!atomic_exchange(&thread->wake_pending, true))
        eventfd_write(thread->event_fd, 1);
}

ws_command *ll_ws_command_new(ws_command_kind kind, const char *text, size_t size)
{
    ws_command *command = calloc(1, sizeof *command + size + 1);
    if (command != NULL) {
        command->kind = kind;
        command->size = size;
        if (size > 0)
            memcpy(command->text, text, size);
    }
    return command;
}

bool ll_ws_submit(ws_thread *thread, ws_command *command)
{
    pthread_mutex_lock(&thread->lock);
    bool open = !thread->stopped;
    if (open) {
        if (thread->last_command != NULL)
            thread->last_command->next = command;
        else
            thread->first_command = command;
        thread->last_command = command;
    }
    pthread_mutex_unlock(&thread->lock);
    if (open)
        ll_ws_wake(thread);
    return open;
}
