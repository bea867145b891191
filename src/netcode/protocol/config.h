/* Configuration of a server and of a player; the tables give names, ranges, defaults and help. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "game/core/compensate.h"
#include "link/dejitter/dejitter.h"
#include "link/stages/parameters.h"
#include "param/param.h"

#define LL_NAME_MAX 24
#define LL_ROLLBACK_MAX 16 /* ticks */
#define LL_SYNC_TEST_MAX 8
#define LL_INPUT_DELAY_MAX 16
/* The longest delay of a packet in one direction, see ll_link_delay_max_ms. */
#define LL_ONE_WAY_MAX_MS 1250

/* What replaces a refused input. */
typedef enum ll_refused { LL_REFUSED_NEUTRAL, LL_REFUSED_PREVIOUS } ll_refused;

/* What snapshots contain that do not contain every entity. */
typedef struct ll_selection {
    int64_t bytes;   /* of a snapshot's world; 0: no limit */
    double radius_m; /* of the area of interest; 0: everything */
    double margin_m; /* an entity leaves it this much farther away than it enters */
} ll_selection;

typedef struct ll_server_config {
    ll_selection selection;
    double update_hz, timeout_s;
    int64_t max_rollback_ticks, sync_test_ticks;
    int32_t sync;     /* index into ll_syncs */
    int32_t snapshot; /* index into ll_codecs */
    ll_compensation compensation;
    double quantum_m, quantum_mps, quantum_rad, quantum_radps; /* steps of the grid */
    double starved_tau_ms;
    int64_t starved_ticks;
    int32_t starved;                         /* index into ll_starves */
    int32_t refused;                         /* ll_refused */
    int32_t transport, delivery, congestion; /* ll_transport_kind, ll_delivery, ll_congestion_kind */
    bool validation, nagle;
    uint8_t reckons : 1; /* not of a row: there is dead reckoning */
    uint8_t peers : 7;   /* neither: ll_peers_choice bits */
    bool detection;
} ll_server_config;

/* Where the inputs of the peer-to-peer syncs travel: by the relay server, or from each peer to each other. */
typedef enum ll_topology { LL_TOPOLOGY_RELAY, LL_TOPOLOGY_MESH } ll_topology;

/* What a peer does that is ahead of another: it leaves out frames, or makes them longer. */
typedef enum ll_time_sync { LL_TIME_SYNC_WAIT, LL_TIME_SYNC_STRETCH } ll_time_sync;

/* Choices of the peer-to-peer syncs. A block has them by themselves, and only where one is made. */
typedef struct ll_peers_params {
    int32_t topology;  /* ll_topology */
    int32_t time_sync; /* ll_time_sync */
    int64_t budget_ticks;
    bool adaptive_delay;
    uint8_t reserved[7];
} ll_peers_params;

/* What is chosen other than by default. */
typedef enum ll_peers_choice {
    LL_PEERS_MESH = 1,
    LL_PEERS_STRETCH = 2,
    LL_PEERS_ADAPT = 4,
    LL_PEERS_PACE = LL_PEERS_STRETCH | LL_PEERS_ADAPT, /* leads are reported by fractions of a tick */
} ll_peers_choice;

#define LL_ADAPTIVE_DELAY_MAX 8 /* ticks */

typedef enum ll_control { LL_CONTROL_SCRIPT, LL_CONTROL_PERSON } ll_control;

/* What a client sends of its own entity: controls that move it, or also its state. */
typedef enum ll_authority { LL_AUTHORITY_CONTROLS, LL_AUTHORITY_POSITION } ll_authority;

/* A client that breaks the rules, to test the server's validation. */
typedef enum ll_cheat {
    LL_CHEAT_NONE,
    LL_CHEAT_MAGNITUDE,
    LL_CHEAT_RATE,
    LL_CHEAT_BUDGET,
    LL_CHEAT_VIEW_TIME,
    LL_CHEAT_FIRE_RATE,
    LL_CHEAT_CLAIM,
    LL_CHEAT_TELEPORT,
    LL_CHEAT_LAG_SWITCH,
    LL_CHEAT_AIM_BOT,
    LL_CHEAT_SPEED, /* from here on: cheats that move the own entity (ll_cheat_moves) */
    LL_CHEAT_LEAP,
    LL_CHEATS
} ll_cheat;

/* Correction of a wrongly drawn position. */
typedef enum ll_correction { LL_CORRECTION_SNAP, LL_CORRECTION_SMOOTH } ll_correction;

/* The clock by which a client knows the server's present when it extrapolates. */
typedef enum ll_extrapolation_clock { LL_CLOCK_MEASURED, LL_CLOCK_ARRIVAL } ll_extrapolation_clock;

typedef struct ll_link_pair {
    int32_t preset; /* index into ll_link_presets; later changes of up and down apply on top */
    int32_t reserved;
    ll_link_params up, down;
} ll_link_pair;

typedef struct ll_player_config {
    char name[LL_NAME_MAX + 4];
    int32_t authority; /* ll_authority */
    double lag_ms;     /* one way, both directions */
    ll_link_pair link;
    double interpolation_ratio, jitter_margin_ms, extrapolation_ms, correction_half_life_ms;
    double timer_jitter_ms, dejitter_ms, reconciliation_tolerance_m;
    double clock_phase, drift_ppm;                       /* -1: random phase */
    double send_hz, display_hz;                          /* 0: with every tick; as the scenario's tick_hz */
    double input_hz, input_device_ms, display_device_ms; /* 0 Hz: the device is read at once */
    int64_t slack_ticks, input_delay_ticks;
    int64_t redundancy;
    int64_t lane;                                                  /* -1: the player's own */
    int32_t interpolation_method, interpolation_delay, time_scale; /* indices into the tables of view.h */
    int32_t correction;                                            /* ll_correction */
    int32_t dejitter;                                              /* ll_dejitter_choice */
    int32_t control, script, cheat, float_mode;
    int32_t prediction_scope;    /* index into ll_scopes */
    int32_t ack;                 /* index into ll_acks */
    int32_t clock_filter;        /* index into ll_clock_filters */
    int32_t extrapolation_clock; /* ll_extrapolation_clock */
    bool prediction, reconciliation, interpolation, time_dilation;
} ll_player_config;

extern const ll_param_table ll_server_table;
extern const ll_param_table ll_player_table;
extern const ll_param_table ll_policy_table;      /* of ll_policy_params */
extern const ll_policy_params ll_policy_defaults; /* those of its rows */
extern const ll_param_table ll_reckoning_table;   /* of ll_reckoning_params */
extern const ll_param_table ll_peers_table;       /* of ll_peers_params */

/* The ll_peers_choice bits of these parameters. */
uint8_t ll_peers_choices(const ll_peers_params *params);

/* Reconciliation on turns prediction on; prediction off turns reconciliation off. `before` is the
 * configuration before the change, so that the changed parameter wins. */
void ll_player_apply_dependencies(ll_player_config *now, const ll_player_config *before);
