/* A fluid stepped by several threads has the bits of one stepped alone, for any number of threads. */
#include "fluid/harness.h"

#include <inttypes.h>

#include "support/many.h"
#include "threads/team.h"

typedef struct trial {
    const char *scene, *settings;
    int steps;
    const char *few; /* settings, where these take most of the time of all: of `test_fluid team many` */
} trial;

/* Large enough that threads share the work, with row numbers that no number of threads divides evenly. */
static const trial trials[] = {
    {"cavity", "params.n=72", 2, NULL},
    {"cavity", "params.n=70 solver.pressure=jacobi solver.sweeps=40 solver.advection=semi_lagrangian", 2,
     NULL},
    {"cavity", "params.n=70 solver.pressure=gauss_seidel solver.sweeps=40 solver.advection=bfecc", 2, NULL},
    {"cavity", "params.n=66 solver.pressure=sor solver.splitting=reflection solver.advection=maccormack", 2,
     NULL},
    {"cavity", "params.n=66 solver.pressure=pcg solver.advection=maccormack solver.backtrace=3", 2, NULL},
    {"taylor_green", "params.n=72", 2, NULL},
    {"taylor_green", "params.n=72 solver.pressure=direct solver.advection=bfecc solver.backtrace=1", 2, NULL},
    {"taylor_green", "params.n=88 solver.pressure=multigrid solver.advection=maccormack", 2, NULL},
    {"cylinder", "params.n=96", 2, NULL},
    {"cylinder", "params.n=72 solver.advection=central params.buoyancy_mps2=1", 2, NULL},
    {"cylinder", "params.n=74 solver.vorticity_confinement=0.5 params.re=1", 2, NULL},
    {"rotation", "params.n=72", 2, NULL},
    {"rotation", "params.n=72 params.shape=gaussian solver.advection=central", 2, NULL},
    {"sea", "params.n=128", 2, NULL},
    {"dam_break", "params.size=30", 2, NULL},
    {"dam_break", "params.size=30 solver.method=pbf solver.smoothing=0.1 solver.no_slip=true", 2, NULL},
    {"dam_break", "params.size=30 solver.method=dfsph", 2, NULL},
    {"poiseuille", "params.size=40", 2, NULL},
    {"poiseuille", "params.size=40 solver.method=pbf", 2, "params.size=28 solver.method=pbf"},
    {"poiseuille", "params.size=40 solver.method=dfsph solver.iterations=10", 2, NULL},
    {"raft", "params.size=40", 2, NULL},
    {"raft", "params.size=40 solver.method=wcsph solver.no_slip=true", 2, NULL},
    {"raft", "params.size=40 solver.method=pbf", 2, NULL},
    {"pool", "params.size=150", 2, NULL},
};

static bool many;

/* The same fluid alone and by a team of each number of threads; 0: none. */
static void compare(const trial *t, const int threads[2])
{
    const char *settings = t->few != NULL && !many ? t->few : t->settings;
    tank alone = tank_open(t->scene, settings), shared[2];
    ll_team *team[2] = {NULL};
    for (int k = 0; k < 2 && threads[k] > 0; k++) {
        shared[k] = tank_open(t->scene, settings);
        ll_status made = ll_team_make(threads[k], &team[k]);
        assert_false(ll_failed(&made));
    }
    for (int i = 0; i < t->steps; i++) {
        tank_run(&alone, 1, 1.0 / 60);
        uint64_t expected = tank_hash(&alone);
        for (int k = 0; k < 2 && threads[k] > 0; k++) {
            ll_fluid_run by_team = {.team = team[k]};
            ll_status status = shared[k].scene->method->step(shared[k].block, 1.0 / 60, &by_team);
            if (ll_failed(&status))
                fail_msg("%s %s: %s", t->scene, settings, status.text);
            uint64_t hash = tank_hash(&shared[k]);
            if (hash != expected)
                fail_msg("%s %s, step %d by %d threads: %016" PRIx64 " instead of %016" PRIx64, t->scene,
                         settings, i, threads[k], hash, expected);
        }
    }
    for (int k = 0; k < 2 && threads[k] > 0; k++) {
        ll_team_free(team[k]);
        tank_close(&shared[k]);
    }
    tank_close(&alone);
}

static void the_same_bits_by_any_number(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof trials / sizeof *trials; i++)
        compare(&trials[i], (int[]){2, i % 2 == 0 ? 5 : 0});
}

static void the_same_bits_by_more_threads_than_a_small_fluid_has_rows(void **state)
{
    (void)state;
    compare(&(trial){"cavity", "params.n=8", 3, NULL}, (int[]){LL_TEAM_PARTS_MAX, 0});
    compare(&(trial){"cylinder", "params.n=64", 1, NULL}, (int[]){LL_TEAM_PARTS_MAX, 0});
}

int main(int count, char **arguments)
{
    many = ll_test_many(count, arguments);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_same_bits_by_any_number),
        cmocka_unit_test(the_same_bits_by_more_threads_than_a_small_fluid_has_rows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
