/* The link presets: their values, and that each can be set. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "link/harness.h"
#include "link/line/presets.h"

static int preset_named(const char *name)
{
    int i = 0;
    while (ll_link_preset_names[i] && strcmp(ll_link_preset_names[i], name) != 0)
        i++;
    assert_non_null(ll_link_preset_names[i]);
    return i;
}

static ll_link_params preset_params(const char *name)
{
    ll_link_params up = {0}, down = {0};
    ll_link_preset_apply(preset_named(name), &up, &down);
    assert_memory_equal(&up, &down, sizeof up);
    return up;
}

static void names_follow_the_table(void **state)
{
    (void)state;
    int n = 0;
    for (; ll_link_presets[n].name; n++) {
        assert_string_equal(ll_link_preset_names[n], ll_link_presets[n].name);
        assert_non_null(ll_link_presets[n].source);
        assert_int_equal(preset_named(ll_link_presets[n].name), n);
    }
    assert_null(ll_link_preset_names[n]);
    assert_string_equal(ll_link_preset_names[0], "custom");
}

/* One preset of each source: exactly the source's values. */
static void values_are_those_of_the_source(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double delay, jitter, loss;
    } cases[] = {{"home_broadband", 32, 12, 2}, {"lte_4g", 100, 20, 4},
                 {"gsm_2g", 520, 50, 7},        {"nfe_regional_p95", 151, 11, 4},
                 {"unreal_bad", 150, 50, 5},    {"lightyear_good", 40, 6, 0.2},
                 {"paper", 255, 245, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ll_link_params want = link_params(), got = preset_params(cases[i].name);
        want.delay_ms = cases[i].delay;
        want.jitter_ms = cases[i].jitter;
        want.loss_pct = cases[i].loss;
        assert_memory_equal(&got, &want, sizeof got);
    }
}

/* The paper's delays lie in 10 to 500 ms, uniformly. */
static void the_papers_link_is_that_of_the_paper(void **state)
{
    (void)state;
    ll_link_params params = preset_params("paper");
    ll_link *link = link_open(10, 1000, 1, 1);
    ll_sending *s = link_send_many(link, &params, 0, 100000);
    const ll_link_stats *stats = ll_link_get_stats(link);
    assert_true(stats->delay.min_ms >= 10 && stats->delay.min_ms < 10.1);
    assert_true(stats->delay.max_ms < 500 && stats->delay.max_ms > 499.9);
    assert_near(stats->delay.sum_ms / 1e5, 255, 3 * 245 / sqrt(3e5));
    free(s);
    free(link);
}

/* Of a busy cell: 1 % of the packets begin a bad time of four on average, in which 60 % are lost. */
static void a_busy_cell_loses_in_bursts(void **state)
{
    (void)state;
    enum { COUNT = 400000 };
    ll_link_params params = preset_params("wifi_busy");
    ll_link *link = link_open(10, 1000, 1, 1);
    ll_sending *s = link_send_many(link, &params, 0, COUNT);
    double lost = 0, again = 0;
    for (int i = 0; i + 1 < COUNT; i++) {
        lost += s[i].fate == LL_FATE_LOST;
        again += s[i].fate == LL_FATE_LOST && s[i + 1].fate == LL_FATE_LOST;
    }
    assert_near(lost / COUNT, 0.6 * 0.01 / (0.01 + 0.25), 0.002);
    assert_near(again / lost, 0.6 * (1 - 0.25), 0.03);
    free(s);
    free(link);
}

static void custom_sets_nothing(void **state)
{
    (void)state;
    ll_link_params up = preset_params("bufferbloat"), down = preset_params("tunnel"), u = up, d = down;
    ll_link_preset_apply(0, &up, &down);
    assert_memory_equal(&up, &u, sizeof u);
    assert_memory_equal(&down, &d, sizeof d);
}

/* Earlier values do not remain. */
static void a_preset_sets_every_row(void **state)
{
    (void)state;
    ll_link_params up = preset_params("bufferbloat"), down = preset_params("tunnel"),
                   want = preset_params("fiber");
    ll_link_preset_apply(preset_named("fiber"), &up, &down);
    assert_memory_equal(&up, &want, sizeof want);
    assert_memory_equal(&down, &want, sizeof want);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_follow_the_table),
        cmocka_unit_test(values_are_those_of_the_source),
        cmocka_unit_test(the_papers_link_is_that_of_the_paper),
        cmocka_unit_test(a_busy_cell_loses_in_bursts),
        cmocka_unit_test(custom_sets_nothing),
        cmocka_unit_test(a_preset_sets_every_row),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
