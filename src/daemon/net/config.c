#include "daemon/net/config.h"

#define TEXT(name_, default_, help_)                                                                         \
    {                                                                                                        \
        .name = #name_, .type = LL_PARAM_TEXT, .offset = offsetof(ll_web_server_config, name_),              \
        .max = sizeof(((ll_web_server_config *)0)->name_) - 1, .text = default_, .help = help_               \
    }
#define COUNT(name_, min_, max_, default_, unit_, help_)                                                     \
    {                                                                                                        \
        .name = #name_, .type = LL_PARAM_INT, .offset = offsetof(ll_web_server_config, name_), .min = min_,  \
        .max = max_, .default_value = default_, .unit = unit_, .help = help_                                 \
    }
#define REAL(name_, min_, max_, default_, unit_, help_)                                                      \
    {                                                                                                        \
        .name = #name_, .type = LL_PARAM_REAL, .offset = offsetof(ll_web_server_config, name_), .min = min_, \
        .max = max_, .default_value = default_, .unit = unit_, .help = help_                                 \
    }

static const ll_param rows[] = {
    TEXT(listen, "127.0.0.1:8080", "Address and port, ADDR:PORT or [ADDR6]:PORT; port 0: any free port."),
    TEXT(www, "", "Folder of the page, read at the start; empty: `www` next to the program."),
    TEXT(allow_origin, "", "Other origins whose pages may use the daemon, comma separated."),
    TEXT(allow_embed, "", "Origins whose pages may show the page of ?embed=1 in a frame, comma separated."),
    TEXT(allow_host, "", "Host names of the daemon other than localhost and addresses, comma separated."),
    TEXT(trusted_proxy, "",
         "Addresses or networks of trusted proxies, comma separated: their X-Forwarded-For names the client, "
         "which then has limits of its own."),
    COUNT(http_threads, 1, 16, 2, NULL, "Threads that read requests and run fast handlers."),
    COUNT(control_threads, 1, 64, 4, NULL,
          "Threads for short requests that wait until their change is stored."),
    REAL(request_cpu_s, 0.01, 86400, 20, "s",
         "Processor time of one request; beyond it the answer is 503 with the progress so far."),
    COUNT(stream_threads, 1, 16, 1, NULL, "Threads that send frames; a session's viewers share one."),
    COUNT(max_connections, 16, 30000, 4096, NULL, "Concurrent connections of every kind; more get a 503."),
    COUNT(max_connections_per_ip, 4, 30000, 2048, NULL,
          "Concurrent connections of one address; more get a 429."),
    COUNT(max_viewers, 1, 30000, 1000, NULL, "Viewers of one session; more are closed with 4429."),
    COUNT(max_head_bytes, 1024, 65536, 16384, "B", "Size of a request head; larger ones get a 431."),
    COUNT(max_answers_mib, 1, 1048576, 256, "MiB",
          "Memory of large answers (above 64 KiB) being sent; more get a 503."),
    REAL(head_timeout_s, 0.1, 60, 5, "s", "Time to receive a whole request head; then a 408."),
    REAL(body_timeout_s, 0.1, 600, 30, "s",
         "Time to receive a whole request body; then the connection is cut."),
    REAL(idle_timeout_s, 0.1, 3600, 65, "s", "Time between two requests of a connection; then it is closed."),
    REAL(response_timeout_s, 1, 3600, 300, "s", "Time to send a whole response; then the connection is cut."),
    COUNT(max_message_bytes, 256, 1048576, 65536, "B",
          "Size of a viewer's message; larger ones are closed with 1009."),
    REAL(max_messages_per_s, 1, 100000, 300, "1/s",
         "Messages of one viewer, acks included, sustained; twice that in a burst; more are closed with "
         "1008."),
    REAL(hello_timeout_s, 0.1, 600, 20, "s",
         "Time until a session sends a viewer its hello message; then it is closed with 1013."),
    REAL(ack_timeout_s, 0.1, 600, 5, "s",
         "Time without acknowledgements of a viewer that acknowledged before; then it is closed with 1013."),
    REAL(drain_s, 0, 60, 3, "s", "Time for viewers to close their connections when the daemon stops."),
};

const ll_param_table ll_web_server_table = {
    .name = "web_server",
    .help = "The port of the daemon and its limits.",
    .rows = rows,
    .count = sizeof rows / sizeof *rows,
    .size = sizeof(ll_web_server_config),
};
