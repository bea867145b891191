/* Parameters of a player's link: presets, and the bound of the longest delay. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "link/line/presets.h"
#include "netcode/protocol/config.h"

static ll_status parse(const char *text, ll_player_config *player)
{
    cJSON *json = cJSON_Parse(text);
    assert_non_null(json);
    ll_param_defaults(&ll_player_table, player);
    ll_status status = ll_param_parse(&ll_player_table, json, player);
    cJSON_Delete(json);
    return status;
}

static ll_status set(ll_player_config *player, const char *path, const char *value)
{
    return ll_param_set(&ll_player_table, player, path, value, true);
}

/* This tries every preset too: its values are in range and obey the rules. */
static void the_tables_are_sound(void **state)
{
    (void)state;
    assert_string_equal(ll_param_table_valid(&ll_player_table).text, "");
    assert_string_equal(ll_param_table_valid(&ll_server_table).text, "");
    assert_string_equal(ll_param_table_valid(&ll_policy_table).text, "");
    assert_string_equal(ll_param_table_valid(&ll_reckoning_table).text, "");
    ll_policy_params policies;
    ll_param_defaults(&ll_policy_table, &policies);
    assert_memory_equal(&policies, &ll_policy_defaults, sizeof policies);
}

static void a_preset_and_one_change(void **state)
{
    (void)state;
    ll_player_config player;
    ll_status status =
        parse("{\"lag_ms\":30,\"link\":{\"up\":{\"loss_pct\":5},\"preset\":\"lte_4g\"}}", &player);
    assert_string_equal(status.text, "");
    assert_true(player.lag_ms == 30);
    assert_true(player.link.up.loss_pct == 5 && player.link.down.loss_pct == 4);
    assert_true(player.link.up.delay_ms == 100 && player.link.down.delay_ms == 100);
    assert_true(player.link.up.jitter_ms == 20 && player.link.down.jitter_ms == 20);

    assert_string_equal(set(&player, "link.preset", "fiber").text, "");
    assert_true(player.link.up.loss_pct == 0 && player.link.up.delay_ms == 10 && player.lag_ms == 30);
    assert_string_equal(set(&player, "link.preset", "custom").text, "");
    assert_true(player.link.up.delay_ms == 10);
}

/* Every preset is there for a player without lag, and reads back, also after a change. */
static void presets_read_back(void **state)
{
    (void)state;
    for (int i = 0; ll_link_preset_names[i]; i++) {
        ll_player_config player, again;
        ll_param_defaults(&ll_player_table, &player);
        ll_param_defaults(&ll_player_table, &again);
        assert_string_equal(set(&player, "link.preset", ll_link_preset_names[i]).text, "");
        assert_string_equal(set(&player, "link.down.duplicate_pct", "7").text, "");
        cJSON *json = ll_param_write(&ll_player_table, &player);
        assert_string_equal(ll_param_parse(&ll_player_table, json, &again).text, "");
        assert_memory_equal(&player, &again, sizeof player);
        assert_int_equal(player.link.preset, i);
        cJSON_Delete(json);
    }
}

static void an_unknown_preset_lists_the_known_ones(void **state)
{
    (void)state;
    ll_player_config player;
    assert_string_equal(parse("{\"link\":{\"preset\":\"lte\"}}", &player).text,
                        "link.preset: must be one of custom, home_broadband, fiber, cable, dsl, "
                        "satellite_leo, congested, gsm_2g, gprs_2_5g, edge_2_75g, umts_3g, ...; got \"lte\"");
}

/* The bound counts the longest possible delay of a packet, not the usual one. */
static void the_longest_delay_is_bounded(void **state)
{
    (void)state;
    static const struct {
        const char *text, *got; /* NULL: it is allowed */
    } cases[] = {
        {"{\"lag_ms\":1000,\"link\":{\"down\":{\"delay_ms\":200,\"jitter_ms\":50}}}", NULL},
        {"{\"lag_ms\":1000,\"link\":{\"down\":{\"delay_ms\":200,\"jitter_ms\":51}}}", "1251"},
        {"{\"link\":{\"down\":{\"jitter_ms\":312,\"distribution\":\"normal\"}}}", NULL},
        {"{\"link\":{\"down\":{\"jitter_ms\":313,\"distribution\":\"normal\"}}}", "1252.67"},
        {"{\"link\":{\"down\":{\"jitter_ms\":104,\"distribution\":\"pareto\"}}}", "1260.93"},
        {"{\"lag_ms\":800,\"link\":{\"down\":{\"limit_ms\":500}}}", NULL},
        {"{\"lag_ms\":800,\"link\":{\"down\":{\"limit_ms\":500,\"rate_kbps\":1}}}", "1300"},
        {"{\"lag_ms\":800,\"link\":{\"down\":{\"spike_add_ms\":500,\"spike_length_ms\":1}}}", "1300"},
        {"{\"lag_ms\":700,\"link\":{\"preset\":\"gsm_2g\"}}", "1270"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ll_player_config player;
        ll_status status = parse(cases[i].text, &player);
        assert_int_equal(ll_failed(&status), cases[i].got != NULL);
        if (cases[i].got)
            assert_string_equal(strstr(status.text, "got ") + 4, cases[i].got);
    }
    ll_player_config player;
    ll_status status = parse("{\"lag_ms\":700,\"link\":{\"preset\":\"gsm_2g\"}}", &player);
    assert_string_equal(status.field, "link.up");
    assert_string_equal(status.text,
                        "link.up must delay a packet by at most 1250 ms: lag_ms, delay_ms, the largest "
                        "jitter, spike_add_ms and, with a rate_kbps, limit_ms together; got 1270");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_tables_are_sound),
        cmocka_unit_test(a_preset_and_one_change),
        cmocka_unit_test(presets_read_back),
        cmocka_unit_test(an_unknown_preset_lists_the_known_ones),
        cmocka_unit_test(the_longest_delay_is_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
