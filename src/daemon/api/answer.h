/* Answers that are large files: what need not be made again (ETag, If-None-Match), what is asked of it only
 * in part (Range), compressed (Accept-Encoding), or not at all (HEAD).
 *
 * A handler names what it would answer by a tag; when ll_answer_known says that the client needs no more, the
 * response is complete and nothing is made. Else it makes the file and gives it to ll_answer_send. */
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "base/status.h"
#include "daemon/http/http.h"

typedef struct ll_answer {
    const char *type;   /* Content-Type */
    const char *folder; /* for the file, which has no name; where it cannot be made, it is in memory */
    uint64_t tag;       /* of what it is made from */
    bool final;         /* the same tag means the same bytes: parts of it fit together */
    const char *vary;   /* beside Accept-Encoding; NULL: nothing */
} ll_answer;

/* Sets ETag, Vary and Accept-Ranges. True: 304, or HEAD. */
bool ll_answer_known(const ll_http_request *request, ll_http_response *response, const ll_answer *answer);

FILE *ll_answer_open(const ll_answer *answer, ll_status *status); /* NULL: `status` says why */

/* Takes `file` (may be NULL). On an error that is answered in its place. */
void ll_answer_send(const ll_http_request *request, ll_http_response *response, const ll_answer *answer,
                    const ll_status *status, FILE *file);
