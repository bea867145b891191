/* A class as values: phases, votes, seats, lost connections, and the choice of addresses. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "daemon/class/class.h"
#include "daemon/class/origins.h"
#include "session/session.h"

enum { MEMBERS = 4 };

typedef struct fixture {
    ll_class c;
    char key[LL_KEY_LENGTH + 1], token[MEMBERS + 2][LL_KEY_LENGTH + 1];
    ll_time now;
} fixture;

static void set(fixture *f, const char *patch)
{
    cJSON *json = cJSON_Parse(patch);
    ll_status status = ll_class_change(&f->c, json);
    cJSON_Delete(json);
    assert_string_equal(status.text, "");
}

static ll_status refused(fixture *f, const char *patch)
{
    cJSON *json = cJSON_Parse(patch);
    ll_status status = ll_class_change(&f->c, json);
    cJSON_Delete(json);
    return status;
}

static void show_players(fixture *f, const char *session, const char *text)
{
    cJSON *params = cJSON_Parse(text);
    ll_class_set_board(&f->c, session);
    ll_class_set_players(&f->c, params, 1);
    cJSON_Delete(params);
}

/* Two players, `A` and `B`, are on the board. */
static void show(fixture *f)
{
    show_players(f, "abcdefghijklmnopqrstuvwxyz",
                 "{\"players\":[{\"name\":\"A\",\"lag_ms\":150},{\"name\":\"B\",\"lag_ms\":20}]}");
}

static ll_code join_from(fixture *f, int i, uint64_t client, int *place)
{
    char copy[LL_ID_LENGTH + 1];
    ll_class_arrival arrival = {.client = client, .now = f->now, .unix_s = 1700000000};
    assert_true(ll_new_key(f->token[i]) && ll_key_hash_make(f->token[i], &arrival.token));
    ll_status status = ll_class_admits(&f->c, client, f->now);
    *place = ll_failed(&status) ? -1 : ll_class_join(&f->c, &arrival, copy);
    return status.code;
}

static int join(fixture *f, int i)
{
    int place = -1;
    assert_int_equal(join_from(f, i, 1, &place), LL_OK);
    return place;
}

static int setup(void **state)
{
    static fixture f;
    ll_key_hash hash;
    memset(&f, 0, sizeof f);
    f.now = 1000 * LL_SECOND;
    assert_true(ll_new_key(f.key) && ll_key_hash_make(f.key, &hash));
    ll_status status = ll_class_init(&f.c, MEMBERS, &hash);
    assert_false(ll_failed(&status));
    show(&f);
    *state = &f;
    return 0;
}

static int teardown(void **state)
{
    ll_class_end(&((fixture *)*state)->c);
    return 0;
}

static const cJSON *described(fixture *f, const char *name)
{
    static cJSON *last;
    cJSON_Delete(last);
    last = ll_class_describe(&f->c, f->now);
    return cJSON_GetObjectItemCaseSensitive(last, name);
}

static const char *seat_state(fixture *f, int player)
{
    const cJSON *seat = cJSON_GetArrayItem(described(f, "seats"), player);
    return cJSON_GetObjectItemCaseSensitive(seat, "state")->valuestring;
}

/* ---- the teacher ---- */

static void phases_order_the_board(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *phase;
        ll_class_order order;
    } rows[] = {{"lobby", LL_CLASS_NO_ORDER},      {"predict", LL_CLASS_PAUSE_BOARD},
                {"locked", LL_CLASS_PAUSE_BOARD},  {"run", LL_CLASS_PLAY_BOARD},
                {"stopped", LL_CLASS_PAUSE_BOARD}, {"explain", LL_CLASS_NO_ORDER},
                {"change", LL_CLASS_PLAY_BOARD},   {"free", LL_CLASS_PLAY_BOARD}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char patch[80];
        f->c.board.order = LL_CLASS_NO_ORDER;
        snprintf(patch, sizeof patch, "{\"phase\":\"%s\",\"choices\":3}", rows[i].phase);
        set(f, patch);
        assert_int_equal(f->c.board.order, rows[i].order);
        assert_string_equal(described(f, "phase")->valuestring, rows[i].phase);
    }
    f->c.board.order = LL_CLASS_NO_ORDER;
    set(f, "{\"frozen\":true}");
    assert_int_equal(f->c.board.order, LL_CLASS_NO_ORDER);
}

