#include "netcode/protocol/config.h"

#include <stdio.h>

#include "link/line/presets.h"
#include "netcode/client/ack.h"
#include "netcode/client/scope.h"
#include "netcode/peer/float_mode.h"
#include "netcode/protocol/clock_sync.h"
#include "netcode/view/view.h"

static const char *const controls[] = {"script", "person", NULL};
static const char *const authorities[] = {"controls", "position", NULL};
static const char *const corrections[] = {"snap", "smooth", NULL};
static const char *const extrapolation_clocks[] = {"measured", "arrival", NULL};
static const char *const cheats[] = {"none",      "magnitude", "rate",     "budget",     "view_time",
                                     "fire_rate", "claim",     "teleport", "lag_switch", "aim_bot",
                                     "speed",     "leap",      NULL};

static void choose_preset(void *object, int preset)
{
    ll_link_pair *pair = object;
    ll_link_preset_apply(preset, &pair->up, &pair->down);
}

static const ll_param link_rows[] = {
    {LL_PARAM_ROW("preset", CHOICE, ll_link_pair, preset), .choices = ll_link_preset_names, .live = true,
     .chosen = choose_preset,
     .help = "Named link: sets every parameter of both directions before the parameters given next to it "
             "apply. custom sets none."},
    {LL_PARAM_ROW("up", OBJECT, ll_link_pair, up), .child = &ll_link_table, .live = true,
     .help = "From the client to the server."},
    {LL_PARAM_ROW("down", OBJECT, ll_link_pair, down), .child = &ll_link_table, .live = true,
     .help = "From the server to the client."},
};

static const ll_param_table link_table = {
    .name = "link_pair", .help = "A player's link, per direction.", LL_PARAM_ROWS(link_rows, ll_link_pair)};

