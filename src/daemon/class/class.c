/* Members, seats, votes and phases of a class. */
#include "daemon/class/class.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "session/session.h"

#define ACTS_PER_S 2.0 /* votes and changes of part of a member */
#define ACTS_BURST 20.0

/* ---- begin and end ---- */

ll_status ll_class_init(ll_class *c, int capacity, const ll_key_hash *teacher)
{
    memset(c, 0, sizeof *c);
    ll_param_defaults(&ll_class_table, &c->now);
    c->teacher = *teacher;
    c->board.status = -1;
    c->members = calloc((size_t)capacity, sizeof *c->members);
    c->capacity = c->members ? capacity : 0;
    return c->members ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: class");
}

void ll_class_end(ll_class *c)
{
    free(c->members);
    c->members = NULL;
    c->capacity = 0;
}

ll_class *ll_class_copy(const ll_class *c)
{
    size_t size = (size_t)c->capacity * sizeof *c->members;
    ll_class *copy = malloc(sizeof *copy);
    ll_class_member *members = malloc(size);
    if (!copy || !members) {
        free(copy);
        free(members);
        return NULL;
    }
    *copy = *c;
    copy->members = members;
    memcpy(members, c->members, size);
    return copy;
}

/* ---- the teacher ---- */

static void ask(ll_class *c)
{
    const ll_class_settings *s = &c->now;
    if (strcmp(c->question.lesson, s->lesson) == 0 && c->question.step == s->step &&
        c->question.choices == s->choices)
        return; /* asked again: votes stay, and may change */
    memcpy(c->question.lesson, s->lesson, sizeof c->question.lesson);
    c->question.step = (int)s->step;
    c->question.choices = (int)s->choices;
    for (int i = 0; i < c->capacity; i++) {
        c->members[i].notified = c->members[i].notified && c->members[i].choice < 0;
        c->members[i].choice = -1;
    }
}

static void enter_phase(ll_class *c)
{
    switch (c->now.phase) {
    case LL_CLASS_PREDICT:
        ask(c);
        c->board.order = LL_CLASS_PAUSE_BOARD;
        break;
    case LL_CLASS_LOCKED:
    case LL_CLASS_STOPPED:
        c->board.order = LL_CLASS_PAUSE_BOARD;
        break;
    case LL_CLASS_RUN:
    case LL_CLASS_CHANGE:
    case LL_CLASS_FREE:
        c->board.order = LL_CLASS_PLAY_BOARD;
        break;
    default: /* the clock stays as it is */
        break;
    }
}

ll_status ll_class_change(ll_class *c, const cJSON *patch)
{
    ll_class_settings settings = c->now;
    bool asks = cJSON_HasObjectItem(patch, "phase") || cJSON_HasObjectItem(patch, "lesson") ||
                cJSON_HasObjectItem(patch, "step") || cJSON_HasObjectItem(patch, "choices");
    ll_status status = ll_param_merge(&ll_class_table, patch, &settings);
    if (ll_failed(&status))
        return status;
    c->now = settings;
    c->changed = true;
    if (cJSON_HasObjectItem(patch, "phase") || (asks && settings.phase == LL_CLASS_PREDICT))
        enter_phase(c);
    return status;
}

/* ---- the board ---- */

int ll_class_holder(const ll_class *c, int player)
{
    for (int i = 0; i < c->capacity; i++)
        if (c->members[i].used && c->members[i].player == player)
            return i;
    return -1;
}

static void free_seat(ll_class *c, int place)
{
    ll_class_member *m = &c->members[place];
    if (m->player < 0)
        return;
    c->board.script[m->player] = false;
    c->board.revoke[m->player] = true;
    m->player = -1;
    m->role = LL_CLASS_WATCH;
    m->notified = false;
    c->changed = true;
}

void ll_class_set_board(ll_class *c, const char *session)
{
    ll_class_board board = {.status = -1, .unread = *session != '\0'};
    for (int i = 0; i < c->capacity; i++) {
        ll_class_member *m = &c->members[i];
        if (!*session)
            free_seat(c, i);
        if (m->player < 0)
            continue;
        board.script[m->player] = c->board.script[m->player];
        m->notified = false; /* so that it authenticates at this one */
    }
    memcpy(board.link.session, session, strlen(session) + 1);
    if (strcmp(session, c->board.link.session) == 0)
        memcpy(board.driven, c->board.driven, sizeof board.driven);
    if (*session && c->now.phase == LL_CLASS_FREE)
        board.order = LL_CLASS_PLAY_BOARD;
    c->board = board;
    c->changed = true;
}

