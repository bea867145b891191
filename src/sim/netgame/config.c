#include "sim/netgame/netgame.h"

#include <stdio.h>
#include <string.h>

#include "link/transport/transport.h"
#include "netcode/client/scope.h"
#include "netcode/protocol/wire.h"
#include "sim/core/scenario_rows.h"

static const ll_param rows[] = {
    LL_SCENARIO_ROWS,
    {LL_PARAM_ROW("game", CHOICE, ll_netgame_config, game), .choices = ll_game_names, .help = "The game."},
    {LL_PARAM_ROW("params", VARIANT, ll_netgame_config, params), .variants = ll_game_tables,
     .count_offset = offsetof(ll_netgame_config, game), .help = "The game's own parameters."},
    {LL_PARAM_ROW("tick_hz", REAL, ll_netgame_config, tick_hz), .min = 10, .max = 128, .default_value = 60,
     .unit = "Hz",
     .help = "Steps per second of the clients, and of the server unless it steps at update_hz."},
    {LL_PARAM_ROW("warmup_s", REAL, ll_netgame_config, warmup_s), .max = 3600, .default_value = 2,
     .unit = "s", .help = "Metrics count from this time on."},
    {LL_PARAM_ROW("server", OBJECT, ll_netgame_config, server), .child = &ll_server_table, .live = true,
     .help = "The authoritative server."},
    {LL_PARAM_ROW("players", ARRAY, ll_netgame_config, players), .min = 1, .max = LL_PLAYERS_MAX,
     .child = &ll_player_table, .count_offset = offsetof(ll_netgame_config, player_count), .live = true,
     .required = true, .help = "The players, each with its own link and techniques."},
    {LL_PARAM_ROW("bucket_delay_ms", REAL, ll_netgame_config, bucket_delay_ms), .max = 500,
     .default_value = 100, .unit = "ms", .live = true,
     .help = "With sync bucket, the playout delay of inputs: time from the end of the interval in which an "
             "input was made to the step that applies it, at any lag of the player."},
    {LL_PARAM_ROW("policies", OBJECT, ll_netgame_config, policies), .child = &ll_policy_table,
     .help = "Parameters of single policies of lag compensation."},
    {LL_PARAM_ROW("reckoning", OBJECT, ll_netgame_config, reckoning), .child = &ll_reckoning_table,
     .help = "Dead reckoning with send thresholds."},
    {LL_PARAM_ROW("peers", OBJECT, ll_netgame_config, peers), .child = &ll_peers_table,
     .help = "The peer-to-peer syncs, deterministic and rollback."},
    {LL_PARAM_ROW("reports", OBJECT, ll_netgame_config, reports), .child = &ll_report_table,
     .help = "Validation of the positions that clients report."},
    {LL_PARAM_ROW("bottleneck", OBJECT, ll_netgame_config, bottleneck), .child = &ll_bottleneck_table,
     .help = "A queue in each direction that the players share, with cross traffic."},
    {LL_PARAM_ROW("profiles", ARRAY, ll_netgame_config, profiles), .max = LL_PROFILES_MAX,
     .child = &ll_profile_table, .count_offset = offsetof(ll_netgame_config, profile_count),
     .help = "Profiles of links, for the row profile of a direction: traces, slots, cells, ECN, a distance."},
};

static ll_status send_too_seldom(int player, double send_hz, double least)
{
    char field[48];
    snprintf(field, sizeof field, "players.%d.send_hz", player);
    return ll_field_error(LL_BAD_INPUT, field,
                          "%s: must be 0 or at least %g, since a packet holds %d inputs at most; got %g",
                          field, least, LL_INPUTS_MAX, send_hz);
}

static ll_status check_transport(const ll_server_config *server)
{
    if (!ll_transport_delivers(server->transport, server->delivery))
        return ll_field_error(LL_BAD_INPUT, "server.delivery",
                              "server.delivery: must be usual or what server.transport %s does; got %s",
                              ll_transport_names[server->transport], ll_delivery_names[server->delivery]);
    if (server->nagle && server->transport != LL_TRANSPORT_TCP)
        return ll_field_error(LL_BAD_INPUT, "server.nagle",
                              "server.nagle: must be false unless server.transport is tcp; got true");
    return ll_ok();
}

