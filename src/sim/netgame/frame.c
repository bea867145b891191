/* Streamed rows of a netgame: its views, the entities in them, the game's own values, and sums of each
 * player's view; then the records of
 * the other files of this room. */
#include <math.h>

#include "record/integers.h"
#include "sim/netgame/netgame.h"

/* ---- views: the server's, then each player's ---- */

typedef struct view {
    uint8_t view, connection, flags;
    bool connected;
    uint32_t input_seq, acked_seq, unacked, corrections, refused;
    float lag_ms, view_age_ms, own_lead_m, remote_error_m, buffer_ms, slack_ticks, correction_m, alpha;
    double render_time_s;
} view;

enum { PREDICTION = 1, RECONCILIATION = 2, INTERPOLATION = 4, UNDERRUN = 8, STALLED = 16, PERSON = 32 };
static const char *const view_flags[] = {
    "prediction", "reconciliation", "interpolation", "underrun", "stalled", "person", NULL};

static const ll_record_field view_fields[] = {
    LL_INT(view, view, NULL, "0: the server; 1 + p: player p"),
    LL_FLAGS(view, flags, view_flags,
             "techniques that are on; underrun: the buffer is empty; stalled: waits for an input; person: "
             "controlled by a person"),
    LL_ENUM(view, connection, ll_connection_state_names,
            "state of the player's connection; the server's own is playing"),
    LL_INT(view, connected, NULL, "whether the server has the player connected"),
    LL_INT(view, input_seq, NULL, "of the last sent input; for the server its step"),
    LL_INT(view, acked_seq, NULL, "of the last input that the server acknowledged"),
    LL_INT(view, unacked, NULL, "unacknowledged inputs"),
    LL_STEP(view, lag_ms, LL_BITS_MS, "ms", "configured one-way lag in both directions"),
    LL_STEP(view, view_age_ms, LL_BITS_MS, "ms", "age of the remote entities as drawn"),
    LL_STEP(view, own_lead_m, LL_BITS_M, "m",
            "own entity: drawn minus the server's present; prediction makes it lead, which is no error"),
    LL_STEP(view, remote_error_m, LL_BITS_M, "m",
            "remote entities: drawn minus the server's present, the largest, signed"),
    LL_STEP(view, buffer_ms, LL_BITS_MS, "ms", "time of the newest snapshot minus render time"),
    LL_STEP(view, slack_ticks, LL_BITS_MS, "ticks",
            "input slack of the last input at the server; negative: late; null: unknown"),
    LL_INT(view, corrections, NULL, "number of corrections of the own entity"),
    LL_STEP(view, correction_m, LL_BITS_M, "m", "the last correction, signed"),
    LL_INT(view, refused, NULL, "inputs that the server refused"),
    LL_STEP(view, alpha, LL_BITS_RATIO, NULL, "position of render time between its two snapshots"),
    LL_STEP(view, render_time_s, LL_BITS_S, "s", "render time of the remote entities"),
};

LL_INTEGERS(view_integers, view, view_fields)

static const ll_record view_record = {.id = 2,
                                      .name = "views",
                                      .channel = LL_CHANNEL_SCENE,
                                      .help = "The server's view, then each player's.",
                                      .form = LL_FORM_BY_INDEX,
                                      LL_ROWS_OF(view, view_fields),
                                      .integers = view_integers};

static view server_view(const ll_netgame *g)
{
    const ll_server *server = ll_netgame_server(g);
    return (view){.input_seq = (uint32_t)server->step,
                  .flags = ll_netgame_sync(g)->due(server) == LL_NEVER ? STALLED : 0,
                  .connection = LL_CONNECTION_PLAYING,
                  .connected = true,
                  .alpha = 1,
                  .render_time_s = ll_to_s(server->stepped)};
}

static uint8_t flags_of(const ll_netgame *g, int i)
{
    const ll_player_config *config = &g->config.players[i];
    return (uint8_t)((config->prediction ? PREDICTION : 0) | (config->reconciliation ? RECONCILIATION : 0) |
                     (config->interpolation ? INTERPOLATION : 0) |
                     (ll_netgame_client(g, i)->view.held ? UNDERRUN : 0) |
                     (ll_netgame_stalled(g, i) ? STALLED : 0) |
                     (config->control == LL_CONTROL_PERSON ? PERSON : 0));
}

static view player_view(const ll_netgame *g, int i)
{
    const ll_client *c = ll_netgame_client(g, i);
    const ll_client_metrics *in = ll_netgame_client_metrics(g, i);
    const ll_client_slot *client_slot = &ll_netgame_server(g)->client_slots[i];
    return (view){.view = (uint8_t)(i + 1),
                  .flags = flags_of(g, i),
                  .connection = (uint8_t)c->connection.state,
                  .connected = client_slot->connection.connected,
                  .input_seq = c->inputs.seq,
                  .acked_seq = c->inputs.acked,
                  .unacked = c->inputs.seq - c->inputs.acked,
                  .lag_ms = (float)g->config.players[i].lag_ms,
                  .view_age_ms = (float)in->last.view_age,
                  .own_lead_m = (float)in->last.own_lead,
                  .remote_error_m = (float)in->last.remote_error,
                  .buffer_ms = (float)c->drawing.buffer_ms,
                  .slack_ticks = client_slot->snapshots.last_slack == LL_SLACK_UNKNOWN
                                     ? NAN
                                     : (float)client_slot->snapshots.last_slack,
                  .corrections = (uint32_t)in->corrections.count,
                  .correction_m = (float)in->last.correction,
                  .refused = (uint32_t)in->input_history.count[LL_INPUT_WAS_REFUSED],
                  .alpha = (float)c->drawing.alpha,
                  .render_time_s = ll_to_s(c->drawing.view_time)};
}

