/* The verb `serve`: its options are the daemon's settings, `--name VALUE` with - for _. */
#include "daemon/serve/serve.h"

#include <stdio.h>
#include <stdlib.h>

#include "cli/arguments.h"
#include "cli/verbs.h"

enum { NAME_MAX_BYTES = 80 };

typedef struct setting {
    const ll_param_table *table;
    void *object; /* set to the defaults */
} setting;

static void option_name(const char *row, char *name)
{
    snprintf(name, NAME_MAX_BYTES, "--%s", row);
    for (char *p = name; *p; p++)
        if (*p == '_')
            *p = '-';
}

/* The last of `settings` has no table. The names are stored after the options, which the caller frees. */
static ll_option *options_of(const setting *settings)
{
    size_t count = 0, next = 0;
    for (const setting *s = settings; s->table; s++)
        count += (size_t)s->table->count;
    ll_option *options = calloc(1, (count + 1) * sizeof *options + count * NAME_MAX_BYTES);
    if (!options)
        return NULL;
    char *names = (char *)(options + count + 1);
    for (const setting *s = settings; s->table; s++) {
        ll_param_defaults(s->table, s->object);
        for (int i = 0; i < s->table->count; i++, next++) {
            const ll_param *row = &s->table->rows[i];
            char *name = names + next * NAME_MAX_BYTES;
            option_name(row->name, name);
            options[next] = (ll_option){.name = name,
                                        .takes = row->type == LL_PARAM_TEXT ? "TEXT" : "N",
                                        .help = row->help,
                                        .table = s->table,
                                        .row = row,
                                        .object = s->object};
        }
    }
    return options;
}

int ll_verb_serve(int argc, char **argv)
{
    ll_serve_config *config = calloc(1, sizeof *config);
    const setting settings[] = {{&ll_web_server_table, config ? &config->web_server : NULL},
                                {&ll_host_table, config ? &config->host : NULL},
                                {&ll_access_table, config ? &config->access : NULL},
                                {&ll_classes_table, config ? &config->classes : NULL},
                                {0}};
    ll_option *options = config ? options_of(settings) : NULL;
    ll_status status = options ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: settings");
    LL_THEN(status,
            ll_arguments_one("serve [OPTION VALUE]...: host sessions; page, API and streams on one port.",
                             argc, argv, options, NULL));
    int result = ll_failed(&status) ? ll_argument_fail(&status) : ll_serve(config);
    free(options);
    free(config);
    return result;
}
