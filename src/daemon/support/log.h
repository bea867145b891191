/* The daemon's log: one JSON object per line on stderr, {"ts","level","msg","detail"}.
 *
 * A line is one write, so that lines of several threads do not mix. No session id and no key is ever logged:
 * an id is all that reading needs. Any thread. */
#pragma once

void ll_log_write(const char *level, const char *msg, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
