/* A class as a text, which outlives the daemon, and back. Keys, tokens and addresses stay hashes. What
 * depends on connections and on the daemon's clock is not a part of it. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "daemon/class/class.h"

static void add_hash(cJSON *json, const char *name, const ll_key_hash *hash)
{
    char text[LL_KEY_HASH_TEXT + 1];
    ll_key_hash_write(hash, text);
    cJSON_AddStringToObject(json, name, text);
}

static bool read_hash(const cJSON *json, const char *name, ll_key_hash *hash)
{
    return ll_key_hash_read(cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, name)), hash);
}

static cJSON *save_link(const ll_class_link *link)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "session", link->session);
    cJSON_AddBoolToObject(json, "held", link->held);
    cJSON_AddBoolToObject(json, "resume", link->resume);
    return json;
}

static bool is_true(const cJSON *json, const char *name)
{
    return cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(json, name));
}

/* A number from `low` to `high`; else `low`. */
static int number(const cJSON *json, const char *name, int low, int high)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, name);
    return cJSON_IsNumber(item) && item->valuedouble >= low && item->valuedouble <= high ? item->valueint
                                                                                         : low;
}

static void load_link(const cJSON *json, ll_class_link *link)
{
    const char *session = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "session"));
    *link = (ll_class_link){.held = is_true(json, "held"), .resume = is_true(json, "resume")};
    if (session && ll_is_id(session))
        snprintf(link->session, sizeof link->session, "%s", session);
}

/* Of the players, for whom `flags` is true. */
static void add_players(cJSON *json, const char *name, const bool flags[LL_PLAYERS_MAX])
{
    cJSON *list = cJSON_AddArrayToObject(json, name);
    for (int p = 0; p < LL_PLAYERS_MAX; p++)
        if (flags[p])
            cJSON_AddItemToArray(list, cJSON_CreateNumber(p));
}

static void load_players(const cJSON *json, const char *name, bool flags[LL_PLAYERS_MAX])
{
    const cJSON *item, *list = cJSON_GetObjectItemCaseSensitive(json, name);
    cJSON_ArrayForEach(item, list)
    {
        if (cJSON_IsNumber(item) && item->valueint >= 0 && item->valueint < LL_PLAYERS_MAX)
            flags[item->valueint] = true;
    }
}

static void add_client(cJSON *json, uint64_t client)
{
    char text[17];
    snprintf(text, sizeof text, "%016" PRIx64, client);
    cJSON_AddStringToObject(json, "client", text);
}

static uint64_t read_client(const cJSON *json)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "client"));
    return text ? strtoull(text, NULL, 16) : 0;
}

static cJSON *save_member(const ll_class_member *m)
{
    cJSON *json = cJSON_CreateObject();
    add_hash(json, "token", &m->token);
    add_client(json, m->client);
    cJSON_AddNumberToObject(json, "number", m->number);
    cJSON_AddNumberToObject(json, "joined_s", (double)m->joined_s);
    cJSON_AddBoolToObject(json, "seen", m->seen);
    cJSON_AddNumberToObject(json, "role", m->role);
    cJSON_AddNumberToObject(json, "player", m->player);
    cJSON_AddNumberToObject(json, "choice", m->choice);
    cJSON_AddItemToObject(json, "copy", save_link(&m->copy));
    return json;
}

static void load_member(ll_class *c, const cJSON *json, ll_time now)
{
    char copy[LL_ID_LENGTH + 1];
    const cJSON *joined = cJSON_GetObjectItemCaseSensitive(json, "joined_s");
    ll_class_arrival arrival = {.client = read_client(json),
                                .unix_s = cJSON_IsNumber(joined) ? (int64_t)joined->valuedouble : 0,
                                .now = now};
    if (ll_class_count(c) == c->capacity /* there may be fewer places than before */ ||
        !read_hash(json, "token", &arrival.token))
        return;
    ll_class_member *m = &c->members[ll_class_join(c, &arrival, copy)];
    m->seen = is_true(json, "seen");
    int stored = number(json, "number", 0, INT32_MAX);
    m->number = stored > 0 ? (uint32_t)stored : m->number;
    int player = c->board.link.session[0] ? number(json, "player", -1, LL_PLAYERS_MAX - 1) : -1;
    m->player = player >= 0 && ll_class_holder(c, player) < 0 ? player : -1;
    m->role = (ll_class_role)number(json, "role", LL_CLASS_WATCH, LL_CLASS_COPY);
    if (m->role == LL_CLASS_PLAY && m->player < 0) /* its seat went with the board */
        m->role = LL_CLASS_WATCH;
    m->choice = number(json, "choice", -1, c->question.choices - 1);
    load_link(cJSON_GetObjectItemCaseSensitive(json, "copy"), &m->copy);
}

