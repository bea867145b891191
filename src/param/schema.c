/* JSON Schema (2020-12) of a table. Rows of the root are in the root, those of nested tables in `$defs`. */
#include <stdio.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "base/assert.h"
#include "param/internal.h"

#define TABLES_MAX 64

/* If memory runs out, that is noted once, and the schema is discarded at the end. */
typedef struct schema {
    cJSON *defs;
    const ll_param_table *tables[TABLES_MAX]; /* those in `defs` */
    char names[TABLES_MAX][48];               /* their names there */
    int count;
    bool failed;
} schema;

static cJSON *add(schema *s, cJSON *object, const char *name, cJSON *item)
{
    if (!cJSON_AddItemToObject(object, name, item)) {
        cJSON_Delete(item);
        s->failed = true;
        return NULL;
    }
    return item;
}

static void add_string(schema *s, cJSON *object, const char *name, const char *text)
{
    if (text != NULL)
        add(s, object, name, cJSON_CreateString(text));
}

static void add_number(schema *s, cJSON *object, const char *name, double value)
{
    add(s, object, name, ll_param_number(value));
}

static void append(schema *s, cJSON *array, cJSON *item)
{
    if (!cJSON_AddItemToArray(array, item)) {
        cJSON_Delete(item);
        s->failed = true;
    }
}

static void describe_object(schema *s, cJSON *node, const ll_param_table *table);

/* Two tables may have the same name (both directions of a link): the second becomes `name_2`. */
static void name_definition(schema *s, int at, const char *name)
{
    int alike = 1;
    for (int i = 0; i < at; i++)
        if (strcmp(s->tables[i]->name, name) == 0)
            alike++;
    if (alike > 1)
        snprintf(s->names[at], sizeof s->names[at], "%s_%d", name, alike);
    else
        snprintf(s->names[at], sizeof s->names[at], "%s", name);
}

static const char *definition_of(schema *s, const ll_param_table *table)
{
    int at = 0;
    while (at < s->count && s->tables[at] != table)
        at++;
    if (at == s->count) {
        LL_ASSERT(s->count < TABLES_MAX);
        s->count++;
        s->tables[at] = table;
        name_definition(s, at, table->name);
        cJSON *node = add(s, s->defs, s->names[at], cJSON_CreateObject());
        describe_object(s, node, table);
    }
    return s->names[at];
}

/* {"$ref":"#/$defs/link"}; an empty object if it takes no parameters */
static void refer(schema *s, cJSON *node, const ll_param_table *table)
{
    if (table == NULL) {
        add_string(s, node, "type", "object");
        add_number(s, node, "maxProperties", 0);
        return;
    }
    char reference[64];
    snprintf(reference, sizeof reference, "#/$defs/%s", definition_of(s, table));
    add_string(s, node, "$ref", reference);
}

static void describe_number(schema *s, cJSON *node, const ll_param *row)
{
    bool whole = row->type == LL_PARAM_INT;
    double limit = whole ? LL_WHOLE_MAX : 1e300;
    double min = row->min < -limit ? -limit : row->min;
    double max = row->max > limit ? limit : row->max;
    add_string(s, node, "type", whole ? "integer" : "number");
    if (min > -1e300)
        add_number(s, node, "minimum", min);
    if (max < 1e300)
        add_number(s, node, "maximum", max);
    if (!row->required)
        add_number(s, node, "default", row->default_value);
}

static void describe_choice(schema *s, cJSON *node, const ll_param *row)
{
    add_string(s, node, "type", "string");
    cJSON *names = add(s, node, "enum", cJSON_CreateArray());
    for (int i = 0; row->choices[i] != NULL; i++)
        append(s, names, cJSON_CreateString(row->choices[i]));
    if (!row->required)
        add_string(s, node, "default", row->choices[(int)row->default_value]);
}

