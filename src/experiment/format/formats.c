#include <string.h>

#include "experiment/format/formats.h"

const ll_format *const ll_formats[] = {&ll_format_csv, &ll_format_ndjson, &ll_format_json, &ll_format_sqlite,
                                       NULL};

const ll_format *ll_format_find(const char *name, size_t length)
{
    for (int i = 0; ll_formats[i]; i++)
        if (strncmp(ll_formats[i]->name, name, length) == 0 && ll_formats[i]->name[length] == '\0')
            return ll_formats[i];
    return NULL;
}
