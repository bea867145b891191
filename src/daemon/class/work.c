/* What a class does to sessions: pauses and plays the board and the copies, gives players to persons and back
 * to the script, reads the players. One task per class does one thing after the other, until what was done
 * last agrees with what the class wants. */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <string.h>

#include "daemon/class/internal.h"

#define RETRY_NS (500 * LL_MS)

typedef enum deed { NOTHING, HOLD, LET_GO, PLAY, PAUSE, REVOKE, SEAT, READ } deed;

typedef struct action {
    deed deed;
    char session[LL_ID_LENGTH + 1];
    int place; /* of the member whose copy it is; -1: the board */
    uint32_t number;
    int player;
    bool person, plays;
    int64_t stop_tick;
    bool was_playing; /* result of HOLD */
    cJSON *params;    /* result of READ */
    uint32_t version;
} action;

/* ---- what to do next; locked ---- */

static bool pick_link(const ll_class *c, const ll_class_link *link, action *a)
{
    if (!link->session[0] || c->now.frozen == link->held)
        return false;
    a->deed = c->now.frozen ? HOLD : LET_GO;
    a->plays = link->resume;
    memcpy(a->session, link->session, sizeof a->session);
    return true;
}

static bool pick_seat(const ll_class *c, action *a)
{
    for (int p = 0; p < c->board.players; p++) {
        bool drives = ll_class_drives(c, p);
        if (!c->board.revoke[p] && c->board.driven[p] == drives)
            continue;
        a->deed = c->board.revoke[p] ? REVOKE : SEAT;
        a->player = p;
        a->person = drives;
        return true;
    }
    return false;
}

static bool pick_copy(const ll_class *c, action *a)
{
    for (int i = 0; i < c->capacity; i++) {
        a->place = i;
        a->number = c->members[i].number;
        if (c->members[i].used && pick_link(c, &c->members[i].copy, a))
            return true;
    }
    a->place = -1;
    return false;
}

static bool pick(ll_class *c, action *a)
{
    ll_class_board *board = &c->board;
    *a = (action){.place = -1, .stop_tick = ll_class_runs(c) ? c->now.stop_tick : 0};
    memcpy(a->session, board->link.session, sizeof a->session);
    if (!a->session[0])
        return pick_copy(c, a);
    if (pick_link(c, &board->link, a) || pick_copy(c, a))
        return true;
    memcpy(a->session, board->link.session, sizeof a->session);
    if (board->order != LL_CLASS_NO_ORDER && c->now.frozen) { /* for the end of the freeze */
        board->link.resume = board->order == LL_CLASS_PLAY_BOARD;
        board->order = LL_CLASS_NO_ORDER;
    }
    if (board->order != LL_CLASS_NO_ORDER)
        a->deed = board->order == LL_CLASS_PLAY_BOARD ? PLAY : PAUSE;
    else if (board->unread)
        a->deed = READ;
    else
        return pick_seat(c, a);
    return true;
}

/* ---- doing it; unlocked ---- */

static ll_status control(ll_session *session, ll_time wall, const char *op, int64_t until_tick)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "op", op);
    if (until_tick > 0)
        cJSON_AddNumberToObject(json, "until_tick", (double)until_tick);
    ll_status status = ll_session_begin_control(session, wall, json);
    cJSON_Delete(json);
    return status;
}

/* A stop tick that the board has passed, or that it never reaches, is none. */
static ll_status play(const action *a, ll_session *session, ll_time wall)
{
    ll_session_info info = ll_session_get_info(session);
    int64_t from = info.tick >= info.end_tick ? 0 : info.tick;
    bool stops = a->place < 0 && a->stop_tick > from && a->stop_tick <= info.end_tick;
    return control(session, wall, "play", stops ? a->stop_tick : 0);
}

static ll_status change(void *context, ll_session *session, ll_time wall)
{
    action *a = context;
    ll_status status = ll_ok();
    if (a->deed == HOLD)
        a->was_playing = ll_session_get_info(session).status == LL_SESSION_PLAYING;
    if (a->deed == HOLD || a->deed == PAUSE)
        return control(session, wall, "pause", 0);
    if (a->deed == PLAY || (a->deed == LET_GO && a->plays))
        return play(a, session, wall);
    if (a->deed == SEAT) {
        char path[32];
        snprintf(path, sizeof path, "players.%d.control", a->player);
        cJSON *patch = cJSON_CreateObject();
        cJSON_AddStringToObject(patch, path, a->person ? "person" : "script");
        status = ll_session_patch(session, wall, patch);
        cJSON_Delete(patch);
    }
    return status;
}

