/* Validity of a table: author's mistakes that no compiler sees. */
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "param/internal.h"

static bool is_name(const char *name)
{
    if (name == NULL || name[0] < 'a' || name[0] > 'z')
        return false;
    return name[strspn(name, "abcdefghijklmnopqrstuvwxyz0123456789_")] == '\0';
}

static int choices_of(const ll_param *row)
{
    int count = 0;
    while (row->choices != NULL && row->choices[count] != NULL)
        count++;
    return count;
}

/* The row that a VARIANT depends on: it must come earlier. */
static const ll_param *choice_before(const ll_param_table *table, int variant)
{
    for (int i = 0; i < variant; i++)
        if (table->rows[i].type == LL_PARAM_CHOICE &&
            table->rows[i].offset == table->rows[variant].count_offset)
            return &table->rows[i];
    return NULL;
}

static size_t largest_variant(const ll_param *row, int choices)
{
    size_t size = 0;
    for (int i = 0; i < choices; i++)
        if (row->variants[i] != NULL && row->variants[i]->size > size)
            size = row->variants[i]->size;
    return size;
}

/* Bytes of the row's member; 0 for an invalid row. */
static size_t size_of(const ll_param_table *table, int i)
{
    const ll_param *row = &table->rows[i];
    switch (row->type) {
    case LL_PARAM_REAL:
        return sizeof(double);
    case LL_PARAM_INT:
        return sizeof(int64_t);
    case LL_PARAM_BOOL:
        return sizeof(bool);
    case LL_PARAM_CHOICE:
        return sizeof(int32_t);
    case LL_PARAM_TEXT:
    case LL_PARAM_JSON:
        return (size_t)row->max + 1;
    case LL_PARAM_VECTOR:
        return 2 * sizeof(double);
    case LL_PARAM_POINTS:
        return (size_t)row->max * 2 * sizeof(double);
    case LL_PARAM_NUMBERS:
        return (size_t)row->max * sizeof(double);
    case LL_PARAM_OBJECT:
        return row->child == NULL ? 0 : row->child->size;
    case LL_PARAM_VARIANT: {
        const ll_param *choice = choice_before(table, i);
        return choice == NULL || row->variants == NULL ? 0 : largest_variant(row, choices_of(choice));
    }
    case LL_PARAM_ARRAY:
        return row->child == NULL || row->max < 1 ? 0 : (size_t)row->max * row->child->size;
    }
    return 0;
}

static const char *fault_of_value(const ll_param *row)
{
    bool whole = (double)(int64_t)row->default_value == row->default_value;
    bool within = row->default_value >= row->min && row->default_value <= row->max;
    switch (row->type) {
    case LL_PARAM_REAL:
    case LL_PARAM_INT:
        if (!(row->min <= row->max) || row->max - row->max != 0 || row->min - row->min != 0)
            return "has no range";
        if (!within && !row->required)
            return "has a default out of range";
        return row->type == LL_PARAM_INT && !whole ? "has a default that is not whole" : NULL;
    case LL_PARAM_CHOICE:
        if (choices_of(row) == 0)
            return "has no choices";
        return !whole || row->default_value < 0 || row->default_value >= choices_of(row)
                   ? "has no such default"
                   : NULL;
    case LL_PARAM_TEXT: {
        double length = row->text == NULL ? 0 : (double)strlen(row->text);
        if (row->max < 1)
            return "has no length";
        return length > row->max || (length < row->min && !row->required)
                   ? "has a default of the wrong length"
                   : NULL;
    }
    case LL_PARAM_JSON:
        return row->max < 2 ? "has no length" : NULL;
    case LL_PARAM_VECTOR:
        if (!(row->min <= row->max) || row->max - row->max != 0 || row->min - row->min != 0)
            return "has no range";
        return row->vector[0] < row->min || row->vector[0] > row->max || row->vector[1] < row->min ||
                       row->vector[1] > row->max
                   ? "has a default out of range"
                   : NULL;
    case LL_PARAM_POINTS:
        return row->max < 1 || row->max > LL_POINTS_MAX || !(row->default_value > 0)
                   ? "has no room or no range"
                   : NULL;
    case LL_PARAM_NUMBERS:
        return row->max < 1 || !(row->vector[0] < row->vector[1]) ? "has no room or no range" : NULL;
    default:
        return NULL;
    }
}

/* Whether the choices that other values depend on are equal in two structs. */
static bool same_governing(const ll_param_table *table, const char *a, const char *b)
{
    for (int i = 0; i < table->count; i++) {
        const ll_param *row = &table->rows[i];
        const char *in_a = a + row->offset, *in_b = b + row->offset;
        if (ll_row_governs(table, row) && memcmp(in_a, in_b, sizeof(int32_t)) != 0)
            return false;
        if (row->type == LL_PARAM_OBJECT && !same_governing(row->child, in_a, in_b))
            return false;
    }
    return true;
}

