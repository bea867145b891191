/* Streamed rows of fluids, for each of those side by side. */
#include <math.h>
#include <stdlib.h>

#include "record/integers.h"
#include "sim/fluid/fluid.h"

/* ---- its state and its numbers ---- */

typedef struct fluid_row {
    uint8_t status;
    bool held;
    uint32_t ticks;
} fluid_row;

static const ll_record_field fluid_fields[] = {
    LL_ENUM(fluid_row, status, ll_run_status_names, "ok, or why it has stopped"),
    LL_INT(fluid_row, held, NULL, "whether a person drags it"),
    LL_INT(fluid_row, ticks, NULL, "ticks made"),
};

static const ll_record fluid_record = {.id = 48,
                                       .name = "fluid",
                                       .channel = LL_CHANNEL_FIELD,
                                       .help = "The fluids side by side.",
                                       .form = LL_FORM_BY_INDEX,
                                       LL_ROWS_OF(fluid_row, fluid_fields)};

typedef struct number_row {
    uint8_t fluid, number;
    double value;
} number_row;

static const ll_record_field number_fields[] = {
    LL_INT(number_row, fluid, NULL, "whose"),
    LL_INT(number_row, number, NULL, "index of its name in the hello's layout"),
    LL_REAL(number_row, value, 23, NULL, "the number; null: unknown"),
};

static const ll_record number_record = {.id = 49,
                                        .name = "fluid_numbers",
                                        .channel = LL_CHANNEL_FIELD,
                                        .help = "Numbers that the method and the scene measure.",
                                        .form = LL_FORM_BY_INDEX,
                                        LL_ROWS_OF(number_row, number_fields)};

static void fill_state(const ll_fluid_sim *s, ll_row_set *rows)
{
    ll_fluid_number all[LL_FLUID_NUMBERS_MAX];
    int count = ll_fluid_sim_numbers(s, all);
    fluid_row row = {
        .status = s->failed ? LL_RUN_DIVERGED : LL_RUN_OK, .held = s->held != 0, .ticks = (uint32_t)s->ticks};
    ll_row_set_put(rows, &fluid_record, &row, 1);
    for (int i = 0; i < count; i++) {
        number_row number = {(uint8_t)s->setup.place, (uint8_t)i, all[i].value};
        ll_row_set_put(rows, &number_record, &number, 1);
    }
}

/* ---- the displayed field ---- */

enum { NO_FLUID = 255, LEVELS = 254 };

typedef struct field_row {
    uint16_t width, height;
    uint8_t fluid, layer;
    float low, high;
} field_row;

static const ll_record_field field_fields[] = {
    LL_INT(field_row, width, "cells", "in x"),
    LL_INT(field_row, height, "cells", "in y"),
    LL_INT(field_row, fluid, NULL, "whose"),
    LL_INT(field_row, layer, NULL, "index in the hello's layout"),
    LL_REAL(field_row, low, 23, NULL, "value of a cell of 0"),
    LL_REAL(field_row, high, 23, NULL, "value of a cell of 254; a cell of 255 has no fluid"),
};

static const ll_record field_record = {
    .id = 50,
    .name = "field",
    .channel = LL_CHANNEL_FIELD,
    .help = "The displayed field of fluids that have one, row by row from the bottom.",
    .form = LL_FORM_GRID,
    LL_ROWS_OF(field_row, field_fields)};

/* The `index`th layer of a shape, or its last one; -1: none. */
static int layer_of(const ll_fluid_method *method, int32_t shape, int64_t index)
{
    int found = -1;
    for (int i = 0; i < method->layer_count && index >= 0; i++)
        if (method->layers[i].shape == shape) {
            found = i;
            index--;
        }
    return found;
}

static int columns_of(const ll_fluid_layer *layer)
{
    int n = 0;
    while (layer->columns[n])
        n++;
    return n;
}

/* The values of a layer; the caller frees. NULL: out of memory. */
static float *values_of(const ll_fluid_sim *s, int layer, int32_t *width, int32_t *height)
{
    const ll_fluid_method *method = ll_fluid_sim_scene(&s->setup)->method;
    method->layer_size(ll_fluid_sim_block(s), layer, width, height);
    size_t count = (size_t)*width * (size_t)*height * (size_t)columns_of(&method->layers[layer]);
    float *values = malloc((count + 1) * sizeof *values);
    if (values)
        method->layer_values(ll_fluid_sim_block(s), layer, values);
    return values;
}

static bool known(float value)
{
    return value - value == 0;
}

