/* Reading of a session: state, metrics, trace, packets, log. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/api/answer.h"
#include "daemon/api/api.h"
#include "daemon/support/tasks.h"
#include "session/frame.h"
#include "threads/clock.h"

/* An answer is held in memory. */
enum { TRACE_ROWS = 100000 };  /* rows of one answer */
enum { PACKET_TICKS = 50000 }; /* ticks times players whose packets are in one answer: about 40 MB */

/* `fill` writes the answer while the session is locked, or makes a copy and sets how to finish from it. */
typedef struct reader {
    ll_api *api;
    const ll_http_request *request;
    ll_session *copy; /* NULL: the answer is complete */
    const char *type; /* of what is finished from the copy; NULL: JSON */
    int64_t from, to, reserved;
    int interface;           /* of packets */
    const ll_format *format; /* of a trace */
} reader;
typedef ll_status fill(ll_session *session, const ll_http_request *request, ll_http_response *response,
                       reader *r);
typedef ll_status finish(reader *r, ll_task *task,
                         ll_http_response *response); /* reads the copy; the session is not locked */

static ll_status read_or_copy(ll_session_entry *session_entry, const ll_http_request *request,
                              ll_http_response *response, fill *write, reader *r)
{
    ll_session *session;
    ll_status status = ll_session_entry_enter(session_entry, request->task, &session, NULL);
    if (ll_failed(&status))
        return status;
    status = write(session, request, response, r);
    ll_session_entry_leave(session_entry);
    return status;
}

static void reading(ll_api *api, const ll_http_request *request, ll_http_response *response, fill *write,
                    finish *end)
{
    reader r = {.api = api, .request = request};
    ll_session_entry *session_entry = ll_api_session(api, request, response);
    if (!session_entry)
        return;
    ll_status status = read_or_copy(session_entry, request, response, write, &r);
    if (r.copy && request->head) {
        ll_http_no_body(response, r.type ? r.type : "application/json");
        ll_session_destroy(r.copy);
    } else if (r.copy) {
        r.reserved = (int64_t)ll_session_awake_bytes(r.copy);
        status = ll_host_reserve_memory(api->host, r.reserved);
        if (!ll_failed(&status)) {
            status = end(&r, request->task, response);
            ll_host_release_memory(api->host, r.reserved);
        }
        ll_session_destroy(r.copy);
    }
    if (ll_failed(&status)) {
        ll_http_clear(response);
        ll_api_problem(response, request, &status);
    }
    ll_session_entry_release(session_entry);
}

/* A number of the query in [low, high]; unchanged if absent. */
static ll_status query_number(const ll_http_request *request, const char *name, double low, double high,
                              double *value)
{
    const char *text = ll_http_query(request, name);
    if (!text)
        return ll_ok();
    char *end = NULL;
    errno = 0;
    double number = strtod(text, &end);
    if (end == text || *end || !isfinite(number) || number < low || number > high)
        return ll_field_error(LL_BAD_INPUT, name, "%s: must be a number from %g to %g; got `%.40s`.", name,
                              low, high, text);
    *value = number;
    return ll_ok();
}

static ll_status fill_state(ll_session *session, const ll_http_request *request, ll_http_response *response,
                            reader *r)
{
    double tick = -1;
    ll_session_info info = ll_session_get_info(session);
    ll_status status = query_number(request, "tick", 0, (double)info.head_tick, &tick);
    if (!ll_failed(&status) && tick >= 0 && tick != floor(tick))
        status = ll_field_error(LL_BAD_INPUT, "tick", "tick: must be a whole number from 0 to %lld.",
                                (long long)info.head_tick);
    if (ll_failed(&status))
        return status;
    if (tick >= 0 && (int64_t)tick != info.tick) {
        r->to = (int64_t)tick;
        return ll_session_copy(session, r->to, &r->copy);
    }
    cJSON *json = ll_session_state(session);
    ll_http_json(response, 200, json);
    return status;
}

static ll_status finish_state(reader *r, ll_task *task, ll_http_response *response)
{
    ll_interrupt interrupt = ll_task_interrupt(task);
    LL_TRY(ll_session_run_within(r->copy, r->to, &interrupt));
    cJSON *json = ll_session_state(r->copy);
    ll_http_json(response, 200, json);
    return ll_ok();
}

