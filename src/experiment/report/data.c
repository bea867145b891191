#include "experiment/report/data.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/rng.h"
#include "experiment/report/pack.h"
#include "experiment/report/page.h"
#include "experiment/spec/metric_path.h"

enum {
    TEXTS_MAX = 200,
    HEAD_ROOM = 4000,                /* of the head, for what is known last */
    DIFFERENCES_ROOM = 200000,       /* of text */
    WHOLE_PLANES = LL_PACK_8_DIGITS, /* of whole numbers: exact up to 2^29 */
    TEXT_PLANES = 3,
};

typedef enum statistic { MEAN, LOW, HIGH, METHOD, DEVIATION, P25, P50, P75, RUNS, STATISTICS } statistic;

static const char *const statistic_names[] = {"mean", "low", "high", "method", "sd",
                                              "p25",  "p50", "p75",  "n"};
static const bool statistic_is_whole[STATISTICS] = {[METHOD] = true, [RUNS] = true};

typedef struct data {
    const ll_report_rows *rows;
    const ll_points *points;
    const ll_differences *differences;
    const ll_experiment *e;
    cJSON *head, *texts, *covers;
    uint32_t *index; /* of the points that are written */
    int64_t count;
} data;

/* What a column reads. */
typedef struct column {
    const data *d;
    int at; /* metric, axis, or difference */
    statistic what;
} column;

/* ---- texts ---- */

static int text_index(const data *d, const char *text, const char *covers)
{
    int k = 0;
    const cJSON *item;
    cJSON_ArrayForEach(item, d->texts)
    {
        if (strcmp(item->valuestring, text) == 0)
            return k;
        k++;
    }
    if (k == TEXTS_MAX)
        return TEXTS_MAX;
    cJSON_AddItemToArray(d->texts, cJSON_CreateString(text));
    cJSON_AddItemToArray(d->covers, cJSON_CreateString(covers ? covers : ""));
    return k;
}

static double statistic_of(const data *d, const ll_summary *s, statistic what)
{
    char text[LL_SUMMARY_TEXT_MAX];
    switch (what) {
    case MEAN:
        return s->mean;
    case LOW:
        return s->of_mean.low;
    case HIGH:
        return s->of_mean.high;
    case METHOD:
        ll_summary_text(s, text);
        return text_index(d, text, s->covers);
    case DEVIATION:
        return s->deviation;
    case RUNS:
        return (double)s->n;
    default:
        return s->quartiles[what - P25];
    }
}

/* ---- columns ---- */

static const ll_point *point_of(const column *c, int64_t k)
{
    return &c->d->points->points[c->d->index[k]];
}

static double metric_at(const void *context, int64_t k)
{
    const column *c = context;
    return statistic_of(c->d, &point_of(c, k)->metrics[c->at], c->what);
}

static double place_at(const void *context, int64_t k)
{
    const column *c = context;
    return point_of(c, k)->places[c->at];
}

static double number_at(const void *context, int64_t k)
{
    return (double)point_of(context, k)->point;
}

static double runs_at(const void *context, int64_t k)
{
    return (double)point_of(context, k)->runs;
}

static double failed_at(const void *context, int64_t k)
{
    return (double)point_of(context, k)->failed;
}

static double front_at(const void *context, int64_t k)
{
    return point_of(context, k)->front;
}

static double difference_at(const void *context, int64_t k)
{
    const column *c = context;
    return statistic_of(c->d, &c->d->differences->list[c->at].details[k], c->what);
}

static void add_column(cJSON *list, ll_pack *pack, const char *name, int at, int planes, int64_t count,
                       ll_pack_value *value, const column *c)
{
    cJSON *item = cJSON_CreateObject();
    cJSON_AddStringToObject(item, "name", name);
    cJSON_AddNumberToObject(item, "of", at);
    cJSON_AddNumberToObject(item, "planes", planes);
    cJSON_AddNumberToObject(item, "count", (double)count);
    cJSON_AddItemToArray(list, item);
    ll_pack_add(pack, planes, count, value, c);
}

/* ---- points ---- */

/* What is tried in this order; the last is repeated for fewer points each time. */
typedef struct attempt {
    statistic statistics; /* number */
    int planes;
} attempt;

static const attempt attempts[] = {{STATISTICS, LL_PACK_EXACT},
                                   {STATISTICS, LL_PACK_8_DIGITS},
                                   {STATISTICS, LL_PACK_6_DIGITS},
                                   {METHOD + 1, LL_PACK_6_DIGITS},
                                   {METHOD + 1, LL_PACK_4_DIGITS}};
