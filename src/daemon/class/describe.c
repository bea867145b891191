/* The broadcast of a class, and what only one member receives. */
#include "daemon/class/class.h"

#include <cjson/cJSON.h>

#include "session/session.h"

static void add_seats(const ll_class *c, cJSON *json, ll_time now)
{
    cJSON *seats = cJSON_AddArrayToObject(json, "seats");
    for (int p = 0; p < c->board.players; p++) {
        cJSON *seat = cJSON_CreateObject();
        int holder = ll_class_holder(c, p);
        const ll_class_member *m = holder >= 0 ? &c->members[holder] : NULL;
        const char *state = !m                         ? "free"
                            : c->board.script[p]       ? "script"
                            : ll_class_is_away(m, now) ? "away"
                                                       : "held";
        cJSON_AddNumberToObject(seat, "player", p);
        cJSON_AddStringToObject(seat, "name", c->board.names[p]);
        cJSON_AddStringToObject(seat, "state", state);
        if (m && m->round_trip_ns >= 0)
            cJSON_AddNumberToObject(seat, "rtt_ms", (double)(m->round_trip_ns / 10000) / 100);
        else
            cJSON_AddNullToObject(seat, "rtt_ms");
        cJSON_AddNumberToObject(seat, "lag_ms", c->board.lag_ms[p]);
        cJSON_AddItemToArray(seats, seat);
    }
}

static void add_tally(const ll_class *c, cJSON *json)
{
    int counts[LL_CLASS_CHOICES] = {0}, votes = 0;
    for (int i = 0; i < c->capacity; i++) {
        if (c->members[i].used && c->members[i].choice >= 0) {
            counts[c->members[i].choice]++;
            votes++;
        }
    }
    if (c->question.choices > 0) {
        cJSON *question = cJSON_AddObjectToObject(json, "question");
        cJSON_AddStringToObject(question, "lesson", c->question.lesson);
        cJSON_AddNumberToObject(question, "step", c->question.step);
        cJSON_AddNumberToObject(question, "choices", c->question.choices);
    } else {
        cJSON_AddNullToObject(json, "question");
    }
    cJSON_AddNumberToObject(json, "votes", votes);
    bool open = c->now.phase == LL_CLASS_PREDICT || c->question.choices == 0;
    cJSON_AddItemToObject(json, "tally",
                          open ? cJSON_CreateNull() : cJSON_CreateIntArray(counts, c->question.choices));
}

cJSON *ll_class_describe(const ll_class *c, ll_time now)
{
    int connected = 0, copies = 0;
    for (int i = 0; i < c->capacity; i++) {
        connected += c->members[i].used && c->members[i].connections > 0;
        copies += c->members[i].used && c->members[i].copy.session[0] != '\0';
    }
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "type", "class");
    cJSON_AddNumberToObject(json, "serial", c->serial);
    cJSON_AddStringToObject(json, "phase", ll_class_phases[c->now.phase]);
    cJSON_AddStringToObject(json, "lesson", c->now.lesson);
    cJSON_AddNumberToObject(json, "step", (double)c->now.step);
    cJSON_AddBoolToObject(json, "frozen", c->now.frozen);
    cJSON_AddBoolToObject(json, "together", c->now.together);
    cJSON_AddNumberToObject(json, "stop_tick", (double)c->now.stop_tick);
    cJSON_AddStringToObject(json, "door", c->now.door == LL_CLASS_CLOSED ? "closed" : "open");
    add_tally(c, json);
    add_seats(c, json, now);
    cJSON_AddNumberToObject(json, "n", connected);
    cJSON_AddNumberToObject(json, "copies", copies);
    if (c->board.link.session[0])
        cJSON_AddStringToObject(json, "board", c->board.link.session);
    else
        cJSON_AddNullToObject(json, "board");
    if (c->board.status >= 0)
        cJSON_AddStringToObject(json, "status", ll_session_status_names[c->board.status]);
    else
        cJSON_AddNullToObject(json, "status");
    cJSON_AddNumberToObject(json, "tick", (double)c->board.tick);
    return json;
}

cJSON *ll_class_describe_member(const ll_class *c, int place)
{
    const ll_class_member *m = &c->members[place];
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "type", "member");
    cJSON_AddNumberToObject(json, "number", m->number);
    cJSON_AddStringToObject(json, "role", ll_class_roles[m->role]);
    cJSON_AddItemToObject(json, "player",
                          m->player >= 0 ? cJSON_CreateNumber(m->player) : cJSON_CreateNull());
    cJSON_AddItemToObject(json, "choice",
                          m->choice >= 0 ? cJSON_CreateNumber(m->choice) : cJSON_CreateNull());
    cJSON_AddItemToObject(json, "copy",
                          m->copy.session[0] ? cJSON_CreateString(m->copy.session) : cJSON_CreateNull());
    return json;
}

/* A, B, ... Z, AA, AB, ... */
static void write_group(int group, char text[4])
{
    int at = 0;
    if (group >= 26)
        text[at++] = (char)('A' + (group / 26 - 1) % 26);
    text[at++] = (char)('A' + group % 26);
    text[at] = '\0';
}

static cJSON *describe_place(const ll_class *c, const ll_class_member *m)
{
    char group[4];
    cJSON *json = cJSON_CreateObject();
    write_group(m->group, group);
    cJSON_AddNumberToObject(json, "number", m->number);
    cJSON_AddStringToObject(json, "role", ll_class_roles[m->role]);
    cJSON_AddItemToObject(json, "player",
                          m->player >= 0 ? cJSON_CreateNumber(m->player) : cJSON_CreateNull());
    cJSON_AddBoolToObject(json, "connected", m->connections > 0);
    cJSON_AddBoolToObject(json, "voted", m->choice >= 0);
    cJSON_AddStringToObject(json, "group", group);
    cJSON_AddBoolToObject(json, "home", m->client == c->home);
    cJSON_AddNumberToObject(json, "joined_s", (double)m->joined_s);
    return json;
}

cJSON *ll_class_describe_members(const ll_class *c)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "type", "members");
    cJSON_AddNumberToObject(json, "most", c->capacity);
    cJSON *list = cJSON_AddArrayToObject(json, "members");
    for (int i = 0; i < c->capacity; i++)
        if (c->members[i].used)
            cJSON_AddItemToArray(list, describe_place(c, &c->members[i]));
    return json;
}
