/* What is measured of a run, as tables.
 *
 * A table describes the members of one object of a kind's metrics: of each its name, type, unit, help, when
 * it is null, and the expression that measures it. It is written as a list next to the code that measures, a
 * row a metric:
 *
 *   #define BOX_METRICS(X)                                                          \
 *       X(number, area_m2, "m^2", b->w * b->h, "area", NULL)                        \
 *       X(count, touched, NULL, b->touched, "how often it was touched", NULL)
 *
 *   static const ll_metric_table box_table = {
 *       .path = "boxes.*", .help = "A box.", LL_METRICS_FROM(BOX_METRICS)};
 *
 *   LL_METRICS_PUT(object, &box_table, BOX_METRICS);    where `b` is known
 *
 * From these tables come the members of a run's metrics, GET /api/v1/metrics, the tables in docs, the page's
 * help, and what comparisons know of a metric. Columns of traces (record/trace.h) and of results
 * (experiment/format/table.h) are lists of the same form. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct cJSON;

typedef enum ll_metric_type {
    LL_METRIC_NUMBER,
    LL_METRIC_COUNT, /* a whole number */
    LL_METRIC_FLAG,
    LL_METRIC_TEXT,         /* a name out of a list, or a sentence */
    LL_METRIC_NUMBERS,      /* a list of numbers */
    LL_METRIC_DISTRIBUTION, /* an object: mean, rms, p50, p95, p99, max, count */
    LL_METRIC_LATENCY,      /* a distribution, and lost_ratio: the share of those that never came about */
    LL_METRIC_GAUGE,        /* an object: mean, min, max, count */
    LL_METRIC_BY_NAME,      /* an object: a number for each of some names */
    LL_METRIC_CURVE,        /* a list of pairs: coordinate, value. Its kind writes it */
    LL_METRIC_NOTICES,      /* a list of sentences. Its kind writes it */
    LL_METRIC_TYPES
} ll_metric_type;

/* What is rare in a run of a random kind, and large: how much it makes of the mean over runs. */
typedef enum ll_metric_tail {
    LL_TAIL_LIGHT,
    LL_TAIL_LONG,    /* a few runs in a hundred make much of it; more of its rms and its percentiles */
    LL_TAIL_EXTREME, /* they make most of it */
    LL_TAILS
} ll_metric_tail;

typedef struct ll_metric_field {
    const char *name;
    const char *unit; /* `m`, `ms`; NULL: it has none */
    const char *help;
    const char *null; /* when it is null, or of a text when it is left out; NULL: never */
    ll_metric_type type;
    bool is_signed; /* may be below 0 and is better the nearer it is to 0: comparisons take its magnitude */
    bool rare;      /* counts events that come one by one, so that their number is near to Poisson's */
    bool is_rate;   /* a count per second of the time from warmup_s on */
    ll_metric_tail tail;
} ll_metric_field;

typedef struct ll_metric_table {
    /* Where the object stands in the metrics: empty, the metrics themselves; `methods.*`, each element of a
     * list, or each member of an object whose names are those of something else. */
    const char *path;
    const char
        *also; /* where the same stands once more, before `path`: `side_by_side.*`; NULL: in no other place */
    const char *when; /* it is there; NULL: always */
    const char *help;
    bool short_numbers; /* 15 digits where they are within a rounding error, not all that it takes */
    const ll_metric_field *fields;
    int count;
} ll_metric_table;

enum { LL_METRIC_PARTS_MAX = 8 };

/* Of a field the member that its type asks for; a number that is not finite is null. */
typedef struct ll_metric_reading {
    double number;    /* of a count whole, of a flag 0 or 1; of `numbers` and `by_name` how many there are */
    const char *text; /* NULL: it is left out */
    const double *numbers;             /* NULL: of nulls */
    const char *const *names;          /* of `by_name`, for its numbers */
    double parts[LL_METRIC_PARTS_MAX]; /* of a distribution, a latency and a gauge, in their order */
} ll_metric_reading;

/* ---- a row of a list, X(type, name, unit, value, help, null), as a field and as a value ---- */

