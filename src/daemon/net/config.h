/* Settings of the web server: HTTP and streams. */
#pragma once

#include "param/param.h"

/* Every setting is a row of ll_web_server_table: `max_connections` is `--max-connections` on the command
 * line. */
typedef struct ll_web_server_config {
    char listen[128];         /* ADDR:PORT, [ADDR6]:PORT; port 0: any free port */
    char www[512];            /* folder of the page */
    char allow_origin[1024];  /* comma separated: https://lab.example */
    char allow_embed[1024];   /* comma separated: https://course.example */
    char allow_host[1024];    /* comma separated: lab.example */
    char trusted_proxy[1024]; /* comma separated: 10.0.0.0/8 */
    int64_t http_threads;     /* that read requests and run fast handlers */
    int64_t control_threads;  /* that run handlers of LL_HTTP_POOL */
    double request_cpu_s;     /* processor time of one request */
    int64_t stream_threads;   /* that send frames */
    int64_t max_connections;
    int64_t max_connections_per_ip;
    int64_t max_viewers; /* of one session */
    int64_t max_head_bytes;
    int64_t max_answers_mib;   /* of large answers being sent */
    double head_timeout_s;     /* absolute, for a whole request head */
    double body_timeout_s;     /* absolute, for a whole request body */
    double idle_timeout_s;     /* of a kept connection between requests */
    double response_timeout_s; /* absolute, for a whole response */
    int64_t max_message_bytes; /* of a viewer's message */
    double max_messages_per_s; /* of one viewer, sustained; twice that in a burst */
    double hello_timeout_s;    /* until hosting sends a hello; then the viewer is closed */
    double ack_timeout_s;      /* without acks, of a viewer that acknowledged before */
    double drain_s;            /* at the end: time for viewers to close */
} ll_web_server_config;

extern const ll_param_table ll_web_server_table;
