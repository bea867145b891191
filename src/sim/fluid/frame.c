/* What is streamed of fluids: sections 48 to 51 of session/frame.h. */
#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>

#include "sim/fluid/fluid.h"

enum { SECTION_FLUID = 48, SECTION_FIELD, SECTION_POINTS, SECTION_FLOATS };
enum { NO_FLUID = 255, LEVELS = 254, POINT_LAYERS = 2 };

typedef struct fluid_record {
    uint8_t status, held;
    uint16_t numbers;
    uint32_t ticks;
    double numbers_of[LL_FLUID_NUMBERS_MAX];
} fluid_record;

typedef struct layer_record {
    uint8_t layer;
    uint8_t columns;
    uint16_t fluid; /* of those side by side */
    uint32_t width, height, values;
    float low, high;
    /* then the values */
} layer_record;

_Static_assert(offsetof(fluid_record, numbers_of) == 8 && sizeof(layer_record) == 24,
               "the layout of session/frame.h");

static void record_of(const ll_fluid_sim *s, fluid_record *out)
{
    ll_fluid_number all[LL_FLUID_NUMBERS_MAX];
    int count = ll_fluid_sim_numbers(s, all);
    *out = (fluid_record){.status = s->failed != 0,
                          .held = s->held != 0,
                          .numbers = (uint16_t)count,
                          .ticks = (uint32_t)s->ticks};
    for (int i = 0; i < count; i++)
        out->numbers_of[i] = all[i].value;
}

/* ---- layers ---- */

/* The layer of a shape that is `index`th, or the last of them; -1: none. */
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

static uint32_t columns_of(const ll_fluid_layer *layer)
{
    uint32_t n = 0;
    while (layer->columns[n])
        n++;
    return n;
}

/* The head and the values as they are; the caller frees. NULL without memory. */
static float *values_of(const ll_fluid_sim *s, int layer, layer_record *head)
{
    const ll_fluid_method *method = ll_fluid_sim_scene(&s->setup)->method;
    int32_t width, height;
    method->layer_size(ll_fluid_sim_block(s), layer, &width, &height);
    *head = (layer_record){.layer = (uint8_t)layer,
                           .fluid = (uint16_t)s->setup.place,
                           .columns = (uint8_t)columns_of(&method->layers[layer]),
                           .width = (uint32_t)width,
                           .height = (uint32_t)height};
    head->values = head->width * head->height * head->columns;
    float *values = malloc(((size_t)head->values + 1) * sizeof *values);
    if (values)
        method->layer_values(ll_fluid_sim_block(s), layer, values);
    return values;
}

static bool known(float value)
{
    return value - value == 0;
}

/* A byte a cell: LEVELS steps from the least to the most; NO_FLUID where there is no value. The count of
 * values is filled up to eights. */
static uint8_t *field_of(const ll_fluid_sim *s, int layer, layer_record *head)
{
    float *values = values_of(s, layer, head);
    uint32_t cells = head->values;
    head->values = (cells + 7) & ~UINT32_C(7);
    uint8_t *bytes = values ? calloc(sizeof *head + head->values, 1) : NULL;
    if (bytes) {
        bool any = false;
        for (uint32_t i = 0; i < cells; i++)
            if (known(values[i])) {
                head->low = !any || values[i] < head->low ? values[i] : head->low;
                head->high = !any || values[i] > head->high ? values[i] : head->high;
                any = true;
            }
        double range = (double)head->high - (double)head->low, scale = range > 0 ? LEVELS / range : 0;
        for (uint32_t i = 0; i < cells; i++)
            bytes[sizeof *head + i] = known(values[i])
                                          ? (uint8_t)(((double)values[i] - (double)head->low) * scale + 0.5)
                                          : NO_FLUID;
        memcpy(bytes, head, sizeof *head);
    }
    free(values);
    return bytes;
}

/* The values themselves, filled up to pairs; what is not finite is 0. */
static uint8_t *points_of(const ll_fluid_sim *s, int layer, layer_record *head)
{
    float *values = values_of(s, layer, head);
    uint32_t count = head->values;
    head->values = (count + 1) & ~UINT32_C(1);
    uint8_t *bytes = values ? calloc(sizeof *head + head->values * sizeof(float), 1) : NULL;
    for (uint32_t i = 0; bytes && i < count; i++)
        values[i] = known(values[i]) ? values[i] : 0;
    if (bytes) {
        memcpy(bytes, head, sizeof *head);
        memcpy(bytes + sizeof *head, values, count * sizeof(float));
    }
    free(values);
    return bytes;
}

typedef void section_writer(void *context, int type, int count, const void *bytes, size_t size);

