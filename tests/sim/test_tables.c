/* Lists that must follow the order of a table. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "netcode/state/client.h"
#include "session/kinds.h"
#include "sim/core/scenario_rows.h"

static void lists_follow_their_tables(void **state)
{
    (void)state;
    int n = 0;
    for (; ll_syncs[n]; n++) {
        assert_true(ll_syncs[n]->due && ll_syncs[n]->step && ll_syncs[n]->take && ll_syncs[n]->compose);
        assert_true(ll_syncs[n]->receive && ll_syncs[n]->tick && ll_syncs[n]->display);
        assert_true(ll_syncs[n]->interpolate || ll_syncs[n]->display != ll_client_display);
        /* a mode whose clients wait for snapshots needs repeated ones, and a mode with clients' own worlds
         * needs to send the world */
        assert_true(!ll_syncs[n]->answers || ll_syncs[n]->waits);
        assert_true((ll_syncs[n]->start != NULL) == (ll_syncs[n]->observe != NULL));
    }
    for (n = 0; ll_sim_kinds[n]; n++)
        assert_string_equal(ll_sim_kinds[n]->name, ll_sim_kind_names[n]);
    assert_null(ll_sim_kind_names[n]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lists_follow_their_tables)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
