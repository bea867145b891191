#include "daemon/support/log.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static size_t escape(char *to, size_t capacity, const char *text)
{
    size_t n = 0;
    for (const char *p = text; *p && n + 7 < capacity; p++) {
        unsigned char c = (unsigned char)*p;
        if (c == '"' || c == '\\') {
            to[n++] = '\\';
            to[n++] = (char)c;
        } else if (c < 0x20) {
            n += (size_t)snprintf(to + n, capacity - n, "\\u%04x", c);
        } else {
            to[n++] = (char)c;
        }
    }
    to[n] = '\0';
    return n;
}

void ll_log_write(const char *level, const char *msg, const char *format, ...)
{
    char detail[1024], quoted[2048], line[2400], stamp[40];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(detail, sizeof detail, format, arguments);
    va_end(arguments);
    escape(quoted, sizeof quoted, detail);

    struct timespec now;
    struct tm utc;
    clock_gettime(CLOCK_REALTIME, &now);
    gmtime_r(&now.tv_sec, &utc);
    strftime(stamp, sizeof stamp, "%Y-%m-%dT%H:%M:%S", &utc);
    int length = snprintf(line, sizeof line,
                          "{\"ts\":\"%s.%03ldZ\",\"level\":\"%s\",\"msg\":\"%s\",\"detail\":\"%s\"}\n", stamp,
                          now.tv_nsec / 1000000, level, msg, quoted);
    if (length > 0 && write(STDERR_FILENO, line, (size_t)length) < 0)
        return; /* no other place to report to */
}
