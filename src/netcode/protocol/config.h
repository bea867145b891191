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

typedef struct ll_server_config {
    double update_hz, timeout_s;
    int64_t max_rollback_ticks, sync_test_ticks;
    int32_t sync;     /* index into ll_syncs */
    int32_t snapshot; /* index into ll_codecs */
    ll_compensation compensation;
    double quantum_m, quantum_mps, quantum_rad, quantum_radps; /* steps of the grid */
    double starved_tau_ms;
    int64_t starved_ticks;
    int32_t starved; /* index into ll_starves */
    int32_t refused; /* ll_refused */
    bool validation;
    uint8_t reserved[7];
} ll_server_config;

typedef enum ll_control { LL_CONTROL_SCRIPT, LL_CONTROL_PERSON } ll_control;

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
    char name[LL_NAME_MAX + 8];
    double lag_ms; /* one way, both directions */
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

/* Reconciliation on turns prediction on; prediction off turns reconciliation off. `before` is the
 * configuration before the change, so that the changed parameter wins. */
void ll_player_apply_dependencies(ll_player_config *now, const ll_player_config *before);