static void a_wrong_patch_names_field_and_range_and_changes_nothing(void **state)
{
    fixture *f = *state;
    static const char *const rows[][2] = {{"{\"phase\":\"party\"}", "phase"},
                                          {"{\"step\":1000}", "999"},
                                          {"{\"step\":-1}", "step"},
                                          {"{\"choices\":9}", "8"},
                                          {"{\"lesson\":\"Anna B\"}", "lesson"},
                                          {"{\"nonsense\":1}", "nonsense"},
                                          {"{\"step\":5,\"stop_tick\":-1}", "stop_tick"},
                                          {"{\"phase\":\"predict\"}", "1 to 8"}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ll_status status = refused(f, rows[i][0]);
        assert_int_equal(status.code, LL_BAD_INPUT);
        assert_non_null(strstr(status.text, rows[i][1]));
        assert_int_equal(f->c.now.step, 0);
        assert_int_equal(f->c.now.phase, LL_CLASS_LOBBY);
    }
}

static void a_board_that_stops_by_itself_ends_the_run(void **state)
{
    fixture *f = *state;
    ll_class_see_board(&f->c, LL_SESSION_PAUSED, 0);
    set(f, "{\"phase\":\"run\",\"stop_tick\":19}");
    ll_class_see_board(&f->c, LL_SESSION_PAUSED, 0); /* the order has not been carried out */
    assert_int_equal(f->c.now.phase, LL_CLASS_RUN);
    f->c.board.order = LL_CLASS_NO_ORDER;
    ll_class_see_board(&f->c, LL_SESSION_PLAYING, 3);
    f->c.now.frozen = true;
    ll_class_see_board(&f->c, LL_SESSION_PAUSED, 7); /* by the freeze */
    assert_int_equal(f->c.now.phase, LL_CLASS_RUN);
    f->c.now.frozen = false;
    ll_class_see_board(&f->c, LL_SESSION_PLAYING, 7);
    ll_class_see_board(&f->c, LL_SESSION_PAUSED, 19);
    assert_int_equal(f->c.now.phase, LL_CLASS_STOPPED);
    assert_int_equal(described(f, "tick")->valueint, 19);
}

/* ---- votes ---- */

static ll_code vote(fixture *f, int place, int step, int choice)
{
    ll_status status = ll_class_vote(&f->c, place, &(ll_class_ballot){step, choice});
    return status.code;
}

static void votes_count_once_and_are_hidden_until_locked(void **state)
{
    fixture *f = *state;
    int a = join(f, 0), b = join(f, 1);
    assert_int_equal(vote(f, a, 0, 0), LL_CONFLICT);
    set(f, "{\"phase\":\"predict\",\"step\":2,\"choices\":3}");
    for (int i = 0; i < 3; i++)
        assert_int_equal(vote(f, a, 2, i), LL_OK);
    assert_int_equal(vote(f, b, 2, 2), LL_OK);
    assert_int_equal(vote(f, b, 2, 3), LL_BAD_INPUT);
    assert_int_equal(vote(f, b, 1, 0), LL_CONFLICT);
    assert_int_equal(described(f, "votes")->valueint, 2);
    assert_true(cJSON_IsNull(described(f, "tally")));
    set(f, "{\"phase\":\"locked\"}");
    assert_int_equal(vote(f, b, 2, 0), LL_CONFLICT);
    const cJSON *tally = described(f, "tally");
    assert_int_equal(cJSON_GetArraySize(tally), 3);
    assert_int_equal(cJSON_GetArrayItem(tally, 2)->valueint, 2);
    set(f, "{\"phase\":\"predict\"}"); /* the same question again */
    assert_int_equal(described(f, "votes")->valueint, 2);
    set(f, "{\"step\":3}"); /* another one, in the same phase */
    assert_int_equal(described(f, "votes")->valueint, 0);
}