static ll_status read_players(ll_session_entry *session_entry, action *a, ll_task *task)
{
    ll_session *session;
    ll_status status = ll_session_entry_enter(session_entry, task, &session, NULL);
    if (ll_failed(&status))
        return status;
    a->params = ll_session_params(session);
    a->version = ll_session_get_info(session).params_version;
    ll_session_entry_leave(session_entry);
    return status;
}

/* That a session plays is stored before it is held, so that it goes on playing also after a restart. */
static ll_status note_resume(ll_class_entry *entry, const action *a)
{
    ll_session_glance glance;
    const ll_status good = ll_ok();
    ll_class *c;
    ll_session_entry *session_entry = ll_host_find(entry->classes->host, a->session);
    bool plays = session_entry && ll_session_entry_glance(session_entry, &glance) &&
                 glance.status == LL_SESSION_PLAYING;
    ll_session_entry_release(session_entry);
    if (!plays)
        return ll_ok();
    LL_TRY(ll_class_entry_begin(entry, &c));
    ll_class_link *link = a->place < 0 ? &c->board.link : &c->members[a->place].copy;
    link->resume = link->resume || strcmp(link->session, a->session) == 0;
    return ll_class_entry_store(entry, &good);
}

static ll_status perform(ll_classes *classes, action *a, ll_task *task)
{
    ll_session_entry *session_entry = ll_host_find(classes->host, a->session);
    ll_status status = ll_ok();
    if (!session_entry)
        return ll_error(LL_NOT_FOUND, "Session not found.");
    if (a->deed == REVOKE)
        ll_session_entry_revoke_guests(session_entry, a->player);
    else if (a->deed == READ)
        status = read_players(session_entry, a, task);
    else
        status = ll_host_command(
            classes->host, session_entry,
            &(ll_command_request){.change = change, .context = a, .task = task, .clock = a->deed != SEAT});
    ll_session_entry_release(session_entry);
    return status;
}

/* ---- afterwards; locked ---- */

static void settle_link(ll_class_link *link, const action *a)
{
    link->held = a->deed == HOLD;
    link->resume = link->held && (link->resume || a->was_playing);
}

static void settle_board(ll_class *c, const action *a)
{
    ll_class_board *board = &c->board;
    bool plays = a->deed == PLAY || (a->deed == LET_GO && a->plays);
    if (a->deed == HOLD || a->deed == LET_GO)
        settle_link(&board->link, a);
    if ((a->deed == PLAY && board->order == LL_CLASS_PLAY_BOARD) ||
        (a->deed == PAUSE && board->order == LL_CLASS_PAUSE_BOARD)) /* else another came meanwhile */
        board->order = LL_CLASS_NO_ORDER;
    if (plays)
        board->status = LL_SESSION_PLAYING; /* it may stop before the next check */
    if (a->deed == REVOKE)
        board->revoke[a->player] = false;
    if (a->deed == SEAT)
        board->driven[a->player] = a->person;
    if (a->deed == READ)
        ll_class_set_players(c, a->params, a->version);
    c->changed = c->changed || a->deed != READ;
}

static void settle(ll_class *c, const action *a, bool gone)
{
    if (a->place < 0) {
        if (strcmp(c->board.link.session, a->session) != 0)
            return; /* another board meanwhile */
        if (gone)
            ll_class_set_board(c, "");
        else
            settle_board(c, a);
        return;
    }
    ll_class_member *m = &c->members[a->place];
    if (!m->used || m->number != a->number || strcmp(m->copy.session, a->session) != 0)
        return;
    if (gone) {
        m->copy = (ll_class_link){.session = ""};
        m->notified = false;
        c->stirred = true;
    } else {
        settle_link(&m->copy, a);
    }
}

/* An order that the session refuses, as one that has failed, is not repeated; one that it could not take now
 * is. */
