#include "cli/output.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

ll_status ll_argument_format(const char *name, const char *out, const ll_format **format)
{
    const char *dot = out ? strrchr(out, '.') : NULL;
    if (!name)
        name = dot && ll_format_find(dot + 1, strlen(dot + 1)) ? dot + 1 : "csv";
    *format = ll_format_find(name, strlen(name));
    if (*format)
        return ll_ok();
    char known[80] = "";
    for (int i = 0; ll_formats[i]; i++)
        snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", i ? ", " : "",
                 ll_formats[i]->name);
    return ll_error(LL_BAD_INPUT, "--format: must be one of %s; got %.40s", known, name);
}

/* Nothing, or a plain file. A device, a pipe or a link stays what it is: its target is written. */
static bool may_be_replaced(const char *path)
{
    struct stat file;
    return lstat(path, &file) != 0 || S_ISREG(file.st_mode);
}

ll_status ll_argument_write(const char *out, const ll_format *format, const ll_table *table)
{
    char temporary[4096];
    if (!out)
        return format->write(table, stdout);
    bool replace = may_be_replaced(out);
    snprintf(temporary, sizeof temporary, "%s%s", out, replace ? ".part" : "");
    FILE *file = fopen(temporary, "wb");
    if (!file)
        return ll_error(LL_IO, "cannot write %.200s", temporary);
    ll_status status = format->write(table, file);
    bool good = fclose(file) == 0;
    if (!ll_failed(&status) && (!good || (replace && rename(temporary, out) != 0)))
        status = ll_error(LL_IO, "cannot write %.200s", out);
    if (ll_failed(&status) && replace)
        unlink(temporary);
    return status;
}

void ll_put_text(ll_cell **cell, const char *text)
{
    *(*cell)++ = (ll_cell){.text = text};
}

void ll_put_number(ll_cell **cell, double value)
{
    *(*cell)++ = (ll_cell){.null = !isfinite(value), .number = value};
}

int ll_print_json(cJSON *json)
{
    char *text = cJSON_Print(json);
    puts(text ? text : "null");
    cJSON_free(text);
    cJSON_Delete(json);
    return 0;
}