/* ---- seats ---- */

static void a_seat_has_one_holder(void **state)
{
    fixture *f = *state;
    int a = join(f, 0), b = join(f, 1), d = join(f, 2);
    ll_status status = ll_class_claim(&f->c, a, 0, f->now);
    assert_false(ll_failed(&status));
    status = ll_class_claim(&f->c, b, 0, f->now);
    assert_int_equal(status.code, LL_CONFLICT);
    assert_string_equal(status.text, "player: seat 0 (A) is taken.");
    status = ll_class_claim(&f->c, b, -1, f->now);
    assert_int_equal(f->c.members[b].player, 1);
    status = ll_class_claim(&f->c, d, -1, f->now);
    assert_int_equal(status.code, LL_CONFLICT);
    status = ll_class_claim(&f->c, d, 2, f->now);
    assert_int_equal(status.code, LL_BAD_INPUT);
    ll_class_watch(&f->c, a);
    assert_true(f->c.board.revoke[0]);
    assert_false(ll_class_drives(&f->c, 0));
    status = ll_class_claim(&f->c, b, 0, f->now); /* moves */
    assert_int_equal(f->c.members[b].player, 0);
    assert_false(ll_class_drives(&f->c, 1));
    ll_class_set_board(&f->c, "");
    assert_int_equal(f->c.members[b].player, -1);
    status = ll_class_claim(&f->c, b, -1, f->now);
    assert_int_equal(status.code, LL_CONFLICT);
}

static void seats_stay_where_the_new_board_has_their_players(void **state)
{
    fixture *f = *state;
    int a = join(f, 0), b = join(f, 1);
    assert_int_equal(ll_class_claim(&f->c, a, 0, f->now).code, LL_OK);
    assert_int_equal(ll_class_claim(&f->c, b, 1, f->now).code, LL_OK);
    ll_class_connected(&f->c, a, f->now);
    f->now += LL_CLASS_SEAT_NS + 1;
    ll_class_heard(&f->c, a, 1, f->now);
    ll_class_pass_time(&f->c, f->now); /* the script has B's */
    f->c.board.driven[0] = true;
    f->c.members[a].notified = true;
    show_players(f, "bbbbbbbbbbbbbbbbbbbbbbbbbb",
                 "{\"players\":[{\"name\":\"X\"},{\"name\":\"Y\"},{\"name\":\"Z\"}]}");
    assert_string_equal(seat_state(f, 0), "held");
    assert_string_equal(seat_state(f, 1), "script");
    assert_string_equal(seat_state(f, 2), "free");
    assert_true(ll_class_drives(&f->c, 0) && !ll_class_drives(&f->c, 1));
    assert_false(f->c.board.driven[0]); /* it is to be set there, too */
    assert_false(f->c.members[a].notified);
    f->c.board.driven[0] = true;
    ll_class_set_board(&f->c, "bbbbbbbbbbbbbbbbbbbbbbbbbb");
    assert_true(f->c.board.driven[0]);
    show_players(f, "cccccccccccccccccccccccccc", "{\"players\":[{\"name\":\"X\"}]}");
    assert_int_equal(f->c.members[a].player, 0);
    assert_int_equal(f->c.members[b].player, -1);
    assert_int_equal(f->c.members[b].role, LL_CLASS_WATCH);
    assert_int_equal(f->c.board.order, LL_CLASS_NO_ORDER);
    set(f, "{\"phase\":\"free\"}");
    show_players(f, "dddddddddddddddddddddddddd", "{}");
    assert_int_equal(f->c.members[a].player, -1);
    assert_int_equal(f->c.board.order, LL_CLASS_PLAY_BOARD);
}

