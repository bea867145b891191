#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/utf8.h"

/* Length of `text` without a UTF-8 sequence that was cut at its end. */
static size_t whole_sequences(const char *text, size_t length)
{
    size_t start = length;
    while (start > 0 && length - start < 4) {
        unsigned char byte = (unsigned char)text[--start];
        if (byte < 0x80)
            return length;
        if (byte >= 0xc0) { /* the first byte of the last sequence */
            size_t needed = byte >= 0xf0 ? 4 : byte >= 0xe0 ? 3 : 2;
            return length - start < needed ? start : length;
        }
    }
    return length;
}

/* Messages may quote user input, cut by a precision: replaces all bytes that are not text. */
static void make_printable(char *text)
{
    while (*text) {
        int sequence = ll_utf8_printable(text);
        if (sequence == 0)
            *text = '?';
        text += sequence == 0 ? 1 : sequence;
    }
}

static void fill(char *out, size_t capacity, const char *format, va_list arguments)
    __attribute__((format(printf, 3, 0)));

static void fill(char *out, size_t capacity, const char *format, va_list arguments)
{
    int length = vsnprintf(out, capacity, format, arguments);
    if (length < 0)
        out[0] = '\0';
    else if ((size_t)length >= capacity)
        out[whole_sequences(out, capacity - 1)] = '\0';
    make_printable(out);
}

ll_status ll_error(ll_code code, const char *format, ...)
{
    ll_status s = {.code = code};
    va_list arguments;
    va_start(arguments, format);
    fill(s.text, sizeof s.text, format, arguments);
    va_end(arguments);
    return s;
}

ll_status ll_field_error(ll_code code, const char *field, const char *format, ...)
{
    ll_status s = {.code = code};
    size_t length = strlen(field);
    if (length >= sizeof s.field)
        length = whole_sequences(field, sizeof s.field - 1);
    memcpy(s.field, field, length);
    make_printable(s.field);
    va_list arguments;
    va_start(arguments, format);
    fill(s.text, sizeof s.text, format, arguments);
    va_end(arguments);
    return s;
}
