/* The grid against what is known: the driven cavity, Taylor and Green's vortices, solid rotation. */
#include "fluid/harness.h"

#include "fluid/scenes/cavity_reference.h"

#define PI 3.14159265358979323846

/* Steady at Re 100 after 20 s. 128 x 128 cells are measured by bench/fluid_grid. */
static void the_cavity_converges_at_order_2(void **state)
{
    (void)state;
    double error[3];
    for (int i = 0; i < 3; i++) {
        char settings[64];
        snprintf(settings, sizeof settings, "params.n=%d params.re=100", 8 << i);
        error[i] = tank_result("cavity", settings, 20 * 20, 0.05, "error_max");
    }
    assert_between("order from 16 to 32 cells", log2(error[1] / error[2]), 1.8, 2.3);
    assert_between("error with 32 cells", error[2], 0, 0.0065);
    assert_between("error with 8 cells", error[0], error[1], 0.2);
}

static void profiles_run_from_wall_to_wall(void **state)
{
    (void)state;
    tank t = tank_open("cavity", "params.n=16 params.re=100");
    double pairs[LL_FLUID_POINTS_MAX][2];
    const char *name;
    tank_run(&t, 10, 0.05);
    assert_int_equal(t.scene->profile(t.block, 0, &name, pairs), 129);
    assert_string_equal(name, "u");
    assert_true(pairs[0][0] == 0 && pairs[0][1] == 0 && pairs[128][0] == 1 && pairs[128][1] == 1);
    assert_int_equal(t.scene->profile(t.block, 1, &name, pairs), 129);
    assert_string_equal(name, "v");
    assert_true(pairs[0][1] == 0 && pairs[128][1] == 0);
    assert_int_equal(t.scene->profile(t.block, 2, &name, pairs), 17);
    assert_string_equal(name, "u_reference");
    assert_true(pairs[8][0] == 0.5 && pairs[8][1] == -0.209149);
    assert_int_equal(t.scene->profile(t.block, 4, &name, pairs), 0);
    tank_close(&t);
    t = tank_open("cavity", "params.n=16 params.re=500");
    assert_int_equal(t.scene->profile(t.block, 2, &name, pairs), 0);
    tank_close(&t);
}

/* The printed table of 1982 is off by so much, no more and no less. */
static void ghias_table_has_its_known_errors(void **state)
{
    (void)state;
    static const double known[3] = {0.00926, 0, 0.01842}; /* at Re 400 it is all that is known */
    for (int r = 0; r < 3; r++) {
        double most = 0;
        for (int c = 0; c < 2; c++)
            for (int i = 0; i < ll_cavity_references[r].count[c]; i++) {
                const ll_cavity_point *p = &ll_cavity_references[r].points[c][i];
                most = larger(most, fabs(p->ghia - p->value));
            }
        assert_between("Ghia's error", most, known[r] - 1e-5, known[r] + 1e-5);
    }
}

static double vortices(int n, const char *settings, const char *name)
{
    char all[200];
    snprintf(all, sizeof all, "params.n=%d solver.substeps=1 %s", n, settings);
    double dt = PI / n; /* half a cell's time of the mean flow */
    return tank_result("taylor_green", all, (int)(5 / dt + 0.5), dt, name);
}

static void central_fluxes_carry_vortices_at_order_2(void **state)
{
    (void)state;
    double coarse = vortices(16, "", "error_l2"), fine = vortices(32, "", "error_l2");
    assert_between("order", log2(coarse / fine), 1.9, 2.1);
    assert_between("decay", vortices(32, "", "decay_error"), -0.01, 0.01);
}