static void in_a_lesson_the_script_drives_until_all_are_free(void **state)
{
    fixture *f = *state;
    int a = join(f, 0);
    assert_int_equal(ll_class_claim(&f->c, a, 0, f->now).code, LL_OK);
    static const struct {
        const char *patch;
        bool drives;
    } rows[] = {{"{\"phase\":\"run\"}", true},     {"{\"lesson\":\"who_waits\"}", false},
                {"{\"phase\":\"change\"}", false}, {"{\"phase\":\"free\"}", true},
                {"{\"phase\":\"lobby\"}", false},  {"{\"lesson\":\"\"}", true}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        set(f, rows[i].patch);
        assert_int_equal(ll_class_drives(&f->c, 0), rows[i].drives);
        assert_string_equal(seat_state(f, 0), "away"); /* it stays the holder's */
    }
}

static void the_script_takes_a_seat_after_20_s_and_its_holder_gets_it_back(void **state)
{
    fixture *f = *state;
    int a = join(f, 0), b = join(f, 1);
    ll_class_claim(&f->c, a, 0, f->now);
    ll_class_connected(&f->c, a, f->now);
    assert_string_equal(seat_state(f, 0), "held");
    f->now += 7 * LL_SECOND; /* connected, and silent: Wi-Fi is lost without a word */
    assert_string_equal(seat_state(f, 0), "away");
    ll_class_disconnected(&f->c, a, f->now);
    f->now += 12 * LL_SECOND;
    ll_class_pass_time(&f->c, f->now);
    assert_true(ll_class_drives(&f->c, 0));
    f->c.changed = false;
    ll_class_pass_time(&f->c, f->now);
    assert_false(f->c.changed);
    f->now += 2 * LL_SECOND;
    ll_class_pass_time(&f->c, f->now);
    assert_true(f->c.changed); /* all are to know at once */
    assert_string_equal(seat_state(f, 0), "script");
    assert_false(ll_class_drives(&f->c, 0));
    ll_class_connected(&f->c, a, f->now);
    assert_string_equal(seat_state(f, 0), "held");
    assert_true(ll_class_drives(&f->c, 0));
    ll_class_heard(&f->c, a, 3 * LL_MS, f->now + LL_SECOND);
    const cJSON *seat = cJSON_GetArrayItem(described(f, "seats"), 0);
    assert_true(cJSON_GetObjectItemCaseSensitive(seat, "rtt_ms")->valuedouble == 3);
    assert_true(cJSON_GetObjectItemCaseSensitive(seat, "lag_ms")->valuedouble == 150);
    f->now += 22 * LL_SECOND;
    ll_class_pass_time(&f->c, f->now);
    ll_status status = ll_class_claim(&f->c, b, 0, f->now); /* another member is faster */
    assert_false(ll_failed(&status));
    assert_int_equal(f->c.members[a].player, -1);
    assert_int_equal(f->c.members[b].player, 0);
}

static void a_full_class_drops_who_has_been_away_for_longest(void **state)
{
    fixture *f = *state;
    int place = -1, first = join(f, 0);
    ll_class_connected(&f->c, first, f->now);
    ll_class_disconnected(&f->c, first, f->now);
    for (int i = 1; i < MEMBERS; i++) {
        f->now += LL_SECOND;
        ll_class_connected(&f->c, join(f, i), f->now);
    }
    assert_int_equal(join_from(f, MEMBERS, 1, &place), LL_LIMIT);
    f->now += 59 * LL_SECOND - MEMBERS * LL_SECOND;
    assert_int_equal(join_from(f, MEMBERS, 1, &place), LL_LIMIT);
    f->now += 7 * LL_SECOND;
    uint32_t number = f->c.members[first].number;
    assert_int_equal(join(f, MEMBERS), first);
    assert_int_not_equal(f->c.members[first].number, number);
    assert_int_equal(ll_class_find(&f->c, f->token[0], LL_KEY_LENGTH), -1);
    assert_int_equal(ll_class_find(&f->c, f->token[MEMBERS], LL_KEY_LENGTH), first);
    assert_int_equal(ll_class_find(&f->c, f->key, LL_KEY_LENGTH), -1);
}

