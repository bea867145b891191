/* Who hosts a game whose server runs on a player's machine, and who does when that player is gone.
 *
 * A player who has received nothing from the host for `timeout_s` has lost it. It asks the player that it
 * wants as the next host, and promises to ask no other one for `patience_s`. A player who has lost the host
 * too, asks itself, and has the promises of more than half of all players, itself included, hosts from then
 * on. A host goes on only as long as more than half of all players cannot have promised themselves to
 * another: so there is never a second one, and a game that is cut in two goes on in one part at most (as
 * leases do, Gray and Cheriton 1989).
 *
 * Part of a simulation's block: no pointers. What lies in a view is known to that player's machine alone, and
 * what lies in votes and leases to the machine that is asked. */
#pragma once

#include "netcode/protocol/config.h"
#include "netcode/protocol/wire.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

/* What a player says of itself as the next host. */
typedef struct ll_candidacy {
    int64_t tick;       /* of the newest state that it has */
    ll_time round_trip; /* to the host that is lost */
} ll_candidacy;

typedef enum ll_host_news {
    LL_HOST_CANDIDACY = 1, /* of the sender */
    LL_HOST_IS = 2,        /* `host` hosts */
    LL_HOST_FAREWELL = 3,  /* the sender hosts no longer; the world after step `tick` follows */
} ll_host_news;

/* From one player's machine to another's. */
typedef struct ll_host_message {
    ll_message_head head; /* LL_MESSAGE_PING; count: ll_host_news */
    int64_t host;
    ll_candidacy of;
} ll_host_message;

/* A request to host, with the sender's promise. */
typedef struct ll_host_vote {
    ll_time until; /* the voter asks no other player before; 0: none */
    ll_request_message request;
} ll_host_vote;

/* What a player's machine knows. */
typedef struct ll_host_view {
    int64_t target;    /* where its messages to the host go */
    int64_t lost;      /* the host that it has lost; -1: none */
    ll_time since;     /* when it noticed */
    ll_time asked;     /* since when it asks `target`; LL_NEVER: it has asked no one yet */
    int64_t promises;  /* it promises to ask no other one; 0: a message said that `target` hosts */
    ll_time bound;     /* its last promise lasts until then */
    uint64_t departed; /* bits of hosts that it lost earlier, and from which nothing has come since */
    uint64_t again;    /* 1: all have been asked in this outage */
    uint64_t tried;    /* bits of players who did not answer in this outage */
    uint64_t heard;    /* bits of players whose candidacy has come */
    int64_t announced; /* step of the world that the last host left it; -1: none */
    ll_time without;   /* since when no one has hosted its game; LL_NEVER: someone does */
    ll_candidacy of[LL_PEERS_MAX];
    /* For metrics. */
    ll_time without_sum, without_max, hosted;
    ll_time host_from; /* when it began to host last; LL_NEVER: it never has */
    double set_back_m; /* what changes of the host moved its entity by, in all */
} ll_host_view;

typedef struct ll_hosting {
    ll_hosting_params params;
    int64_t players;
    int64_t host;     /* whose machine makes the steps; -1: no one's */
    ll_time since;    /* when it began to host */
    ll_time stopped;  /* when the last one stopped */
    ll_time leaves;   /* when the host leaves; LL_NEVER: it does not */
    int64_t farewell; /* step of the world behind this */
    uint64_t gone;    /* bits of players whose machines have left for good */
    int64_t changes, lost_ticks, again_ticks, step_downs;
    ll_time without;             /* time in which no one hosted, over the game */
    ll_time lease[LL_PEERS_MAX]; /* the player asks no other one to host before; LL_NEVER: it has
                                    not begun to play */
    ll_host_vote votes[LL_PEERS_MAX][LL_PEERS_MAX]; /* by who is asked, and who asks */
    ll_host_view view[LL_PEERS_MAX];
} ll_hosting;

#pragma GCC diagnostic pop

/* A way to choose the next host: one row each. */
typedef struct ll_election {
    const char *name;
    const char *help;
    bool asks; /* players first report their candidacies to each other */
    /* Below 0: `a` is better than `b`; of equal ones the first in the list of players. NULL: all are equal.
     */
    int (*compare)(const ll_candidacy *a, const ll_candidacy *b);
} ll_election;

extern const ll_election ll_election_lowest_index, ll_election_newest_state, ll_election_best_connection;
extern const ll_election *const ll_elections[]; /* NULL-terminated; the index is the choice `election` */
extern const char *const ll_election_names[];

void ll_hosting_init(ll_hosting *hosting, const ll_hosting_params *params, int players);

static inline const ll_election *ll_hosting_election(const ll_hosting *hosting)
{
    return ll_elections[hosting->params.election];
}

static inline ll_time ll_hosting_patience(const ll_hosting *hosting)
{
    return (ll_time)(hosting->params.patience_s * 1e9);
}

/* `player` has lost its host: it knows of itself as a candidate, and of no other. */
void ll_hosting_lose(ll_hosting *hosting, int player, const ll_candidacy *own, ll_time now);

/* Whether it has the candidacies of all who can be the next host. */
bool ll_hosting_heard_all(const ll_hosting *hosting, int player);

/* Whom it asks next: the best of those that it has not asked in this outage, and not the host that it lost,
 * nor one that has departed. When all of these have been asked it begins again, with those too. */
int ll_hosting_choose(ll_hosting *hosting, int player);

/* Something of `other` has come to `player`: it is not gone. */
static inline void ll_hosting_hear_of(ll_hosting *hosting, int player, int64_t other)
{
    hosting->view[player].departed &= ~(UINT64_C(1) << other);
}

/* `player` has been accepted by a host. */
void ll_hosting_join(ll_hosting *hosting, int player, ll_time now);

/* Whether `candidate`, who has asked itself, has promises beyond `at` of more than half of all players. */
bool ll_hosting_elected(const ll_hosting *hosting, int candidate, ll_time at);

/* `host` hosts from `now` on, and the promises to it become leases. */
void ll_hosting_begin(ll_hosting *hosting, int host, ll_time now, ll_time timeout);

/* What a promise up to `until` is worth to a host that lets its player in at `now`: the player is bound by it
 * until it knows, and loses the host `timeout` after that at the earliest. */
static inline ll_time ll_hosting_lease(ll_time until, ll_time now, ll_time timeout)
{
    return until < now + timeout ? until : now + timeout;
}

/* The host hosts no longer. */
void ll_hosting_stop(ll_hosting *hosting, ll_time now);

/* The time-out is `less` shorter from now on: players lose the host earlier, and the leases that they gave
 * end earlier by as much. */
void ll_hosting_shorten(ll_hosting *hosting, ll_time less);

/* The host knows that `player` asks no other one before `until`. */
void ll_hosting_renew(ll_hosting *hosting, int player, ll_time until);

/* Whether the leases that last beyond `at` are more than half of all: no other player can have as many
 * promises. */
bool ll_hosting_holds(const ll_hosting *hosting, ll_time at);
