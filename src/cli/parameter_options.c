#include "cli/parameter_options.h"

#include <stdio.h>
#include <stdlib.h>

enum { NAME_MAX_BYTES = 80 };

static void option_name(const char *row, char *name)
{
    snprintf(name, NAME_MAX_BYTES, "--%s", row);
    for (char *p = name; *p; p++)
        if (*p == '_')
            *p = '-';
}

/* The names are stored after the options. */
ll_option *ll_parameter_options(const ll_parameter_object *objects)
{
    size_t count = 0, next = 0;
    for (const ll_parameter_object *o = objects; o->table; o++)
        count += (size_t)o->table->count;
    ll_option *options = calloc(1, (count + 1) * sizeof *options + count * NAME_MAX_BYTES);
    if (!options)
        return NULL;
    char *names = (char *)(options + count + 1);
    for (const ll_parameter_object *o = objects; o->table; o++) {
        ll_param_defaults(o->table, o->object);
        for (int i = 0; i < o->table->count; i++, next++) {
            const ll_param *row = &o->table->rows[i];
            char *name = names + next * NAME_MAX_BYTES;
            option_name(row->name, name);
            options[next] = (ll_option){.name = name,
                                        .takes = row->type == LL_PARAM_TEXT ? "TEXT" : "N",
                                        .help = row->help,
                                        .table = o->table,
                                        .row = row,
                                        .object = o->object};
        }
    }
    return options;
}

void ll_parameter_options_free(ll_option *options)
{
    free(options);
}
