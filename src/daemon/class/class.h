/* A class as values: phase, question, members, seats, votes. No thread, no lock, no session: classes.h has
 * these. Time is an argument (monotonic ns), and keys come as hashes.
 *
 * A member is a device: who has its token. It watches, holds a seat (a player of the board's netgame, whose
 * inputs it sends) or has a copy of the board. Of its address there is a hash, for the shares of places;
 * there is no name.
 *
 * Places: while one is free, anyone gets it. When the class is full a newcomer gets the place of who is not
 * there, or of the newest member of the address that has the most, as long as that has at least two more than
 * the newcomer's: one device can fill a class, but keeps no other out. The address at which the class was
 * opened, a school's perhaps, keeps half of the places. See places.c.
 *
 * A seat stays with its holder for LL_CLASS_SEAT_NS without a sign of life. Then the script takes it, and
 * any member may claim it; until one does, the holder gets it back by connecting again. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "base/vtime.h"
#include "daemon/support/keys.h"
#include "daemon/support/rate_limits.h"
#include "input/action.h"
#include "param/param.h"

struct cJSON;

enum {
    LL_CLASS_CHOICES = 8,     /* at most, of a question */
    LL_CLASS_LESSON_MAX = 64, /* characters of a lesson's id */
    LL_CLASS_REMOVED = 64     /* devices, and addresses, that stay out: the last ones */
};
#define LL_CLASS_SILENT_NS (6 * LL_SECOND) /* without a sign of life: the seat's state is `away` */
#define LL_CLASS_SEAT_NS (20 * LL_SECOND)  /* then the script takes the seat */
#define LL_CLASS_EVICT_NS (60 * LL_SECOND) /* then a member without connection makes room for a new one */
#define LL_CLASS_SHOW_NS (5 * LL_SECOND)   /* the same for one that never had a connection */

#define LL_CLASS_OUT "device: the teacher has removed it from the class."

typedef enum ll_class_phase {
    LL_CLASS_LOBBY,
    LL_CLASS_PREDICT, /* votes are open */
    LL_CLASS_LOCKED,
    LL_CLASS_RUN,
    LL_CLASS_STOPPED,
    LL_CLASS_EXPLAIN,
    LL_CLASS_CHANGE, /* plays once more, with one thing changed */
    LL_CLASS_FREE,
} ll_class_phase;

typedef enum ll_class_role { LL_CLASS_WATCH, LL_CLASS_PLAY, LL_CLASS_COPY } ll_class_role;

extern const char *const ll_class_phases[], *const ll_class_roles[]; /* NULL-terminated */

typedef enum ll_class_door { LL_CLASS_OPEN, LL_CLASS_CLOSED } ll_class_door;

/* Whom the teacher removes: a member, it and all who came later, or all of its address. */
typedef enum ll_class_reach { LL_CLASS_ONE, LL_CLASS_LATER, LL_CLASS_ADDRESS } ll_class_reach;

extern const char *const ll_class_reaches[]; /* NULL-terminated */

/* What the teacher sets; rows of ll_class_table. */
typedef struct ll_class_settings {
    int32_t phase; /* an ll_class_phase */
    char lesson[LL_CLASS_LESSON_MAX + 1];
    int64_t step, choices, stop_tick;
    bool frozen, together;
    int32_t door; /* an ll_class_door */
} ll_class_settings;

extern const ll_param_table ll_class_table;

/* What a request to join or to change one's role says; rows of ll_class_join_table. */
typedef struct ll_class_wish {
    int32_t role;   /* an ll_class_role */
    int64_t player; /* -1: any that is free */
    bool fresh;     /* a new copy in place of the present one */
} ll_class_wish;

extern const ll_param_table ll_class_join_table;

/* A vote; rows of ll_class_vote_table. */
typedef struct ll_class_ballot {
    int64_t step, choice;
} ll_class_ballot;

extern const ll_param_table ll_class_vote_table;