static ll_status fill_hello(ll_session *session, const ll_http_request *request, ll_http_response *response,
                            reader *r)
{
    (void)r;
    char *hello = ll_frame_hello(session, request->parameter[0], LL_FRAME_BINARY);
    if (!hello)
        return ll_error(LL_NO_MEMORY, "Out of memory.");
    ll_http_text(response, 200, hello);
    snprintf(response->type, sizeof response->type, "application/json");
    free(hello);
    return ll_ok();
}

/* The channels of a list of names between commas; without one all. */
static ll_status query_channels(const ll_http_request *request, uint16_t *channels)
{
    const char *text = ll_http_query(request, "channels");
    *channels = text ? 0 : UINT16_MAX;
    while (text) {
        char name[40];
        size_t size = strcspn(text, ",");
        snprintf(name, sizeof name, "%.*s", (int)(size < sizeof name ? size : sizeof name - 1), text);
        ll_channel channel = ll_channel_named(name);
        if (channel == LL_CHANNELS)
            return ll_field_error(LL_BAD_INPUT, "channels", "channels: there is no channel `%s`.", name);
        *channels |= (uint16_t)(1U << channel);
        text = text[size] ? text + size + 1 : NULL;
    }
    return ll_ok();
}

static ll_status fill_frame(ll_session *session, const ll_http_request *request, ll_http_response *response,
                            reader *r)
{
    (void)r;
    double from = -1;
    ll_record_request wanted = {.wall_ns = (uint64_t)ll_now_ns()};
    LL_TRY(query_channels(request, &wanted.channels));
    LL_TRY(query_number(request, "from_event", 0, UINT32_MAX, &from));
    wanted.anew = from < 0;
    wanted.from_event = from < 0 ? LL_NO_EVENT : (int64_t)from;
    ll_buffer bytes = {0};
    ll_status status = ll_frame_write_whole(session, &wanted, &bytes);
    if (!ll_failed(&status)) {
        ll_http_append(response, bytes.bytes, bytes.size);
        snprintf(response->type, sizeof response->type, "application/octet-stream");
    }
    free(bytes.bytes);
    return status;
}

static ll_status fill_metrics(ll_session *session, const ll_http_request *request, ll_http_response *response,
                              reader *r)
{
    (void)request, (void)r;
    cJSON *json = ll_session_metrics(session);
    ll_http_json(response, 200, json);
    return ll_ok();
}

static void append(void *context, const char *text, size_t length)
{
    ll_http_append(context, text, length);
}

/* The ticks from from_s to to_s; without these, all of the log. */
static ll_status query_ticks(const ll_http_request *request, const ll_session_info *info, int64_t *from,
                             int64_t *to)
{
    double log_end_s = (double)info->head / 1e9, from_s = 0, to_s = log_end_s;
    ll_status status = query_number(request, "from_s", 0, 1e9, &from_s);
    LL_THEN(status, query_number(request, "to_s", 0, 1e9, &to_s));
    if (!ll_failed(&status) && from_s > to_s)
        status = ll_field_error(LL_BAD_INPUT, "from_s", "from_s: must be at most to_s; got %g and %g", from_s,
                                to_s);
    if (ll_failed(&status))
        return status;
    *from = ll_tick_at((ll_time)(fmin(from_s, log_end_s) * 1e9 + 0.5), info->tick_freq);
    *to = ll_tick_at((ll_time)(fmin(to_s, log_end_s) * 1e9 + 0.5), info->tick_freq);
    if (*to > info->head_tick)
        *to = info->head_tick;
    return ll_ok();
}

/* Of a table or file of every tick. */
static ll_status at_most(const reader *r, int64_t ticks, const char *of)
{
    if (r->to - r->from < ticks)
        return ll_ok();
    return ll_field_error(LL_BAD_INPUT, "to_s",
                          "from_s to to_s: must be at most %lld ticks%s in one answer; got %lld",
                          (long long)ticks, of, (long long)(r->to - r->from + 1));
}

