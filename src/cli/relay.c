/* The verb `relay`. */
#include "daemon/relay/relay.h"

#include <stdlib.h>

#include "cli/parameter_options.h"
#include "cli/verbs.h"

typedef struct settings {
    ll_relay_config relay;
    ll_web_server_config web_server;
} settings;

#ifndef LAGLAB_CURL

int ll_verb_relay(int argc, char **argv)
{
    (void)argc, (void)argv;
    ll_status missing = ll_error(LL_BAD_INPUT, "relay: this program was built without libcurl");
    return ll_argument_fail(&missing);
}

#else

int ll_verb_relay(int argc, char **argv)
{
    settings *s = calloc(1, sizeof *s);
    const ll_parameter_object objects[] = {
        {&ll_relay_table, s ? &s->relay : NULL}, {&ll_web_server_table, s ? &s->web_server : NULL}, {0}};
    ll_option *options = s ? ll_parameter_options(objects) : NULL;
    ll_status status = options ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: settings");
    LL_THEN(status,
            ll_arguments_one("relay --of URL [OPTION VALUE]...: pass the sessions of another daemon on "
                             "to many viewers.",
                             argc, argv, options, NULL));
    int result = ll_failed(&status) ? ll_argument_fail(&status) : ll_relay(&s->relay, &s->web_server);
    ll_parameter_options_free(options);
    free(s);
    return result;
}

#endif
