#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "param/param.h"

void ll_number_text(double value, char out[32])
{
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(out, 32, "%.*g", digits, value);
        if (strtod(out, NULL) == value)
            return;
    }
}

/* cJSON takes 15 digits for enough when they come out within a rounding error, and writes those. */
cJSON *ll_param_number(double value)
{
    char text[32];
    snprintf(text, sizeof text, "%.15g", value);
    if (strtod(text, NULL) == value)
        return cJSON_CreateNumber(value);
    ll_number_text(value, text);
    cJSON *item = cJSON_CreateRaw(text);
    if (item != NULL)
        item->valuedouble = value;
    return item;
}

const cJSON *ll_param_number_at(const cJSON *json, const char *path)
{
    char name[64], *end;
    while (json && *path != '\0') {
        size_t length = strcspn(path, ".");
        if (length >= sizeof name)
            return NULL;
        memcpy(name, path, length);
        name[length] = '\0';
        path += length + (path[length] == '.');
        long index = strtol(name, &end, 10);
        json = cJSON_IsArray(json) && end != name && *end == '\0' && index >= 0
                   ? cJSON_GetArrayItem(json, (int)index)
                   : cJSON_GetObjectItemCaseSensitive(json, name);
    }
    return cJSON_IsNumber(json) || cJSON_IsRaw(json) ? json : NULL;
}