static ll_status fill_trace(ll_session *session, const ll_http_request *request, ll_http_response *response,
                            reader *r)
{
    ll_session_info info = ll_session_get_info(session);
    ll_trace_request wanted = ll_answer_trace(request, NULL);
    LL_TRY(query_ticks(request, &info, &r->from, &r->to));
    LL_TRY(at_most(r, TRACE_ROWS, ""));
    if (wanted.of)
        LL_TRY(ll_trace_table_check(session, wanted.name, wanted.of));
    r->format = ll_answer_format(request, response);
    r->type = r->format->type;
    return ll_session_copy(session, r->to, &r->copy);
}

/* CSV of ticks; other tables are files. */
static bool is_text(const reader *r, const ll_trace_request *wanted)
{
    return !wanted->of && r->format == ll_formats[0];
}

static ll_status finish_trace(reader *r, ll_task *task, ll_http_response *response)
{
    ll_interrupt interrupt = ll_task_interrupt(task);
    ll_trace_request wanted = ll_answer_trace(r->request, &interrupt);
    ll_trace_table *table = NULL;
    ll_status status;
    wanted.from = r->from;
    wanted.to = r->to;
    ll_http_set_header(response, "Vary", "Accept, Accept-Encoding");
    if (is_text(r, &wanted)) {
        snprintf(response->type, sizeof response->type, "%s", r->type);
        return ll_session_write_trace(r->copy, r->from, r->to, &interrupt, append, response);
    }
    const ll_answer answer = {.type = r->type, .folder = ll_host_get_config(r->api->host)->data};
    FILE *file = ll_answer_open(&answer, &status);
    LL_THEN(status, ll_trace_table_new(r->copy, &wanted, &table));
    LL_THEN(status, r->format->write(ll_trace_table_get(table), file));
    ll_trace_table_free(table);
    ll_answer_send(r->request, response, &answer, &status, file);
    return ll_ok();
}

static ll_status fill_packets(ll_session *session, const ll_http_request *request, ll_http_response *response,
                              reader *r)
{
    (void)response;
    ll_session_info info = ll_session_get_info(session);
    LL_TRY(query_ticks(request, &info, &r->from, &r->to));
    int64_t players = ll_session_players(session);
    char of[40];
    if (players == 0)
        return ll_error(LL_CONFLICT, "packets: the kind must be netgame; got %s", info.kind);
    snprintf(of, sizeof of, " of %lld players", (long long)players);
    LL_TRY(at_most(r, PACKET_TICKS / players, of));
    LL_TRY(ll_session_interface(session, ll_http_query(request, "at"), &r->interface));
    r->type = "application/x-pcapng";
    return ll_session_copy(session, r->to, &r->copy);
}

static ll_status finish_packets(reader *r, ll_task *task, ll_http_response *response)
{
    ll_interrupt interrupt = ll_task_interrupt(task);
    snprintf(response->type, sizeof response->type, "%s", r->type);
    ll_capture_range range = {r->from, r->to, r->interface};
    return ll_session_write_capture(r->copy, &range, &interrupt, append, response);
}

static void append_line(void *context, const char *line, size_t length)
{
    ll_http_append(context, line, length);
    ll_http_append(context, "\n", 1);
}

static ll_status fill_log(ll_session *session, const ll_http_request *request, ll_http_response *response,
                          reader *r)
{
    (void)request, (void)r;
    ll_session_log(session, append_line, response);
    memcpy(response->type, "application/x-ndjson", sizeof "application/x-ndjson");
    return ll_ok();
}

void ll_get_state(void *context, const ll_http_request *request, ll_http_response *response)
{
    reading(context, request, response, fill_state, finish_state);
}

void ll_get_hello(void *context, const ll_http_request *request, ll_http_response *response)
{
    reading(context, request, response, fill_hello, NULL);
}

void ll_get_frame(void *context, const ll_http_request *request, ll_http_response *response)
{
    reading(context, request, response, fill_frame, NULL);
}

void ll_get_metrics(void *context, const ll_http_request *request, ll_http_response *response)
{
    reading(context, request, response, fill_metrics, NULL);
}

void ll_get_trace(void *context, const ll_http_request *request, ll_http_response *response)
{
    if (ll_answer_format(request, response))
        reading(context, request, response, fill_trace, finish_trace);
}

void ll_get_packets(void *context, const ll_http_request *request, ll_http_response *response)
{
    reading(context, request, response, fill_packets, finish_packets);
}

void ll_get_log(void *context, const ll_http_request *request, ll_http_response *response)
{
    reading(context, request, response, fill_log, NULL);
}
