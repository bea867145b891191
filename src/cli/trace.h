/* Traces of a run as tables, in every format of results. */
#pragma once

#include "session/session.h"

/* Checks `RECORD=FILE` (RECORD: a record of the stream of this session's kind, or packets or corrections,
 * which are events) and the format of FILE, by its ending. */
ll_status ll_trace_check(const ll_session *session, const char *order);

/* Writes the rows of a record at every tick up to the present one, or each event as it happened. Computed on
 * a copy. */
ll_status ll_trace_write(ll_session *session, const char *order);

/* The columns of the trace, a row per tick; any format but CSV, which ll_session_trace writes. */
ll_status ll_trace_write_columns(ll_session *session, const char *path);
bool ll_trace_is_csv(const char *path); /* by its ending */
