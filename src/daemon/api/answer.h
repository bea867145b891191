/* Answers that are large files: unchanged (ETag, If-None-Match), partial (Range), compressed
 * (Accept-Encoding) or without body (HEAD).
 *
 * A handler identifies its answer by a tag. When ll_answer_known returns true, the response is complete and
 * the file is not made. Otherwise the handler makes the file and passes it to ll_answer_send. */
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "base/status.h"
#include "daemon/http/http.h"
#include "experiment/format/trace_table.h"

typedef struct ll_answer {
    const char *type;   /* Content-Type */
    const char *folder; /* for the file, which has no name; in memory if the file cannot be created there */
    uint64_t tag;       /* hash of its sources */
    bool final;         /* equal tags mean equal bytes, so that parts of it fit together */
    const char *vary;   /* in addition to Accept-Encoding; NULL: none */
} ll_answer;

/* Sets ETag, Vary and Accept-Ranges. True: 304, or HEAD. */
bool ll_answer_known(const ll_http_request *request, ll_http_response *response, const ll_answer *answer);

FILE *ll_answer_open(const ll_answer *answer, ll_status *status); /* NULL: see `status` */

/* Takes ownership of `file` (may be NULL). If `status` is an error, that is the answer. */
void ll_answer_send(const ll_http_request *request, ll_http_response *response, const ll_answer *answer,
                    const ll_status *status, FILE *file);

/* The format of a table, by the query's `format`, else by Accept. NULL: refused, and answered. */
const ll_format *ll_answer_format(const ll_http_request *request, ll_http_response *response);

/* A trace of what the query's `of` names, without ticks; absent or `ticks`: the columns of the trace. */
ll_trace_request ll_answer_trace(const ll_http_request *request, const ll_interrupt *interrupt);
