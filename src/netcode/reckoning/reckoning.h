/* Dead reckoning with send thresholds and convergence (IEEE 1278.1, Distributed Interactive Simulation).
 *
 * Sender and receivers run the same model of an entity's motion from its state when it was last sent. The
 * sender sends it again only when the true one is farther from the model than a threshold, or a heartbeat is
 * due. Between, receivers draw the model at the present by their synchronised clock, from the sender's time
 * stamp: a delay of the network makes errors larger, its jitter alone does not. When a state arrives the
 * drawn one converges to the new model.
 *
 * Part of a simulation's block: no pointers. Lengths in m, angles in rad, times by the server's clock. */
#pragma once

#include "base/histogram.h"
#include "netcode/snapshot/snapshot.h"

typedef struct ll_reckoning_params {
    double threshold_m, threshold_deg; /* farther from the model than this an entity is sent */
    double heartbeat_s;                /* and after this time anyway; 0: never */
    double tau_s;                      /* duration of convergence */
    int32_t model;                     /* index into ll_reckoning_names; 0: no dead reckoning */
    int32_t convergence;               /* index into ll_convergences */
} ll_reckoning_params;

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

/* A state as sent. */
typedef struct ll_reckoned {
    ll_time time; /* -1: none */
    ll_entity entity;
    double ax, ay; /* m/s2; 0 unless the model accelerates */
} ll_reckoned;

/* Drawn - model: at `since`, and its rate of change then. */
typedef struct ll_deviation {
    ll_time since;
    double x, y, angle, vx, vy, angular_velocity;
} ll_deviation;

/* What the sender counts of one receiver. */
typedef struct ll_reckoning_counts {
    int64_t by_threshold, by_heartbeat;
    int64_t first;            /* sent to a receiver that had nothing yet, or whose flags changed */
    int64_t suppressed;       /* states that no update sent */
    ll_histogram model_error; /* m: |true - model|, before the decision to send */
} ll_reckoning_counts;

typedef struct ll_reckoning {
    ll_reckoning_params params;
    ll_time from;  /* counts from here on */
    ll_time moved; /* of the last `motion` */
    int32_t players, entities;
    /* then motion: ll_reckoned[entities]; and per player: ll_reckoning_counts, ll_reckoned[entities] as sent,
     * ll_reckoned[entities] as received, ll_deviation[entities] */
} ll_reckoning;

#pragma GCC diagnostic pop

/* ---- tables ---- */

typedef struct ll_reckoning_model {
    bool accelerates; /* needs ax and ay, which are sent */
    /* The state `s` seconds after it was sent. */
    void (*at)(const ll_reckoned *sent, double s, ll_entity *out);
} ll_reckoning_model;

typedef struct ll_convergence {
    /* What is left of a deviation of `e` and its rate `u` after `t` seconds of `tau`, 0 <= t < tau, and its
     * rate of change then. */
    double (*left)(double e, double u, double tau, double t, double *rate);
} ll_convergence;

extern const ll_reckoning_model *const ll_reckoning_models[]; /* [0] is NULL: none; the end is NULL too */
extern const ll_convergence *const ll_convergences[];         /* NULL-terminated */
extern const char *const ll_reckoning_names[];
extern const char *const ll_convergence_names[];

/* ---- sender and receivers ---- */

size_t ll_reckoning_size(int players, int entities); /* a multiple of 8 */
void ll_reckoning_init(ll_reckoning *reckoning, const ll_reckoning_params *params, int players, int entities,
                       ll_time from);

/* Bits that a message may have beyond a full snapshot's. */
int64_t ll_reckoning_extra_bits(int entities);

const ll_reckoning_counts *ll_reckoning_counted(const ll_reckoning *reckoning, int player);

/* Appends the world of time `now` for a player: its own entity, the others that are due, and the tail.
 * `whole`: the player has no state yet. */
void ll_reckoning_encode(ll_reckoning *reckoning, int player, const ll_world *world, ll_time now, bool whole,
                         ll_bit_writer *w, ll_snapshot_cost *cost);

/* Fills `world`, whose header is set, with the model's world of time `time`. States that the message has
 * replace those before at `now`, the receiver's estimate of the server's present. After an error nothing has
 * changed but `world`. */
ll_status ll_reckoning_decode(ll_reckoning *reckoning, int player, ll_bit_reader *r, ll_world *world,
                              ll_time time, ll_time now);

/* Draws the others of `player` at the server's present `now`. */
void ll_reckoning_draw(const ll_reckoning *reckoning, int player, ll_time now, ll_world *shown);
