/* Lag compensation: how a server judges shots of players who see a past state (paper, "More Challenges").
 *
 * A hitscan policy selects the positions that a shot is judged against. A projectile family says when the
 * flight began and how its past part is tested. Each is a row of a table and a file of its own (hitscan_*.c,
 * projectile_*.c).
 *
 * The rules limit how far the server rewinds: to the client's stated view time, and at most by max_rewind_ms.
 * A client draws its newest snapshot, whose age the server measures, or slightly before it. A stated view age
 * that exceeds the measured one by more than the tolerance is rejected, and the measured one counts (Source's
 * cross-check; Bernier, 2001). A view newer than any snapshot belongs to a client that extrapolates or
 * predicts others. */
#pragma once

#include "game/core/arena.h"
#include "game/core/history.h"

typedef struct ll_compensation {
    double max_rewind_ms, rewind_tolerance_ms, projectile_forward_ms;
    int32_t hitscan, projectile; /* indices into ll_hitscan_policies and ll_projectile_families */
    int32_t projectile_trace;    /* ll_trace */
    int32_t tuned;               /* not of a row: the policies have other parameters than the defaults */
} ll_compensation;

/* Parameters of single hitscan policies. */
typedef struct ll_policy_params {
    double hybrid_full_ms,
        hybrid_none_ms; /* ages of a view: the oldest rewound whole, the first not at all */
    double veto_grace_ms;
} ll_policy_params;

/* How a part of a flight is tested: along the flight itself, along the straight line between its ends, or,
 * for the past part, along the parabola of the same launch without drag. Parts are the past part, then each
 * step. */
typedef enum ll_trace { LL_TRACE_PARABOLA, LL_TRACE_STRAIGHT, LL_TRACE_DRAG_NEGLECTED } ll_trace;

extern const char *const ll_trace_names[];

struct ll_hit_result; /* game/core/weapons.h */

/* What a server's step may rewind to. */
typedef struct ll_past {
    const ll_history *history; /* its newest record is the world before the step */
    const ll_compensation *rules;
    const ll_policy_params *params;
    ll_time measured[LL_PLAYERS_MAX]; /* age of the newest snapshot that each player had */
    ll_time buffer;                   /* an honest client may draw this much before its newest snapshot */
    void (*witness)(void *context, const struct ll_hit_result *hit_result);
    void *context;
} ll_past;

/* A shot as received by the server. */
typedef struct ll_shot {
    int32_t shooter;
    int16_t claim; /* body that the client claims to hit, or LL_NOBODY */
    uint16_t tag;  /* of a projectile */
    ll_point from, direction;
    ll_time now;             /* of the world that it hits */
    ll_time seen;            /* view time of the shooter, limited by the rules */
    bool looks_back;         /* the policy or family uses `seen` */
    bool clamped;            /* judged nearer than the view: by max_rewind_ms or by the policy's share */
    bool view_time_rejected; /* the stated view age was rejected */
} ll_shot;

/* What a shot is judged in. */
typedef struct ll_field {
    const ll_arena *arena;
    const ll_point *present;  /* bodies at `now` */
    const ll_past *past;      /* NULL: no history */
    const ll_action *actions; /* of all players in the step */
} ll_field;

typedef struct ll_hitscan_policy {
    bool rewinds;                                             /* judges against bodies at the view time */
    int (*judge)(const ll_field *field, const ll_shot *shot); /* body that is hit, or LL_NOBODY */
    /* The part of the rewind that a view of this age gets, 0 to 1; NULL: all of it. */
    double (*share)(const ll_policy_params *params, ll_time age);
    /* Whether a hit on `body` counts for its owner too; NULL: always. */
    bool (*stands)(const ll_field *field, const ll_shot *shot, int body);
} ll_hitscan_policy;

typedef struct ll_projectile_family {
    bool looks_back; /* the flight begins at the view time, within the rules, not now */
    bool rewinds;    /* the past part is tested against past bodies, else against present ones */
    bool claims;     /* the client reports the hits of its projectiles; the server does not test them */
    /* Sets the start of the flight, at or before shot->now. Returns what it hit until then. */
    ll_flight_hit (*launch)(const ll_field *field, const ll_shot *shot, const ll_flight *flight,
                            ll_time *start);
} ll_projectile_family;

/* In the order of their names, which end with NULL. */
extern const ll_hitscan_policy ll_hitscan_policies[];
extern const char *const ll_hitscan_names[];
extern const ll_projectile_family ll_projectile_families[];
extern const char *const ll_projectile_names[];

/* ---- for policies and families, and for their tests ---- */

void ll_bodies_now(const ll_arena *arena, const ll_world *world, ll_point *bodies);
void ll_bodies_at(const ll_arena *arena, const ll_history *history, ll_time time, ll_point *bodies);

/* Age of a player's view at the step, as it states it or, where the rules reject that, as measured. */
ll_time ll_view_age(const ll_past *past, int player, uint32_t stated_ns, bool *rejected);

/* Flight and bodies together, record by record, between two times; `start`: time at which the flight
 * began. */
ll_flight_hit ll_flight_through(const ll_arena *arena, const ll_history *history, int shooter,
                                const ll_flight *flight, ll_time start, ll_time from, ll_time to);

/* The first `s` seconds of a flight as the rules test it: the flight or its chord. */
ll_flight ll_traced(const ll_past *past, const ll_flight *flight, double s);
