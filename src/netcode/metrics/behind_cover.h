/* Hits behind cover: how long a victim had been behind cover, in its own view, when its client first showed
 * the hit of a hitscan shot. And the hits that a policy did not count.
 *
 * The time counts from the frame in which the line of sight to the shooter, from centre to centre, closed.
 * A hit that is shown while the line is open has none, and a line that never was open does not close. Kept by
 * the observer, behind the other parts of a simulation's block: no pointers. */
#pragma once

#include "netcode/metrics/shots.h"

#define LL_HITS_AWAITED 32 /* hits of a shooter that its victims' clients do not show yet */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded"

typedef struct ll_awaited_hit {
    int64_t step;   /* of the server that judged it; 0: none */
    int64_t victim; /* player */
} ll_awaited_hit;

typedef struct ll_behind_cover_player {
    ll_histogram shown;                   /* ms, of the hits of this shooter */
    int64_t vetoed;                       /* hits of this shooter */
    int64_t judged;                       /* the ring's next index */
    ll_awaited_hit hits[LL_HITS_AWAITED]; /* ring */
    ll_time closed[LL_PLAYERS_MAX];       /* in the own view, by the other player; 0: never */
    uint32_t seen;                        /* bits: the line of sight was open in the last frame */
    uint32_t awaited;                     /* hits in the ring */
} ll_behind_cover_player;

typedef struct ll_behind_cover {
    ll_time from; /* shots that are judged earlier do not count */
    int64_t players;
    ll_behind_cover_player player[];
} ll_behind_cover;

#pragma GCC diagnostic pop

size_t ll_behind_cover_size(int players); /* a multiple of 8 */
void ll_behind_cover_init(ll_behind_cover *cover, int players, ll_time from);

/* A shot that the server judged in `step`. */
void ll_behind_cover_judge(ll_behind_cover *cover, const ll_hit_result *hit_result, int64_t step);

/* After a frame of the client of player `self`, of which `shots` knows what it sees; it shows the effects of
 * the server's steps up to `known`. */
void ll_behind_cover_frame(ll_behind_cover *cover, const ll_shots *shots, int self, int64_t known,
                           ll_time now);