enum { ATTEMPTS = sizeof attempts / sizeof attempts[0] };

static void choose_points(data *d, double share)
{
    enum { STREAM = 0x5245 };
    d->count = 0;
    for (int i = 0; i < d->points->count; i++)
        if (share >= 1 || ll_rng_unit(0, STREAM, (uint64_t)d->points->points[i].point) < share)
            d->index[d->count++] = (uint32_t)i;
}

static bool is_whole(const data *d)
{
    return d->count == d->e->points;
}

/* A point of one run has only one value. */
static bool is_written(const data *d, statistic what, statistic statistics)
{
    return what < statistics && (d->e->head.repeats > 1 || what == MEAN);
}

static cJSON *add_points(const data *d, const attempt *a, ll_pack *pack)
{
    const ll_experiment *e = d->e;
    cJSON *list = cJSON_CreateArray();
    column c = {.d = d};
    if (!is_whole(d))
        add_column(list, pack, "point", 0, WHOLE_PLANES, d->count, number_at, &c);
    add_column(list, pack, "runs", 0, WHOLE_PLANES, d->count, runs_at, &c);
    add_column(list, pack, "failed", 0, WHOLE_PLANES, d->count, failed_at, &c);
    add_column(list, pack, "front", 0, TEXT_PLANES, d->count, front_at, &c);
    for (c.at = 0; c.at < e->axis_count && e->head.sample.method != LL_SAMPLE_NONE; c.at++)
        add_column(list, pack, "place", c.at, a->planes, d->count, place_at, &c);
    for (c.at = 0; c.at < e->metric_count; c.at++)
        for (statistic s = MEAN; s < STATISTICS; s++)
            if (is_written(d, s, a->statistics)) {
                c.what = s;
                add_column(list, pack, statistic_names[s], c.at,
                           statistic_is_whole[s] ? WHOLE_PLANES : a->planes, d->count, metric_at, &c);
            }
    return list;
}

/* Deflated, columns of numbers are rarely below a fourteenth; it is not tried whether these are. */
static bool is_hopeless(size_t bytes, size_t room)
{
    return bytes / 14 > room;
}

/* Bytes of the metrics' columns before deflation. */
static size_t expected_size(const data *d, const attempt *a)
{
    size_t each = 0;
    for (statistic s = MEAN; s < STATISTICS; s++)
        each += is_written(d, s, a->statistics) ? (size_t)a->planes : 0;
    return each * (size_t)d->e->metric_count * (size_t)d->points->count;
}

static ll_status pack_points(data *d, size_t room, ll_pack *pack)
{
    double share = 1;
    for (int i = 0;; i++) {
        attempt a = attempts[i < ATTEMPTS ? i : ATTEMPTS - 1];
        if (i < ATTEMPTS - 1 && is_hopeless(expected_size(d, &a), room))
            continue;
        choose_points(d, share);
        cJSON *list = add_points(d, &a, pack);
        bool tries = !is_hopeless(pack->size, room);
        ll_status status = tries ? ll_pack_deflate(pack) : ll_ok();
        if (ll_failed(&status) || (tries && ll_pack_text_size(pack) <= room) || d->count == 0) {
            cJSON_AddItemToObject(d->head, "point_columns", list);
            cJSON_AddNumberToObject(d->head, "planes", a.planes);
            cJSON_AddNumberToObject(d->head, "shown", (double)d->count);
            return status;
        }
        if (i >= ATTEMPTS - 1)
            share *= tries ? fmin(0.9, 0.98 * (double)room / (double)ll_pack_text_size(pack)) : 0.5;
        cJSON_Delete(list);
        ll_pack_free(pack);
    }
}

/* ---- differences ---- */

static void add_number(cJSON *list, double value)
{
    cJSON_AddItemToArray(list, isfinite(value) ? cJSON_CreateNumber(value) : cJSON_CreateNull());
}

static cJSON *difference_head(const data *d, const ll_difference *one)
{
    cJSON *item = cJSON_CreateObject(), *all = cJSON_AddArrayToObject(item, "all");
    cJSON_AddNumberToObject(item, "dimension", one->dimension);
    cJSON_AddNumberToObject(item, "metric", one->metric);
    cJSON_AddNumberToObject(item, "from", one->from);
    cJSON_AddNumberToObject(item, "of", one->of);
    cJSON_AddNumberToObject(item, "settings", (double)one->settings);
    cJSON_AddNumberToObject(item, "complete", (double)one->complete);
    for (statistic s = MEAN; s <= METHOD; s++)
        add_number(all, statistic_of(d, &one->all, s));
    return item;
}

