#include "record/integers.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

/* ---- values and integers ---- */

int64_t ll_field_integer(const ll_record_field *f, const void *row)
{
    return ll_integer_of(f, row);
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
        return (double)integer * ll_power_of_2(-f->bits);
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