/* ---- places ---- */

static void connect_from(fixture *f, int i, uint64_t client)
{
    int place = -1;
    assert_int_equal(join_from(f, i, client, &place), LL_OK);
    ll_class_connected(&f->c, place, f->now);
}

static void a_full_class_is_shared_between_addresses(void **state)
{
    fixture *f = *state;
    int place = -1;
    f->c.home = 1;
    for (int i = 0; i < MEMBERS; i++)
        connect_from(f, i, 7);
    assert_int_equal(join_from(f, MEMBERS, 7, &place), LL_LIMIT);
    connect_from(f, MEMBERS, 8);
    assert_int_equal(ll_class_find(&f->c, f->token[MEMBERS - 1], LL_KEY_LENGTH), -1); /* the newest */
    assert_int_equal(ll_class_at(&f->c, 7), MEMBERS - 1);
    connect_from(f, MEMBERS, 8);
    assert_int_equal(join_from(f, MEMBERS + 1, 8, &place), LL_LIMIT); /* two each */
    assert_int_equal(join_from(f, MEMBERS + 1, 7, &place), LL_LIMIT);
    assert_int_equal(ll_class_at(&f->c, 7), 2);
    connect_from(f, MEMBERS, 9);
    assert_int_equal(join_from(f, MEMBERS + 1, 10, &place), LL_OK);
    assert_int_equal(join_from(f, MEMBERS + 1, 11, &place), LL_LIMIT); /* one of each address */
}

static void the_address_of_the_teacher_keeps_half_of_the_places(void **state)
{
    fixture *f = *state;
    int place = -1;
    f->c.home = 1;
    for (int i = 0; i < MEMBERS; i++)
        connect_from(f, i, 1);
    for (int i = 0; i < 2; i++)
        connect_from(f, MEMBERS, 8 + (uint64_t)i);
    assert_int_equal(join_from(f, MEMBERS, 20, &place), LL_LIMIT); /* many addresses with one device each */
    assert_int_equal(ll_class_at(&f->c, 1), 2);
    ll_class_leave(&f->c, ll_class_find(&f->c, f->token[0], LL_KEY_LENGTH));
    connect_from(f, MEMBERS, 21);
    connect_from(f, MEMBERS, 1);
    assert_int_equal(ll_class_at(&f->c, 21), 0);
    assert_int_equal(ll_class_at(&f->c, 1), 2);
}

static void devices_that_only_joined_give_way(void **state)
{
    fixture *f = *state;
    int place = -1;
    for (int i = 0; i < MEMBERS; i++)
        join(f, i);
    connect_from(f, MEMBERS, 1); /* in place of the first of the same address */
    assert_int_equal(ll_class_find(&f->c, f->token[0], LL_KEY_LENGTH), -1);
    assert_true(ll_class_find(&f->c, f->token[1], LL_KEY_LENGTH) >= 0);
    f->now += 6 * LL_SECOND;
    connect_from(f, MEMBERS, 30);
    assert_int_equal(ll_class_find(&f->c, f->token[1], LL_KEY_LENGTH), -1);
    assert_int_equal(join_from(f, MEMBERS, 1, &place), LL_OK);
}

static void no_copy(void *context, const char *copy)
{
    (void)context;
    fail_msg("%s", copy);
}

