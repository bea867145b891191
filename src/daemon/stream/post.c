/* What every file of the streams uses: time, counters, and mail to the stream threads. */
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#include "daemon/stream/internal.h"

int64_t ll_ws_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

void ll_ws_count(atomic_ullong *counter, uint64_t n)
{
    atomic_fetch_add_explicit(counter, n, memory_order_relaxed);
}

/* A thread takes what is there after it has cleared `wake_pending`. */
void ll_ws_wake(ws_thread *thread)
{
    if (!atomic_exchange(&thread->wake_pending, true)) {
        eventfd_write(thread->event_fd, 1);
    }
}

void ll_ws_release(const ll_ws_socket *socket)
{
    if (socket->release != NULL) {
        socket->release(socket->owner);
    } else {
        close(socket->fd);
    }
}

ws_mail *ll_ws_mail_new(ws_mail_kind kind, const char *text, size_t size)
{
    ws_mail *mail = calloc(1, sizeof *mail + size + 1);
    if (mail != NULL) {
        mail->kind = kind;
        mail->size = size;
        if (size > 0) {
            memcpy(mail->text, text, size);
        }
    }
    return mail;
}

bool ll_ws_post(ws_thread *thread, ws_mail *mail)
{
    pthread_mutex_lock(&thread->lock);
    bool open = !thread->stopped;
    if (open) {
        if (thread->last_mail != NULL) {
            thread->last_mail->next = mail;
        } else {
            thread->first_mail = mail;
        }
        thread->last_mail = mail;
    }
    pthread_mutex_unlock(&thread->lock);
    if (open) {
        ll_ws_wake(thread);
    }
    return open;
}