/* The limit is in bytes; in characters, which a schema counts, it is not larger. */
static void describe_text(schema *s, cJSON *node, const ll_param *row)
{
    add_string(s, node, "type", "string");
    if (row->min > 0)
        add_number(s, node, "minLength", 1);
    add_number(s, node, "maxLength", row->max);
    add_string(s, node, "pattern", "^[^\\u0000-\\u001f\\u007f-\\u009f]*$");
    if (!row->required)
        add_string(s, node, "default", row->text == NULL ? "" : row->text);
}

static void describe_array(schema *s, cJSON *node, const ll_param *row)
{
    add_string(s, node, "type", "array");
    add_number(s, node, "minItems", row->min);
    add_number(s, node, "maxItems", row->max);
    cJSON *items = add(s, node, "items", cJSON_CreateObject());
    refer(s, items, row->child);
}

/* [x, y] */
static void describe_pair(schema *s, cJSON *node, double min, double max)
{
    add_string(s, node, "type", "array");
    add_number(s, node, "minItems", 2);
    add_number(s, node, "maxItems", 2);
    cJSON *items = add(s, node, "items", cJSON_CreateObject());
    add_string(s, items, "type", "number");
    add_number(s, items, "minimum", min);
    add_number(s, items, "maximum", max);
}

static void describe_vector(schema *s, cJSON *node, const ll_param *row)
{
    describe_pair(s, node, row->min, row->max);
    if (!row->required)
        add(s, node, "default", cJSON_CreateDoubleArray(row->vector, 2));
}

static void describe_points(schema *s, cJSON *node, const ll_param *row)
{
    add_string(s, node, "type", "array");
    add_number(s, node, "minItems", 0);
    add_number(s, node, "maxItems", row->max);
    describe_pair(s, add(s, node, "items", cJSON_CreateObject()), -row->default_value, row->default_value);
}

static void describe_numbers(schema *s, cJSON *node, const ll_param *row)
{
    add_string(s, node, "type", "array");
    add_number(s, node, "minItems", 0);
    add_number(s, node, "maxItems", row->max);
    cJSON *items = add(s, node, "items", cJSON_CreateObject());
    add_string(s, items, "type", "number");
    add_number(s, items, "minimum", row->vector[0]);
    add_number(s, items, "maximum", row->vector[1]);
}

static const ll_param *choice_of(const ll_param_table *table, const ll_param *variant)
{
    for (int i = 0; i < table->count; i++)
        if (table->rows[i].type == LL_PARAM_CHOICE && table->rows[i].offset == variant->count_offset)
            return &table->rows[i];
    return NULL;
}

static void describe_variant(schema *s, cJSON *node, const ll_param_table *table, const ll_param *row)
{
    const ll_param *choice = choice_of(table, row);
    cJSON *any = add(s, node, "anyOf", cJSON_CreateArray());
    for (int i = 0; choice->choices[i] != NULL; i++) {
        cJSON *branch = cJSON_CreateObject();
        append(s, any, branch);
        if (!s->failed)
            refer(s, branch, row->variants[i]);
    }
}

/* if game is "race" then params are those of the race; those of the default also apply without a game */
static void tie_variant(schema *s, cJSON *all, const ll_param_table *table, const ll_param *row)
{
    const ll_param *choice = choice_of(table, row);
    for (int i = 0; choice->choices[i] != NULL && !s->failed; i++) {
        cJSON *rule = cJSON_CreateObject();
        append(s, all, rule);
        cJSON *condition = add(s, rule, "if", cJSON_CreateObject());
        cJSON *properties = add(s, condition, "properties", cJSON_CreateObject());
        cJSON *named = add(s, properties, choice->name, cJSON_CreateObject());
        add_string(s, named, "const", choice->choices[i]);
        if (i != (int)choice->default_value || choice->required) {
            cJSON *required = add(s, condition, "required", cJSON_CreateArray());
            append(s, required, cJSON_CreateString(choice->name));
        }
        cJSON *conclusion = add(s, rule, "then", cJSON_CreateObject());
        cJSON *then = add(s, conclusion, "properties", cJSON_CreateObject());
        cJSON *params = add(s, then, row->name, cJSON_CreateObject());
        refer(s, params, row->variants[i]);
    }
}