static const ll_param player_rows[] = {
    {LL_PARAM_ROW("name", TEXT, ll_player_config, name), .max = LL_NAME_MAX,
     .help = "Name in the views; A, B, ... if empty."},
    {LL_PARAM_ROW("lag_ms", REAL, ll_player_config, lag_ms), .max = 1000, .unit = "ms", .live = true,
     .help = "One-way delay in each direction: the round trip takes twice as long."},
    {LL_PARAM_ROW("link", OBJECT, ll_player_config, link), .child = &link_table, .live = true,
     .help = "Impairments of each direction."},
    {LL_PARAM_ROW("prediction", BOOL, ll_player_config, prediction), .live = true,
     .help = "Client-side prediction: the client applies its own inputs to its own entity at once."},
    {LL_PARAM_ROW("prediction_scope", CHOICE, ll_player_config, prediction_scope),
     .choices = ll_prediction_scope_names, .live = true,
     .help = "Entities that the client predicts: its own, also those that may touch it, or the whole world. "
             "Others are predicted with their last received controls."},
    {LL_PARAM_ROW("reconciliation", BOOL, ll_player_config, reconciliation), .live = true,
     .help = "Server reconciliation: the client takes the server's state and replays its unacknowledged "
             "inputs. Needs prediction."},
    {LL_PARAM_ROW("reconciliation_tolerance_m", REAL, ll_player_config, reconciliation_tolerance_m),
     .max = 10, .unit = "m", .live = true,
     .help = "The prediction stands while every predicted entity is within this distance of the server's "
             "snapshot, now and extrapolated by velocity until the next snapshot. 0 demands bitwise "
             "equality, except for what rounding of other entities explains."},
    {LL_PARAM_ROW("ack", CHOICE, ll_player_config, ack), .choices = ll_ack_names, .live = true,
     .help = "How the client learns which inputs were applied. high_water: all inputs up to a number count "
             "as applied. per_input: one bit per input, so that lost, late and refused inputs are known to "
             "be skipped."},
    {LL_PARAM_ROW("interpolation", BOOL, ll_player_config, interpolation), .live = true,
     .help = "Entity interpolation: other entities are drawn in the past, between two snapshots."},
    {LL_PARAM_ROW("interpolation_ratio", REAL, ll_player_config, interpolation_ratio), .min = 1, .max = 4,
     .default_value = 2, .live = true,
     .help = "Interpolation delay in update intervals; 2 covers one lost update."},
    {LL_PARAM_ROW("jitter_margin_ms", REAL, ll_player_config, jitter_margin_ms), .max = 500,
     .default_value = 10, .unit = "ms", .live = true, .help = "Added to the interpolation delay."},
    {LL_PARAM_ROW("dejitter", CHOICE, ll_player_config, dejitter), .choices = ll_dejitter_names, .live = true,
     .help = "When the client applies a received snapshot. none: at once. arrival: dejitter_ms later. "
             "send_time: dejitter_ms after the time at which it would have arrived if it were as fast as the "
             "fastest recent one. mirror and nfe: after a delay that follows the jitter."},
    {LL_PARAM_ROW("dejitter_ms", REAL, ll_player_config, dejitter_ms), .max = 500, .default_value = 100,
     .unit = "ms", .live = true, .help = "Delay of the de-jitter buffer; with nfe the minimum."},
    {LL_PARAM_ROW("interpolation_method", CHOICE, ll_player_config, interpolation_method),
     .choices = ll_interpolation_names, .live = true,
     .help = "Curve between two snapshots. linear: the straight line. hermite: the cubic that also has their "
             "velocities."},
    {LL_PARAM_ROW("interpolation_delay", CHOICE, ll_player_config, interpolation_delay),
     .choices = ll_interpolation_delay_names, .live = true,
     .help = "ratio: interpolation_ratio / update_hz. adaptive: the average gap between snapshots, plus 1.25 "
             "times its deviation, plus the average lateness. jitter_margin_ms is added to both."},
    {LL_PARAM_ROW("time_scale", CHOICE, ll_player_config, time_scale), .choices = ll_time_scale_names,
     .live = true,
     .help = "How render time follows the link. proportional: up to a tenth faster or slower. catch_up: 2 % "
             "faster or 4 % slower while it is more than one update interval off."},
    {LL_PARAM_ROW("extrapolation_ms", REAL, ll_player_config, extrapolation_ms), .max = 1000, .unit = "ms",
     .live = true,
     .help = "How long others are extrapolated by their velocity when no newer snapshot has arrived; then "
             "they are held. Without interpolation they are extrapolated to the server's present."},
    {LL_PARAM_ROW("extrapolation_clock", CHOICE, ll_player_config, extrapolation_clock),
     .choices = extrapolation_clocks, .live = true,
     .help = "Clock for extrapolation without interpolation. measured: the server's present by the clock "
             "that the pings measured. arrival: the server time of the fastest snapshot."},
    {LL_PARAM_ROW("correction", CHOICE, ll_player_config, correction), .choices = corrections, .live = true,
     .help = "Correction of a wrongly drawn position. snap: it jumps. smooth: the error decays in the view, "
             "never in the state. Errors above 4 m always jump."},
    {LL_PARAM_ROW("correction_half_life_ms", REAL, ll_player_config, correction_half_life_ms), .min = 1,
     .max = 5000, .default_value = 200, .unit = "ms", .live = true, .help = "Half-life of a smoothed error."},
    {LL_PARAM_ROW("timer_jitter_ms", REAL, ll_player_config, timer_jitter_ms), .max = 50, .unit = "ms",
     .live = true,
     .help = "Maximum lateness of the client's timer, uniform; a late timer sets the next one from its own "
             "time, as a busy browser does."},
    {LL_PARAM_ROW("clock_phase", REAL, ll_player_config, clock_phase), .min = -1, .max = 1,
     .default_value = -1,
     .help = "Delay of this machine's ticks and displays relative to the server's clock, in ticks. Negative: "
             "random from 0 to 1, by the seed."},
    {LL_PARAM_ROW("drift_ppm", REAL, ll_player_config, drift_ppm), .min = -500, .max = 500, .unit = "ppm",
     .help = "Rate of this machine's clock above the server's, in parts per million."},
    {LL_PARAM_ROW("clock_filter", CHOICE, ll_player_config, clock_filter), .choices = ll_clock_filter_names,
     .live = true,
     .help = "How the client estimates the server's clock from its last eight pings: the median, the ping of "
             "the shortest round trip, or the mean."},
    {LL_PARAM_ROW("send_hz", REAL, ll_player_config, send_hz), .max = 128, .unit = "Hz", .live = true,
     .help = "How often the client sends its new inputs; 0, and in lockstep: with every tick."},
    {LL_PARAM_ROW("display_hz", REAL, ll_player_config, display_hz), .max = 240, .unit = "Hz",
     .help = "How often the client draws; 0: tick_hz. At the rate of the ticks it draws with them."},
    {LL_PARAM_ROW("input_hz", REAL, ll_player_config, input_hz), .max = 8000, .unit = "Hz", .live = true,
     .help = "How often the input device is read; a change waits for the next reading. 0: at once."},
    {LL_PARAM_ROW("input_device_ms", REAL, ll_player_config, input_device_ms), .max = 200, .unit = "ms",
     .live = true, .help = "Delay from the hand to the game, in addition to the wait for input_hz."},
    {LL_PARAM_ROW("display_device_ms", REAL, ll_player_config, display_device_ms), .max = 200, .unit = "ms",
     .live = true, .help = "Delay from the drawn frame to the light on the screen."},
    {LL_PARAM_ROW("slack_ticks", INT, ll_player_config, slack_ticks), .max = 10, .default_value = 1,
     .unit = "ticks", .live = true,
     .help = "Wanted input slack: the client runs ahead of the server by its lag plus this."},
    {LL_PARAM_ROW("input_delay_ticks", INT, ll_player_config, input_delay_ticks), .max = LL_INPUT_DELAY_MAX,
     .unit = "ticks", .live = true,
     .help = "Input delay: an input takes effect this many ticks later. The player feels it later, and the "
             "others receive it earlier relative to its effect."},
    {LL_PARAM_ROW("time_dilation", BOOL, ll_player_config, time_dilation), .live = true,
     .help = "With sync free the client keeps its slack by running its frames up to a tenth faster or "
             "slower, instead of doubling or skipping inputs."},
    {LL_PARAM_ROW("redundancy", INT, ll_player_config, redundancy), .max = 15, .default_value = 2,
     .live = true, .help = "Number of earlier unacknowledged inputs that each input packet repeats."},
    {LL_PARAM_ROW("lane", INT, ll_player_config, lane), .min = -1, .max = LL_PLAYERS_MAX - 1,
     .default_value = -1, .help = "Lane of the race; -1: a lane of the player's own."},
    {LL_PARAM_ROW("control", CHOICE, ll_player_config, control), .choices = controls, .live = true,
     .help = "Controlled by a script or a person."},
    {LL_PARAM_ROW("authority", CHOICE, ll_player_config, authority), .choices = authorities,
     .help = "Who moves the player's entity. controls: the server, by the inputs that the client sends. "
             "position: the client, which also sends the state of its entity after its newest input; the "
             "server takes it if the entity can have got there, and otherwise corrects the client."},
    {LL_PARAM_ROW("script", CHOICE, ll_player_config, script), .choices = ll_script_names, .live = true,
     .help = "The script."},
    {LL_PARAM_ROW("cheat", CHOICE, ll_player_config, cheat), .choices = cheats, .live = true,
     .help =
         "A client that cheats, to test the server's rules. Inputs: half as large again, twice as many, "
         "a fifth more than time has passed, a huge one at intervals, or packets held back for 3 s of "
         "every 6 and released at once. With weapons: a view of half a second before, presses without "
         "pause, a claim that every hitscan shot hits, or an aim bot, which shoots at what its view shows "
         "as soon as it is in sight. Positions: the own entity half as fast again (speed), or 10 m ahead "
         "every 2 s (leap), which counts with authority position."},
    {LL_PARAM_ROW("float_mode", CHOICE, ll_player_config, float_mode), .choices = ll_float_mode_names,
     .live = true,
     .help = "Deterministic and rollback: floating-point arithmetic of the player's machine: exact as the "
             "server's, stored as floats, with fused multiply-add, or with occasional errors of one ulp."},
};

/* Client rings are sized for this: 512 inputs cover a round trip of 2.5 s, one update per second and 128
 * ticks per second. */
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
    LL_THEN(status, check_way(player, &player->link.down, path, "down"));
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
                                        LL_PARAM_ROWS(player_rows, ll_player_config),
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
