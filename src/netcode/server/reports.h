/* Client-authoritative movement with server validation (paper, Figures 6 and 7): players who report the state
 * of their own entity, next to players who send controls.
 *
 * The server steps the world with the controls of all players. Then a reported state replaces that of its
 * player's entity, if the entity can have got there: within what the game's own step permits since the last
 * accepted state, and an allowance. The allowance is one for the whole connection, so that a cheat gains it
 * once. Otherwise the server keeps its own state, and its next snapshots say that the client must take that.
 *
 * Part of a simulation's block: no pointers. */
#pragma once

#include "netcode/protocol/report.h"
#include "netcode/server/server.h"

#define LL_REPORT_RING 256 /* by step; not less than ll_budget_ticks */

typedef struct ll_report_params {
    double allowance_m;
} ll_report_params;

extern const ll_param_table ll_report_table; /* of ll_report_params */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef struct ll_report {
    int64_t tick; /* the step whose result this is; 0: empty */
    ll_motion state;
} ll_report;

/* What the server knows of one player's reports. */
typedef struct ll_report_slot {
    ll_entity anchor;     /* the last state that is certain: accepted, or the server's own after a refusal */
    int64_t anchor_step;  /* its step */
    double used_m;        /* of the allowance */
    uint32_t refused_seq; /* the newest input whose report was refused; 0: none */
    uint16_t epoch;       /* of the connection that the anchor belongs to */
    uint16_t reports;     /* 1: its `authority` is position */
    int64_t accepted, refused, late, missing;
    ll_report ring[LL_REPORT_RING];
} ll_report_slot;

typedef struct ll_reports {
    double allowance_m;
    int64_t players;
    ll_report_slot slot[];
} ll_reports;

#pragma GCC diagnostic pop

static inline size_t ll_reports_size(int players)
{
    return sizeof(ll_reports) + (size_t)players * sizeof(ll_report_slot);
}

/* `reports` must be zeros. */
void ll_reports_init(ll_reports *reports, const ll_report_params *params, int players);
static inline void ll_reports_watch(ll_reports *reports, int player)
{
    reports->slot[player].reports = 1;
}

/* Keeps the state that the ll_input_message contains, if it has one for a step to come. After
 * ll_server_receive, which has judged the inputs. */
void ll_reports_take(ll_reports *reports, const ll_server *server, int player, const void *packet);

/* After a step: takes or refuses the states reported for it. Returns a bit for each player whose report was
 * refused. Cost per report: four steps of an entity for each step since the last accepted one. */
uint64_t ll_reports_apply(ll_reports *reports, ll_server *server, const ll_game *game,
                          const ll_game_env *env);

/* Completes a snapshot message to `player`: it says which report was refused last. */
void ll_reports_mark(const ll_reports *reports, int player, void *packet);
