/* Messages of a viewer, one per line, to a host whose streams are in this file: every answer must be JSON in
 * UTF-8. */
#include "check.h"

#include "daemon/hosting/host.h"
#include "daemon/support/tasks.h"
#include "session/scenario.h"

#define MESSAGES 20
#define VIEWER 7

static ll_ws_hooks hooks;

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* ---- streams: one viewer ---- */

static void told(const char *text, size_t length)
{
    char *copy = malloc(length + 1);
    FUZZ_CHECK(copy != NULL);
    memcpy(copy, text, length);
    copy[length] = '\0';
    FUZZ_CHECK(strlen(copy) == length && fuzz_is_text(copy));
    cJSON *json = cJSON_ParseWithOpts(copy, NULL, true);
    FUZZ_CHECK(cJSON_IsObject(json) && cJSON_IsString(cJSON_GetObjectItemCaseSensitive(json, "type")));
    cJSON_Delete(json);
    free(copy);
}

void ll_ws_send(ll_ws *ws, ll_ws_viewer viewer, const char *text, size_t length)
{
    (void)ws;
    FUZZ_CHECK(viewer == VIEWER);
    told(text, length);
}

void ll_ws_hello(ll_ws *ws, ll_ws_viewer viewer, const char *text, size_t length)
{
    ll_ws_send(ws, viewer, text, length);
}

void ll_ws_close(ll_ws *ws, ll_ws_viewer viewer, int code, const char *reason)
{
    (void)ws;
    (void)viewer;
    (void)code;
    FUZZ_CHECK(fuzz_is_text(reason));
}

ll_status ll_ws_stream_open(ll_ws *ws, ll_stream_kind kind, const char *id, void *session,
                            ll_ws_stream **stream)
{
    (void)ws;
    (void)kind;
    (void)id;
    *stream = session;
    return ll_ok();
}

void ll_ws_stream_close(ll_ws_stream *stream, int code, const char *reason)
{
    (void)stream;
    (void)code;
    (void)reason;
}

int ll_ws_viewers(const ll_ws_stream *stream)
{
    (void)stream;
    return 1;
}

void ll_ws_wants(ll_ws_stream *stream, uint32_t seq, uint32_t generation, bool whole,
                 ll_record_request *request)
{
    (void)stream;
    (void)seq;
    (void)generation;
    (void)whole;
    *request = (ll_record_request){0};
}

void ll_ws_publish(ll_ws_stream *stream, ll_frame *frame)
{
    (void)stream;
    (void)frame;
}

void ll_ws_subscribe(ll_ws *ws, ll_ws_viewer viewer, const ll_ws_subscription *subscription)
{
    (void)ws;
    (void)viewer;
    (void)subscription;
}

void ll_ws_set_hooks(ll_ws *ws, ll_stream_kind kind, const ll_ws_hooks *given)
{
    (void)ws;
    (void)kind;
    hooks = *given;
}

void ll_ws_flush(ll_ws *ws)
{
    (void)ws;
}

/* For the web server only, which shares code with the host. */
void ll_ws_adopt(ll_ws *ws, const ll_upgrade *upgrade, int fd, const struct ll_connection_limiter_pass *pass)
{
    (void)ws;
    (void)upgrade;
    (void)fd;
    (void)pass;
}

bool ll_ws_knows(ll_ws *ws, const ll_upgrade *upgrade)
{
    (void)ws;
    (void)upgrade;
    return false;
}

/* ---- the host ---- */

static ll_host *host;
static ll_created_session made;
static char key_message[128];

static void start(void)
{
    static const char scenario[] =
        "{\"kind\":\"netgame\",\"game\":\"race\",\"players\":[{},{\"control\":\"person\"}]}";
    ll_host_config config;
    ll_param_defaults(&ll_host_table, &config);
    config.threads = 1;
    config.max_commands_per_s = 1e6;
    ll_tasks *tasks;
    ll_status status = ll_tasks_start(1, &tasks);
    FUZZ_CHECK(!fuzz_failed(&status));
    status = ll_host_create(&config, NULL, tasks, &host);
    FUZZ_CHECK(!fuzz_failed(&status));
    status = ll_host_start(host, NULL);
    FUZZ_CHECK(!fuzz_failed(&status));
    cJSON *json = cJSON_Parse(scenario);
    ll_create_request order = {.scenario = json, .seed = -1, .paused = true, .peer = "192.0.2.1"};
    status = ll_host_create_session(host, &order, &made);
    FUZZ_CHECK(!fuzz_failed(&status));
    cJSON_Delete(json);
    snprintf(key_message, sizeof key_message, "{\"auth\":\"%s\"}", made.owner_key);
}

static void say(const char *text, size_t length)
{
    hooks.message(hooks.context, made.session_entry, VIEWER, text, length);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (host == NULL)
        start();
    hooks.opened(hooks.context, made.session_entry, VIEWER, size % 2 ? LL_FRAME_JSON : LL_FRAME_BINARY);
    const char *at = (const char *)data, *end = at + size;
    for (int i = 0; i < MESSAGES && at < end; i++) {
        const char *newline = memchr(at, '\n', (size_t)(end - at));
        size_t length = (size_t)((newline != NULL ? newline : end) - at);
        if (length == 1 && at[0] == 'k') { /* a fuzzer cannot guess the key */
            say(key_message, strlen(key_message));
        } else {
            char *text = malloc(length + 1); /* NUL-terminated after its length, as from the streams */
            FUZZ_CHECK(text != NULL);
            memcpy(text, at, length);
            text[length] = '\0';
            if (fuzz_is_text(text) && strlen(text) == length) /* the streams pass nothing else */
                say(text, length);
            free(text);
        }
        at += length + 1;
    }
    hooks.closed(hooks.context, made.session_entry, VIEWER);
    return 0;
}