static bool set_player(ll_class_board *board, int p, const cJSON *player)
{
    const cJSON *name = cJSON_GetObjectItemCaseSensitive(player, "name");
    const cJSON *lag = cJSON_GetObjectItemCaseSensitive(player, "lag_ms");
    char text[sizeof board->names[0]] = "";
    double lag_ms = lag ? lag->valuedouble : 0;
    if (cJSON_IsString(name) && strlen(name->valuestring) < sizeof text)
        memcpy(text, name->valuestring, strlen(name->valuestring) + 1);
    bool same =
        strcmp(text, board->names[p]) == 0 && lag_ms >= board->lag_ms[p] && lag_ms <= board->lag_ms[p];
    memcpy(board->names[p], text, sizeof text);
    board->lag_ms[p] = lag_ms;
    return !same;
}

void ll_class_set_players(ll_class *c, const cJSON *params, uint32_t version)
{
    ll_class_board *board = &c->board;
    const cJSON *player, *players = cJSON_GetObjectItemCaseSensitive(params, "players");
    int count = 0;
    cJSON_ArrayForEach(player, players)
    {
        if (count == LL_PLAYERS_MAX)
            break;
        c->changed = set_player(board, count++, player) || c->changed;
    }
    for (int i = 0; i < c->capacity; i++)
        if (c->members[i].player >= count)
            free_seat(c, i);
    c->changed = c->changed || count != board->players;
    board->players = count;
    board->params_version = version;
    board->unread = false;
}

void ll_class_see_board(ll_class *c, int status, int64_t tick)
{
    ll_class_board *board = &c->board;
    bool playing = status == LL_SESSION_PLAYING;
    bool waits = board->order != LL_CLASS_NO_ORDER || c->now.frozen || board->link.held;
    bool stopped = board->status >= 0 && status != board->status && !playing;
    if (board->resumed && playing && ll_class_runs(c))
        board->order = LL_CLASS_PLAY_BOARD; /* again as far as its stop */
    stopped = stopped || (board->resumed && !playing);
    board->resumed = false;
    if (stopped && c->now.phase == LL_CLASS_RUN && !waits) {
        c->now.phase = LL_CLASS_STOPPED;
        c->changed = true;
    }
    c->changed = c->changed || status != board->status || (!playing && tick != board->tick);
    board->status = status;
    board->tick = tick;
}

bool ll_class_runs(const ll_class *c)
{
    return c->now.phase == LL_CLASS_RUN || c->now.phase == LL_CLASS_CHANGE;
}

bool ll_class_drives(const ll_class *c, int player)
{
    bool shows = c->now.lesson[0] && c->now.phase != LL_CLASS_FREE;
    return !shows && ll_class_holder(c, player) >= 0 && !c->board.script[player];
}

/* ---- members ---- */

void ll_class_leave(ll_class *c, int place)
{
    free_seat(c, place);
    memset(&c->members[place], 0, sizeof c->members[place]);
    c->stirred = true;
}

int ll_class_find(const ll_class *c, const char *token, size_t length)
{
    int found = -1;
    for (int i = 0; i < c->capacity; i++)
        if (c->members[i].used && ll_key_matches(&c->members[i].token, token, length))
            found = i;
    return found;
}

static ll_status count_act(ll_bucket *acts, ll_time now)
{
    return ll_bucket_take(acts, ACTS_PER_S, ACTS_BURST, now)
               ? ll_ok()
               : ll_error(LL_LIMIT, "Too many votes and changes of part from this device.");
}

ll_status ll_class_act(ll_class *c, int place, ll_time now)
{
    return count_act(&c->members[place].acts, now);
}

ll_status ll_class_may_act(const ll_class *c, int place, ll_time now)
{
    ll_bucket acts = c->members[place].acts;
    return count_act(&acts, now);
}

static void name_seat(const ll_class *c, int player, char text[48])
{
    snprintf(text, 48, "%d (%s)", player, c->board.names[player]);
}

static ll_status choose_seat(const ll_class *c, int place, int *player)
{
    int players = c->board.players;
    char name[48];
    if (players == 0)
        return ll_field_error(LL_CONFLICT, "role", "role: the board has no players; only watch or copy.");
    for (int pass = 0; pass < 2 && *player < 0; pass++) {
        for (int p = 0; p < players && *player < 0; p++) {
            int holder = ll_class_holder(c, p);
            if (holder < 0 || holder == place || (pass == 1 && c->board.script[p]))
                *player = p;
        }
    }
    if (*player < 0)
        return ll_field_error(LL_CONFLICT, "player", "player: all %d seats are taken.", players);
    if (*player >= players)
        return ll_field_error(LL_BAD_INPUT, "player", "player: must be 0 to %d; got %d.", players - 1,
                              *player);
    int holder = ll_class_holder(c, *player);
    if (holder < 0 || holder == place || c->board.script[*player])
        return ll_ok();
    name_seat(c, *player, name);
    return ll_field_error(LL_CONFLICT, "player", "player: seat %s is taken.", name);
}