static void who_was_removed_stays_out(void **state)
{
    fixture *f = *state;
    int place = -1;
    uint64_t of[] = {1, 7, 1, 7};
    f->c.home = 1;
    for (int i = 0; i < MEMBERS; i++)
        connect_from(f, i, of[i]);
    set(f, "{\"phase\":\"predict\",\"choices\":2}");
    for (int i = 0; i < MEMBERS; i++) {
        place = ll_class_find(&f->c, f->token[i], LL_KEY_LENGTH);
        assert_int_equal(vote(f, place, 0, i % 2), LL_OK);
    }
    assert_int_equal(described(f, "votes")->valueint, 4);
    assert_int_equal(ll_class_remove(&f->c, 9, LL_CLASS_ONE, no_copy, NULL).code, LL_NOT_FOUND);
    assert_int_equal(ll_class_remove(&f->c, 1, LL_CLASS_ADDRESS, no_copy, NULL).code, LL_CONFLICT);
    assert_int_equal(ll_class_remove(&f->c, 2, LL_CLASS_ADDRESS, no_copy, NULL).code, LL_OK);
    assert_int_equal(described(f, "votes")->valueint, 2);
    assert_true(ll_class_has_removed(&f->c, f->token[1], LL_KEY_LENGTH));
    assert_true(ll_class_has_removed(&f->c, f->token[3], LL_KEY_LENGTH));
    assert_false(ll_class_has_removed(&f->c, f->token[0], LL_KEY_LENGTH));
    assert_int_equal(join_from(f, MEMBERS, 7, &place), LL_FORBIDDEN);
    connect_from(f, MEMBERS, 8);
    assert_int_equal(ll_class_remove(&f->c, 3, LL_CLASS_LATER, no_copy, NULL).code, LL_OK);
    assert_int_equal(ll_class_count(&f->c), 1);
    set(f, "{\"door\":\"closed\"}");
    assert_int_equal(join_from(f, MEMBERS, 8, &place), LL_FORBIDDEN);
    cJSON *json = ll_class_save(&f->c);
    ll_class_end(&f->c);
    assert_int_equal(ll_class_load(&f->c, MEMBERS, json, f->now).code, LL_OK);
    cJSON_Delete(json);
    assert_true(ll_class_has_removed(&f->c, f->token[3], LL_KEY_LENGTH));
    assert_int_equal(ll_class_count(&f->c), 1);
    set(f, "{\"door\":\"open\"}");
    assert_int_equal(join_from(f, MEMBERS, 7, &place), LL_FORBIDDEN);
    assert_int_equal(join_from(f, MEMBERS, 8, &place), LL_OK);
    assert_int_equal(f->c.members[place].number, 6); /* numbers are not given twice */
}

static void a_seat_that_the_teacher_frees_is_for_others(void **state)
{
    fixture *f = *state;
    int a = join(f, 0), b = join(f, 1);
    assert_int_equal(ll_class_claim(&f->c, a, 1, f->now).code, LL_OK);
    assert_int_equal(ll_class_free_seat(&f->c, 2, f->now).code, LL_NOT_FOUND);
    assert_int_equal(ll_class_free_seat(&f->c, 0, f->now).code, LL_OK);
    assert_string_equal(seat_state(f, 1), "away");
    assert_int_equal(ll_class_free_seat(&f->c, 1, f->now).code, LL_OK);
    assert_string_equal(seat_state(f, 1), "free");
    assert_int_equal(ll_class_claim(&f->c, a, 0, f->now + 19 * LL_SECOND).code, LL_CONFLICT);
    assert_int_equal(ll_class_claim(&f->c, b, 1, f->now + 19 * LL_SECOND).code, LL_OK);
    assert_int_equal(ll_class_claim(&f->c, a, 0, f->now + 20 * LL_SECOND).code, LL_OK);
}

/* ---- addresses ---- */

