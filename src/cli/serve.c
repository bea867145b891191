/* The verb `serve`. */
#include "daemon/serve/serve.h"

#include <stdlib.h>

#include "cli/parameter_options.h"
#include "cli/verbs.h"

int ll_verb_serve(int argc, char **argv)
{
    ll_serve_config *config = calloc(1, sizeof *config);
    const ll_parameter_object objects[] = {{&ll_web_server_table, config ? &config->web_server : NULL},
                                           {&ll_host_table, config ? &config->host : NULL},
                                           {&ll_access_table, config ? &config->access : NULL},
                                           {&ll_classes_table, config ? &config->classes : NULL},
                                           {0}};
    ll_option *options = config ? ll_parameter_options(objects) : NULL;
    ll_status status = options ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: settings");
    LL_THEN(status,
            ll_arguments_one("serve [OPTION VALUE]...: host sessions; page, API and streams on one port.",
                             argc, argv, options, NULL));
    int result = ll_failed(&status) ? ll_argument_fail(&status) : ll_serve(config);
    ll_parameter_options_free(options);
    free(config);
    return result;
}
