/* What is streamed of every session, in addition to what its kind has. */
#pragma once

#include "record/row_set.h"
#include "session/session.h"

struct cJSON;

#define LL_NO_EVENT INT64_MAX

/* Of a frame that is taken. */
typedef struct ll_record_request {
    uint16_t channels; /* bits of ll_channel */
    bool anew;         /* of the events also those of the last LL_EVENTS_NEW_S: some viewer has seen none */
    int64_t
        from_event; /* number of the first that some viewer has not got; LL_NO_EVENT: none waits for any */
    uint32_t viewers;
    uint64_t wall_ns; /* of the daemon's monotonic clock */
} ll_record_request;

#define LL_EVENTS_NEW_S 4.0

/* Where the events stand in the set. */
enum { LL_RECORD_SESSION, LL_RECORD_CLOCK, LL_RECORD_EVENTS, LL_OWN_RECORDS };

/* Those above, then those of the kind. Nothing of the session changes; it must be awake. */
void ll_session_fill(const ll_session *session, const ll_record_request *request, ll_row_set *rows);

/* Of all kinds, each once, NULL-terminated. */
#define LL_ALL_RECORDS_MAX 48
void ll_all_records(const ll_record *records[LL_ALL_RECORDS_MAX + 1]);

/* GET /api/v1/stream/schema.json: the tables of all kinds (record/schema.h) and the channels. Caller deletes.
 */
struct cJSON *ll_stream_schema(void);
uint64_t ll_stream_schema_hash(void);

/* GET /api/v1/metrics: the tables of metrics of all kinds (record/metric.h). Caller deletes. */
struct cJSON *ll_metrics_of_kinds(void);
/* Those that stand in the metrics of every kind. */
extern const ll_metric_table *const ll_session_metric_tables[];
