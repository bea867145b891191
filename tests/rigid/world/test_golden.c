/* Hashes of scenes when all their bodies have fallen asleep, and the step of that: the same on every
 * compiler, optimisation level, SIMD width and broad phase. `test_rigid golden --update` writes the table. */
#include "rigid/harness.h"

#include <inttypes.h>

#define TABLE "tests/rigid/hashes.csv"

typedef struct row {
    char scene[32], solver[16];
    int64_t size;
    int steps; /* step at which all slept, or the last one */
    uint64_t hash;
} row;

static const row wanted[] = {
    {"column", "soft_step", 20, 0, 0},      {"pyramid", "soft_step", 10, 0, 0},
    {"heavy_tops", "soft_step", 6, 0, 0},   {"domino", "soft_step", 15, 0, 0},
    {"card_house", "soft_step", 3, 0, 0},   {"arch", "soft_step", 1, 0, 0},
    {"rugged_wall", "soft_step", 30, 0, 0}, {"drop", "soft_step", 12, 0, 0},
    {"overlap", "soft_step", 4, 0, 0},      {"ball_chain", "soft_step", 10, 0, 0},
    {"rain", "soft_step", 6, 0, 0},         {"windmill", "soft_step", 1, 0, 0},
    {"heavy_on_two", "soft_step", 1, 0, 0}, {"tiny_pyramid", "soft_step", 8, 0, 0},
    {"circle_stack", "soft_step", 6, 0, 0}, {"tilted_stack", "soft_step", 4, 0, 0},
    {"ramps", "soft_step", 1, 0, 0},        {"confined", "soft_step", 6, 0, 0},
    {"column", "impulse", 5, 0, 0},         {"pyramid", "pgs", 5, 0, 0},
    {"pyramid", "pgs_ngs", 5, 0, 0},        {"pyramid", "tgs_sticky", 5, 0, 0},
    {"bridge", "xpbd", 10, 0, 0},           {"bridge", "avbd", 10, 0, 0},
};
enum { count = sizeof wanted / sizeof wanted[0], longest = 900 };

static row measure(const row *w, int32_t simd, int32_t broad)
{
    row r = *w;
    ll_scene_args args = {.size = w->size};
    ll_rigid_params p = scene_params(w->scene, args);
    p.sleep = true;
    p.simd = simd;
    ok(ll_param_set(&ll_rigid_table, &p, "method", w->solver, false));
    lab l = lab_open(w->scene, args, &p, broad);
    do
        lab_run(&l, 1);
    while (++r.steps < longest && ll_rigid_get_stats(l.world).awake > 0);
    r.hash = ll_rigid_hash(l.world);
    lab_close(&l);
    return r;
}

static void update(void)
{
    FILE *f = fopen(TABLE, "w");
    if (f == NULL)
        abort();
    fprintf(f, "scene,solver,size,steps,hash\n");
    for (int i = 0; i < count; i++) {
        row r = measure(&wanted[i], LL_SIMD_AUTO, LL_BROAD_GRID);
        fprintf(f, "%s,%s,%" PRId64 ",%d,%016" PRIx64 "\n", r.scene, r.solver, r.size, r.steps, r.hash);
    }
    fclose(f);
}

static void every_scene_ends_with_its_hash(void **state)
{
    (void)state;
    FILE *f = fopen(TABLE, "r");
    assert_non_null(f);
    char line[160];
    assert_non_null(fgets(line, sizeof line, f));
    int asleep = 0;
    for (int i = 0; i < count; i++) {
        row expected;
        assert_non_null(fgets(line, sizeof line, f));
        assert_int_equal(sscanf(line, "%31[^,],%15[^,],%" SCNd64 ",%d,%" SCNx64, expected.scene,
                                expected.solver, &expected.size, &expected.steps, &expected.hash),
                         5);
        assert_string_equal(expected.scene, wanted[i].scene);
        row r = measure(&wanted[i], i % 2 == 0 ? LL_SIMD_AUTO : LL_SIMD_SCALAR, i % LL_BROADS);
        if (r.hash != expected.hash || r.steps != expected.steps)
            fail_msg("%s by %s: step %d, hash %016" PRIx64 " instead of %d, %016" PRIx64, r.scene, r.solver,
                     r.steps, r.hash, expected.steps, expected.hash);
        asleep += r.steps < longest;
    }
    fclose(f);
    assert_true(asleep >= 14); /* ten scenes, some of them with several solvers */
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "--update") == 0) {
        update();
        return 0;
    }
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_scene_ends_with_its_hash)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