/* ---- entities: view by view ---- */

typedef struct entity {
    uint8_t view;
    uint16_t entity, flags;
    float x, y, vx, vy, angle, angular_velocity, age_ms;
} entity;

static const char *const entity_flags[] = {"finished",     "predicted", "interpolated", "held",    "active",
                                           "extrapolated", "unsettled", "away",         "unknown", NULL};

static const ll_record_field entity_fields[] = {
    LL_INT(entity, view, NULL, "index of the view"),
    LL_INT(entity, entity, NULL, "index of the entity; those of the players come first"),
    LL_FLAGS(entity, flags, entity_flags,
             "held: no newer data; active: a projectile in flight; unsettled: overlaps what it was pushed "
             "into; away: its player is not connected; unknown: the player's snapshots do not contain it"),
    LL_STEP(entity, x, LL_BITS_M, "m", "position"),
    LL_STEP(entity, y, LL_BITS_M, "m", "position"),
    LL_STEP(entity, vx, LL_BITS_MPS, "m/s", "velocity"),
    LL_STEP(entity, vy, LL_BITS_MPS, "m/s", "velocity"),
    LL_STEP(entity, angle, LL_BITS_RAD, "rad", "orientation"),
    LL_STEP(entity, angular_velocity, LL_BITS_RAD, "rad/s", "angular velocity"),
    LL_STEP(entity, age_ms, LL_BITS_MS, "ms", "view age"),
};

LL_INTEGERS(entity_integers, entity, entity_fields)

static const ll_record entity_record = {.id = 3,
                                        .name = "entities",
                                        .channel = LL_CHANNEL_SCENE,
                                        .help = "The entities of each view, as drawn.",
                                        .form = LL_FORM_BY_INDEX,
                                        LL_ROWS_OF(entity, entity_fields),
                                        .integers = entity_integers};

static entity entity_of(int of, int index, const ll_entity *e, ll_time age, uint32_t flags)
{
    return (entity){.view = (uint8_t)of,
                    .entity = (uint16_t)index,
                    .flags = (uint16_t)(e->flags | flags),
                    .x = (float)e->x,
                    .y = (float)e->y,
                    .vx = (float)e->vx,
                    .vy = (float)e->vy,
                    .angle = (float)e->angle,
                    .angular_velocity = (float)e->angular_velocity,
                    .age_ms = (float)ll_to_ms(age)};
}

static void fill_entities(const ll_netgame *g, ll_row_set *rows)
{
    const ll_server *server = ll_netgame_server(g);
    const ll_world *world = ll_server_world_const(server);
    entity all[LL_ENTITIES_MAX];
    for (int i = 0; i < world->entities; i++)
        all[i] = entity_of(0, i, &world->entity[i], g->now - server->stepped, 0);
    ll_row_set_put(rows, &entity_record, all, world->entities);
    for (int p = 0; p < g->config.player_count; p++) {
        const ll_client *c = ll_netgame_client(g, p);
        const ll_world *shown = ll_client_rendered_const(c);
        const ll_draw_info *marks = ll_client_draw_infos_const(c);
        for (int i = 0; i < shown->entities; i++)
            all[i] = entity_of(p + 1, i, &shown->entity[i], g->now - marks[i].time, marks[i].flags);
        ll_row_set_put(rows, &entity_record, all, shown->entities);
    }
}

static void fill_views(const ll_netgame *g, ll_row_set *rows)
{
    view all[LL_PLAYERS_MAX + 1];
    all[0] = server_view(g);
    for (int i = 0; i < g->config.player_count; i++)
        all[i + 1] = player_view(g, i);
    ll_row_set_put(rows, &view_record, all, g->config.player_count + 1);
}

/* ---- the game's own values ---- */

typedef struct game_value {
    uint8_t player, index;
    double value;
} game_value;

static const ll_record_field game_fields[] = {
    LL_INT(game_value, player, NULL, "whose"),
    LL_INT(game_value, index, NULL, "index of its name in the hello's layout, game_values"),
    LL_REAL(game_value, value, 23, NULL, "the value; null: none yet"),
};

LL_INTEGERS(game_integers, game_value, game_fields)

static const ll_record game_record = {.id = 4,
                                      .name = "game",
                                      .channel = LL_CHANNEL_SCENE,
                                      .help = "The game's own values of each player.",
                                      .form = LL_FORM_BY_INDEX,
                                      LL_ROWS_OF(game_value, game_fields),
                                      .integers = game_integers};

