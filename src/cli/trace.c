#include "cli/trace.h"

#include <stdio.h>
#include <string.h>

#include "cli/output.h"
#include "experiment/format/trace_table.h"

#define OPTION "--trace-of"

/* The record that an order names. */
static ll_status record_of(const char *order, char name[40])
{
    const char *equals = strchr(order, '=');
    if (!equals || equals[1] == '\0')
        return ll_error(LL_BAD_INPUT, OPTION ": must be RECORD=FILE; got %.100s", order);
    snprintf(name, 40, "%.*s", (int)(equals - order), order);
    return ll_ok();
}

static const char *file_of(const char *order)
{
    return strchr(order, '=') + 1;
}

ll_status ll_trace_check(const ll_session *session, const char *order)
{
    char name[40];
    const ll_format *format;
    LL_TRY(record_of(order, name));
    LL_TRY(ll_trace_table_check(session, OPTION, name));
    return ll_argument_format(NULL, file_of(order), &format);
}

/* `record` NULL: the columns of the trace. */
static ll_status write_table(ll_session *session, const char *option, const char *record, const char *path)
{
    ll_trace_table *table = NULL;
    ll_session *copy = NULL;
    const ll_format *format = NULL;
    const ll_trace_request request = {.of = record, .name = option, .to = ll_session_get_info(session).tick};
    ll_status status = ll_argument_format(NULL, path, &format);
    LL_THEN(status, ll_session_copy(session, request.to, &copy));
    LL_THEN(status, ll_trace_table_new(copy, &request, &table));
    LL_THEN(status, ll_argument_write(path, format, ll_trace_table_get(table)));
    ll_trace_table_free(table);
    if (copy)
        ll_session_account_copy(session, copy);
    ll_session_destroy(copy);
    return status;
}

ll_status ll_trace_write(ll_session *session, const char *order)
{
    char name[40];
    LL_TRY(record_of(order, name));
    return write_table(session, OPTION, name, file_of(order));
}

bool ll_trace_is_csv(const char *path)
{
    const ll_format *format;
    ll_status status = ll_argument_format(NULL, path, &format);
    return ll_failed(&status) || strcmp(format->name, "csv") == 0;
}

ll_status ll_trace_write_columns(ll_session *session, const char *path)
{
    return write_table(session, "--trace", NULL, path);
}
