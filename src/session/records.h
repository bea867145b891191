/* Records that every session streams, in addition to those of its kind. */
#pragma once

#include "record/row_set.h"
#include "session/session.h"

struct cJSON;

#define LL_NO_EVENT INT64_MAX

/* What a frame is to contain. */
typedef struct ll_record_request {
    uint16_t channels;  /* bits of ll_channel */
    bool anew;          /* also the events of the last LL_EVENTS_NEW_S: a viewer has none yet */
    int64_t from_event; /* first event that a viewer does not have; LL_NO_EVENT: no viewer wants events */
    uint32_t viewers;
    bool deltas;      /* small sections get their differences from the last at once (frame.h) */
    uint64_t wall_ns; /* of the daemon's monotonic clock */
} ll_record_request;

#define LL_EVENTS_NEW_S 4.0
#define LL_EVENT_RING 2048 /* events kept for viewers: 4 s of two players */

/* Indices of these records in the set. */
enum { LL_RECORD_SESSION, LL_RECORD_CLOCK, LL_RECORD_EVENTS, LL_OWN_RECORDS };

/* Fills in the records above, then those of the kind. The session must be awake, and does not change. */
void ll_session_fill(const ll_session *session, const ll_record_request *request, ll_row_set *rows);

/* Records of all kinds, each once, NULL-terminated. */
#define LL_ALL_RECORDS_MAX 48
void ll_all_records(const ll_record *records[LL_ALL_RECORDS_MAX + 1]);

/* GET /api/v1/stream/schema.json: the tables of all kinds (record/schema.h) and the channels. Caller
 * deletes. */
struct cJSON *ll_stream_schema(void);
uint64_t ll_stream_schema_hash(void);

/* GET /api/v1/metrics: the tables of metrics of all kinds (record/metric.h). Caller deletes. */
struct cJSON *ll_metrics_of_kinds(void);
struct cJSON *ll_traces_of_kinds(void); /* the same of the columns of traces (record/trace.h) */
/* Those that stand in the metrics of every kind. */
extern const ll_metric_table *const ll_session_metric_tables[];
