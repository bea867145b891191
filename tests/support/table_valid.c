#include "support/table_valid.h"

#include <ctype.h>
#include <string.h>

#include "base/status.h"

/* ---- records ---- */

static bool is_name(const char *name)
{
    if (name == NULL || !islower((unsigned char)name[0]))
        return false;
    for (const char *c = name; *c; c++)
        if (!islower((unsigned char)*c) && !isdigit((unsigned char)*c) && *c != '_')
            return false;
    return true;
}

static ll_status record_field_valid(const ll_record *r, const ll_record_field *f)
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

ll_status record_valid(const ll_record *r)
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
        LL_TRY(record_field_valid(r, &r->fields[i]));
    }
    return ll_ok();
}

/* ---- metrics ---- */

static bool is_made_of(const char *name, const char *others)
{
    if (name == NULL)
        return false;
    for (const char *c = name; *c; c++)
        if (!islower((unsigned char)*c) && !isdigit((unsigned char)*c) && !strchr(others, *c))
            return false;
    return true;
}

static bool is_told(const char *text)
{
    return text != NULL && text[0] != '\0';
}

static ll_status metric_field_valid(const ll_metric_table *t, const ll_metric_field *f)
{
    if (!is_made_of(f->name, "_") || !islower((unsigned char)f->name[0]) || !is_told(f->help))
        return ll_field_error(LL_BAD_INPUT, t->path, "a metric needs a name of a-z, 0-9 and _, and help");
    if (f->type >= LL_METRIC_TYPES || ((f->is_signed || f->rare) && f->type > LL_METRIC_COUNT))
        return ll_field_error(LL_BAD_INPUT, f->name, "only a number or a count is signed or rare");
    if ((f->unit != NULL && f->unit[0] == '\0') || (f->null != NULL && f->null[0] == '\0'))
        return ll_field_error(LL_BAD_INPUT, f->name, "no unit and never null are NULL, not empty");
    return ll_ok();
}

/* Whether a table before `last` has the field under the same path. Several may have one only where they
 * are of different scenarios: then they say when. */
static bool stands_twice(const ll_metric_table *const *tables, const ll_metric_table *const *last,
                         const ll_metric_field *field)
{
    const ll_metric_table *own = *last;
    for (; tables != last; tables++)
        for (int i = 0; i < (*tables)->count; i++)
            if (strcmp((*tables)->path, own->path) == 0 &&
                strcmp((*tables)->fields[i].name, field->name) == 0 &&
                ((*tables)->when == NULL || own->when == NULL))
                return true;
    for (const ll_metric_field *f = own->fields; f < field; f++)
        if (strcmp(f->name, field->name) == 0)
            return true;
    return false;
}

ll_status metrics_valid(const ll_metric_table *const *tables)
{
    for (const ll_metric_table *const *t = tables; t != NULL && *t != NULL; t++) {
        if (!is_made_of((*t)->path, "_.*") || !is_told((*t)->help) || (*t)->count < 1)
            return ll_error(LL_BAD_INPUT, "a table of metrics needs a path, help and rows");
        for (int i = 0; i < (*t)->count; i++) {
            LL_TRY(metric_field_valid(*t, &(*t)->fields[i]));
            if (stands_twice(tables, t, &(*t)->fields[i]))
                return ll_field_error(LL_BAD_INPUT, (*t)->fields[i].name, "two metrics of %s have this name",
                                      (*t)->path);
        }
    }
    return ll_ok();
}
