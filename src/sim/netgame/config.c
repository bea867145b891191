#include "sim/netgame/netgame.h"

#include <stdio.h>
#include <string.h>

#include "netcode/client/scope.h"
#include "netcode/protocol/wire.h"
#include "sim/core/scenario_rows.h"

static const ll_param rows[] = {
    LL_SCENARIO_ROWS,
    {.name = "game",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_netgame_config, game),
     .choices = ll_game_names,
     .help = "The game."},
    {.name = "params",
     .type = LL_PARAM_VARIANT,
     .offset = offsetof(ll_netgame_config, params),
     .variants = ll_game_tables,
     .count_offset = offsetof(ll_netgame_config, game),
     .help = "The game's own parameters."},
    {.name = "tick_hz",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_netgame_config, tick_hz),
     .min = 10,
     .max = 128,
     .default_value = 60,
     .unit = "Hz",
     .help = "Steps per second of the clients, and of the server unless it steps at update_hz."},
    {.name = "warmup_s",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_netgame_config, warmup_s),
     .max = 3600,
     .default_value = 2,
     .unit = "s",
     .help = "Metrics count from this time on."},
    {.name = "server",
     .type = LL_PARAM_OBJECT,
     .offset = offsetof(ll_netgame_config, server),
     .child = &ll_server_table,
     .live = true,
     .help = "The authoritative server."},
    {.name = "players",
     .type = LL_PARAM_ARRAY,
     .offset = offsetof(ll_netgame_config, players),
     .min = 1,
     .max = LL_PLAYERS_MAX,
     .child = &ll_player_table,
     .count_offset = offsetof(ll_netgame_config, player_count),
     .live = true,
     .required = true,
     .help = "The players, each with its own link and techniques."},
};

static ll_status send_too_seldom(int player, double send_hz, double least)
{
    char field[48];
    snprintf(field, sizeof field, "players.%d.send_hz", player);
    return ll_field_error(LL_BAD_INPUT, field,
                          "%s: must be 0 or at least %g, since a packet holds %d inputs at most; got %g",
                          field, least, LL_INPUTS_MAX, send_hz);
}

static ll_status check(const void *object, const char *path)
{
    const ll_netgame_config *c = object;
    (void)path;
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
                                         .rows = rows,
                                         .count = sizeof rows / sizeof rows[0],
                                         .size = sizeof(ll_netgame_config),
                                         .check = check};
