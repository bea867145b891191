/* A vocabulary with every type of row, nested as deep as the real ones. */
#pragma once

#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "param/param.h"

typedef struct wire {
    double jitter_ms;
    int32_t order;
    int32_t reserved;
} wire;

typedef struct member {
    char name[9];
    bool ready;
    double lag_ms;
    int64_t tries;
    wire up, down;
} member;

typedef struct circle {
    double radius;
} circle;

typedef struct box {
    double width, height;
} box;

typedef struct sample {
    int64_t seed;
    int32_t shape;
    int32_t count;
    union {
        circle circle;
        box box;
    } params;
    double ratio;
    double level; /* within [low, high] only together with the rule below */
    member members[3];
    bool loud;
} sample;

static const char *const sample_orders[] = {"unordered", "fifo", NULL};
static const char *const sample_shapes[] = {"circle", "box", "point", NULL};

static const ll_param wire_rows[] = {
    {.name = "jitter_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(wire, jitter_ms),
     .max = 500,
     .unit = "ms",
     .live = true,
     .help = "Jitter."},
    {.name = "order",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(wire, order),
     .choices = sample_orders,
     .default_value = 1,
     .live = true,
     .help = "Order."},
};
static const ll_param_table wire_table = {
    .name = "wire", .help = "A wire.", .rows = wire_rows, .count = 2, .size = sizeof(wire)};

static const ll_param member_rows[] = {
    {.name = "name",
     .type = LL_PARAM_TEXT,
     .offset = offsetof(member, name),
     .min = 1,
     .max = 8,
     .text = "anna",
     .live = true,
     .help = "Name."},
    {.name = "ready",
     .type = LL_PARAM_BOOL,
     .offset = offsetof(member, ready),
     .default_value = 1,
     .live = true,
     .help = "Ready."},
    {.name = "lag_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(member, lag_ms),
     .max = 1000,
     .default_value = 50,
     .unit = "ms",
     .live = true,
     .required = true,
     .help = "Lag."},
    {.name = "tries",
     .type = LL_PARAM_INT,
     .offset = offsetof(member, tries),
     .min = -2,
     .max = 9,
     .live = true,
     .help = "Tries."},
    {.name = "up",
     .type = LL_PARAM_OBJECT,
     .offset = offsetof(member, up),
     .child = &wire_table,
     .live = true,
     .help = "Up."},
    {.name = "down",
     .type = LL_PARAM_OBJECT,
     .offset = offsetof(member, down),
     .child = &wire_table,
     .help = "Down: not live, with all that is in it."},
};

static inline ll_status member_check(const void *object, const char *path)
{
    const member *m = object;
    char field[64];
    if (m->up.jitter_ms <= m->lag_ms)
        return ll_ok();
    snprintf(field, sizeof field, "%sup.jitter_ms", path);
    return ll_field_error(LL_BAD_INPUT, field, "%s: must be at most the lag", field);
}

static const ll_param_table member_table = {.name = "member",
                                            .help = "A member.",
                                            .rows = member_rows,
                                            .count = 6,
                                            .size = sizeof(member),
                                            .check = member_check};

static const ll_param circle_rows[] = {
    {.name = "radius_m",
     .type = LL_PARAM_REAL,
     .offset = offsetof(circle, radius),
     .max = 10,
     .default_value = 1,
     .unit = "m",
     .live = true,
     .help = "Radius."},
};
static const ll_param_table circle_table = {
    .name = "circle", .help = "A circle.", .rows = circle_rows, .count = 1, .size = sizeof(circle)};

static const ll_param box_rows[] = {
    {.name = "width_m",
     .type = LL_PARAM_REAL,
     .offset = offsetof(box, width),
     .max = 10,
     .default_value = 2,
     .unit = "m",
     .live = true,
     .help = "Width."},
    {.name = "height_m",
     .type = LL_PARAM_REAL,
     .offset = offsetof(box, height),
     .max = 10,
     .default_value = 3,
     .unit = "m",
     .live = true,
     .help = "Height."},
};
static const ll_param_table box_table = {
    .name = "box", .help = "A box.", .rows = box_rows, .count = 2, .size = sizeof(box)};

static const ll_param_table *const sample_variants[] = {&circle_table, &box_table, NULL};

static const ll_param sample_rows[] = {
    {.name = "seed",
     .type = LL_PARAM_INT,
     .offset = offsetof(sample, seed),
     .max = 1e18,
     .default_value = 7,
     .help = "Seed."},
    {.name = "shape",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(sample, shape),
     .choices = sample_shapes,
     .live = true,
     .help = "Shape."},
    {.name = "params",
     .type = LL_PARAM_VARIANT,
     .offset = offsetof(sample, params),
     .variants = sample_variants,
     .count_offset = offsetof(sample, shape),
     .live = true,
     .help = "The shape's own."},
    {.name = "ratio",
     .type = LL_PARAM_REAL,
     .offset = offsetof(sample, ratio),
     .min = -1e308,
     .max = 1e308,
     .live = true,
     .help = "Any number."},
    {.name = "level",
     .type = LL_PARAM_REAL,
     .offset = offsetof(sample, level),
     .min = 0.1,
     .max = 0.9,
     .default_value = 0.3,
     .live = true,
     .help = "Level."},
    {.name = "members",
     .type = LL_PARAM_ARRAY,
     .offset = offsetof(sample, members),
     .min = 1,
     .max = 3,
     .child = &member_table,
     .count_offset = offsetof(sample, count),
     .live = true,
     .required = true,
     .help = "Members."},
    {.name = "loud", .type = LL_PARAM_BOOL, .offset = offsetof(sample, loud), .live = true, .help = "Loud."},
};
static const ll_param_table sample_table = {
    .name = "sample", .help = "A sample.", .rows = sample_rows, .count = 7, .size = sizeof(sample)};

/* Two members with a lag of 10 and 20 ms. */
#define SAMPLE_TWO "{\"members\":[{\"lag_ms\":10},{\"lag_ms\":20,\"name\":\"ben\"}]}"

static inline ll_status sample_parse(const char *text, sample *s)
{
    cJSON *json = cJSON_Parse(text);
    assert_non_null(json);
    ll_status status = ll_param_parse(&sample_table, json, s);
    cJSON_Delete(json);
    return status;
}

static inline void sample_two(sample *s)
{
    ll_param_defaults(&sample_table, s);
    ll_status status = sample_parse(SAMPLE_TWO, s);
    assert_string_equal(status.text, "");
}

static inline void assert_status(ll_status got, ll_code code, const char *field, const char *text)
{
    assert_string_equal(got.text, text);
    assert_string_equal(got.field, field);
    assert_int_equal(got.code, code);
}