/* nu = 0, so that all decay is the method's. The published figures are of vortices at rest. */
static void each_scheme_has_its_own_viscosity(void **state)
{
    (void)state;
    static const struct {
        const char *advection;
        double viscosity[3]; /* m^2/s, with 32, 64 and 128 cells */
    } known[] = {
        {"semi_lagrangian", {3.4e-2, 1.85e-2, 9.7e-3}},
        {"maccormack", {1.06e-2, 5.7e-3, 2.95e-3}},
        {"bfecc", {1.06e-2, 5.7e-3, 2.95e-3}},
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        for (int k = 0; k < 3; k++) {
            char settings[160];
            snprintf(settings, sizeof settings,
                     "params.viscosity_m2ps=0 params.mean_x_mps=0 params.mean_y_mps=0 solver.advection=%s",
                     known[i].advection);
            double wanted = known[i].viscosity[k];
            assert_between(known[i].advection, vortices(32 << k, settings, "numerical_viscosity_m2ps"),
                           0.97 * wanted, 1.03 * wanted);
        }
}

/* Interpolating where a of a cell is gone adds h^2 / (2 dt) a (1 - a) of viscosity along each axis: with the
 * mean flow, of half a cell a step, h / 4 (1 - u^2) and h / 4 (1 - v^2), whose work on the vortices is that
 * of 11 / 64 h as h falls. At rest it is less. The split adds the rest, what MacCormack has. */
static void a_mean_flow_adds_the_viscosity_of_interpolation(void **state)
{
    (void)state;
    double interpolation[2];
    for (int i = 0; i < 2; i++) {
        double part[2];
        for (int k = 0; k < 2; k++)
            part[k] = vortices(64 << i,
                               k ? "params.viscosity_m2ps=0 solver.advection=maccormack"
                                 : "params.viscosity_m2ps=0 solver.advection=semi_lagrangian",
                               "numerical_viscosity_m2ps");
        interpolation[i] = (part[0] - part[1]) * (64 << i) / (2 * PI);
    }
    assert_between("of interpolation over h", 2 * interpolation[1] - interpolation[0], 0.99 * 11 / 64,
                   1.01 * 11 / 64);
    assert_between("central", vortices(32, "params.viscosity_m2ps=0", "numerical_viscosity_m2ps"), -2e-4,
                   2e-4);
}

/* Split schemes are of order 1, whatever the order of advection; the reflection lifts that. */
static void the_reflection_lifts_the_order_of_the_split(void **state)
{
    (void)state;
    static const char *const split =
        "params.viscosity_m2ps=0 solver.advection=maccormack solver.splitting=%s";
    double viscosity[2][2];
    for (int r = 0; r < 2; r++)
        for (int i = 0; i < 2; i++) {
            char settings[120];
            snprintf(settings, sizeof settings, split, r ? "reflection" : "projection");
            viscosity[r][i] = vortices(32 << i, settings, "numerical_viscosity_m2ps");
        }
    assert_between("order of the split", log2(viscosity[0][0] / viscosity[0][1]), 0.7, 1.2);
    assert_between("order with reflection", log2(viscosity[1][0] / viscosity[1][1]), 1.9, 3.5);
    assert_between("gain", viscosity[0][1] / viscosity[1][1], 10, 1000);
    assert_between("decay with viscosity",
                   vortices(64, "solver.advection=maccormack solver.splitting=reflection", "decay_error"),
                   -0.01, 0.01);
}

static double turn(int n, const char *settings, const char *name)
{
    char all[200];
    snprintf(all, sizeof all, "params.n=%d solver.substeps=1 %s", n, settings);
    return tank_result("rotation", all, 4 * n, 0.25 / n, name);
}

/* One turn at a CFL of 0.785 a side: the L1 errors that are known, within a fifth. */
static void a_hill_comes_round_as_known(void **state)
{
    (void)state;
    static const struct {
        const char *advection;
        double error;
    } known[] = {{"semi_lagrangian", 2.8e-2}, {"maccormack", 6.4e-3}, {"bfecc", 1.7e-3}};
    for (size_t i = 0; i < 3; i++) {
        char settings[100];
        snprintf(settings, sizeof settings, "params.shape=gaussian solver.advection=%s", known[i].advection);
        assert_between(known[i].advection, turn(64, settings, "error_l1"), 0.8 * known[i].error,
                       1.2 * known[i].error);
    }
    double coarse = turn(32, "params.shape=gaussian solver.advection=bfecc", "error_l1");
    double fine = turn(64, "params.shape=gaussian solver.advection=bfecc", "error_l1");
    assert_between("order of bfecc", log2(coarse / fine), 1.8, 2.6);
}

/* An Euler step back spirals: it loses 12 % of the mass; the midpoint and the third order gain 1.7 %, most of
 * it through the sides. */
static void the_way_back_wants_order_2(void **state)
{
    (void)state;
    static const double change[3] = {-0.12, 0.017, 0.017};
    for (int order = 1; order <= 3; order++) {
        char settings[120];
        snprintf(settings, sizeof settings,
                 "params.shape=gaussian solver.advection=semi_lagrangian solver.conserve_mass=false "
                 "solver.backtrace=%d",
                 order);
        double wanted = change[order - 1];
        assert_between("change of mass", turn(64, settings, "mass_change"), wanted - 0.2 * fabs(wanted),
                       wanted + 0.2 * fabs(wanted));
    }
}

static void a_slotted_disc_overshoots_only_unclamped(void **state)
{
    (void)state;
    static const char *const schemes[] = {"maccormack", "bfecc"};
    for (int i = 0; i < 2; i++) {
        char settings[80];
        snprintf(settings, sizeof settings, "params.n=64 solver.advection=%s", schemes[i]);
        tank t = tank_open("rotation", settings);
        tank_run(&t, 120, 1.0 / 240);
        assert_between("least", tank_number(&t, "dye_min"), 0, 0);
        assert_between("most", tank_number(&t, "dye_max"), 0.5, 1);
        tank_close(&t);
    }
    assert_between("unclamped", turn(64, "solver.advection=maccormack solver.limiter=false", "dye_max"), 1.05,
                   1.6);
}

/* Clamping lifts what undershoots beside the disc and in its slot by a quarter of its mass in a turn, and
 * cuts half of that from what overshoots. What is left with the mass kept comes in through the sides. */
static void a_slotted_disc_keeps_its_mass(void **state)
{
    (void)state;
    assert_between("clamped alone", turn(64, "solver.conserve_mass=false", "mass_change"), 0.12, 0.13);
    assert_between("kept", turn(64, "", "mass_change"), -1e-4, 1e-4);
    assert_between("kept, 128 cells", turn(128, "", "mass_change"), -2e-6, 2e-6);
    assert_between("most", turn(64, "", "dye_max"), 0.5, 1);
    assert_between("least", turn(64, "", "dye_min"), 0, 0);
    assert_between("share of the error",
                   turn(64, "", "error_l1") / turn(64, "solver.conserve_mass=false", "error_l1"), 0.9, 1);
}

static void limited_fluxes_keep_the_mass(void **state)
{
    (void)state;
    tank t = tank_open("rotation", "solver.advection=central");
    tank_run(&t, 15, 1.0 / 60); /* later its thin end reaches the sides, and leaves */
    assert_between("change of mass", tank_number(&t, "mass_change"), -1e-13, 1e-13);
    assert_between("least", tank_number(&t, "dye_min"), -1e-15, 0);
    assert_between("most", tank_number(&t, "dye_max"), 0.8, 1 + 1e-15);
    tank_close(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_cavity_converges_at_order_2),
        cmocka_unit_test(profiles_run_from_wall_to_wall),
        cmocka_unit_test(ghias_table_has_its_known_errors),
        cmocka_unit_test(central_fluxes_carry_vortices_at_order_2),
        cmocka_unit_test(each_scheme_has_its_own_viscosity),
        cmocka_unit_test(a_mean_flow_adds_the_viscosity_of_interpolation),
        cmocka_unit_test(the_reflection_lifts_the_order_of_the_split),
        cmocka_unit_test(a_hill_comes_round_as_known),
        cmocka_unit_test(the_way_back_wants_order_2),
        cmocka_unit_test(a_slotted_disc_overshoots_only_unclamped),
        cmocka_unit_test(a_slotted_disc_keeps_its_mass),
        cmocka_unit_test(limited_fluxes_keep_the_mass),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
