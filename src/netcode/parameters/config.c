#include "netcode/protocol/config.h"

#include <stdio.h>

#include "game/core/game.h"
#include "link/line/presets.h"
#include "netcode/client/ack.h"
#include "netcode/client/scope.h"
#include "netcode/peer/float_mode.h"
#include "netcode/protocol/clock_sync.h"
#include "netcode/protocol/sync.h"
#include "netcode/server/starve.h"
#include "netcode/snapshot/snapshot.h"
#include "netcode/view/view.h"

static const char *const controls[] = {"script", "person", NULL};
static const char *const corrections[] = {"snap", "smooth", NULL};
static const char *const extrapolation_clocks[] = {"measured", "arrival", NULL};
static const char *const refusals[] = {"neutral", "previous", NULL};
static const char *const cheats[] = {"none",      "magnitude", "rate",     "budget",     "view_time",
                                     "fire_rate", "claim",     "teleport", "lag_switch", NULL};

static const ll_param server_rows[] = {
    {.name = "update_hz",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_server_config, update_hz),
     .min = 1,
     .max = 128,
     .default_value = 30,
     .unit = "Hz",
     .live = true,
     .help = "How often the server sends to every client: its state, or with deterministic and rollback the "
             "others' inputs; in lockstep also how often it steps."},
    {.name = "sync",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_server_config, sync),
     .choices = ll_sync_mode_names,
     .live = true,
     .help =
         "How server and clients keep in step: free runs on its own clock; in lockstep every client sends an "
         "input and waits for the state, in lockstep_pipelined it does not wait but the server does; "
         "gambetta drains its queue as the live demo does; with deterministic and rollback only inputs "
         "travel "
         "and every client steps its own world."},
    {.name = "timeout_s",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_server_config, timeout_s),
     .max = 600,
     .default_value = 5,
     .unit = "s",
     .live = true,
     .help =
         "Who was not heard for so long is disconnected, on both sides, and joins again when it can; 0 waits "
         "for ever."},
    {.name = "validation",
     .type = LL_PARAM_BOOL,
     .offset = offsetof(ll_server_config, validation),
     .default_value = 1,
     .live = true,
     .help = "The server refuses inputs that are too large, too many, or of more time than has passed. Off, "
             "it takes "
             "everything, so that one sees what a cheat brings."},
    {.name = "refused",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_server_config, refused),
     .choices = refusals,
     .live = true,
     .help =
         "What stands in for a refused input: neutral is no control touched, previous the input before it, "
         "which a cheat can make use of."},
    {.name = "starved",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_server_config, starved),
     .choices = ll_starve_names,
     .live = true,
     .help =
         "What stands in under free for an input that has not come for its step: decay lets the axes of the "
         "last applied one go to zero in starved_tau_ms, repeat keeps them, repeat_n keeps them for "
         "starved_ticks, neutral is zero at once. Presses are never repeated."},
    {.name = "starved_tau_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_server_config, starved_tau_ms),
     .min = 1,
     .max = 10000,
     .default_value = 250,
     .unit = "ms",
     .live = true,
     .help = "In this time decay lets the axes go to zero."},
    {.name = "starved_ticks",
     .type = LL_PARAM_INT,
     .offset = offsetof(ll_server_config, starved_ticks),
     .max = 1000,
     .default_value = 12,
     .unit = "ticks",
     .live = true,
     .help = "So long repeat_n repeats."},
    {.name = "hitscan",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_server_config, compensation.rifle),
     .choices = ll_rifle_names,
     .default_value = 1,
     .live = true,
     .help = "How shots of a rifle are judged: none against the server's present, rewind against the targets "
             "where the shooter saw them, trust as the client says (insecure)."},
    {.name = "projectile",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_server_config, compensation.shell),
     .choices = ll_shell_names,
     .default_value = 2,
     .live = true,
     .help =
         "How shells are judged: none (A) starts them at the server's present, fast_forward (B) puts them "
         "where the shooter has them, among the targets of the present, rewind (C) lets shell and targets go "
         "together from the time that the shooter saw, partial (D) forwards by at most "
         "projectile_forward_ms, "
         "trust takes the client's word (insecure)."},
    {.name = "projectile_trace",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_server_config, compensation.projectile_trace),
     .choices = ll_trace_names,
     .live = true,
     .help =
         "How a stretch of a shell's way is tested: along the parabola, or along the straight line between "
         "its ends."},
    {.name = "max_rewind_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_server_config, compensation.max_rewind_ms),
     .max = 1000,
     .default_value = 250,
     .unit = "ms",
     .live = true,
     .help = "The server looks no further back, however old the shooter's view was."},
    {.name = "rewind_tolerance_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_server_config, compensation.rewind_tolerance_ms),
     .max = 10000,
     .default_value = 200,
     .unit = "ms",
     .live = true,
     .help =
         "A client draws its newest state, whose age the server measures, or up to two updates before it. "
         "When the age of view that it states is more than this beyond, the measured one counts."},
    {.name = "projectile_forward_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_server_config, compensation.projectile_forward_ms),
     .max = 1000,
     .default_value = 100,
     .unit = "ms",
     .live = true,
     .help = "The most that the shell family partial forwards."},
    {.name = "snapshot_encoding",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_server_config, snapshot),
     .choices = ll_codec_names,
     .live = true,
     .help = "How a state travels: full as it lies in memory, quantised on a grid, delta as what differs on "
             "that grid "
             "from the newest state that the client has acknowledged (of the last 32)."},
    {.name = "quantum_m",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_server_config, quantum_m),
     .min = 0.0001,
     .max = 10,
     .default_value = 0.002,
     .unit = "m",
     .live = true,
     .help =
         "Step of the grid for positions: what is sent of the others is at most half of it off per axis."},
    {.name = "quantum_mps",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_server_config, quantum_mps),
     .min = 0.0001,
     .max = 10,
     .default_value = 0.02,
     .unit = "m/s",
     .live = true,
     .help = "Step of the grid for velocities."},
    {.name = "quantum_rad",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_server_config, quantum_rad),
     .min = 0.0001,
     .max = 1,
     .default_value = 0.005,
     .unit = "rad",
     .live = true,
     .help = "Step of the grid for angles."},
    {.name = "quantum_radps",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_server_config, quantum_radps),
     .min = 0.0001,
     .max = 10,
     .default_value = 0.05,
     .unit = "rad/s",
     .live = true,
     .help = "Step of the grid for spins."},
    {.name = "max_rollback_ticks",
     .type = LL_PARAM_INT,
     .offset = offsetof(ll_server_config, max_rollback_ticks),
     .max = LL_ROLLBACK_MAX,
     .default_value = 8,
     .unit = "ticks",
     .live = true,
     .help = "Rollback: how far a client steps on by guessed inputs before it waits."},
    {.name = "sync_test_ticks",
     .type = LL_PARAM_INT,
     .offset = offsetof(ll_server_config, sync_test_ticks),
     .max = LL_SYNC_TEST_MAX,
     .unit = "ticks",
     .live = true,
     .help = "Deterministic and rollback: every frame a client goes back so far, steps again and compares; 0 "
             "is off."},
};