/* How many a game and its clients can have. */
static ll_status check_sizes(const ll_netgame_config *c)
{
    const ll_game *game = ll_games[c->game];
    const int entities = game->extent(c->params, c->player_count).entities;
    if (!game->many && c->player_count > LL_PEERS_MAX)
        return ll_field_error(LL_BAD_INPUT, "players", "players: must be 1 to %d in the game %s; got %d",
                              LL_PEERS_MAX, game->name, c->player_count);
    if (c->player_count <= LL_PEERS_MAX && entities <= LL_TOUCHING_MAX)
        return ll_ok();
    if (ll_syncs[c->server.sync]->observe)
        return ll_field_error(
            LL_BAD_INPUT, "server.sync",
            "server.sync: in %s clients step all entities: there must be at most %d players "
            "and %d entities; got %d and %d",
            ll_syncs[c->server.sync]->name, LL_PEERS_MAX, LL_TOUCHING_MAX, c->player_count, entities);
    for (int i = 0; i < c->player_count; i++) {
        char field[48];
        snprintf(field, sizeof field, "players.%d.prediction_scope", i);
        if (ll_scopes[c->players[i].prediction_scope]->guesses)
            return ll_field_error(
                LL_BAD_INPUT, field, "%s: must be own with more than %d players or %d entities; got %s",
                field, LL_PEERS_MAX, LL_TOUCHING_MAX, ll_scopes[c->players[i].prediction_scope]->name);
    }
    return ll_ok();
}

static ll_status check_peers(const ll_netgame_config *c)
{
    if (c->peers.topology == LL_TOPOLOGY_RELAY || ll_transport_plain(c->server.transport))
        return ll_ok();
    return ll_field_error(LL_BAD_INPUT, "peers.topology",
                          "peers.topology: must be relay unless server.transport is %s; got mesh with %s",
                          ll_transport_names[0], ll_transport_names[c->server.transport]);
}

static ll_status check_reckoning(const ll_netgame_config *c)
{
    const char *model = ll_reckoning_names[c->reckoning.model];
    if (c->reckoning.model == 0)
        return ll_ok();
    if (strcmp(ll_syncs[c->server.sync]->name, "free") != 0)
        return ll_field_error(LL_BAD_INPUT, "reckoning.model",
                              "reckoning.model: must be none unless server.sync is free; got %s with %s",
                              model, ll_syncs[c->server.sync]->name);
    if (c->server.snapshot != 0)
        return ll_field_error(
            LL_BAD_INPUT, "reckoning.model",
            "reckoning.model: must be none unless server.snapshot_encoding is %s; got %s with %s",
            ll_codec_names[0], model, ll_codec_names[c->server.snapshot]);
    return ll_ok();
}

/* A client can only report what it computes by itself, and the server check only what the game bounds. */
static ll_status check_authority(const ll_netgame_config *c, int i)
{
    const ll_player_config *p = &c->players[i];
    char field[48];
    if (p->authority != LL_AUTHORITY_POSITION)
        return ll_ok();
    snprintf(field, sizeof field, "players.%d.authority", i);
    if (!ll_games[c->game]->own_is_bounded)
        return ll_field_error(LL_BAD_INPUT, field,
                              "%s: must be controls in the game %s, in which more than its controls moves an "
                              "entity; got position",
                              field, ll_games[c->game]->name);
    if (strcmp(ll_syncs[c->server.sync]->name, "free") != 0)
        return ll_field_error(LL_BAD_INPUT, field,
                              "%s: must be controls unless server.sync is free; got position with %s", field,
                              ll_syncs[c->server.sync]->name);
    if (!p->prediction || !p->reconciliation)
        return ll_field_error(
            LL_BAD_INPUT, field,
            "%s: must be controls unless prediction and reconciliation of the player are on; got position",
            field);
    if (ll_scopes[p->prediction_scope]->guesses)
        return ll_field_error(
            LL_BAD_INPUT, field,
            "%s: must be controls unless the player's prediction_scope is own; got position "
            "with %s",
            field, ll_scopes[p->prediction_scope]->name);
    if (p->input_delay_ticks > 0)
        return ll_field_error(LL_BAD_INPUT, field,
                              "%s: must be controls unless the player's input_delay_ticks is 0; got position "
                              "with %lld",
                              field, (long long)p->input_delay_ticks);
    return ll_ok();
}

static ll_status check_authorities(const ll_netgame_config *c)
{
    for (int i = 0; i < c->player_count; i++)
        LL_TRY(check_authority(c, i));
    return ll_ok();
}