/* A session that a freeze pauses. */
typedef struct ll_class_link {
    char session[LL_ID_LENGTH + 1]; /* empty: none */
    bool held;                      /* paused by a freeze */
    bool resume;                    /* it played when it was frozen */
} ll_class_link;

typedef struct ll_class_member {
    bool used;
    uint32_t
        number; /* in order of arrival: distinguishes members that had the same place one after the other */
    ll_key_hash token;
    uint64_t client;       /* hash of the address from which it joined */
    int group;             /* of the members of that address: 0 is shown as A */
    int64_t joined_s;      /* seconds since 1970 */
    bool seen;             /* it had a connection */
    ll_time no_seat_until; /* the teacher has freed its seat for others */
    ll_bucket acts;        /* limits its votes and changes of part */
    ll_class_role role;
    int player; /* whose seat it holds; -1: none */
    int choice; /* its vote; -1: none */
    ll_class_link copy;
    int connections;
    ll_time heard;         /* last sign of life */
    int64_t round_trip_ns; /* -1: not measured */
    bool notified;         /* it knows its own state */
} ll_class_member;

/* What the clock of the board is to do next. */
typedef enum ll_class_order { LL_CLASS_NO_ORDER, LL_CLASS_PLAY_BOARD, LL_CLASS_PAUSE_BOARD } ll_class_order;

typedef struct ll_class_board {
    ll_class_link link;
    ll_class_order order;
    int players; /* of a netgame; else 0 */
    char names[LL_PLAYERS_MAX][24];
    double lag_ms[LL_PLAYERS_MAX];
    bool driven[LL_PLAYERS_MAX]; /* its `control` was set to person, for a seat */
    bool script[LL_PLAYERS_MAX]; /* the script has taken the seat of a lost holder */
    bool revoke[LL_PLAYERS_MAX]; /* its last holder may no longer send inputs */
    bool unread;                 /* players and lags are to be read */
    bool resumed;                /* of a stored class, and not seen yet */
    uint32_t params_version;     /* when they were read */
    int64_t tick;
    int status; /* an ll_session_status; -1: unknown */
} ll_class_board;

typedef struct ll_class {
    ll_key_hash teacher;
    uint64_t home; /* hash of the address at which it was opened */
    ll_class_settings now;
    ll_class_board board;
    struct {
        char lesson[LL_CLASS_LESSON_MAX + 1];
        int step, choices; /* choices 0: no question was asked yet */
    } question;
    ll_class_member *members; /* `capacity` places */
    int capacity;
    uint32_t numbers;
    struct {
        ll_key_hash token;
        uint32_t number;
    } removed[LL_CLASS_REMOVED]; /* devices that the teacher has removed; `removals` counts all of them */
    uint64_t barred[LL_CLASS_REMOVED]; /* addresses, as `client`; `bars` counts */
    uint32_t removals, bars;
    uint32_t serial; /* of the broadcast */
    bool changed;    /* to be sent at once */
    bool stirred;    /* to be sent soon: counts and measurements */
} ll_class;

ll_status ll_class_init(ll_class *c, int capacity, const ll_key_hash *teacher);
void ll_class_end(ll_class *c);
ll_class *ll_class_copy(const ll_class *c); /* NULL without memory; the caller ends and frees it */

/* The teacher's merge patch of ll_class_table, all or nothing. LL_BAD_INPUT names field and range. */
ll_status ll_class_change(ll_class *c, const struct cJSON *patch);

/* Another session is on the board (empty: none): votes stay, and seats as far as it has their players. */
void ll_class_set_board(ll_class *c, const char *session);
/* Players as read from the session. A seat that the board does not have becomes a place to watch. */
void ll_class_set_players(ll_class *c, const struct cJSON *params, uint32_t version);
/* The board as last seen. A board that has stopped by itself ends phase `run`. */
void ll_class_see_board(ll_class *c, int status, int64_t tick);