static void fill_game(const ll_netgame *g, ll_row_set *rows)
{
    const ll_game *game = ll_netgame_game(g);
    for (int p = 0; p < g->config.player_count; p++) {
        double values[LL_GAME_VALUES];
        game_value all[LL_GAME_VALUES];
        int n = 0;
        game->describe(ll_server_world_const(ll_netgame_server(g)), &g->env, p, values);
        for (; n < game->metrics->count; n++)
            all[n] = (game_value){(uint8_t)p, (uint8_t)n, values[n]};
        ll_row_set_put(rows, &game_record, all, n);
    }
}

/* ---- sums of each player's view ----
 *
 * Sums and counts, not means: a viewer takes the difference over any period, and a period without counts has
 * no mean. */

typedef struct measure {
    uint8_t player;
    float age_of_information_ms;
    double own_timeline_error_sum_m, input_latency_sum_ms;
    uint32_t own_timeline_errors, input_latencies, input_changes, input_changes_lost, visible_corrections;
} measure;

static const ll_record_field measure_fields[] = {
    LL_INT(measure, player, NULL, "index of the player"),
    LL_STEP(measure, age_of_information_ms, LL_BITS_MS, "ms", "present age of information"),
    LL_STEP(measure, own_timeline_error_sum_m, LL_BITS_M, "m", "sum of the own timeline error over displays"),
    LL_STEP(measure, input_latency_sum_ms, LL_BITS_MS, "ms", "sum of the input latencies"),
    LL_INT(measure, own_timeline_errors, NULL, "displays in that sum"),
    LL_INT(measure, input_latencies, NULL, "changes of controls in that sum"),
    LL_INT(measure, input_changes, NULL, "changes of controls"),
    LL_INT(measure, input_changes_lost, NULL, "those that were never applied"),
    LL_INT(measure, visible_corrections, NULL, "displays with a visible correction"),
};

LL_INTEGERS(measure_integers, measure, measure_fields)

static const ll_record measure_record = {
    .id = 7,
    .name = "measures",
    .channel = LL_CHANNEL_GAUGES,
    .help = "Sums over each player's view from the warm-up on; a mean is the difference of two sums divided "
            "by that of their counts.",
    .form = LL_FORM_BY_INDEX,
    LL_ROWS_OF(measure, measure_fields),
    .integers = measure_integers};

static measure measure_of(const ll_netgame *g, int i)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(g, i);
    const ll_histogram *error = &in->histogram[LL_METRIC_OWN_TIMELINE_ERROR],
                       *latency = &in->histogram[LL_METRIC_INPUT_LATENCY];
    return (measure){.player = (uint8_t)i,
                     .age_of_information_ms = (float)in->last.age_of_information,
                     .own_timeline_error_sum_m = error->sum,
                     .input_latency_sum_ms = latency->sum,
                     .own_timeline_errors = (uint32_t)error->count,
                     .input_latencies = (uint32_t)latency->count,
                     .input_changes = (uint32_t)(latency->count + latency->never),
                     .input_changes_lost = (uint32_t)in->changes.lost[LL_LATENCY_FELT],
                     .visible_corrections = (uint32_t)in->corrections.visible_m_all.count};
}

static void fill_measures(const ll_netgame *g, ll_row_set *rows)
{
    measure all[LL_PLAYERS_MAX];
    for (int i = 0; i < g->config.player_count; i++)
        all[i] = measure_of(g, i);
    ll_row_set_put(rows, &measure_record, all, g->config.player_count);
}

/* ---- all records ---- */

const ll_record *const ll_netgame_records[] = {&view_record,
                                               &entity_record,
                                               &game_record,
                                               &ll_netgame_projectile_record,
                                               &ll_netgame_buffer_record,
                                               &measure_record,
                                               &ll_netgame_peer_record,
                                               &ll_netgame_input_history_record,
                                               &ll_netgame_buffered_record,
                                               &ll_netgame_shot_record,
                                               &ll_netgame_shot_body_record,
                                               &ll_netgame_traffic_record,
                                               &ll_netgame_link_record,
                                               NULL};

void ll_netgame_fill(const void *block, ll_row_set *rows)
{
    const ll_netgame *g = block;
    if (ll_row_set_wants(rows, &view_record)) {
        fill_views(g, rows);
        fill_entities(g, rows);
        fill_game(g, rows);
        ll_netgame_fill_projectiles(g, rows);
    }
    if (ll_row_set_wants(rows, &ll_netgame_buffer_record)) {
        ll_netgame_fill_buffers(g, rows);
        fill_measures(g, rows);
        ll_netgame_fill_peers(g, rows);
    }
    if (ll_row_set_wants(rows, &ll_netgame_input_history_record))
        ll_netgame_fill_input_history(g, rows);
    if (ll_row_set_wants(rows, &ll_netgame_buffered_record))
        ll_netgame_fill_buffered(g, rows);
    if (ll_row_set_wants(rows, &ll_netgame_shot_record))
        ll_netgame_fill_shots(g, rows);
    if (ll_row_set_wants(rows, &ll_netgame_traffic_record))
        ll_netgame_fill_traffic(g, rows);
}
