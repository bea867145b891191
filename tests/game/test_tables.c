#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "game/game.h"

/* The table of games and the two lists that follow its order. */
static void lists_follow_the_table(void **state)
{
    (void)state;
    int n = 0;
    for (; ll_games[n]; n++) {
        assert_string_equal(ll_games[n]->name, ll_game_names[n]);
        assert_ptr_equal(ll_games[n]->params, ll_game_tables[n]);
        assert_true(ll_games[n]->params->size <= sizeof((ll_game_env *)0)->params);
        assert_true(ll_games[n]->tail(LL_PLAYERS_MAX) % 8 == 0 && ll_games[n]->tail(LL_PLAYERS_MAX) <= 256);
    }
    assert_null(ll_game_names[n]);
    assert_null(ll_game_tables[n]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lists_follow_the_table)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
