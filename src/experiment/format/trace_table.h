/* Traces of a session as tables, which every format writes: the columns of the trace, a row per tick; or the
 * rows of a record of the stream at every tick, of events each once, at the tick by which it has happened. */
#pragma once

#include "base/interrupt.h"
#include "experiment/format/table.h"
#include "session/session.h"

/* What of which ticks. */
typedef struct ll_trace_request {
    const char *of; /* a record of the session's kind, or of its events only `packets` or `corrections`; NULL:
                       the columns of the trace */
    const char *name;              /* of the option or parameter, for errors */
    int64_t from, to;              /* both included, at most the head */
    int64_t rows_max;              /* more are an error; 0: any number */
    const ll_interrupt *interrupt; /* NULL: none */
} ll_trace_request;

typedef struct ll_trace_table ll_trace_table;

/* LL_BAD_INPUT: this session has no such record. */
ll_status ll_trace_table_check(const ll_session *session, const char *name, const char *of);

/* Reading the rows moves `copy`, a new one of ll_session_copy, which must outlive the table; `of` and
 * `interrupt` too. */
ll_status ll_trace_table_new(ll_session *copy, const ll_trace_request *request, ll_trace_table **table);
const ll_table *ll_trace_table_get(const ll_trace_table *table);
void ll_trace_table_free(ll_trace_table *table);