static bool is_final(ll_code code)
{
    return code == LL_OK || code == LL_BAD_INPUT || code == LL_CONFLICT || code == LL_DIVERGED ||
           code == LL_NOT_FOUND;
}

static bool step(ll_class_entry *entry, ll_task *task)
{
    ll_classes *classes = entry->classes;
    action a;
    pthread_mutex_lock(&classes->lock);
    bool wanted = !entry->ended && ll_task_end_reason(task) == LL_TASK_RUNNING && pick(&entry->values, &a);
    entry->working = wanted;
    pthread_mutex_unlock(&classes->lock);
    if (!wanted)
        return false;
    ll_status status = a.deed == HOLD ? note_resume(entry, &a) : ll_ok();
    LL_THEN(status, perform(classes, &a, task));
    pthread_mutex_lock(&classes->lock);
    for (int i = 0; i < LL_CLASS_VERSIONS && is_final(status.code); i++) {
        ll_class *c = ll_class_entry_version(entry, i);
        if (c)
            settle(c, &a, status.code == LL_NOT_FOUND);
    }
    if (!is_final(status.code))
        entry->retry_at = ll_now_ns() + RETRY_NS;
    entry->working = is_final(status.code);
    ll_classes_wake(classes);
    pthread_mutex_unlock(&classes->lock);
    cJSON_Delete(a.params);
    return is_final(status.code);
}

static void run(void *context, ll_task *task)
{
    ll_class_entry *entry = context;
    while (step(entry, task))
        ll_task_yield(task); /* when it was stopped, the next step ends */
    ll_class_entry_release(entry);
}

void ll_class_entry_work(ll_class_entry *entry, ll_time now)
{
    action a;
    if (entry->working || entry->ended || now < entry->retry_at || !pick(&entry->values, &a))
        return;
    ll_task_spec spec = {.own = true, .run = run, .context = entry};
    snprintf(spec.client, sizeof spec.client, "class");
    snprintf(spec.session, sizeof spec.session, "%s", entry->id);
    ll_class_entry_retain(entry);
    entry->working = true;
    ll_status status = ll_tasks_add(entry->classes->tasks, &spec, NULL);
    if (!ll_failed(&status))
        return;
    entry->working = false;
    entry->retry_at = now + RETRY_NS;
    atomic_fetch_sub(&entry->references, 1); /* the list has another */
}

/* ---- looking ---- */

/* A session that plays although it is held, as a copy whose owner pressed play, is held again. */
static void look_at_copies(ll_class_entry *entry, ll_class *c)
{
    for (int i = 0; i < c->capacity; i++) {
        ll_class_link *copy = &c->members[i].copy;
        if (!c->members[i].used || !copy->held)
            continue;
        ll_session_glance glance;
        ll_session_entry *session_entry = ll_host_find(entry->classes->host, copy->session);
        if (session_entry && ll_session_entry_glance(session_entry, &glance))
            copy->held = glance.status != LL_SESSION_PLAYING;
        ll_session_entry_release(session_entry);
    }
}

static void look(ll_class_entry *entry, ll_class *c)
{
    ll_class_board *board = &c->board;
    if (c->now.frozen)
        look_at_copies(entry, c);
    if (!board->link.session[0])
        return;
    ll_session_entry *session_entry = ll_host_find(entry->classes->host, board->link.session);
    ll_session_glance glance;
    if (!session_entry) {
        ll_class_set_board(c, "");
        return;
    }
    if (ll_session_entry_glance(session_entry, &glance)) {
        board->unread = board->unread || glance.params_version != board->params_version;
        /* A session without viewers runs only when it is used, as by reading it: so it comes to its stop. */
        board->unread = board->unread || (ll_class_runs(c) && glance.status == LL_SESSION_PLAYING &&
                                          ll_session_entry_viewers(session_entry) == 0);
        board->link.held = board->link.held && (glance.status != LL_SESSION_PLAYING || !c->now.frozen);
        ll_class_see_board(c, (int)glance.status, glance.tick);
    }
    ll_session_entry_release(session_entry);
}

void ll_class_entry_look(ll_class_entry *entry)
{
    for (int i = 0; i < LL_CLASS_VERSIONS; i++) {
        ll_class *c = ll_class_entry_version(entry, i);
        if (c)
            look(entry, c);
    }
}
