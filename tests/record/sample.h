/* A record of each form, with rows from a seed. */
#pragma once

#include <math.h>
#include <string.h>

#include "base/rng.h"
#include "record/rows.h"

typedef struct sample {
    uint16_t width, height; /* of a plane; else the first two keys */
    uint32_t number;
    int32_t sign;
    int64_t big;
    bool on;
    uint8_t kind;
    float x;
    double energy, ms;
} sample;

static const char *const sample_kinds[] = {"soup", "pie", NULL};

static const ll_record_field sample_fields[] = {
    LL_INT(sample, width, NULL, "first key"),
    LL_INT(sample, height, NULL, "second key"),
    LL_INT(sample, number, NULL, "third key"),
    LL_INT(sample, sign, NULL, "of either sign"),
    LL_INT(sample, big, NULL, "of any size"),
    LL_INT(sample, on, NULL, "whether it is on"),
    LL_ENUM(sample, kind, sample_kinds, "what it is"),
    LL_STEP(sample, x, 13, "m", "a place; null when it has none"),
    LL_REAL(sample, energy, 23, "J", "of any size"),
    LL_STEP(sample, ms, 7, "ms", "a time"),
};

#define SAMPLE(id_, name_, form_, keys_)                                                                     \
    {                                                                                                        \
        .id = id_, .name = name_, .channel = LL_CHANNEL_SCENE, .help = "a sample", .form = form_,            \
        .keys = keys_, LL_ROWS_OF(sample, sample_fields)                                                     \
    }
static const ll_record samples[] = {
    SAMPLE(1, "one", LL_FORM_ONE, 0),     SAMPLE(2, "by_index", LL_FORM_BY_INDEX, 0),
    SAMPLE(3, "keyed", LL_FORM_KEYED, 3), SAMPLE(4, "log", LL_FORM_LOG, 0),
    SAMPLE(5, "grid", LL_FORM_GRID, 0),
};
enum { SAMPLES = sizeof samples / sizeof samples[0] };

typedef struct draw {
    uint64_t seed, counter;
} draw;

static inline uint64_t draw_below(draw *d, uint64_t n)
{
    return ll_rng_u64(d->seed, 1, d->counter++) % n;
}

static inline double draw_real(draw *d)
{
    static const double odd[] = {0, -0.0, INFINITY, -INFINITY, NAN, 1e300, -1e300, 1e-300, 0.1, -3};
    double size = (double)draw_below(d, 1000000) / 1000 - 500;
    return draw_below(d, 12) == 0 ? odd[draw_below(d, 10)] : size;
}

static inline void draw_sample(draw *d, sample *s)
{
    const int64_t edge = INT64_C(1) << 50;
    *s = (sample){.width = (uint16_t)draw_below(d, 5),
                  .height = (uint16_t)draw_below(d, 5),
                  .number = (uint32_t)draw_below(d, 9),
                  .sign = (int32_t)draw_below(d, 3) - 1,
                  .big = draw_below(d, 5) == 0 ? edge - (int64_t)draw_below(d, 3) : -edge,
                  .on = draw_below(d, 2) == 1,
                  .kind = (uint8_t)draw_below(d, 2),
                  .x = (float)draw_real(d),
                  .energy = draw_real(d) * 1e9,
                  .ms = draw_real(d)};
}

/* Rows with much in common with `before`, as in consecutive frames. Of a LOG, they overlap. */
static inline ll_rows *draw_rows(draw *d, const ll_record *record, const ll_rows *before)
{
    int most = record->form == LL_FORM_ONE ? 1 : (int)draw_below(d, 12);
    ll_rows *rows = ll_rows_new(record, 1);
    int old = before != NULL ? before->count : 0;
    if (record->form == LL_FORM_LOG && before != NULL)
        rows->first = before->first + (int64_t)draw_below(d, (uint64_t)old + 3);
    for (int i = 0; i < (record->form == LL_FORM_ONE ? 1 : most); i++) {
        sample s;
        uint8_t plane[16];
        draw_sample(d, &s);
        for (int k = 0; k < 16; k++)
            plane[k] = (uint8_t)draw_below(d, 256);
        if (record->form == LL_FORM_GRID)
            ll_rows_add_plane(rows, &s, plane);
        else
            ll_rows_add(rows, &s, 1);
        int64_t *values = ll_rows_at(rows, rows->count - 1);
        bool keeps = i < old && record->form != LL_FORM_GRID && draw_below(d, 3) > 0;
        if (record->form == LL_FORM_LOG && before != NULL) {
            int64_t at = rows->first + i - before->first;
            if (at < old)
                memcpy(values, ll_rows_at(before, (int)at), (size_t)record->count * sizeof *values);
        } else if (keeps) {
            for (int k = 0; k < record->count; k++)
                if (draw_below(d, 4) > 0)
                    values[k] = ll_rows_at(before, i)[k];
        }
    }
    if (record->form == LL_FORM_LOG && before != NULL && rows->first + rows->count < before->first + old) {
        int64_t end = before->first + old; /* a log keeps its end */
        rows->count = 0;
        rows->first = end;
    }
    ll_rows_sort(rows);
    return rows;
}