/* One byte per cell: LEVELS steps from the minimum to the maximum. */
static void quantise(const float *values, size_t count, field_row *row, uint8_t *cells)
{
    bool any = false;
    for (size_t i = 0; i < count; i++)
        if (known(values[i])) {
            row->low = !any || values[i] < row->low ? values[i] : row->low;
            row->high = !any || values[i] > row->high ? values[i] : row->high;
            any = true;
        }
    double range = (double)row->high - (double)row->low, scale = range > 0 ? LEVELS / range : 0;
    for (size_t i = 0; i < count; i++)
        cells[i] =
            known(values[i]) ? (uint8_t)(((double)values[i] - (double)row->low) * scale + 0.5) : NO_FLUID;
}

static void fill_field(const ll_fluid_sim *s, ll_row_set *rows)
{
    const ll_fluid_method *method = ll_fluid_sim_scene(&s->setup)->method;
    int layer = layer_of(method, LL_FLUID_FIELD, s->setup.shown);
    int32_t width, height;
    float *values = layer >= 0 ? values_of(s, layer, &width, &height) : NULL;
    size_t count = values ? (size_t)width * (size_t)height : 0;
    uint8_t *cells = malloc(count + 1);
    if (values && cells) {
        field_row row = {.width = (uint16_t)width,
                         .height = (uint16_t)height,
                         .fluid = (uint8_t)s->setup.place,
                         .layer = (uint8_t)layer};
        quantise(values, count, &row, cells);
        ll_row_set_put_plane(rows, &field_record, &row, cells);
    } else if (layer >= 0) {
        rows->failed = true;
    }
    free(values);
    free(cells);
}

/* ---- points ---- */

enum { POINT_LAYERS = 2 };

typedef struct point_row {
    uint8_t fluid, layer;
    float x, y, value, value_2, value_3;
} point_row;

static const ll_record_field point_fields[] = {
    LL_INT(point_row, fluid, NULL, "whose"),
    LL_INT(point_row, layer, NULL,
           "index of the layer in the hello's layout, which names its columns in order"),
    LL_STEP(point_row, x, 12, "m", "the first column"),
    LL_STEP(point_row, y, 12, "m", "the second column"),
    LL_REAL(point_row, value, 10, NULL, "the third column; null: the layer has none"),
    LL_REAL(point_row, value_2, 10, NULL, "the fourth column; null: the layer has none"),
    LL_REAL(point_row, value_3, 10, NULL, "the fifth column; null: the layer has none"),
};

LL_INTEGERS(point_integers, point_row, point_fields)

static const ll_record point_record = {.id = 51,
                                       .name = "points",
                                       .channel = LL_CHANNEL_POINTS,
                                       .help = "Points of fluids that have them, layer by layer.",
                                       .form = LL_FORM_BY_INDEX,
                                       LL_ROWS_OF(point_row, point_fields),
                                       .integers = point_integers};

static float finite_or_0(float value)
{
    return known(value) ? value : 0;
}

static void fill_layer(const ll_fluid_sim *s, int layer, ll_row_set *rows)
{
    const ll_fluid_method *method = ll_fluid_sim_scene(&s->setup)->method;
    int32_t width, height;
    float *values = values_of(s, layer, &width, &height);
    int columns = columns_of(&method->layers[layer]);
    rows->failed = rows->failed || values == NULL;
    for (int32_t i = 0; values && i < width * height; i++) {
        const float *from = values + (size_t)i * (size_t)columns;
        point_row row = {.fluid = (uint8_t)s->setup.place,
                         .layer = (uint8_t)layer,
                         .x = finite_or_0(from[0]),
                         .y = columns > 1 ? finite_or_0(from[1]) : NAN,
                         .value = columns > 2 ? finite_or_0(from[2]) : NAN,
                         .value_2 = columns > 3 ? finite_or_0(from[3]) : NAN,
                         .value_3 = columns > 4 ? finite_or_0(from[4]) : NAN};
        ll_row_set_put(rows, &point_record, &row, 1);
    }
    free(values);
}

static void fill_points(const ll_fluid_sim *s, ll_row_set *rows)
{
    const ll_fluid_method *method = ll_fluid_sim_scene(&s->setup)->method;
    for (int k = 0, last = -1; k < POINT_LAYERS; k++) {
        int layer = layer_of(method, LL_FLUID_POINTS, k);
        if (layer > last)
            fill_layer(s, layer, rows);
        last = layer;
    }
}

/* ---- all records ---- */

const ll_record *const ll_fluid_sim_records[] = {&fluid_record, &number_record, &field_record, &point_record,
                                                 NULL};

void ll_fluid_sim_fill(const void *block, ll_row_set *rows)
{
    for (const ll_fluid_sim *s = block; s != NULL; s = ll_fluid_sim_next(s)) {
        if (ll_row_set_wants(rows, &fluid_record)) {
            fill_state(s, rows);
            fill_field(s, rows);
        }
        if (ll_row_set_wants(rows, &point_record))
            fill_points(s, rows);
    }
}
