// clang-format off
/* What a viewer gets: one frame of a session, encoded once and shared by all who look.
 *
 * Binary (`laglab.v1.bin`), little-endian, every part 8-aligned:
 *
 *   header, 80 bytes
 *      0 u16 type        1 = frame
 *      2 u16 flags       1 key (events cover the whole window) 2 playing 4 ended 8 behind the head (replaying) 16 failed
 *      4 u32 seq         counts the frames of a session's stream; the viewer acknowledges it
 *      8 f64 time_s      virtual time
 *     16 f64 head_s      the furthest time of the log
 *     24 f64 duration_s
 *     32 i64 tick
 *     40 f64 speed
 *     48 u64 wall_ns     the daemon's monotonic clock when the frame was published
 *     56 u32 params_version   read the parameters again when it differs
 *     60 u32 generation       time has jumped when it differs: drop charts, dots and lanes
 *     64 u32 viewers
 *     68 u32 sections
 *     72 u64 reserved
 *   sections, each
 *      0 u16 type   2 u16 count (records)   4 u32 bytes (of all records; a multiple of 8)   8 records
 *
 *   section 1, views of a netgame: record 0 is the server, record 1 + p player p; stride = bytes / count
 *      0 u8 view         1 u8 entities       2 u16 flags  1 prediction 2 reconciliation 4 interpolation 8 buffer under-run
 *                                                         16 stalled (waits for an input) 32 driven by a person
 *                                          bits 8 to 10: connection 0 connecting 1 synchronising 2 playing 3 stalled 4 resynchronising
 *                                          5 disconnected (the server's own says playing)   2048 the server does not have the player connected
 *      4 u32 input_seq   last sent           8 u32 acked_seq             12 u32 unacked
 *     16 f32 lag_ms     20 f32 view_age_ms   of the remote entities      24 f32 own_lead_m (M4b, signed: drawn - server now)
 *     28 f32 remote_error_m (M4c, largest, signed)                       32 f32 buffer_ms (newest snapshot - drawn time)
 *     36 f32 slack_ticks (input early at the server; negative: late; NaN: not known)     40 u32 corrections
 *     44 f32 correction_m (last)   48 u32 refused (by the server)   52 f32 alpha (between the two snapshots)
 *     56 f64 shown_s    server time of the remote entities as drawn
 *     64 entities, 32 bytes each: f32 x, y, vx, vy, angle, spin, age_ms; u32 flags 1 finished 2 predicted 4 interpolated 8 held (no data)
 *                                                                     16 active (a projectile in flight) 32 extrapolated
 *                                                                     64 unsettled (overlaps what it was pushed into)
 *                                                                     128 away (its player is not connected)
 *   section 2, events, 32 bytes each (sim.h ll_event)
 *      0 u32 id   4 u8 type  5 u8 player  6 u8 fate  7 u8 outcome   8 f64 begin_s  16 f64 end_s  24 u32 number  28 f32 value
 *      Times below 0 are of the lobby before the game.
 *      A frame repeats the events of the last 8 frames, a key frame those of the last 4 s: a viewer keeps them by id.
 *      Key frames go to a new viewer, after a jump of time, and after a gap of more than 8 frames, but not to one whose link
 *      they would choke.
 *   section 3, the game's own values, f64 each: record = player; their names stand in the hello's layout
 *   section 4, shots, in a game with weapons: of each player the last of each weapon that the server took, not older than 5 s;
 *   stride = bytes / count
 *      0 u8 player   1 u8 weapon  0 rifle 1 shell   2 u8 bodies   3 u8 flags  1 taken 2 clamped to max_rewind_ms
 *                                                                             4 stated age of view not believed 8 shot behind cover
 *      4 u32 tick    the step that it was meant for; with player and weapon it names the shot
 *      8 f64 pressed_s  16 f64 seen_s (of the shooter's picture)  24 f64 judged_s (the server's present)  32 f64 looked_s (of what it
 *                                                                                                         was judged against)
 *     40 f32 x, y, dx, dy    muzzle and unit direction as pressed        56 f32 server_x, server_y   the muzzle at the server
 *     64 i32 client_view_hit, server_now_hit, compensated_hit, perfect_hit   the body, -1 nobody, -2 not known yet
 *     80 bodies, 24 bytes each: f32 seen_x, seen_y, now_x, now_y, looked_x, looked_y   at the times seen_s, judged_s, looked_s
 *   section 5, clients with worlds of their own (deterministic, rollback; otherwise no record): record = player, 64 bytes
 *      0 i64 confirmed   tick up to which all inputs have come            8 i64 tick        that is drawn
 *     16 i64 desync_tick first that differs from the server's, -1: none  24 u32 waiting     bit p: stalls for player p
 *     28 u32 stalls     32 f32 stalled_s  36 u32 rollbacks  40 u32 rollback_ticks (made again)
 *     44 i32 desync_entity (-1: the game's tail)   48 u32 desync_field 0 x 1 y 2 vx 3 vy 4 angle 5 spin 6 flags 7 tail
 *     52 f32 desync_m    distance now              56 f64 desync_ulps   of that field at that tick
 *   section 6, buffers of the players' views: record = player, 32 bytes
 *      0 u8 player       1 u8 state  0 draws the newest state 1 normal 2 catching up 3 slowing 4 starved 5 extrapolating
 *      4 f32 delay_ms (interpolation delay in use)          8 f32 behind_ms (drawn time behind the newest that could be known)
 *     12 f32 time_scale 16 f32 dejitter_ms (in use)        20 u32 underruns   24 u32 overruns   28 u32 late (at the de-jitter buffer)
 *   section 7, the reconciliation ladder: of each player who reconciles the last 32 inputs, oldest first, 24 bytes each
 *      0 u8 player       1 u8 state  0 open 1 acknowledged 2 refused 3 late 4 lost
 *      2 u8 known        1 predicted_x holds 2 server_x holds; with both correction_m holds
 *      4 u32 seq         8 f32 made_ms (from the frame's time on: negative)
 *     12 f32 predicted_x (of the own entity after it, as predicted last)     16 f32 server_x (in the state that acknowledged it)
 *     20 f32 correction_m (server_x - predicted_x)
 *   section 8, states in these buffers, 24 bytes each, by player; at most 16 each of a place, from the one that is drawn on
 *      0 u8 player       1 u8 place  0 snapshot buffer 1 de-jitter buffer
 *      4 u32 tick        8 f32 time_ms (its server time - the drawn one)
 *     12 f32 sent_ms    16 f32 arrived_ms   20 f32 due_ms (played out): from the frame's time on; negative: before it
 *   section 9, shells in flight, in a game with weapons, as each view has them, 40 bytes each
 *      0 u8 view   1 u8 player (whose)   2 u16 number   4 f32 flown_s   8 f32 x, y, vx, vy   24 f32 from_x, from_y, from_vx, from_vy
 *   section 10, what is counted of the players' views from the warm-up on: record = player, 48 bytes; a mean is the difference of two
 *   sums by that of their counts
 *      0 u8 player   4 f32 age_of_information_ms (now)   8 f64 own_timeline_error_sum_m   16 f64 input_latency_sum_ms
 *     24 u32 own_timeline_errors (displays)   28 u32 input_latencies (changes of controls that were felt)   32 u32 input_changes
 *     36 u32 input_changes_lost (never applied)   40 u32 visible_corrections (displays)
 *   section 16, a motion: record 0 is the solution, record 1 + i method i; stride = bytes / count
 *      0 u8 index   1 u8 status 0 ok 1 diverged 2 off 3 failed   2 u16 components   8 f64 t_s (of the last step)   16 f64 error
 *     24 f64 error_max  32 f64 energy_drift  40 f64 evaluations  48 f64 steps  56 f64 rejected
 *     64 f64 error_max_weighted   72 state, f64 each
 *   section 32, worlds of rigid bodies, 152 bytes each
 *      0 u8 world   1 u8 status 0 ok 1 diverged   2 u8 solver   3 u8 dragging   4 u32 bodies, awake, pairs, touching, points, recycled,
 *      tested, islands, passed, stopped, joints    48 f64 energy, energy_start, kinetic, penetration, penetration_worst, sag, drift,
 *      tilt, joint_error, speed_max, momentum_x, momentum_y    144 u32 swept, dynamic
 *   section 33, geometries: each of those that differ once, in the frame of the centre of mass, 120 bytes each
 *      0 u8 kind 0 circle 1 capsule 2 polygon 3 segment 4 link of a chain   1 u8 count   2 u16 number   4 f32 radius
 *      8 f32 x, y of 8 vertices (of a link two, then its ghosts)   72 f32 x, y, radius of the sphere around, 0   88 f32 x, y of the OBB's corners
 *   section 34, shapes, 64 bytes each
 *      0 u32 body (from 1)   4 u16 geometry   6 u8 world   7 u8 flags 1 dynamic 2 kinematic 4 awake
 *      8 f64 x, y (of the centre of mass)   24 f32 angle, vx, vy, spin   40 f32 left, bottom, right, top (box of the broad phase, from x, y)
 *     56 u32 island (bodies that hang together; 0: none)
 *   section 35, pairs of overlapping boxes, at most 8,192, 72 bytes each
 *      0 u32 a, b (bodies)   8 u8 world   9 u8 count (points; 0: they do not touch)   10 u8 recycled   12 f32 nx, ny (from a to b)
 *     24 points, 24 bytes each: f64 x, y; f32 separation, impulse
 *   section 36, joints, at most 8,192, 48 bytes each
 *      0 u32 a, b   8 u8 world   9 u8 type   16 f64 ax, ay, bx, by (anchors)
 *   section 37, bounding volumes, where they are compared, 56 bytes each
 *      0 u8 world   1 u8 volume 0 exact 1 aabb 2 sphere 3 obb   8 f64 tests, hits, false_hits, missed_hits, gap_mean, gap_max
 *   sections 48 to 51, fluids: of those side by side each has its own, one behind the other
 *   section 48, a fluid: one record
 *      0 u8 status 0 ok 1 diverged   1 u8 held (a person stirs)   2 u16 numbers   4 u32 ticks   8 numbers, f64 each: their names stand in
 *      the hello's layout
 *   section 49, the field that is shown, of fluids that have fields: one record
 *      0 u8 layer (in the hello's layout)   1 u8 columns   2 u16 fluid (0 the first)   4 u32 width, height   12 u32 values   16 f32 low, high
 *     24 values, u8 each, row by row from the bottom, 0 to 254 from low to high, 255 where there is no fluid; zeros fill up eights
 *   section 50, points of fluids that have them; section 51, a second layer of them: one record
 *      0 as in section 49; low and high are 0   24 values, f32 each: width records of columns; a zero fills up pairs
 *
 * JSON (`laglab.v1.json`): {"type":"frame", ...the same names..., "views":[{...,"entities":[...]}],"events":[...],"game":[[...]],"peers":[...]}. */
// clang-format on
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "session/session.h"

#define LL_FRAME_WINDOW 4     /* frames in flight to a viewer that acknowledges */
#define LL_FRAME_REPEAT 8     /* frames whose events a frame repeats */
#define LL_FRAME_WINDOW_S 4.0 /* events of a key frame */

typedef enum ll_frame_format { LL_FRAME_BINARY, LL_FRAME_JSON } ll_frame_format;

/* Growing buffer owned by the caller; start with zeroes, free `bytes` at the end. */
typedef struct ll_buffer {
    char *bytes;
    size_t size, capacity;
} ll_buffer;

/* Encodes the present tick. `key` asks for the whole event window. The buffer is overwritten and grows as
 * needed. */
ll_status ll_frame_encode(ll_session *session, ll_frame_format format, bool key, uint32_t seq,
                          uint64_t wall_ns, uint32_t viewers, ll_buffer *buffer);

/* The first message of a stream: protocol, layout of the kind's sections, window, the scenario's present
 * params. Caller frees. */
char *ll_frame_hello(ll_session *session, const char *session_id, ll_frame_format format);