static void addresses_are_those_that_others_reach(void **state)
{
    (void)state;
    static const ll_interface interfaces[] = {
        {"docker0", "172.17.0.1"}, {"eth0", "2001:db8::5"}, {"wlan0", "192.168.1.20"}};
    static const struct {
        const char *bound, *host, *first;
        bool proxied, tls, local;
        int count;
    } rows[] = {
        {"0.0.0.0:8080", "localhost:8080", "http://192.168.1.20:8080", false, false, false, 2},
        {"[::]:8080", "127.0.0.1:8080", "http://192.168.1.20:8080", false, false, false, 3},
        {"0.0.0.0:8080", "192.168.1.20:8080", "http://192.168.1.20:8080", false, false, false, 2},
        {"0.0.0.0:8080", "lab.local:8080", "http://lab.local:8080", false, false, false, 3},
        {"10.0.0.5:8080", "localhost", "http://10.0.0.5:8080", false, false, false, 1},
        {"127.0.0.1:8080", "localhost:8080", "http://127.0.0.1:8080", false, false, true, 1},
        {"127.0.0.1:8080", "lab.example", "https://lab.example", true, true, false, 1},
        {"127.0.0.1:8080", "lab.example:81", "http://lab.example:81", true, false, false, 1},
        {"127.0.0.1:8080", "localhost", "http://localhost", true, false, true, 1},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ll_origins origins;
        ll_origins_request request = {.bound = rows[i].bound,
                                      .port = 8080,
                                      .host = rows[i].host,
                                      .proxied = rows[i].proxied,
                                      .tls = rows[i].tls,
                                      .interfaces = interfaces,
                                      .interface_count = 3};
        ll_origins_choose(&request, &origins);
        assert_string_equal(origins.text[0], rows[i].first);
        assert_int_equal(origins.count, rows[i].count);
        assert_int_equal(origins.local, rows[i].local);
    }
    ll_interface own[LL_INTERFACES_MAX];
    int count = ll_interfaces_list(own);
    for (int i = 0; i < count; i++)
        assert_true(strncmp(own[i].address, "127.", 4) != 0 && strcmp(own[i].address, "::1") != 0);
}

/* What is saved and loaded, as a restart of the daemon does. */
static void saved_and_loaded_a_class_is_the_same_without_its_connections(void **state)
{
    fixture *f = *state;
    int a = join(f, 0), b = join(f, 1);
    ll_class_claim(&f->c, a, 1, f->now);
    ll_class_connected(&f->c, a, f->now);
    set(f, "{\"phase\":\"predict\",\"lesson\":\"late_answer\",\"step\":2,\"choices\":3,\"stop_tick\":70}");
    ll_status status = ll_class_vote(&f->c, b, &(ll_class_ballot){.step = 2, .choice = 1});
    assert_false(ll_failed(&status));
    f->c.board.driven[1] = true;
    strcpy(f->c.members[b].copy.session, "bbcdefghijklmnopqrstuvwxyz");
    cJSON *json = ll_class_save(&f->c);
    char *text = cJSON_PrintUnformatted(json);
    assert_null(strstr(text, f->token[0]));
    assert_null(strstr(text, f->key));
    ll_class_end(&f->c);
    memset(&f->c, 0x55, sizeof f->c);
    f->now += 3600 * LL_SECOND;
    status = ll_class_load(&f->c, MEMBERS, json, f->now);
    assert_string_equal(status.text, "");
    assert_true(ll_key_matches(&f->c.teacher, f->key, strlen(f->key)));
    a = ll_class_find(&f->c, f->token[0], strlen(f->token[0]));
    b = ll_class_find(&f->c, f->token[1], strlen(f->token[1]));
    assert_true(a >= 0 && b >= 0 && a != b);
    assert_int_equal(f->c.members[a].player, 1);
    assert_int_equal(f->c.members[a].role, LL_CLASS_PLAY);
    assert_int_equal(f->c.members[a].connections, 0);
    assert_int_equal(f->c.members[b].choice, 1);
    assert_string_equal(f->c.members[b].copy.session, "bbcdefghijklmnopqrstuvwxyz");
    assert_int_equal(f->c.now.phase, LL_CLASS_PREDICT);
    assert_int_equal(f->c.now.stop_tick, 70);
    assert_true(f->c.board.driven[1] && f->c.board.unread);
    cJSON *again = ll_class_save(&f->c);
    char *second = cJSON_PrintUnformatted(again);
    assert_string_equal(second, text);
    free(second);
    cJSON_Delete(again);
    free(text);
    cJSON_Delete(json);
    set(f, "{\"phase\":\"free\"}");
    ll_class_pass_time(&f->c, f->now + 19 * LL_SECOND); /* of its own time, not of that before */
    assert_true(ll_class_drives(&f->c, 1));
    ll_class_pass_time(&f->c, f->now + 21 * LL_SECOND);
    assert_false(ll_class_drives(&f->c, 1));
}

