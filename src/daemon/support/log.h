/* The daemon's log: one JSON object per line on stderr, {"ts","level","msg","detail"}.
 *
 * Each line is one write, so that lines of several threads do not mix. Session ids and keys are never logged:
 * an id alone permits reading its session. Any thread. */
#pragma once

void ll_log_write(const char *level, const char *msg, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
