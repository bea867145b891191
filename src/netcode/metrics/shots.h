/* Shot statistics: the result of every shot according to four judges. Kept by the observer, who sees the
 * clients' rendered views and the truth.
 *
 * - view: what the shooter's client drew: does the aim at the press hit in its view? A projectile flies on in
 *   the views that follow.
 * - now: the server without lag compensation: the shot as the server received it, in its present (a
 *   projectile: of family A).
 * - server: what counted, by the server's policy.
 * - perfect: a network without delay: the aim at the press, against the truth at that moment.
 *
 * A judge names the body that is hit; two judges agree if they name the same body, or both none. Only in
 * games with weapons. Part of a simulation's block: no pointers. */
#pragma once

#include "base/histogram.h"
#include "game/core/weapons.h"

#define LL_SHOTS_KEPT 32 /* of each player's presses, until all judges have decided */

typedef enum ll_judge { LL_JUDGE_VIEW, LL_JUDGE_NOW, LL_JUDGE_SERVER, LL_JUDGE_PERFECT, LL_JUDGES } ll_judge;

typedef enum ll_shot_flag {
    LL_SHOT_TAKEN = 1,              /* the server has evaluated it */
    LL_SHOT_CLAMPED = 2,            /* max_rewind_ms did not reach back to the view */
    LL_SHOT_VIEW_TIME_REJECTED = 4, /* the server rejected the stated view age */
    LL_SHOT_BEHIND_COVER = 8,
    LL_SHOT_LOST = 16,    /* its input came too late or not at all, or the weapon was not ready */
    LL_SHOT_REWOUND = 32, /* by its policy or family; max_rewind_ms does not limit other shots */
} ll_shot_flag;

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef struct ll_shot_record {
    int64_t tick;          /* the step that its input was meant for; 0: none */
    ll_time pressed, seen; /* time of the press, and render time of the view; by the server's clock */
    ll_time evaluated_at,
        rewound_to;  /* the server's present, and the time of the bodies that the shot was judged against */
    ll_aim aim;      /* at the press */
    ll_point muzzle; /* at the server */
    int32_t weapon;  /* ll_weapon */
    uint32_t number; /* of a projectile: the server's number */
    int16_t body[LL_JUDGES]; /* or LL_NOBODY */
    uint8_t decided;         /* bits of ll_judge */
    uint8_t flags;           /* ll_shot_flag */
    uint8_t reserved[6];
} ll_shot_record;

typedef struct ll_shot_tally {
    int64_t shots; /* shots that all judges have decided */
    int64_t lost;
    int64_t hits[LL_JUDGES];
    int64_t agreed;                   /* server and view agree */
    int64_t within, within_agreed;    /* of these, shots rewound as far as the view was old */
    int64_t false_hits, false_misses; /* of the server against the view */
    int64_t kept;                     /* hits in the view that counted */
    int64_t on_players, behind_cover; /* hits that counted */
    int64_t clamped, view_time_rejected;
} ll_shot_tally;

/* Kept per player. */
typedef struct ll_shot_stats {
    int64_t presses;          /* the ring's next index */
    int64_t settled;          /* earlier presses are settled */
    int64_t last[LL_WEAPONS]; /* index of the newest that the server evaluated; -1 */
    ll_shot_tally tally[LL_WEAPONS];
    ll_histogram rollback;        /* m: |body now - body where it was judged|, of the body that is hit */
    ll_histogram rewind;          /* ms: how far the server rewound */
    ll_histogram trace_error;     /* m: of a projectile's traced path against its flight */
    ll_histogram peek[2];         /* ms, peeker's advantage: it saw first, or together; the other saw first */
    ll_time opened[LL_PEERS_MAX]; /* when the line of sight to each other player opened in the own view */
    ll_time moved;                /* when the own entity was last drawn in motion */
    uint32_t sees,
        peeking; /* bits: the line of sight is open; it opened by the own motion and is not matched yet */
    uint32_t
        awaiting; /* bits: it opened while the own entity had stood for a second, and is not matched yet */
    uint32_t reserved;
    ll_shot_record records[LL_SHOTS_KEPT];
} ll_shot_stats;

typedef struct ll_shots {
    ll_time from; /* earlier presses do not count */
    ll_time stepped;
    ll_arena arena;
    ll_shot_stats
        shot_stats[]; /* per player; then the bodies as seen: per player and record, {float x, y} each */
} ll_shots;

#pragma GCC diagnostic pop

/* A press as its client made it; `body` is the body that a hitscan shot hits in the rendered view. */
typedef struct ll_press {
    int64_t tick;
    ll_time pressed, seen;
    ll_aim aim;
    int body;
} ll_press;

size_t ll_shots_size(int players, int bodies); /* a multiple of 8 */
void ll_shots_init(ll_shots *shots, const ll_arena *arena, ll_time from);

/* From a client: a press on a view with `bodies`, and later the end of its projectile in its views. */
void ll_shots_press(ll_shots *shots, int player, ll_weapon weapon, const ll_press *press,
                    const ll_point *bodies);
void ll_shots_seen(ll_shots *shots, int player, int64_t tick, int body);

/* What a client draws of its player `self` and the others. */
typedef struct ll_sight {
    const ll_world *shown;
    int self;
} ll_sight;

/* From the server's step `tick`; `world` is the world before that step. `victim` is what the client of the
 * hit player draws; NULL: no player was hit. */
void ll_shots_judge(ll_shots *shots, const ll_hit_result *hit_result, int64_t tick, const ll_history *history,
                    const ll_world *world, const ll_sight *victim);

/* After the server's step `tick`, whose world the history has. */
void ll_shots_step(ll_shots *shots, int64_t tick, const ll_history *history);

/* After a frame of a client: the players that it sees. Peeker's advantage: the line of sight opens between
 * two players while one moves and the other has stood for a second. The advantage is the time at which the
 * standing player's client draws it open minus the time at which the moving player's client does. It belongs
 * to the moving player, and is negative if the other saw first. */
void ll_shots_frame(ll_shots *shots, const ll_sight *sight, ll_time now);

/* Peeker's advantage of a player, with its sign, ms. */
ll_summary ll_shots_peeks(const ll_shot_stats *shot_stats);

/* The newest shot of `player` that the server evaluated, and the bodies as the player saw them; NULL:
 * none. */
const ll_shot_record *ll_shots_last(const ll_shots *shots, int player, ll_weapon weapon,
                                    const float (**seen)[2]);
