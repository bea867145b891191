#include "daemon/relay/relay.h"

#define ROW(name_, type_) .name = #name_, .type = type_, .offset = offsetof(ll_relay_config, name_)

static const ll_param rows[] = {
    {ROW(of, LL_PARAM_TEXT), .max = 511,
     .help = "Address of the owner: http://HOST:PORT or https://HOST; a daemon or another relay. Required."},
    {ROW(ca_file, LL_PARAM_TEXT), .max = 511,
     .help = "File of certificate authorities for an owner at https; empty: the system's."},
    {ROW(max_streams, LL_PARAM_INT), .min = 1, .max = 100000, .default_value = 1000,
     .help = "Streams that are passed on at a time; viewers of others get a 404."},
    {ROW(max_tunnels, LL_PARAM_INT), .min = 0, .max = 30000, .default_value = 256,
     .help = "Viewers with a connection of their own to the owner: those who send a key or inputs, and those "
             "of classes and experiments."},
    {ROW(linger_s, LL_PARAM_REAL), .min = 0, .max = 3600, .default_value = 10, .unit = "s",
     .help = "Time after which a stream without viewers is no longer read."},
    {ROW(cache_s, LL_PARAM_REAL), .min = 0, .max = 60, .default_value = 1, .unit = "s",
     .help = "Time for which an answer to a GET without a key is given to others too."},
    {ROW(max_answer_mib, LL_PARAM_INT), .min = 1, .max = 4096, .default_value = 64, .unit = "MiB",
     .help = "Largest answer of the owner that is passed on."},
};

const ll_param_table ll_relay_table = {
    .name = "relay",
    .help = "The owner, and limits of what is passed on.",
    .rows = rows,
    .count = sizeof rows / sizeof *rows,
    .size = sizeof(ll_relay_config),
};
