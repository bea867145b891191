/* Operations on a session's clock: one row each. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "session/internal.h"

typedef struct control_args {
    int64_t ticks, tick, until_tick;
    double time_s, speed;
    bool reset, has_tick, has_time;
} control_args;

static ll_status do_pause(ll_session *s, ll_time wall, const control_args *a)
{
    (void)wall;
    (void)a;
    ll_session_pause(s);
    return ll_ok();
}

static ll_status do_play(ll_session *s, ll_time wall, const control_args *a)
{
    if (s->status == LL_SESSION_FAILED)
        return ll_error(LL_CONFLICT, "the session has failed: %s", s->failure.status.text);
    int64_t from = s->tick >= s->end ? 0 : s->tick;
    if (a->until_tick > 0 && (a->until_tick <= from || a->until_tick > s->end))
        return ll_field_error(LL_BAD_INPUT, "until_tick", "until_tick: must be %lld to %lld; got %lld",
                              (long long)from + 1, (long long)s->end, (long long)a->until_tick);
    if (s->tick >= s->end)
        ll_session_move_to(s, 0);
    s->stop_tick = a->until_tick;
    if (s->status != LL_SESSION_PLAYING) {
        s->status = LL_SESSION_PLAYING;
        ll_session_emit_own(s, "play");
    }
    ll_session_set_clock(s, wall);
    return ll_ok();
}

static ll_status begin_seek_to(ll_session *s, int64_t tick)
{
    s->stop_tick = 0;
    ll_session_begin_seek(s, tick < 0 ? 0 : tick > s->end ? s->end : tick);
    return ll_ok();
}

static ll_status do_step(ll_session *s, ll_time wall, const control_args *a)
{
    (void)wall;
    return begin_seek_to(s, s->tick + a->ticks);
}

static ll_status do_seek(ll_session *s, ll_time wall, const control_args *a)
{
    (void)wall;
    if (a->has_tick == a->has_time)
        return ll_field_error(LL_BAD_INPUT, "tick", "seek: must have either tick or time_s");
    int64_t tick = a->has_tick ? a->tick : ll_tick_at((ll_time)llround(a->time_s * 1e9), s->freq);
    if (tick > s->end)
        return ll_field_error(LL_BAD_INPUT, a->has_tick ? "tick" : "time_s",
                              "the scenario ends at tick %lld; got %lld", (long long)s->end, (long long)tick);
    return begin_seek_to(s, tick);
}

static ll_status do_speed(ll_session *s, ll_time wall, const control_args *a)
{
    s->clock.speed = a->speed;
    ll_session_set_clock(s, wall);
    if (s->status == LL_SESSION_PLAYING)
        ll_session_emit_own(s, "play");
    return ll_ok();
}

static ll_status do_restart(ll_session *s, ll_time wall, const control_args *a)
{
    const void *from = a->reset ? s->scenario.config : s->config;
    void *base = ll_param_clone(s->scenario.kind->table, from, NULL);
    if (!base)
        return ll_error(LL_NO_MEMORY, "out of memory: restart");
    ll_status status = ll_session_rebase(s, base);
    free(base);
    if (ll_failed(&status))
        return status;
    s->stop_tick = 0;
    if (a->reset)
        s->clock.speed = 1;
    ll_session_set_clock(s, wall);
    ll_session_emit_restart(s);
    return ll_ok();
}

static const struct {
    const char *name;
    ll_status (*run)(ll_session *s, ll_time wall, const control_args *a);
} operations[] = {
    {"pause", do_pause}, {"play", do_play},   {"step", do_step},
    {"seek", do_seek},   {"speed", do_speed}, {"restart", do_restart},
};

static const ll_param control_rows[] = {
    {LL_PARAM_ROW("ticks", INT, control_args, ticks), .min = -1e9, .max = 1e9, .default_value = 1,
     .unit = "ticks", .help = "Ticks to step; negative: back."},
    {LL_PARAM_ROW("tick", INT, control_args, tick), .max = 1e12, .unit = "ticks", .help = "Tick to seek to."},
    {LL_PARAM_ROW("until_tick", INT, control_args, until_tick), .max = 1e12, .unit = "ticks",
     .help = "Tick at which it pauses; 0: none."},
    {LL_PARAM_ROW("time_s", REAL, control_args, time_s), .max = 1e6, .unit = "s",
     .help = "Virtual time to seek to."},
    {LL_PARAM_ROW("speed", REAL, control_args, speed), .min = 0.1, .max = 10, .default_value = 1,
     .help = "Virtual seconds per second."},
    {LL_PARAM_ROW("reset", BOOL, control_args, reset),
     .help = "Restart with the parameters that the session was created with."},
};

static const ll_param_table control_table = {.name = "control",
                                             .help = "An operation on a session's clock.",
                                             LL_PARAM_ROWS(control_rows, control_args)};

ll_status ll_session_control(ll_session *s, ll_time wall, const cJSON *control)
{
    ll_status status = ll_session_begin_control(s, wall, control);
    if (!ll_failed(&status))
        ll_session_continue(s, INT64_MAX);
    return status;
}

ll_status ll_session_begin_control(ll_session *s, ll_time wall, const cJSON *control)
{
    LL_TRY(ll_session_wake(s));
    const cJSON *op = cJSON_GetObjectItemCaseSensitive(control, "op");
    if (!cJSON_IsString(op))
        return ll_field_error(LL_BAD_INPUT, "op",
                              "op: must be one of pause, play, step, seek, speed, restart");
    control_args args = {0};
    cJSON *rest = cJSON_Duplicate(control, true);
    cJSON_DeleteItemFromObjectCaseSensitive(rest, "op");
    ll_param_defaults(&control_table, &args);
    ll_status status = ll_param_parse(&control_table, rest, &args);
    cJSON_Delete(rest);
    if (ll_failed(&status))
        return status;
    args.has_tick = cJSON_HasObjectItem(control, "tick");
    args.has_time = cJSON_HasObjectItem(control, "time_s");
    for (size_t i = 0; i < sizeof operations / sizeof operations[0]; i++)
        if (strcmp(op->valuestring, operations[i].name) == 0) {
            ll_session_stop_seek(s);
            return operations[i].run(s, wall, &args);
        }
    return ll_field_error(LL_BAD_INPUT, "op",
                          "op: must be one of pause, play, step, seek, speed, restart; got %.20s",
                          op->valuestring);
}