ll_status ll_class_claim(ll_class *c, int place, int player, ll_time now)
{
    ll_class_member *m = &c->members[place];
    if (now < m->no_seat_until)
        return ll_error(LL_CONFLICT, "The teacher has freed the seat for others: wait %d s.",
                        (int)((m->no_seat_until - now) / LL_SECOND) + 1);
    ll_status status = choose_seat(c, place, &player);
    if (ll_failed(&status))
        return status;
    int holder = ll_class_holder(c, player);
    if (holder >= 0 && holder != place)
        free_seat(c, holder);
    if (m->player != player)
        free_seat(c, place);
    c->board.script[player] = false;
    m->player = player;
    m->role = LL_CLASS_PLAY;
    m->heard = now;
    m->notified = false;
    c->changed = true;
    return ll_ok();
}

ll_status ll_class_free_seat(ll_class *c, int player, ll_time now)
{
    if (player >= c->board.players)
        return ll_error(LL_NOT_FOUND, "The board has no player %d.", player);
    int holder = ll_class_holder(c, player);
    if (holder < 0)
        return ll_ok();
    free_seat(c, holder);
    c->members[holder].no_seat_until = now + LL_CLASS_SEAT_NS;
    return ll_ok();
}

void ll_class_watch(ll_class *c, int place)
{
    free_seat(c, place);
    c->members[place].role = LL_CLASS_WATCH;
    c->members[place].notified = false;
    c->stirred = true;
}

ll_status ll_class_vote(ll_class *c, int place, const ll_class_ballot *ballot)
{
    ll_class_member *m = &c->members[place];
    if (c->now.phase != LL_CLASS_PREDICT)
        return ll_error(LL_CONFLICT, "Votes are locked: the class is in phase %s.",
                        ll_class_phases[c->now.phase]);
    if (ballot->step != c->question.step)
        return ll_field_error(LL_CONFLICT, "step", "step: must be %d, that of the question; got %d.",
                              c->question.step, (int)ballot->step);
    if (ballot->choice >= c->question.choices)
        return ll_field_error(LL_BAD_INPUT, "choice", "choice: must be 0 to %d; got %d.",
                              c->question.choices - 1, (int)ballot->choice);
    c->stirred = c->stirred || m->choice < 0;
    m->notified = m->notified && m->choice == ballot->choice;
    m->choice = (int)ballot->choice;
    return ll_ok();
}

/* ---- connections ---- */

bool ll_class_is_away(const ll_class_member *m, ll_time now)
{
    return m->connections == 0 || now - m->heard > LL_CLASS_SILENT_NS;
}

static void come_back(ll_class *c, ll_class_member *m, ll_time now)
{
    m->heard = now;
    if (m->player < 0)
        return;
    m->notified = m->notified && !c->board.script[m->player]; /* so that it authenticates again */
    c->board.script[m->player] = false;
    c->changed = true;
}

void ll_class_connected(ll_class *c, int place, ll_time now)
{
    ll_class_member *m = &c->members[place];
    m->connections++;
    m->seen = true;
    m->notified = false;
    c->stirred = true;
    come_back(c, m, now);
}

void ll_class_disconnected(ll_class *c, int place, ll_time now)
{
    ll_class_member *m = &c->members[place];
    m->connections--;
    c->stirred = true;
    if (m->connections > 0)
        return;
    m->round_trip_ns = -1;
    if (now - m->heard <= LL_CLASS_SILENT_NS) /* else it was lost before */
        m->heard = now;
    c->changed = c->changed || m->player >= 0;
}

void ll_class_heard(ll_class *c, int place, int64_t round_trip_ns, ll_time now)
{
    ll_class_member *m = &c->members[place];
    bool was_away = ll_class_is_away(m, now) || (m->player >= 0 && c->board.script[m->player]);
    m->round_trip_ns = round_trip_ns;
    m->heard = now;
    if (was_away)
        come_back(c, m, now);
    c->stirred = c->stirred || m->player >= 0;
}

void ll_class_pass_time(ll_class *c, ll_time now)
{
    for (int i = 0; i < c->capacity; i++) {
        const ll_class_member *m = &c->members[i];
        if (!m->used || m->player < 0 || c->board.script[m->player])
            continue;
        if (now - m->heard > LL_CLASS_SEAT_NS) {
            c->board.script[m->player] = c->board.revoke[m->player] = true;
            c->changed = true;
        } else if (now - m->heard > LL_CLASS_SILENT_NS) {
            c->stirred = true; /* held becomes away */
        }
    }
}
