/* Traces as files have them. Nothing is skipped: what is not understood is refused. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "link/profile/trace_text.h"

#define HEADER "t_ms,delay_ms,lost"
#define SHOWN 24 /* characters of a value in a message */

typedef struct reader {
    const char *name;
    const char *at; /* the line */
    size_t length;  /* of it, without its end */
    int line;       /* from 1 */
} reader;

static bool next_line(reader *r, const char **rest)
{
    if (**rest == '\0')
        return false;
    r->at = *rest;
    r->length = strcspn(r->at, "\n");
    *rest = r->at + r->length + (r->at[r->length] == '\n');
    if (r->length > 0 && r->at[r->length - 1] == '\r')
        r->length--;
    r->line++;
    return true;
}

static ll_status refuse(const reader *r, const char *field, const char *must, const char *got, size_t length)
{
    char shown[SHOWN + 1];
    size_t n = length < SHOWN ? length : SHOWN;
    for (size_t i = 0; i < n; i++)
        shown[i] = got[i] >= ' ' && got[i] <= '~' ? got[i] : '?';
    shown[n] = '\0';
    return ll_field_error(LL_BAD_INPUT, field, "%.100s, line %d, %s: must be %s; got %s", r->name, r->line,
                          field, must, n > 0 ? shown : "nothing");
}

/* A decimal number of digits and one point, in [0, most]; false: something else. */
static bool number_of(const char *text, size_t length, bool whole, double most, double *value)
{
    char digits[32];
    if (length == 0 || length >= sizeof digits)
        return false;
    memcpy(digits, text, length);
    digits[length] = '\0';
    size_t before = strspn(digits, "0123456789"), point = digits[before] == '.';
    if (before == 0 || (point && (whole || digits[before + 1] == '\0')) ||
        before + point + strspn(digits + before + point, "0123456789") != length)
        return false;
    *value = strtod(digits, NULL);
    return *value <= most;
}

static ll_status too_long(const reader *r, int most)
{
    return ll_error(LL_BAD_INPUT, "%.100s, line %d: a trace has at most %d lines of samples", r->name,
                    r->line, most);
}

static ll_status read_capacity(reader *r, const char *rest, ll_profile_params *p)
{
    while (next_line(r, &rest)) {
        double *at = &p->capacity_ms[p->capacity_count], before = p->capacity_count > 0 ? at[-1] : 0;
        char must[64];
        if (p->capacity_count == LL_CAPACITY_MAX)
            return too_long(r, LL_CAPACITY_MAX);
        snprintf(must, sizeof must, "a whole number of ms from %.0f to 3600000", before);
        if (!number_of(r->at, r->length, true, 3600000, at) || *at < before)
            return refuse(r, "time", must, r->at, r->length);
        p->capacity_count++;
    }
    return p->capacity_count > 0 && p->capacity_ms[p->capacity_count - 1] > 0
               ? ll_ok()
               : ll_error(LL_BAD_INPUT, "%.100s: the last time must be at least 1 ms", r->name);
}

static ll_status read_time(const reader *r, const char *text, size_t length, const ll_profile_params *p,
                           double *value)
{
    char must[80];
    double before = p->time_count > 0 ? p->trace_t_ms[p->time_count - 1] : 0;
    bool reads = number_of(text, length, false, 3600000, value);
    if (p->time_count == 0) {
        snprintf(must, sizeof must, "0, where a trace begins");
        reads = reads && *value <= 0;
    } else {
        snprintf(must, sizeof must, "a number of ms above %.10g, at most 3600000", before);
        reads = reads && *value - before >= 0.001;
    }
    return reads ? ll_ok() : refuse(r, "t_ms", must, text, length);
}

/* Three fields of a line. */
static ll_status read_row(const reader *r, ll_profile_params *p)
{
    const char *field[3] = {r->at}, *end = r->at + r->length;
    size_t length[3];
    int count = 1;
    for (const char *c = r->at; c < end; c++)
        if (*c == ',' && count < 3)
            field[count++] = c + 1;
    if (count < 3)
        return refuse(r, count < 2 ? "delay_ms" : "lost", "there, after a comma", r->at, r->length);
    length[0] = (size_t)(field[1] - field[0]) - 1;
    length[1] = (size_t)(field[2] - field[1]) - 1;
    length[2] = (size_t)(end - field[2]);
    int32_t i = p->time_count;
    LL_TRY(read_time(r, field[0], length[0], p, &p->trace_t_ms[i]));
    if (!number_of(field[1], length[1], false, 1000, &p->trace_delay_ms[i]))
        return refuse(r, "delay_ms", "a number of ms from 0 to 1000", field[1], length[1]);
    if (length[2] != 1 || (*field[2] != '0' && *field[2] != '1'))
        return refuse(r, "lost", "0 or 1", field[2], length[2]);
    p->trace_lost[i] = *field[2] == '1';
    p->time_count = p->delay_count = p->lost_count = i + 1;
    return ll_ok();
}

static ll_status read_delays(reader *r, const char *rest, ll_profile_params *p)
{
    while (next_line(r, &rest)) {
        if (p->time_count == LL_TRACE_MAX)
            return too_long(r, LL_TRACE_MAX);
        LL_TRY(read_row(r, p));
    }
    return p->time_count > 0 ? ll_ok() : ll_error(LL_BAD_INPUT, "%.100s: no row follows the header", r->name);
}

ll_status ll_trace_read(const char *name, const char *text, ll_profile_params *params)
{
    reader r = {.name = name};
    const char *rest = text;
    ll_param_defaults(&ll_profile_table, params);
    if (!next_line(&r, &rest))
        return ll_error(LL_BAD_INPUT, "%.100s: the file is empty", name);
    if (r.length == strlen(HEADER) && strncmp(r.at, HEADER, r.length) == 0)
        return read_delays(&r, rest, params);
    if (r.length > 0 && (r.at[0] < '0' || r.at[0] > '9'))
        return refuse(&r, "header", HEADER ", or a whole number of ms in a trace of Mahimahi", r.at,
                      r.length);
    r.line = 0;
    return read_capacity(&r, text, params);
}