static void save_removed(const ll_class *c, cJSON *json)
{
    cJSON *removed = cJSON_AddArrayToObject(json, "removed"),
          *barred = cJSON_AddArrayToObject(json, "barred");
    cJSON_AddNumberToObject(json, "numbers", c->numbers);
    for (uint32_t i = 0; i < c->removals && i < LL_CLASS_REMOVED; i++) {
        cJSON *device = cJSON_CreateObject();
        add_hash(device, "token", &c->removed[i].token);
        cJSON_AddItemToArray(removed, device);
    }
    for (uint32_t i = 0; i < c->bars && i < LL_CLASS_REMOVED; i++) {
        cJSON *address = cJSON_CreateObject();
        add_client(address, c->barred[i]);
        cJSON_AddItemToArray(barred, address);
    }
}

static void load_removed(ll_class *c, const cJSON *json)
{
    const cJSON *item;
    c->numbers = (uint32_t)number(json, "numbers", (int)c->numbers, INT32_MAX);
    cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(json, "removed"))
    {
        if (c->removals < LL_CLASS_REMOVED && read_hash(item, "token", &c->removed[c->removals].token))
            c->removals++;
    }
    cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(json, "barred"))
    {
        if (c->bars < LL_CLASS_REMOVED)
            c->barred[c->bars++] = read_client(item);
    }
}

cJSON *ll_class_save(const ll_class *c)
{
    cJSON *json = cJSON_CreateObject(), *question = cJSON_CreateObject(), *members = cJSON_CreateArray();
    add_hash(json, "teacher", &c->teacher);
    add_client(json, c->home);
    cJSON_AddItemToObject(json, "settings", ll_param_write(&ll_class_table, &c->now));
    cJSON_AddItemToObject(json, "board", save_link(&c->board.link));
    add_players(json, "driven", c->board.driven);
    add_players(json, "script", c->board.script);
    cJSON_AddStringToObject(question, "lesson", c->question.lesson);
    cJSON_AddNumberToObject(question, "step", c->question.step);
    cJSON_AddNumberToObject(question, "choices", c->question.choices);
    cJSON_AddItemToObject(json, "question", question);
    for (int i = 0; i < c->capacity; i++)
        if (c->members[i].used)
            cJSON_AddItemToArray(members, save_member(&c->members[i]));
    cJSON_AddItemToObject(json, "members", members);
    save_removed(c, json);
    return json;
}

ll_status ll_class_load(ll_class *c, int capacity, const cJSON *json, ll_time now)
{
    ll_key_hash teacher;
    const cJSON *question = cJSON_GetObjectItemCaseSensitive(json, "question"), *member;
    const char *lesson = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(question, "lesson"));
    if (!read_hash(json, "teacher", &teacher))
        return ll_error(LL_BAD_INPUT, "a stored class has no teacher's key");
    const cJSON *settings = cJSON_GetObjectItemCaseSensitive(json, "settings");
    LL_TRY(ll_class_init(c, capacity, &teacher));
    ll_status status = cJSON_IsObject(settings) ? ll_param_merge(&ll_class_table, settings, &c->now)
                                                : ll_error(LL_BAD_INPUT, "a stored class has no settings");
    if (ll_failed(&status)) {
        ll_class_end(c);
        return status;
    }
    c->home = read_client(json);
    snprintf(c->question.lesson, sizeof c->question.lesson, "%s", lesson ? lesson : "");
    c->question.step = number(question, "step", 0, 999);
    c->question.choices = number(question, "choices", 0, LL_CLASS_CHOICES);
    load_link(cJSON_GetObjectItemCaseSensitive(json, "board"), &c->board.link);
    load_players(json, "driven", c->board.driven);
    c->board.unread = c->board.resumed = c->board.link.session[0] != '\0';
    cJSON_ArrayForEach(member, cJSON_GetObjectItemCaseSensitive(json, "members")) load_member(c, member, now);
    load_players(json, "script", c->board.script);
    load_removed(c, json);
    return status;
}
