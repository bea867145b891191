/* Lag compensation: how a server judges shots of players who saw the past (paper, "More Challenges").
 *
 * A rifle needs no time: its policy says against whose positions it is judged. A shell does: its family says
 * when its flight began and what is tested of the part that lies in the past. Each is a row of a table and a
 * file of its own (rifle_*.c, shell_*.c).
 *
 * The rules say how far back a server looks: to what the client says that it saw, and never further than
 * max_rewind_ms. A client draws its newest state, whose age the server measures, or a little before that; a
 * stated age that is more than the tolerance beyond is not believed, and what was measured counts (Source's
 * cross-check; Bernier, 2001). A view that is younger than any state is that of a client that extrapolates or
 * predicts others. */
#pragma once

#include "game/core/arena.h"
#include "game/core/history.h"

typedef struct ll_compensation {
    double max_rewind_ms, rewind_tolerance_ms, shell_forward_ms;
    int32_t rifle, shell; /* indices into ll_rifle_policies and ll_shell_families */
    int32_t shell_trace;  /* ll_trace */
    int32_t reserved;
} ll_compensation;

/* How a stretch of flight is tested: along the parabola, or along the straight line between its ends. A
 * stretch is what is caught up with at once, then each step. */
typedef enum ll_trace { LL_TRACE_PARABOLA, LL_TRACE_STRAIGHT } ll_trace;

extern const char *const ll_trace_names[];

struct ll_judgement; /* game/core/weapons.h */

/* What a server's step may look into. */
typedef struct ll_past {
    const ll_history *history; /* its newest record is the world before the step */
    const ll_compensation *rules;
    ll_time measured[LL_PLAYERS_MAX]; /* how old the newest state was that each player had */
    ll_time buffer;                   /* by so much an honest client may draw behind its newest state */
    void (*witness)(void *context, const struct ll_judgement *judgement);
    void *context;
} ll_past;

/* A shot as the server takes it. */
typedef struct ll_shot {
    int32_t shooter;
    int16_t claim; /* the body that the client says it hits, or LL_NOBODY */
    uint16_t tag;  /* of a shell */
    ll_point from, direction;
    ll_time now;     /* of the world that it meets */
    ll_time seen;    /* of the world that the shooter saw, as far as the rules believe it */
    bool looks_back; /* the policy or family makes use of `seen` */
    bool clamped;    /* max_rewind_ms kept it from looking back as far as the view was old */
    bool distrusted; /* the stated age of the view was not believed */
} ll_shot;

/* Where a shot is judged. */
typedef struct ll_field {
    const ll_arena *arena;
    const ll_point *present; /* the bodies at `now` */
    const ll_past *past;     /* NULL: nothing is known but the present */
} ll_field;

typedef struct ll_rifle_policy {
    const char *name, *help;
    bool rewinds; /* judges against bodies of the time that was seen */
    int (*judge)(const ll_field *field, const ll_shot *shot); /* the body that is hit, or LL_NOBODY */
} ll_rifle_policy;

typedef struct ll_shell_family {
    const char *name, *help;
    bool looks_back; /* the flight begins when the shooter saw, as far as the rules go, and not now */
    bool rewinds;    /* what is caught up with meets bodies of its own time, otherwise those of the present */
    bool claims;     /* the client says what its shells hit: the server does not test them */
    /* Sets when the flight began, at or before shot->now, and tells what it met until then. */
    ll_meeting (*launch)(const ll_field *field, const ll_shot *shot, const ll_flight *flight, ll_time *start);
} ll_shell_family;

extern const ll_rifle_policy *const ll_rifle_policies[];
extern const ll_shell_family *const ll_shell_families[]; /* NULL-terminated; in the order of the names */
extern const char *const ll_rifle_names[];
extern const char *const ll_shell_names[];

/* ---- for policies and families, and for whoever checks them ---- */

void ll_bodies_now(const ll_arena *arena, const ll_world *world, ll_point *bodies);
void ll_bodies_at(const ll_arena *arena, const ll_history *history, ll_time time, ll_point *bodies);

/* Flight and bodies together, record by record, between two moments; `start` is when the flight began. */
ll_meeting ll_flight_through(const ll_arena *arena, const ll_history *history, int shooter,
                             const ll_flight *flight, ll_time start, ll_time from, ll_time to);

/* What the rules test of the first `s` seconds of a flight: itself, or its chord. */
ll_flight ll_traced(const ll_past *past, const ll_flight *flight, double s);