const ll_param_table ll_server_table = {.name = "server",
                                        .help = "The authoritative server.",
                                        .rows = server_rows,
                                        .count = sizeof server_rows / sizeof server_rows[0],
                                        .size = sizeof(ll_server_config)};

static void choose_preset(void *object, int preset)
{
    ll_link_pair *pair = object;
    ll_link_preset_apply(preset, &pair->up, &pair->down);
}

static const ll_param link_rows[] = {
    {.name = "preset",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_link_pair, preset),
     .choices = ll_link_preset_names,
     .live = true,
     .chosen = choose_preset,
     .help =
         "A named kind of link: sets every row of both directions, before those that are given beside it. "
         "custom sets none."},
    {.name = "up",
     .type = LL_PARAM_OBJECT,
     .offset = offsetof(ll_link_pair, up),
     .child = &ll_link_table,
     .live = true,
     .help = "From the client to the server."},
    {.name = "down",
     .type = LL_PARAM_OBJECT,
     .offset = offsetof(ll_link_pair, down),
     .child = &ll_link_table,
     .live = true,
     .help = "From the server to the client."},
};

static const ll_param_table link_table = {.name = "link_pair",
                                          .help = "A player's link, per direction.",
                                          .rows = link_rows,
                                          .count = sizeof link_rows / sizeof link_rows[0],
                                          .size = sizeof(ll_link_pair)};