static void add_differences(const data *d, int planes, cJSON *list, ll_pack *pack)
{
    static const statistic written[] = {MEAN, LOW, HIGH, METHOD};
    for (int i = 0; i < d->differences->count; i++)
        for (size_t s = 0; s < sizeof written / sizeof written[0] && d->differences->list[i].details; s++)
            add_column(list, pack, statistic_names[written[s]], i,
                       statistic_is_whole[written[s]] ? TEXT_PLANES : planes,
                       d->differences->list[i].settings, difference_at, &(column){d, i, written[s]});
}

static ll_status pack_differences(const data *d, ll_pack *pack)
{
    static const int planes[] = {LL_PACK_EXACT, LL_PACK_8_DIGITS, LL_PACK_6_DIGITS, 0};
    cJSON *heads = cJSON_AddArrayToObject(d->head, "differences"), *list = NULL;
    ll_status status = ll_ok();
    for (int i = 0; i < d->differences->count; i++)
        cJSON_AddItemToArray(heads, difference_head(d, &d->differences->list[i]));
    for (int i = 0; !list; i++) {
        list = cJSON_CreateArray();
        if (planes[i])
            add_differences(d, planes[i], list, pack);
        status = ll_pack_deflate(pack);
        if (!ll_failed(&status) && planes[i] && ll_pack_text_size(pack) > DIFFERENCES_ROOM) {
            cJSON_Delete(list);
            ll_pack_free(pack);
            list = NULL;
        }
    }
    cJSON_AddItemToObject(d->head, "difference_columns", list);
    return status;
}

/* ---- runs ---- */

typedef struct run_column {
    const ll_report_rows *rows;
    int metric;
    int64_t kept;
} run_column;

static double run_at(const void *context, int64_t k)
{
    const run_column *c = context;
    return ll_report_rows_at(c->rows, c->metric, k / c->kept)[k % c->kept];
}

static ll_status pack_runs(const data *d, size_t room, ll_pack *pack)
{
    static const int planes[] = {LL_PACK_EXACT, LL_PACK_8_DIGITS, LL_PACK_6_DIGITS, LL_PACK_4_DIGITS};
    enum { PLANES = sizeof planes / sizeof planes[0] };
    const ll_experiment *e = d->e;
    int64_t kept = is_whole(d) && e->head.repeats > 1 ? d->rows->kept : 0;
    for (int i = 0; kept > 1; i++) {
        int p = planes[i < PLANES ? i : PLANES - 1];
        kept = i < PLANES ? kept : kept * 3 / 4;
        for (int m = 0; m < e->metric_count; m++)
            ll_pack_add(pack, p, e->points * kept, run_at, &(run_column){d->rows, m, kept});
        if (!is_hopeless(pack->size, room) && kept > 1) {
            LL_TRY(ll_pack_deflate(pack));
            if (ll_pack_text_size(pack) <= room) {
                cJSON_AddNumberToObject(d->head, "run_planes", p);
                break;
            }
        }
        ll_pack_free(pack);
    }
    cJSON_AddNumberToObject(d->head, "kept", kept > 1 ? (double)kept : 0);
    return ll_ok();
}

/* ---- the head ---- */

/* Values of an axis that has a list of them. */
static void add_axis(const ll_experiment *e, const ll_axis *axis, cJSON *axes)
{
    const ll_param *row = ll_param_find(e->base.kind->table, e->base.config, axis->path, NULL);
    char name[LL_COLUMN_NAME_MAX];
    cJSON *item = cJSON_CreateObject();
    ll_axis_column(axis->path, row ? row->unit : NULL, name, sizeof name);
    cJSON_AddStringToObject(item, "path", axis->path);
    cJSON_AddStringToObject(item, "name", name);
    cJSON_AddBoolToObject(item, "log", axis->scale == 1);
    if (axis->values) {
        cJSON_AddItemToObject(item, "values", cJSON_Duplicate(axis->values, true));
    } else if (!axis->sampled) {
        cJSON *values = cJSON_AddArrayToObject(item, "values");
        for (int64_t k = 0; k < axis->count; k++)
            cJSON_AddItemToArray(values, ll_axis_at(axis, k));
    }
    cJSON_AddBoolToObject(item, "numeric", axis->type == LL_CELL_REAL || axis->type == LL_CELL_INT);
    cJSON_AddItemToArray(axes, item);
}

