#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "game/core/game.h"

/* The table of games and the two lists that follow its order. */
static void lists_follow_the_table(void **state)
{
    (void)state;
    int n = 0;
    for (; ll_games[n]; n++) {
        assert_string_equal(ll_games[n]->name, ll_game_names[n]);
        assert_ptr_equal(ll_games[n]->params, ll_game_tables[n]);
        double params[LL_GAME_PARAMS] = {0}; /* as many as a configuration has room for */
        assert_true(ll_games[n]->params->size <= sizeof params);
        assert_true(sizeof params <= sizeof((ll_game_env *)0)->params);
        ll_param_defaults(ll_games[n]->params, params);
        for (int players = 1; players <= LL_PLAYERS_MAX; players++) {
            ll_extent extent = ll_games[n]->extent(params, players);
            assert_in_range(extent.entities, players, LL_ENTITIES_MAX);
            assert_int_equal(extent.tail % 8, 0);
        }
    }
    assert_null(ll_game_names[n]);
    assert_null(ll_game_tables[n]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lists_follow_the_table)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