static const ll_param player_rows[] = {
    {.name = "name",
     .type = LL_PARAM_TEXT,
     .offset = offsetof(ll_player_config, name),
     .max = LL_NAME_MAX,
     .help = "Shown in the views; A, B, ... when empty."},
    {.name = "lag_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_player_config, lag_ms),
     .max = 1000,
     .unit = "ms",
     .live = true,
     .help = "One-way delay, in both directions: the round trip takes twice as long."},
    {.name = "link",
     .type = LL_PARAM_OBJECT,
     .offset = offsetof(ll_player_config, link),
     .child = &link_table,
     .live = true,
     .help = "Impairments of each direction."},
    {.name = "prediction",
     .type = LL_PARAM_BOOL,
     .offset = offsetof(ll_player_config, prediction),
     .live = true,
     .help = "The client moves its own entity by its own inputs at once."},
    {.name = "prediction_scope",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_player_config, prediction_scope),
     .choices = ll_prediction_scope_names,
     .live = true,
     .help = "What the client predicts: its own entity, also whatever may touch it, or the whole world; "
             "others by "
             "what their controls were when last heard of."},
    {.name = "reconciliation",
     .type = LL_PARAM_BOOL,
     .offset = offsetof(ll_player_config, reconciliation),
     .live = true,
     .help = "The client takes the server's state and applies the inputs again that the server has not seen; "
             "needs "
             "prediction."},
    {.name = "reconciliation_tolerance_m",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_player_config, reconciliation_tolerance_m),
     .max = 10,
     .unit = "m",
     .live = true,
     .help =
         "The prediction stands while all that it is about is no further from the server's state, now and "
         "by its velocity until the next state; 0 demands equality to the bit, and of others on a grid "
         "what rounding explains."},
    {.name = "ack",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_player_config, ack),
     .choices = ll_ack_names,
     .live = true,
     .help =
         "How the client learns what was applied: high_water takes all inputs up to a number as applied, "
         "per_input has a bit for each, so that one that was lost, late or refused is known to be skipped."},
    {.name = "interpolation",
     .type = LL_PARAM_BOOL,
     .offset = offsetof(ll_player_config, interpolation),
     .live = true,
     .help = "Other entities are drawn in the past, between two states of the server."},
    {.name = "interpolation_ratio",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_player_config, interpolation_ratio),
     .min = 1,
     .max = 4,
     .default_value = 2,
     .live = true,
     .help = "Interpolation delay in update intervals; 2 survives one lost update."},
    {.name = "jitter_margin_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_player_config, jitter_margin_ms),
     .max = 500,
     .default_value = 10,
     .unit = "ms",
     .live = true,
     .help = "Added to the interpolation delay."},
    {.name = "dejitter",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_player_config, dejitter),
     .choices = ll_dejitter_names,
     .live = true,
     .help =
         "When the client takes in a state that has come: none at once, arrival dejitter_ms later, send_time "
         "dejitter_ms after it was sent and the fastest recent state had come, mirror and nfe by delays that "
         "follow the jitter."},
    {.name = "dejitter_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_player_config, dejitter_ms),
     .max = 500,
     .default_value = 100,
     .unit = "ms",
     .live = true,
     .help = "Delay of the de-jitter buffer; the least of nfe."},
    {.name = "interpolation_method",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_player_config, interpolation_method),
     .choices = ll_interpolation_names,
     .live = true,
     .help = "Between two states: linear is on the straight line, hermite on the cubic that also has their "
             "velocities."},
    {.name = "interpolation_delay",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_player_config, interpolation_delay),
     .choices = ll_interpolation_delay_names,
     .live = true,
     .help =
         "ratio is interpolation_ratio / update_hz, adaptive the average gap between states, 1.25 times its "
         "deviation and the average lateness; jitter_margin_ms is added to both."},
    {.name = "time_scale",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_player_config, time_scale),
     .choices = ll_time_scale_names,
     .live = true,
     .help = "How the time that is drawn follows the link: proportional by up to a tenth faster or slower, "
             "catch_up "
             "2 % faster or 4 % slower once it is more than an update interval off."},
    {.name = "extrapolation_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_player_config, extrapolation_ms),
     .max = 1000,
     .unit = "ms",
     .live = true,
     .help = "How long the others go on by their velocity when no newer state has come; then they are held. "
             "Without interpolation they are drawn so at the server's present time."},
    {.name = "extrapolation_clock",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_player_config, extrapolation_clock),
     .choices = extrapolation_clocks,
     .live = true,
     .help = "Without interpolation: measured draws the others at the server's present by the clock that the "
             "pings "
             "measured, arrival at the time of the state that came fastest."},
    {.name = "correction",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_player_config, correction),
     .choices = corrections,
     .live = true,
     .help =
         "When what was drawn was wrong: snap jumps, smooth lets the error decay in the view, never in the "
         "state. Errors above 4 m always jump."},
    {.name = "correction_half_life_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_player_config, correction_half_life_ms),
     .min = 1,
     .max = 5000,
     .default_value = 200,
     .unit = "ms",
     .live = true,
     .help = "In this time a smoothed error halves."},
    {.name = "timer_jitter_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_player_config, timer_jitter_ms),
     .max = 50,
     .unit = "ms",
     .live = true,
     .help =
         "The client's timer fires late by up to so much, uniformly, and sets the next from there, as a busy "
         "browser does."},
    {.name = "clock_phase",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_player_config, clock_phase),
     .min = -1,
     .max = 1,
     .default_value = -1,
     .help =
         "How long after the server's clock this machine's ticks and displays come, in ticks; below 0 it is "
         "drawn by the seed, from 0 to 1."},
    {.name = "drift_ppm",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_player_config, drift_ppm),
     .min = -500,
     .max = 500,
     .unit = "ppm",
     .help = "By how many millionths this machine's clock is faster than the server's."},
    {.name = "clock_filter",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_player_config, clock_filter),
     .choices = ll_clock_filter_names,
     .live = true,
     .help = "How the client takes the server's clock from its last eight pings: the median, the ping of the "
             "shortest round trip, or the mean."},
    {.name = "send_hz",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_player_config, send_hz),
     .max = 128,
     .unit = "Hz",
     .live = true,
     .help = "How often the client sends what inputs it has made; 0, and in lockstep: with every tick."},
    {.name = "display_hz",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_player_config, display_hz),
     .max = 240,
     .unit = "Hz",
     .help = "How often the client draws; 0: tick_hz, and with its ticks where those come as often."},
    {.name = "input_hz",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_player_config, input_hz),
     .max = 8000,
     .unit = "Hz",
     .live = true,
     .help = "How often the input device is read; a change waits for the next time. 0: at once."},
    {.name = "input_device_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_player_config, input_device_ms),
     .max = 200,
     .unit = "ms",
     .live = true,
     .help = "From the hand to the game, beside the wait for input_hz."},
    {.name = "display_device_ms",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_player_config, display_device_ms),
     .max = 200,
     .unit = "ms",
     .live = true,
     .help = "From the drawn picture to the light on the screen."},
    {.name = "slack_ticks",
     .type = LL_PARAM_INT,
     .offset = offsetof(ll_player_config, slack_ticks),
     .max = 10,
     .default_value = 1,
     .unit = "ticks",
     .live = true,
     .help = "How early the client wants its inputs to reach the server: it runs ahead of the server by its "
             "lag and this."},
    {.name = "input_delay_ticks",
     .type = LL_PARAM_INT,
     .offset = offsetof(ll_player_config, input_delay_ticks),
     .max = LL_INPUT_DELAY_MAX,
     .unit = "ticks",
     .live = true,
     .help = "An input that is made now is for a tick so much later: it is felt later, and known earlier to "
             "the others."},
    {.name = "time_dilation",
     .type = LL_PARAM_BOOL,
     .offset = offsetof(ll_player_config, time_dilation),
     .live = true,
     .help = "Under free the client keeps its slack by running its frames up to a tenth faster or slower, "
             "instead of "
             "making inputs twice or leaving them out."},
    {.name = "redundancy",
     .type = LL_PARAM_INT,
     .offset = offsetof(ll_player_config, redundancy),
     .max = 15,
     .default_value = 2,
     .live = true,
     .help = "How many earlier unacknowledged inputs each input packet repeats."},
    {.name = "lane",
     .type = LL_PARAM_INT,
     .offset = offsetof(ll_player_config, lane),
     .min = -1,
     .max = LL_PLAYERS_MAX - 1,
     .default_value = -1,
     .help = "Lane of the race; -1 is a lane of the player's own."},
    {.name = "control",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_player_config, control),
     .choices = controls,
     .live = true,
     .help = "Who drives: a script or a person."},
    {.name = "script",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_player_config, script),
     .choices = ll_script_names,
     .live = true,
     .help = "What the script does."},
    {.name = "cheat",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_player_config, cheat),
     .choices = cheats,
     .live = true,
     .help = "A client that cheats, to try the server's rules: inputs half as large again, twice as many, a "
             "fifth more than "
             "time has passed, a huge one now and then, or packets held back for 3 s of every 6 and released "
             "at once; "
             "with weapons a view of half a second before, presses without pause, or a claim that every "
             "rifle shot "
             "hits."},
    {.name = "float_mode",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_player_config, hardware),
     .choices = ll_hardware_names,
     .live = true,
     .help = "Deterministic and rollback: the arithmetic of the player's machine: as the server's, stored as "
             "floats, "
             "with fused multiply-add, or off by one ulp now and then."},
};