/* With what it shares with others, or few have. */
static double longest_of(const ll_netgame_config *c, int player, bool up)
{
    const ll_link_params *params = up ? &c->players[player].link.up : &c->players[player].link.down;
    const ll_profile_params *profile = params->profile > 0 ? &c->profiles[params->profile - 1] : NULL;
    double longest = ll_link_delay_max_with_ms(params, c->players[player].lag_ms, profile);
    longest += c->bottleneck.rate_kbps > 0 ? c->bottleneck.limit_ms : 0;
    if (!up && c->players[player].dejitter != LL_DEJITTER_NONE)
        longest += c->players[player].dejitter_ms;
    return longest;
}

static ll_status check_profile(const ll_netgame_config *c, int player, bool up)
{
    const ll_link_params *params = up ? &c->players[player].link.up : &c->players[player].link.down;
    const char *name = ll_profile_names[params->profile], *way = up ? "up" : "down";
    char field[64];
    if (params->profile == 0 && c->bottleneck.rate_kbps <= 0)
        return ll_ok();
    snprintf(field, sizeof field, "players.%d.link.%s.profile", player, way);
    if (params->profile > c->profile_count)
        return ll_field_error(LL_BAD_INPUT, field,
                              "%s: must be none or one of the scenario's %d profiles; got %s", field,
                              c->profile_count, name);
    if (params->profile > 0 && c->profiles[params->profile - 1].capacity_count > 0 && params->rate_kbps > 0)
        return ll_field_error(LL_BAD_INPUT, field,
                              "%s: %s has a capacity, and rate_kbps must then be 0; got %g", field, name,
                              params->rate_kbps);
    double longest = longest_of(c, player, up);
    if (longest <= LL_ONE_WAY_MAX_MS)
        return ll_ok();
    snprintf(field, sizeof field, "players.%d.link.%s", player, way);
    return ll_field_error(
        LL_BAD_INPUT, field,
        "%s must delay a packet by at most %d ms: with the distance, trace and table of its profile, "
        "limit_ms of a capacity, of slots and of the bottleneck; got %g",
        field, LL_ONE_WAY_MAX_MS, longest);
}

static ll_status check_profiles(const ll_netgame_config *c)
{
    for (int i = 0; i < c->player_count; i++) {
        LL_TRY(check_profile(c, i, true));
        LL_TRY(check_profile(c, i, false));
    }
    return ll_ok();
}

static ll_status check(const void *object, const char *path)
{
    const ll_netgame_config *c = object;
    (void)path;
    LL_TRY(check_transport(&c->server));
    LL_TRY(check_sizes(c));
    LL_TRY(check_reckoning(c));
    LL_TRY(check_peers(c));
    LL_TRY(check_authorities(c));
    LL_TRY(check_profiles(c));
    for (int i = 0; i < c->player_count; i++) {
        double send_hz = c->players[i].send_hz, least = c->tick_hz / LL_INPUTS_MAX;
        if (send_hz > 0 && send_hz < least)
            return send_too_seldom(i, send_hz, least);
    }
    for (int i = 0; i < c->player_count; i++) {
        const ll_prediction_scope *scope = ll_scopes[c->players[i].prediction_scope];
        char field[48];
        snprintf(field, sizeof field, "players.%d.prediction_scope", i);
        if (scope->guesses && ll_syncs[c->server.sync]->applies_on_arrival)
            return ll_field_error(
                LL_BAD_INPUT, field,
                "%s: must be own where server.sync is %s, which has no steps to predict others by; got %s",
                field, ll_syncs[c->server.sync]->name, scope->name);
    }
    if (ll_syncs[c->server.sync]->client_steps_at_update_hz && c->server.update_hz > c->tick_hz)
        return ll_field_error(
            LL_BAD_INPUT, "server.update_hz",
            "in %s all players step at server.update_hz, which must then be at most tick_hz, %g Hz; got %g",
            ll_syncs[c->server.sync]->name, c->tick_hz, c->server.update_hz);
    const ll_game *game = ll_games[c->game];
    bool more = game->weapons || game->extent(c->params, c->player_count).entities > c->player_count;
    if (ll_syncs[c->server.sync]->applies_on_arrival && more)
        return ll_field_error(LL_BAD_INPUT, "server.sync",
                              "in %s the server only applies inputs on arrival: the game %s needs steps, in "
                              "which objects without a player move too",
                              ll_syncs[c->server.sync]->name, game->name);
    return ll_ok();
}

const ll_param_table ll_netgame_table = {.name = "netgame",
                                         .help = "A game over a network: server, clients and links.",
                                         LL_PARAM_ROWS(rows, ll_netgame_config),
                                         .check = check,
                                         .is_cut = true};