#define LL_METRIC_FIELD(type_, name_, unit_, value_, help_, null_)                                           \
    {.name = #name_, .unit = unit_, .help = help_, .null = null_, LL_METRIC_IS_##type_},

#define LL_METRIC_IS_number .type = LL_METRIC_NUMBER
#define LL_METRIC_IS_signed_number .type = LL_METRIC_NUMBER, .is_signed = true
#define LL_METRIC_IS_count .type = LL_METRIC_COUNT
#define LL_METRIC_IS_events .type = LL_METRIC_COUNT, .rare = true /* a count of rare ones */
#define LL_METRIC_IS_rate .type = LL_METRIC_NUMBER, .is_rate = true
#define LL_METRIC_IS_event_rate .type = LL_METRIC_NUMBER, .is_rate = true, .rare = true
#define LL_METRIC_IS_flag .type = LL_METRIC_FLAG
#define LL_METRIC_IS_optional_flag .type = LL_METRIC_FLAG /* NaN: null */
#define LL_METRIC_IS_text .type = LL_METRIC_TEXT
#define LL_METRIC_IS_numbers .type = LL_METRIC_NUMBERS
#define LL_METRIC_IS_distribution .type = LL_METRIC_DISTRIBUTION
#define LL_METRIC_IS_long_distribution .type = LL_METRIC_DISTRIBUTION, .tail = LL_TAIL_LONG
#define LL_METRIC_IS_extreme_distribution .type = LL_METRIC_DISTRIBUTION, .tail = LL_TAIL_EXTREME
#define LL_METRIC_IS_latency .type = LL_METRIC_LATENCY
#define LL_METRIC_IS_gauge .type = LL_METRIC_GAUGE
#define LL_METRIC_IS_extreme_gauge .type = LL_METRIC_GAUGE, .tail = LL_TAIL_EXTREME
#define LL_METRIC_IS_by_name .type = LL_METRIC_BY_NAME
#define LL_METRIC_IS_curve .type = LL_METRIC_CURVE
#define LL_METRIC_IS_notices .type = LL_METRIC_NOTICES

/* `value` of what is no single number, flag or text is a whole ll_metric_reading. */
#define LL_METRIC_READING(type_, name_, unit_, value_, help_, null_) LL_METRIC_OF_##type_(value_),

#define LL_METRIC_OF_number(v) ll_metric_number((double)(v))
#define LL_METRIC_OF_signed_number(v) ll_metric_number((double)(v))
#define LL_METRIC_OF_count(v) ll_metric_number((double)(v))
#define LL_METRIC_OF_events(v) ll_metric_number((double)(v))
#define LL_METRIC_OF_rate(v) ll_metric_number((double)(v))
#define LL_METRIC_OF_event_rate(v) ll_metric_number((double)(v))
#define LL_METRIC_OF_flag(v) ll_metric_number((v) ? 1 : 0)
#define LL_METRIC_OF_optional_flag(v) ll_metric_number((double)(v))
#define LL_METRIC_OF_text(v) ll_metric_text(v)
#define LL_METRIC_OF_numbers(v) (v)
#define LL_METRIC_OF_distribution(v) (v)
#define LL_METRIC_OF_long_distribution(v) LL_METRIC_OF_distribution(v)
#define LL_METRIC_OF_extreme_distribution(v) LL_METRIC_OF_distribution(v)
#define LL_METRIC_OF_latency(v) (v)
#define LL_METRIC_OF_gauge(v) (v)
#define LL_METRIC_OF_extreme_gauge(v) LL_METRIC_OF_gauge(v)
#define LL_METRIC_OF_by_name(v) (v)

/* The fields of a table, of a list. */
#define LL_METRICS_FROM(LIST)                                                                                \
    .fields = (const ll_metric_field[]){LIST(LL_METRIC_FIELD)},                                              \
    .count = (int)(sizeof((const ll_metric_field[]){LIST(LL_METRIC_FIELD)}) / sizeof(ll_metric_field))

/* Adds the fields of the list to the JSON object, in their order: where its expressions hold. */
#define LL_METRICS_PUT(object, table, LIST)                                                                  \
    ll_metrics_put(object, table, (const ll_metric_reading[]){LIST(LL_METRIC_READING)})

static inline ll_metric_reading ll_metric_number(double number)
{
    return (ll_metric_reading){.number = number};
}

static inline ll_metric_reading ll_metric_text(const char *text)
{
    return (ll_metric_reading){.text = text};
}

static inline ll_metric_reading ll_metric_numbers(const double *numbers, int count)
{
    return (ll_metric_reading){.number = count, .numbers = numbers};
}

/* A reading for each field. */
void ll_metrics_put(struct cJSON *object, const ll_metric_table *table, const ll_metric_reading *values);

/* ---- tables of a kind, NULL-terminated ---- */

/* The field that a path such as `players.0.remote_error_m.mean` is or leads into; NULL: none has it. */
const ll_metric_field *ll_metric_find(const ll_metric_table *const *tables, const char *path);

/* The tables as JSON (NULL: none): a list of objects with path, help and metrics. Caller deletes. */
struct cJSON *ll_metrics_schema(const ll_metric_table *const *tables);