/* What a client keeps is sized for it: 512 inputs are a round trip of 2.5 s, an update a second and 128 ticks
 * a second. */
static bool holds_for_long(const ll_player_config *player)
{
    return player->dejitter != LL_DEJITTER_NONE && player->dejitter != LL_DEJITTER_MIRROR;
}

static ll_status check_way(const ll_player_config *player, const ll_link_params *link, const char *path,
                           const char *way)
{
    char field[64];
    double longest = ll_link_delay_max_ms(link, player->lag_ms);
    if (longest <= LL_ONE_WAY_MAX_MS)
        return ll_ok();
    snprintf(field, sizeof field, "%slink.%s", path, way);
    return ll_field_error(LL_BAD_INPUT, field,
                          "%s must delay a packet by at most %d ms: lag_ms, delay_ms, the largest jitter, "
                          "spike_add_ms and, with a rate_kbps, limit_ms together; got %g",
                          field, LL_ONE_WAY_MAX_MS, longest);
}

static ll_status check_player(const void *object, const char *path)
{
    const ll_player_config *player = object;
    ll_status status = check_way(player, &player->link.up, path, "up");
    if (!ll_failed(&status))
        status = check_way(player, &player->link.down, path, "down");
    double longest = ll_link_delay_max_ms(&player->link.down, player->lag_ms) + player->dejitter_ms;
    if (ll_failed(&status) || !holds_for_long(player) || longest <= LL_ONE_WAY_MAX_MS)
        return status;
    char field[64];
    snprintf(field, sizeof field, "%sdejitter_ms", path);
    return ll_field_error(
        LL_BAD_INPUT, field,
        "%s and the longest delay of the player's link down must be at most %d ms together; got %g", field,
        LL_ONE_WAY_MAX_MS, longest);
}

const ll_param_table ll_player_table = {.name = "player",
                                        .help = "A player, its link and its techniques.",
                                        .rows = player_rows,
                                        .count = sizeof player_rows / sizeof player_rows[0],
                                        .size = sizeof(ll_player_config),
                                        .check = check_player};

void ll_player_apply_dependencies(ll_player_config *now, const ll_player_config *before)
{
    if (!now->reconciliation || now->prediction)
        return;
    if (before->prediction)
        now->reconciliation = false; /* prediction was switched off */
    else
        now->prediction = true; /* reconciliation was switched on */
}