static void add_dimensions(const ll_experiment *e, cJSON *head)
{
    cJSON *dimensions = cJSON_AddArrayToObject(head, "dimensions");
    for (int d = 0; d < e->dimension_count; d++) {
        cJSON *axes = cJSON_CreateArray();
        for (int a = 0; a < e->axis_count; a++)
            if (e->dimension[a] == d)
                add_axis(e, &e->axes[a], axes);
        cJSON_AddItemToArray(dimensions, axes);
    }
}

static void add_metrics(const ll_experiment *e, cJSON *head)
{
    cJSON *metrics = cJSON_AddArrayToObject(head, "metrics"), *front = cJSON_AddArrayToObject(head, "front");
    for (int m = 0; m < e->metric_count; m++)
        cJSON_AddItemToArray(metrics, cJSON_CreateString(e->metrics[m]));
    for (int i = 0; i < e->front_count; i++)
        cJSON_AddItemToArray(front, cJSON_CreateNumber(e->front[i]));
    cJSON_AddNumberToObject(head, "error", e->error_metric);
    cJSON_AddNumberToObject(head, "cost", e->cost_metric);
}

static void make_head(data *d, const char *version)
{
    const ll_experiment *e = d->e;
    const ll_scenario_head *scenario = e->base.config;
    d->head = cJSON_CreateObject();
    cJSON_AddStringToObject(d->head, "version", version);
    cJSON_AddStringToObject(d->head, "scenario", e->head.scenario_id);
    cJSON_AddItemToObject(d->head, "set", e->set ? cJSON_Duplicate(e->set, true) : cJSON_CreateObject());
    cJSON_AddNumberToObject(d->head, "seed", (double)scenario->seed);
    cJSON_AddNumberToObject(d->head, "repeats", (double)e->head.repeats);
    cJSON_AddNumberToObject(d->head, "points", (double)e->points);
    cJSON_AddNumberToObject(d->head, "runs", (double)e->runs);
    cJSON_AddBoolToObject(d->head, "grid", e->head.sample.method == LL_SAMPLE_NONE);
    add_metrics(e, d->head);
    add_dimensions(e, d->head);
    d->texts = cJSON_AddArrayToObject(d->head, "texts");
    d->covers = cJSON_AddArrayToObject(d->head, "covers");
}

static size_t head_size(const data *d)
{
    char *text = cJSON_PrintUnformatted(d->head);
    size_t size = text ? strlen(text) : 0;
    cJSON_free(text);
    return size + HEAD_ROOM;
}

static void write_pack(const char *id, const ll_pack *pack, FILE *file)
{
    fprintf(file, "<script type=\"text/plain\" id=\"%s\">", id);
    ll_pack_write(pack, file);
    fputs("</script>\n", file);
}

static ll_status pack_all(data *d, size_t room, ll_pack packs[3])
{
    LL_TRY(pack_differences(d, &packs[1]));
    size_t used = head_size(d) + ll_pack_text_size(&packs[1]);
    LL_TRY(pack_points(d, room > used ? room - used : 0, &packs[0]));
    used = head_size(d) + ll_pack_text_size(&packs[0]) + ll_pack_text_size(&packs[1]);
    return pack_runs(d, room > used ? room - used : 0, &packs[2]);
}

ll_status ll_report_data_write(const ll_report_rows *rows, const ll_points *points,
                               const ll_differences *differences, const char *version, size_t room,
                               FILE *file)
{
    static const char *const ids[] = {"point-data", "difference-data", "run-data"};
    ll_pack packs[3] = {0};
    data d = {.rows = rows, .points = points, .differences = differences, .e = rows->experiment};
    d.index = malloc((size_t)points->count * sizeof *d.index + 1);
    make_head(&d, version);
    ll_status status =
        d.index ? pack_all(&d, room, packs) : ll_error(LL_NO_MEMORY, "out of memory: data of the report");
    if (!ll_failed(&status))
        ll_page_json("head", d.head, file);
    for (int i = 0; i < 3; i++) {
        if (!ll_failed(&status))
            write_pack(ids[i], &packs[i], file);
        ll_pack_free(&packs[i]);
    }
    cJSON_Delete(d.head);
    free(d.index);
    return status;
}