typedef struct ll_class_arrival {
    ll_key_hash token;
    uint64_t client;
    ll_time now;
    int64_t unix_s;
} ll_class_arrival;

/* LL_FORBIDDEN: the door is closed, or the devices of this address stay out; LL_LIMIT: the class is full. */
ll_status ll_class_admits(const ll_class *c, uint64_t client, ll_time now);
/* The place of a new member that watches; -1: the class is full. `copy`: the session of who gave way for it,
 * which is to be deleted; empty: none. */
int ll_class_join(ll_class *c, const ll_class_arrival *arrival, char copy[LL_ID_LENGTH + 1]);
void ll_class_leave(ll_class *c, int place);
int ll_class_find(const ll_class *c, const char *token, size_t length); /* -1: no member's */
/* Whether the teacher has removed the member that had this token, or this number. */
bool ll_class_has_removed(const ll_class *c, const char *token, size_t length);
bool ll_class_has_removed_number(const ll_class *c, uint32_t number);
int ll_class_count(const ll_class *c);               /* members */
int ll_class_at(const ll_class *c, uint64_t client); /* members of this address */

/* The teacher removes a member, and whom `reach` says with it; they stay out. `removed` is called with the
 * copy of each. LL_NOT_FOUND; LL_CONFLICT: the address is that at which the class was opened. */
ll_status ll_class_remove(ll_class *c, uint32_t number, ll_class_reach reach,
                          void (*removed)(void *context, const char *copy), void *context);
/* The teacher frees a seat: its holder watches, and may not take one for LL_CLASS_SEAT_NS. */
ll_status ll_class_free_seat(ll_class *c, int player, ll_time now);

/* LL_LIMIT: the member votes and changes its part too often; else it is counted. */
ll_status ll_class_act(ll_class *c, int place, ll_time now);
ll_status ll_class_may_act(const ll_class *c, int place, ll_time now); /* the same, not counted */

/* Gives the seat of `player`, or with -1 the first free one. LL_CONFLICT: it is taken. */
ll_status ll_class_claim(ll_class *c, int place, int player, ll_time now);
void ll_class_watch(ll_class *c, int place);

/* Idempotent; may change until it is locked. LL_CONFLICT: locked, or another step; LL_BAD_INPUT: no such
 * choice. */
ll_status ll_class_vote(ll_class *c, int place, const ll_class_ballot *ballot);

void ll_class_connected(ll_class *c, int place, ll_time now);
void ll_class_disconnected(ll_class *c, int place, ll_time now);
void ll_class_heard(ll_class *c, int place, int64_t round_trip_ns, ll_time now); /* a pong */

/* Seats whose holders are silent for too long. */
void ll_class_pass_time(ll_class *c, ll_time now);

/* Whether the phase plays the board, as far as `stop_tick`. */
bool ll_class_runs(const ll_class *c);
/* Whether a member drives this player: its `control` has to be person. A lesson shows what its script does:
 * until phase `free` the holders of its seats only watch. */
bool ll_class_drives(const ll_class *c, int player);
int ll_class_holder(const ll_class *c, int player); /* -1: the seat is free */
bool ll_class_is_away(const ll_class_member *member, ll_time now);

/* The class as it outlives the daemon: hashes of keys and tokens, what the teacher set, question, votes,
 * seats, copies. No connections. Caller deletes it. */
struct cJSON *ll_class_save(const ll_class *c);
/* In place of ll_class_init, from what was saved: every member is away, and has LL_CLASS_SEAT_NS from `now`
 * on to come back to its seat. On error nothing is to be freed. */
ll_status ll_class_load(ll_class *c, int capacity, const struct cJSON *json, ll_time now);

/* The broadcast: {"type","serial","phase",...}. */
struct cJSON *ll_class_describe(const ll_class *c, ll_time now);
struct cJSON *ll_class_describe_member(const ll_class *c, int place); /* what only this member receives */
struct cJSON *ll_class_describe_members(const ll_class *c);           /* what only the teacher receives */
