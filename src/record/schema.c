#include "record/schema.h"

#include <cjson/cJSON.h>
#include <string.h>

#include "base/hash.h"

static const char *const forms[] = {[LL_FORM_ONE] = "one",
                                    [LL_FORM_BY_INDEX] = "by_index",
                                    [LL_FORM_KEYED] = "keyed",
                                    [LL_FORM_LOG] = "log",
                                    [LL_FORM_GRID] = "grid"};
static const char *const codings[] = {
    [LL_CODE_INT] = "int", [LL_CODE_STEP] = "step", [LL_CODE_REAL] = "real"};

static cJSON *field_json(const ll_record_field *f)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "name", f->name);
    cJSON_AddStringToObject(o, "coding", codings[f->coding]);
    if (f->type == LL_TYPE_BOOL)
        cJSON_AddTrueToObject(o, "boolean");
    if (f->coding != LL_CODE_INT)
        cJSON_AddNumberToObject(o, "bits", f->bits);
    if (f->unit != NULL)
        cJSON_AddStringToObject(o, "unit", f->unit);
    if (f->names != NULL) {
        cJSON *names = cJSON_AddArrayToObject(o, f->flags ? "flags" : "names");
        for (int i = 0; f->names[i]; i++)
            cJSON_AddItemToArray(names, cJSON_CreateString(f->names[i]));
    }
    cJSON_AddStringToObject(o, "help", f->help);
    return o;
}

static cJSON *record_json(const ll_record *r)
{
    cJSON *o = cJSON_CreateObject(), *fields;
    cJSON_AddNumberToObject(o, "id", r->id);
    cJSON_AddStringToObject(o, "name", r->name);
    cJSON_AddStringToObject(o, "channel", ll_channels[r->channel].name);
    cJSON_AddStringToObject(o, "form", forms[r->form]);
    if (r->keys > 0)
        cJSON_AddNumberToObject(o, "keys", r->keys);
    cJSON_AddStringToObject(o, "help", r->help);
    fields = cJSON_AddArrayToObject(o, "fields");
    for (int i = 0; i < r->count; i++)
        cJSON_AddItemToArray(fields, field_json(&r->fields[i]));
    return o;
}

cJSON *ll_record_schema(const ll_record *const *records)
{
    cJSON *o = cJSON_CreateObject(), *list;
    cJSON_AddStringToObject(o, "protocol", "laglab.v2");
    list = cJSON_AddArrayToObject(o, "records");
    for (; *records != NULL; records++)
        cJSON_AddItemToArray(list, record_json(*records));
    return o;
}

uint64_t ll_record_schema_hash(const ll_record *const *records)
{
    cJSON *schema = ll_record_schema(records);
    char *text = cJSON_PrintUnformatted(schema);
    uint64_t hash = text != NULL ? ll_hash(0, text, strlen(text)) : 0;
    cJSON_free(text);
    cJSON_Delete(schema);
    return hash;
}
