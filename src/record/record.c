#include "record/record.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

#include "base/assert.h"

/* ---- values and integers ---- */

static int64_t whole_of(const ll_record_field *f, const char *at)
{
    switch (f->type) {
    case LL_TYPE_BOOL:
        return *(const bool *)at;
    case LL_TYPE_U8:
        return *(const uint8_t *)at;
    case LL_TYPE_U16:
        return *(const uint16_t *)(const void *)at;
    case LL_TYPE_U32:
        return *(const uint32_t *)(const void *)at;
    case LL_TYPE_I32:
        return *(const int32_t *)(const void *)at;
    default:
        LL_ASSERT(f->type == LL_TYPE_I64);
        return *(const int64_t *)(const void *)at;
    }
}

static double real_of(const ll_record_field *f, const char *at)
{
    LL_ASSERT(f->type == LL_TYPE_F32 || f->type == LL_TYPE_F64);
    return f->type == LL_TYPE_F32 ? (double)*(const float *)(const void *)at
                                  : *(const double *)(const void *)at;
}

static int64_t within(int64_t integer)
{
    return integer > LL_INTEGER_MAX ? LL_INTEGER_MAX : integer < -LL_INTEGER_MAX ? -LL_INTEGER_MAX : integer;
}

static double power_of_2(int exponent)
{
    uint64_t bits = (uint64_t)(1023 + exponent) << 52;
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Most fields of a frame are steps: without a branch on the sign, which no processor can predict. */
static int64_t step_of(double value, int bits)
{
    double scaled = value * power_of_2(bits);
    if (fabs(scaled) < (double)LL_INTEGER_MAX)
        return (int64_t)(scaled + copysign(0.5, scaled));
    if (value != value)
        return LL_INTEGER_NONE;
    return value < 0 ? -LL_INTEGER_MAX : LL_INTEGER_MAX;
}

/* The bits of a positive double ascend with its value, exponent before mantissa: rounding to the highest bits
 * rounds to equal relative steps. */
static int64_t real_step_of(double value, int bits)
{
    uint64_t pattern;
    memcpy(&pattern, &value, sizeof pattern);
    pattern &= INT64_MAX; /* clears the sign */
    int drop = 52 - bits;
    int64_t integer = (int64_t)((pattern + (UINT64_C(1) << (drop - 1))) >> drop);
    return value < 0 ? -integer : integer;
}

int64_t ll_field_integer(const ll_record_field *f, const void *row)
{
    const char *at = (const char *)row + f->offset;
    if (f->coding == LL_CODE_INT)
        return within(whole_of(f, at));
    double value = real_of(f, at);
    if (f->coding == LL_CODE_STEP)
        return step_of(value, f->bits);
    if (value != value)
        return LL_INTEGER_NONE;
    if (value - value != 0)
        return value < 0 ? -LL_INTEGER_MAX : LL_INTEGER_MAX;
    return real_step_of(value, f->bits);
}

double ll_field_value(const ll_record_field *f, int64_t integer)
{
    if (f->coding == LL_CODE_INT)
        return (double)integer;
    if (integer == LL_INTEGER_NONE)
        return NAN;
    if (integer == LL_INTEGER_MAX || integer == -LL_INTEGER_MAX)
        return integer < 0 ? -INFINITY : INFINITY;
    if (f->coding == LL_CODE_STEP)
        return (double)integer * power_of_2(-f->bits);
    uint64_t pattern = (uint64_t)(integer < 0 ? -integer : integer) << (52 - f->bits);
    double size;
    memcpy(&size, &pattern, sizeof size);
    return integer < 0 ? -size : size;
}

/* ---- validation ---- */

static bool is_name(const char *name)
{
    if (name == NULL || !islower((unsigned char)name[0]))
        return false;
    for (const char *c = name; *c; c++)
        if (!islower((unsigned char)*c) && !isdigit((unsigned char)*c) && *c != '_')
            return false;
    return true;
}

static ll_status field_valid(const ll_record *r, const ll_record_field *f)
{
    bool real = f->type == LL_TYPE_F32 || f->type == LL_TYPE_F64;
    if (!is_name(f->name) || f->help == NULL || f->help[0] == '\0')
        return ll_field_error(LL_BAD_INPUT, r->name, "a field must have help and a name of a-z, 0-9 and _");
    if (real != (f->coding != LL_CODE_INT))
        return ll_field_error(LL_BAD_INPUT, f->name, "whole numbers must be INT, real ones STEP or REAL");
    if (f->coding == LL_CODE_REAL ? f->bits < 1 || f->bits > 39 : f->bits < 0 || f->bits > 40)
        return ll_field_error(LL_BAD_INPUT, f->name,
                              "bits: must be 1 to 39 for REAL, 0 to 40 for STEP; got %d", f->bits);
    if (f->names != NULL && f->coding != LL_CODE_INT)
        return ll_field_error(LL_BAD_INPUT, f->name, "only whole numbers may have names");
    for (const ll_record_field *other = r->fields; other < f; other++)
        if (strcmp(other->name, f->name) == 0)
            return ll_field_error(LL_BAD_INPUT, f->name, "duplicate field name");
    return ll_ok();
}

ll_status ll_record_valid(const ll_record *r)
{
    if (!is_name(r->name) || r->channel >= LL_CHANNELS || r->help == NULL || r->help[0] == '\0')
        return ll_error(LL_BAD_INPUT, "a record must have a name, a channel and help");
    if (r->count < 1 || r->count > LL_FIELDS_MAX)
        return ll_field_error(LL_BAD_INPUT, r->name, "fields: must be 1 to %d; got %d", LL_FIELDS_MAX,
                              r->count);
    int keys = r->form == LL_FORM_KEYED ? r->keys : r->form == LL_FORM_GRID ? 2 : 0;
    if (r->keys != (r->form == LL_FORM_KEYED ? keys : 0) || keys > LL_KEYS_MAX || keys > r->count)
        return ll_field_error(LL_BAD_INPUT, r->name, "%d keys: invalid for its form and fields", r->keys);
    if (r->form == LL_FORM_KEYED && (keys < 1 || r->count < LL_KEYS_MAX))
        return ll_field_error(LL_BAD_INPUT, r->name, "a KEYED record must have a key and at least %d fields",
                              LL_KEYS_MAX);
    for (int i = 0; i < keys; i++)
        if (r->fields[i].coding != LL_CODE_INT)
            return ll_field_error(LL_BAD_INPUT, r->fields[i].name, "keys and sizes must be whole numbers");
    for (int i = 0; i < r->count; i++) {
        LL_TRY(field_valid(r, &r->fields[i]));
    }
    return ll_ok();
}

const ll_record *ll_record_named(const ll_record *const *records, const char *name)
{
    while (*records != NULL && strcmp((*records)->name, name) != 0)
        records++;
    return *records;
}