static void a_run_that_was_interrupted_goes_on_to_its_stop_or_has_stopped(void **state)
{
    fixture *f = *state;
    set(f, "{\"phase\":\"run\"}");
    f->c.board.resumed = true;
    f->c.board.status = -1;
    f->c.board.order = LL_CLASS_NO_ORDER;
    ll_class_see_board(&f->c, LL_SESSION_PLAYING, 3);
    assert_int_equal(f->c.board.order, LL_CLASS_PLAY_BOARD);
    assert_int_equal(f->c.now.phase, LL_CLASS_RUN);
    f->c.board.resumed = true;
    f->c.board.status = -1;
    f->c.board.order = LL_CLASS_NO_ORDER;
    ll_class_see_board(&f->c, LL_SESSION_PAUSED, 9);
    assert_int_equal(f->c.board.order, LL_CLASS_NO_ORDER);
    assert_int_equal(f->c.now.phase, LL_CLASS_STOPPED);
}

static void what_is_no_saved_class_is_refused(void **state)
{
    fixture *f = *state;
    cJSON *json = ll_class_save(&f->c);
    static const char *const without[] = {"settings", "teacher"};
    for (int i = 0; i < 2; i++) {
        ll_class other;
        cJSON_DeleteItemFromObjectCaseSensitive(json, without[i]);
        ll_status status = ll_class_load(&other, MEMBERS, json, f->now);
        assert_int_equal(status.code, LL_BAD_INPUT);
        status = ll_class_load(&other, MEMBERS, NULL, f->now);
        assert_int_equal(status.code, LL_BAD_INPUT);
    }
    cJSON_Delete(json);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(phases_order_the_board, setup, teardown),
        cmocka_unit_test_setup_teardown(a_wrong_patch_names_field_and_range_and_changes_nothing, setup,
                                        teardown),
        cmocka_unit_test_setup_teardown(a_board_that_stops_by_itself_ends_the_run, setup, teardown),
        cmocka_unit_test_setup_teardown(votes_count_once_and_are_hidden_until_locked, setup, teardown),
        cmocka_unit_test_setup_teardown(a_seat_has_one_holder, setup, teardown),
        cmocka_unit_test_setup_teardown(seats_stay_where_the_new_board_has_their_players, setup, teardown),
        cmocka_unit_test_setup_teardown(in_a_lesson_the_script_drives_until_all_are_free, setup, teardown),
        cmocka_unit_test_setup_teardown(the_script_takes_a_seat_after_20_s_and_its_holder_gets_it_back, setup,
                                        teardown),
        cmocka_unit_test_setup_teardown(a_full_class_drops_who_has_been_away_for_longest, setup, teardown),
        cmocka_unit_test_setup_teardown(a_full_class_is_shared_between_addresses, setup, teardown),
        cmocka_unit_test_setup_teardown(the_address_of_the_teacher_keeps_half_of_the_places, setup, teardown),
        cmocka_unit_test_setup_teardown(devices_that_only_joined_give_way, setup, teardown),
        cmocka_unit_test_setup_teardown(who_was_removed_stays_out, setup, teardown),
        cmocka_unit_test_setup_teardown(a_seat_that_the_teacher_frees_is_for_others, setup, teardown),
        cmocka_unit_test_setup_teardown(saved_and_loaded_a_class_is_the_same_without_its_connections, setup,
                                        teardown),
        cmocka_unit_test_setup_teardown(a_run_that_was_interrupted_goes_on_to_its_stop_or_has_stopped, setup,
                                        teardown),
        cmocka_unit_test_setup_teardown(what_is_no_saved_class_is_refused, setup, teardown),
        cmocka_unit_test(addresses_are_those_that_others_reach),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