static void describe_row(schema *s, cJSON *node, const ll_param_table *table, const ll_param *row)
{
    switch (row->type) {
    case LL_PARAM_REAL:
    case LL_PARAM_INT:
        describe_number(s, node, row);
        break;
    case LL_PARAM_BOOL:
        add_string(s, node, "type", "boolean");
        if (!row->required)
            add(s, node, "default", cJSON_CreateBool(row->default_value != 0));
        break;
    case LL_PARAM_CHOICE:
        describe_choice(s, node, row);
        break;
    case LL_PARAM_TEXT:
        describe_text(s, node, row);
        break;
    case LL_PARAM_JSON:
        add_string(s, node, "type", "object");
        break;
    case LL_PARAM_VECTOR:
        describe_vector(s, node, row);
        break;
    case LL_PARAM_POINTS:
        describe_points(s, node, row);
        break;
    case LL_PARAM_NUMBERS:
        describe_numbers(s, node, row);
        break;
    case LL_PARAM_OBJECT:
        refer(s, node, row->child);
        break;
    case LL_PARAM_VARIANT:
        describe_variant(s, node, table, row);
        break;
    case LL_PARAM_ARRAY:
        describe_array(s, node, row);
        break;
    }
    add_string(s, node, "description", row->help);
    add_string(s, node, "x-unit", row->unit);
    add(s, node, "x-live", cJSON_CreateBool(row->live));
}

static void describe_object(schema *s, cJSON *node, const ll_param_table *table)
{
    add_string(s, node, "description", table->help);
    add_string(s, node, "type", "object");
    cJSON *properties = add(s, node, "properties", cJSON_CreateObject());
    cJSON *required = cJSON_CreateArray();
    cJSON *all = cJSON_CreateArray();
    for (int i = 0; i < table->count && !s->failed; i++) {
        const ll_param *row = &table->rows[i];
        cJSON *property = add(s, properties, row->name, cJSON_CreateObject());
        describe_row(s, property, table, row);
        if (row->required)
            append(s, required, cJSON_CreateString(row->name));
        if (row->type == LL_PARAM_VARIANT)
            tie_variant(s, all, table, row);
    }
    if (cJSON_GetArraySize(required) > 0)
        add(s, node, "required", required);
    else
        cJSON_Delete(required);
    if (cJSON_GetArraySize(all) > 0)
        add(s, node, "allOf", all);
    else
        cJSON_Delete(all);
    add(s, node, "additionalProperties", cJSON_CreateBool(false));
}

cJSON *ll_param_schema(const ll_param_table *table)
{
    schema s = {.defs = cJSON_CreateObject()};
    cJSON *root = cJSON_CreateObject();
    add_string(&s, root, "$schema", "https://json-schema.org/draft/2020-12/schema");
    add_string(&s, root, "title", table->name);
    describe_object(&s, root, table);
    add(&s, root, "$defs", s.defs);
    if (s.failed) {
        cJSON_Delete(root);
        return NULL;
    }
    return root;
}

void ll_param_schema_part(cJSON *part, cJSON *defs)
{
    cJSON *own = cJSON_DetachItemFromObject(part, "$defs"), *def;
    while ((def = cJSON_DetachItemFromArray(own, 0)) != NULL)
        if (cJSON_GetObjectItemCaseSensitive(defs, def->string)) {
            LL_ASSERT(cJSON_Compare(cJSON_GetObjectItemCaseSensitive(defs, def->string), def, true));
            cJSON_Delete(def);
        } else {
            cJSON_AddItemToArray(defs, def); /* the item keeps its name */
        }
    cJSON_Delete(own);
    cJSON_DeleteItemFromObject(part, "$schema");
}