/* Whether a struct reads back as the same from what is written of it, and so is in range and obeys the
 * rules. */
static bool reads_back(const ll_param_table *table, const char *object)
{
    char *again = calloc(1, table->size);
    cJSON *json = ll_param_write(table, object);
    bool same = false;
    if (again != NULL && json != NULL) {
        ll_param_defaults(table, again);
        ll_status status = ll_param_parse(table, json, again);
        same = !ll_failed(&status) && memcmp(again, object, table->size) == 0;
    }
    cJSON_Delete(json);
    free(again);
    return same;
}

/* `before` has the choice and defaults otherwise, `after` the result. */
static const char *fault_of_choice(const ll_param_table *table, int i, int choice, char *before, char *after)
{
    ll_param_defaults(table, before);
    memcpy(before + table->rows[i].offset, &(int32_t){choice}, sizeof(int32_t));
    memcpy(after, before, table->size);
    table->rows[i].chosen(after, choice);
    if (choice == (int)table->rows[i].default_value && memcmp(after, before, table->size) != 0)
        return "has a default that changes something";
    for (int k = 0; k <= i; k++)
        if (memcmp(after + table->rows[k].offset, before + table->rows[k].offset, size_of(table, k)) != 0)
            return "changes a row that does not stand after it";
    if (!same_governing(table, before, after))
        return "changes a choice that others depend on";
    return reads_back(table, after) ? NULL : "has a choice whose values do not read back";
}

static const char *fault_of_chosen(const ll_param_table *table, int i)
{
    const ll_param *row = &table->rows[i];
    const char *fault = NULL;
    if (row->chosen == NULL)
        return NULL;
    if (row->type != LL_PARAM_CHOICE)
        return "is no choice that could be chosen";
    char *structs = calloc(2, table->size);
    if (structs == NULL)
        return "could not be tried: out of memory";
    for (int choice = 0; row->choices[choice] != NULL && fault == NULL; choice++)
        fault = fault_of_choice(table, i, choice, structs, structs + table->size);
    free(structs);
    return fault;
}

static const char *fault_of(const ll_param_table *table, int i)
{
    const ll_param *row = &table->rows[i];
    if (!is_name(row->name))
        return "has no name of a-z, 0-9 and _";
    if (ll_row_named(table, row->name, strlen(row->name)) != row)
        return "has the name of another row";
    if (row->help == NULL || row->help[0] == '\0')
        return "has no help";
    const char *fault = fault_of_value(row);
    if (fault != NULL)
        return fault;
    size_t size = size_of(table, i);
    if (size == 0)
        return "lacks a table, or the choice before it";
    bool counted = row->type == LL_PARAM_ARRAY || row->type == LL_PARAM_VARIANT ||
                   row->type == LL_PARAM_POINTS || row->type == LL_PARAM_NUMBERS;
    if (row->offset + size > table->size || (counted && row->count_offset + sizeof(int32_t) > table->size))
        return "lies beyond its struct";
    return NULL;
}

static ll_status valid_below(const ll_param_table *table, int i)
{
    const ll_param *row = &table->rows[i];
    ll_status status = ll_ok();
    if (row->type == LL_PARAM_OBJECT || row->type == LL_PARAM_ARRAY)
        return ll_param_table_valid(row->child);
    if (row->type != LL_PARAM_VARIANT)
        return status;
    int count = choices_of(choice_before(table, i));
    for (int v = 0; v < count && !ll_failed(&status); v++)
        if (row->variants[v] != NULL)
            status = ll_param_table_valid(row->variants[v]);
    return status;
}

static ll_status faulty_row(const ll_param_table *table, int i, const char *fault)
{
    const char *name = table->rows[i].name == NULL ? "" : table->rows[i].name;
    return ll_field_error(LL_BAD_INPUT, name, "row %d (%s) of %s %s", i, name, table->name, fault);
}

ll_status ll_param_table_valid(const ll_param_table *table)
{
    if (!is_name(table->name))
        return ll_error(LL_BAD_INPUT, "a table has no name");
    if (table->count > LL_ROWS_MAX)
        return ll_error(LL_BAD_INPUT, "%s has more than %d rows", table->name, LL_ROWS_MAX);
    ll_status status = ll_ok();
    for (int i = 0; i < table->count && !ll_failed(&status); i++) {
        const char *fault = fault_of(table, i);
        if (fault != NULL)
            return faulty_row(table, i, fault);
        status = valid_below(table, i);
    }
    for (int i = 0; i < table->count && !ll_failed(&status); i++) { /* it needs valid rows */
        const char *fault = fault_of_chosen(table, i);
        if (fault != NULL)
            status = faulty_row(table, i, fault);
    }
    return status;
}
