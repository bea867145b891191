/* Hashes of whole blocks after some steps: the same on every compiler, optimisation level and machine.
 * `test_fluid golden_grid --update` writes the table anew. */
#include "fluid/harness.h"

#include <inttypes.h>

#define TABLE "tests/fluid/hashes_grid.csv"

static const char *const wanted[][2] = {
    {"cavity", "params.n=32"},
    {"cavity", "params.n=32 solver.pressure=jacobi solver.sweeps=40 solver.advection=semi_lagrangian"},
    {"cavity", "params.n=30 solver.pressure=gauss_seidel solver.sweeps=40 solver.advection=maccormack"},
    {"cavity", "params.n=36 solver.pressure=sor solver.advection=bfecc solver.backtrace=3"},
    {"cavity", "params.n=32 solver.pressure=pcg solver.splitting=reflection solver.advection=maccormack"},
    {"taylor_green", "params.n=32"},
    {"taylor_green",
     "params.n=30 solver.pressure=multigrid solver.advection=bfecc solver.splitting=reflection"},
    {"cylinder", "params.n=64"},
    {"cylinder", "params.n=48 solver.pressure=pcg solver.advection=central params.buoyancy_mps2=1"},
    {"cylinder", "params.n=40 solver.pressure=sor solver.vorticity_confinement=0.5 solver.backtrace=1"},
    {"rotation", "params.n=32"},
    {"rotation", "params.n=32 params.shape=gaussian solver.advection=central"},
};
enum { count = sizeof wanted / sizeof wanted[0], steps = 20 };

static uint64_t measure(int i)
{
    tank t = tank_open(wanted[i][0], wanted[i][1]);
    tank_run(&t, steps, 1.0 / 60);
    uint64_t hash = tank_hash(&t);
    tank_close(&t);
    return hash;
}

static void update(void)
{
    FILE *f = fopen(TABLE, "w");
    if (f == NULL)
        abort();
    fprintf(f, "scene,settings,hash\n");
    for (int i = 0; i < count; i++)
        fprintf(f, "%s,%s,%016" PRIx64 "\n", wanted[i][0], wanted[i][1], measure(i));
    fclose(f);
}

static void every_scene_has_its_hash(void **state)
{
    (void)state;
    char line[300], expected[300];
    FILE *f = fopen(TABLE, "r");
    assert_non_null(f);
    assert_non_null(fgets(line, sizeof line, f));
    for (int i = 0; i < count; i++) {
        assert_non_null(fgets(line, sizeof line, f));
        snprintf(expected, sizeof expected, "%s,%s,%016" PRIx64 "\n", wanted[i][0], wanted[i][1], measure(i));
        assert_string_equal(line, expected);
    }
    fclose(f);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_scene_has_its_hash)};
    if (argc > 1 && strcmp(argv[1], "--update") == 0) {
        update();
        return 0;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