static void sections_of(const ll_fluid_sim *s, section_writer *section, void *context)
{
    const ll_fluid_method *method = ll_fluid_sim_scene(&s->setup)->method;
    fluid_record record;
    layer_record head;
    record_of(s, &record);
    section(context, SECTION_FLUID, 1, &record,
            offsetof(fluid_record, numbers_of) + record.numbers * sizeof(double));
    int field = layer_of(method, LL_FLUID_FIELD, s->setup.shown);
    uint8_t *bytes = field >= 0 ? field_of(s, field, &head) : NULL;
    if (bytes)
        section(context, SECTION_FIELD, 1, bytes, sizeof head + head.values);
    free(bytes);
    for (int k = 0, last = -1; k < POINT_LAYERS; k++) {
        int layer = layer_of(method, LL_FLUID_POINTS, k);
        bytes = layer > last ? points_of(s, layer, &head) : NULL;
        if (bytes)
            section(context, SECTION_POINTS + k, 1, bytes, sizeof head + head.values * sizeof(float));
        free(bytes);
        last = layer;
    }
}

void ll_fluid_sim_sections(const void *block,
                           void (*section)(void *context, int type, int count, const void *bytes,
                                           size_t size),
                           void *context)
{
    for (const ll_fluid_sim *s = block; s != NULL; s = ll_fluid_sim_next(s))
        sections_of(s, section, context);
}

/* ---- the same as JSON ---- */

static void add_number(cJSON *object, const char *name, double value)
{
    cJSON_AddItemToObject(object, name, value - value == 0 ? ll_param_number(value) : cJSON_CreateNull());
}

/* In the frame's list of that name, which begins with the first fluid that has such a layer. */
static cJSON *layer_json(cJSON *frame, const char *name, const layer_record *head)
{
    cJSON *list = cJSON_GetObjectItemCaseSensitive(frame, name), *o = cJSON_CreateObject();
    cJSON_AddNumberToObject(o, "fluid", head->fluid);
    cJSON_AddNumberToObject(o, "layer", head->layer);
    cJSON_AddNumberToObject(o, "columns", head->columns);
    cJSON_AddNumberToObject(o, "width", head->width);
    cJSON_AddNumberToObject(o, "height", head->height);
    add_number(o, "low", (double)head->low);
    add_number(o, "high", (double)head->high);
    cJSON_AddItemToArray(list ? list : cJSON_AddArrayToObject(frame, name), o);
    return cJSON_AddArrayToObject(o, "values");
}

static void fluid_json(const ll_fluid_sim *s, cJSON *frame)
{
    static const char *const names[POINT_LAYERS] = {"points", "floats"};
    const ll_fluid_method *method = ll_fluid_sim_scene(&s->setup)->method;
    fluid_record record;
    layer_record head;
    record_of(s, &record);
    cJSON *o = cJSON_CreateObject();
    cJSON_AddNumberToObject(o, "status", record.status);
    cJSON_AddNumberToObject(o, "held", record.held);
    cJSON_AddNumberToObject(o, "ticks", record.ticks);
    cJSON *numbers = cJSON_AddArrayToObject(o, "numbers");
    for (int i = 0; i < record.numbers; i++)
        cJSON_AddItemToArray(numbers, ll_param_number(record.numbers_of[i]));
    cJSON_AddItemToArray(cJSON_GetObjectItemCaseSensitive(frame, "fluid"), o);
    int field = layer_of(method, LL_FLUID_FIELD, s->setup.shown);
    uint8_t *bytes = field >= 0 ? field_of(s, field, &head) : NULL;
    if (bytes) {
        cJSON *values = layer_json(frame, "field", &head);
        for (uint32_t i = 0; i < head.values; i++)
            cJSON_AddItemToArray(values, cJSON_CreateNumber(bytes[sizeof head + i]));
    }
    free(bytes);
    for (int k = 0, last = -1; k < POINT_LAYERS; k++) {
        int layer = layer_of(method, LL_FLUID_POINTS, k);
        bytes = layer > last ? points_of(s, layer, &head) : NULL;
        cJSON *values = bytes ? layer_json(frame, names[k], &head) : NULL;
        for (uint32_t i = 0; values && i < head.values; i++) {
            float value;
            memcpy(&value, bytes + sizeof head + i * sizeof value, sizeof value);
            cJSON_AddItemToArray(values, ll_param_number((double)value));
        }
        free(bytes);
        last = layer;
    }
}

void ll_fluid_sim_sections_json(const void *block, cJSON *frame)
{
    cJSON_AddArrayToObject(frame, "fluid");
    for (const ll_fluid_sim *s = block; s != NULL; s = ll_fluid_sim_next(s))
        fluid_json(s, frame);
}
