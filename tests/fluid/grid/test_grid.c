/* What every grid keeps: divergence as asked, momentum, its block; and how it tells that it cannot go on. */
#include "fluid/harness.h"

#include "fluid/grid/parameters.h"
#include "fluid/grid/state.h"
#include "fluid/scenes/scenes.h"
#include "support/allocations.h"

static void tables_are_sound(void **state)
{
    (void)state;
    for (int i = 0; ll_fluid_scenes[i]; i++) {
        const ll_fluid_scene *scene = ll_fluid_scenes[i];
        assert_string_equal(scene->name, ll_fluid_scene_names[i]);
        assert_ptr_equal(scene->params, ll_fluid_params_tables[i]);
        assert_ptr_equal(scene->solver, ll_fluid_solver_tables[i]);
        const ll_param_table *both[] = {scene->params, scene->solver};
        for (int t = 0; t < 2; t++) {
            ll_status status = ll_param_table_valid(both[t]);
            if (ll_failed(&status))
                fail_msg("%s: %s", scene->name, status.text);
            assert_true(both[t]->size <= LL_FLUID_PARAMS_MAX);
        }
    }
}

/* Per second of a flow of 1 m/s and cells of 1/32 m. */
static void the_projection_leaves_what_is_asked(void **state)
{
    (void)state;
    static const struct {
        const char *settings;
        double most;
    } known[] = {{"solver.pressure=direct", 1e-12},
                 {"solver.pressure=multigrid solver.tolerance=1e-3", 1e-1},
                 {"solver.pressure=multigrid solver.tolerance=1e-9", 1e-7},
                 {"solver.pressure=pcg solver.tolerance=1e-9", 1e-7},
                 {"solver.pressure=sor solver.tolerance=1e-9", 1e-7}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        char settings[160];
        snprintf(settings, sizeof settings, "params.n=32 solver.advection=maccormack %s", known[i].settings);
        tank t = tank_open("cavity", settings);
        for (int step = 0; step < 30; step++) {
            tank_run(&t, 1, 1.0 / 60);
            assert_between(known[i].settings, tank_number(&t, "divergence_max"), 0, known[i].most);
        }
        tank_close(&t);
    }
}

/* Neither what advection nor what a hand carries into an obstacle comes out of it again. */
static void obstacles_let_nothing_through(void **state)
{
    (void)state;
    static const char *const advections[] = {"solver.advection=semi_lagrangian",
                                             "solver.advection=maccormack", "solver.advection=central"};
    for (int i = 0; i < 3; i++) {
        tank t = tank_open("cylinder", "params.n=64 solver.tolerance=1e-12");
        tank_set(&t, advections[i]);
        t.scene->method->set_solver(t.block, t.solver);
        t.scene->method->drag_force(
            t.block, &(ll_drag_force){.x = 0.6, .y = 1, .velocity_x = -2, .velocity_y = 1, .radius = 0.3});
        for (int step = 0; step < 5; step++) {
            tank_run(&t, 1, 1. / 60);
            assert_between(advections[i], tank_number(&t, "divergence_max"), 0, 1e-9);
        }
        tank_close(&t);
    }
}

/* What games do is told, not hidden. */
static void few_sweeps_leave_divergence(void **state)
{
    (void)state;
    tank t = tank_open("cylinder", "params.n=64 solver.pressure=jacobi solver.tolerance=0 solver.sweeps=20");
    tank_run(&t, 10, 1.0 / 60);
    assert_between("sweeps", tank_number(&t, "sweeps"), 20, 20);
    assert_between("left", tank_number(&t, "divergence_max"), 1e-3, 100);
    tank_close(&t);
}

/* ---- the dye's mass ---- */

/* A disc in a vortex that fills a closed box, and the flow's stream function. */
static double stream(double x, double y)
{
    return sin(M_PI * x) * sin(M_PI * y) / M_PI;
}

static ll_grid *closed_box(const ll_grid_solver *solver)
{
    enum { N = 48 };
    const ll_grid_config config = {.nx = N, .ny = N, .h = 1. / N, .dyed = 1, .frozen = 1};
    ll_grid *g = malloc(ll_grid_size(N, N));
    assert_non_null(g);
    ll_grid_init(g, &config, solver);
    for (int32_t j = 0; j <= N; j++)
        for (int32_t i = 0; i <= N; i++) {
            int64_t k = ll_grid_at(N, i, j);
            double h = config.h, x = i * h, y = j * h, dx = x + h / 2 - 0.5, dy = y + h / 2 - 0.7;
            ll_grid_u(g)[k] = j < N ? (stream(x, y + h) - stream(x, y)) / h : 0;
            ll_grid_v(g)[k] = i < N ? (stream(x, y) - stream(x + h, y)) / h : 0;
            ll_grid_dye(g)[k] = i < N && j < N && dx * dx + dy * dy < 0.15 * 0.15;
        }
    ll_grid_start(g);
    return g;
}

static double number_of(const ll_grid *g, const char *name)
{
    ll_fluid_number all[LL_FLUID_NUMBERS_MAX];
    int count = ll_grid_numbers(g, all);
    for (int i = 0; i < count; i++)
        if (strcmp(all[i].name, name) == 0)
            return all[i].value;
    fail_msg("a grid tells no %s", name);
    return 0;
}

/* By every scheme, at every length of a step, and without a new extreme. Clamped schemes alone do not. */
static void a_closed_box_keeps_its_dye(void **state)
{
    (void)state;
    for (int advection = 0; advection < LL_ADVECTION_CENTRAL; advection++)
        for (int steps = 16; steps <= 64; steps *= 4)
            for (int keep = 0; keep < 2; keep++) {
                ll_grid_solver solver;
                ll_param_defaults(&ll_fluid_rotation_solver, &solver);
                solver.advection = advection;
                solver.substeps = 1;
                solver.conserve_mass = keep;
                ll_grid *g = closed_box(&solver);
                for (int i = 0; i < steps; i++) {
                    ll_status status = ll_grid_step(g, 1. / steps, NULL);
                    assert_false(ll_failed(&status));
                }
                const char *name = ll_advection_names[advection];
                double change = fabs(number_of(g, "mass_change"));
                assert_between(name, change, keep ? 0 : 1e-4, keep ? 1e-12 : 1);
                assert_between(name, number_of(g, "dye_min"), 0, 0.1);
                assert_between(name, number_of(g, "dye_max"), 0.5, 1);
                free(g);
            }
}

static void obstacles_take_no_dye(void **state)
{
    (void)state;
    tank t = tank_open("cylinder", "params.n=32 solver.advection=semi_lagrangian");
    tank_run(&t, 180, 1.0 / 60); /* it stands in the smoke */
    for (int32_t j = 0; j < 32; j++)
        for (int32_t i = 0; i < 32; i++) {
            int64_t k = ll_grid_at(32, i, j);
            if (!ll_grid_fluid(t.block)[k])
                assert_true(ll_grid_dye(t.block)[k] == 0);
        }
    assert_between("dye", tank_number(&t, "mass"), 0.05, 1);
    tank_close(&t);
}

static void momentum_is_kept_without_walls(void **state)
{
    (void)state;
    tank t = tank_open("taylor_green", "params.n=32");
    double x = tank_number(&t, "momentum_x"), y = tank_number(&t, "momentum_y");
    tank_run(&t, 60, 1.0 / 60);
    assert_between("along x", tank_number(&t, "momentum_x") / x - 1, -1e-13, 1e-13);
    assert_between("along y", tank_number(&t, "momentum_y") / y - 1, -1e-13, 1e-13);
    tank_close(&t);
}

static void as_much_flows_out_as_in(void **state)
{
    (void)state;
    tank t = tank_open("cylinder", "params.n=32 solver.tolerance=1e-10");
    tank_run(&t, 60, 1.0 / 60);
    const ll_grid *g = t.block;
    double flow = 0;
    for (int32_t j = 0; j < 32; j++)
        flow += ll_grid_u(g)[ll_grid_at(32, 32, j)] - ll_grid_u(g)[ll_grid_at(32, 0, j)];
    assert_between("the difference", flow, -1e-12, 1e-12);
    assert_between("divergence", tank_number(&t, "divergence_max"), 0, 1e-7);
    tank_close(&t);
}

static void nothing_flows_into_obstacles(void **state)
{
    (void)state;
    tank t = tank_open("cylinder", "params.n=32");
    tank_run(&t, 30, 1.0 / 60);
    const ll_grid *g = t.block;
    int obstacles = 0;
    for (int32_t j = 0; j < 32; j++)
        for (int32_t i = 0; i < 32; i++) {
            int64_t k = ll_grid_at(32, i, j);
            if (ll_grid_fluid(g)[k])
                continue;
            obstacles++;
            assert_true(ll_grid_u(g)[k] == 0 && ll_grid_u(g)[k + 1] == 0);
            assert_true(ll_grid_v(g)[k] == 0 && ll_grid_v(g)[k + g->stride] == 0);
        }
    assert_between("cells of the cylinder", obstacles, 4, 12);
    tank_close(&t);
}

static void a_copy_goes_on_alike(void **state)
{
    (void)state;
    tank t = tank_open("cylinder", "params.n=32"), other = t;
    tank_run(&t, 10, 1.0 / 60);
    other.block = malloc(t.size);
    memcpy(other.block, t.block, t.size);
    tank_run(&t, 10, 1.0 / 60);
    tank_run(&other, 10, 1.0 / 60);
    assert_int_equal(tank_hash(&t), tank_hash(&other));
    tank_close(&t);
    tank_close(&other);
}

/* Solver, scheme and viscosity change while it runs. */
static void settings_change_between_steps(void **state)
{
    (void)state;
    tank t = tank_open("cavity", "params.n=32 params.re=1000");
    for (int advection = 0; advection < LL_ADVECTIONS; advection++)
        for (int pressure = 0; pressure < LL_PRESSURES; pressure++) {
            ll_grid_solver *s = (ll_grid_solver *)t.solver;
            s->advection = advection;
            s->pressure = pressure;
            s->sweeps = 40;
            t.scene->method->set_solver(t.block, s);
            tank_run(&t, 3, 1.0 / 60);
        }
    double before = tank_number(&t, "energy");
    assert_int_equal(tank_set(&t, "solver.viscosity_scale=100").code, LL_OK);
    t.scene->method->set_solver(t.block, t.solver);
    tank_run(&t, 30, 1.0 / 60);
    assert_between("divergence", tank_number(&t, "divergence_max"), 0, 1e-12);
    assert_between("energy", tank_number(&t, "energy"), 0, 10 * before);
    tank_close(&t);
}

static void steps_do_not_allocate(void **state)
{
    (void)state;
    for (int advection = 0; advection < LL_ADVECTIONS; advection++) {
        char settings[100];
        snprintf(settings, sizeof settings,
                 "params.n=32 solver.vorticity_confinement=0.1 solver.advection=%s",
                 ll_advection_names[advection]);
        tank t = tank_open("cylinder", settings);
        long before = allocations();
        tank_run(&t, 5, 1.0 / 60);
        assert_int_equal(allocations() - before, 0);
        assert_true(before != 0); /* the count does count */
        tank_close(&t);
    }
}

static void stirring_draws_along(void **state)
{
    (void)state;
    tank t = tank_open("cavity", "params.n=32");
    ll_drag_force drag_force = {.x = 0.5, .y = 0.3, .velocity_x = 2, .radius = 0.1};
    t.scene->method->drag_force(t.block, &drag_force);
    tank_run(&t, 5, 1.0 / 60);
    const ll_grid *g = t.block;
    assert_between("speed where it is stirred", ll_grid_u(g)[ll_grid_at(32, 16, 9)], 1, 2.5);
    drag_force.radius = 0;
    t.scene->method->drag_force(t.block, &drag_force);
    double before = tank_number(&t, "energy");
    tank_run(&t, 60, 1.0 / 60);
    assert_between("energy afterwards", tank_number(&t, "energy"), 0, before);
    tank_close(&t);
}

static void confinement_feeds_vortices(void **state)
{
    (void)state;
    double without = tank_result("cylinder", "params.n=64", 60, 1.0 / 60, "energy");
    double with =
        tank_result("cylinder", "params.n=64 solver.vorticity_confinement=2", 60, 1.0 / 60, "energy");
    assert_between("energy", with, without * 1.0001, without * 2);
}

static void smoke_rises(void **state)
{
    (void)state;
    assert_between("momentum upward",
                   tank_result("cylinder", "params.n=32 params.buoyancy_mps2=2", 30, 1.0 / 60, "momentum_y"),
                   1e-4, 1);
}

/* ---- what cannot go on ---- */

static void a_value_that_is_not_finite_is_found_by_its_step(void **state)
{
    (void)state;
    tank t = tank_open("cavity", "params.n=16");
    tank_run(&t, 4, 1.0 / 60);
    ll_grid_u(t.block)[ll_grid_at(16, 5, 7)] = NAN;
    ll_status status = tank_try(&t, 1, 1.0 / 60);
    assert_int_equal(status.code, LL_DIVERGED);
    assert_non_null(strstr(status.text, "step 4: cell (4, 7) is not finite"));
    tank_close(&t);
}

static void a_step_beyond_the_cfl_limit_is_named(void **state)
{
    (void)state;
    tank t = tank_open("taylor_green", "params.n=32 solver.substeps=1");
    ll_status status = tank_try(&t, 10, 1);
    assert_int_equal(status.code, LL_DIVERGED);
    assert_non_null(strstr(status.text, "step 0: cell ("));
    assert_non_null(strstr(status.text, "CFL"));
    tank_close(&t);
    t = tank_open("taylor_green", "params.n=32 solver.cfl=0.01");
    ll_grid_u(t.block)[ll_grid_at(32, 3, 4)] = 1e9;
    status = tank_try(&t, 1, 1);
    assert_int_equal(status.code, LL_DIVERGED);
    assert_non_null(strstr(status.text, "more than 1000 substeps"));
    tank_close(&t);
}

static void too_many_cells_are_refused_with_their_memory(void **state)
{
    (void)state;
    tank t;
    ll_status status = tank_check(&t, "cavity", "params.n=4096");
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_string_equal(status.field, "params.n");
    assert_non_null(strstr(status.text, "4096 x 4096 cells would take"));
    assert_non_null(strstr(status.text, "MiB"));
    status = tank_check(&t, "cylinder", "params.n=512");
    assert_false(ll_failed(&status));
    status = tank_check(&t, "cylinder", "params.n=33");
    assert_int_equal(status.code, LL_BAD_INPUT);
}

static void a_direct_solver_wants_an_empty_box(void **state)
{
    (void)state;
    tank t;
    ll_status status = tank_check(&t, "cylinder", "solver.pressure=direct");
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_string_equal(status.field, "solver.pressure");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_are_sound),
        cmocka_unit_test(the_projection_leaves_what_is_asked),
        cmocka_unit_test(obstacles_let_nothing_through),
        cmocka_unit_test(few_sweeps_leave_divergence),
        cmocka_unit_test(a_closed_box_keeps_its_dye),
        cmocka_unit_test(obstacles_take_no_dye),
        cmocka_unit_test(momentum_is_kept_without_walls),
        cmocka_unit_test(as_much_flows_out_as_in),
        cmocka_unit_test(nothing_flows_into_obstacles),
        cmocka_unit_test(a_copy_goes_on_alike),
        cmocka_unit_test(settings_change_between_steps),
        cmocka_unit_test(steps_do_not_allocate),
        cmocka_unit_test(stirring_draws_along),
        cmocka_unit_test(confinement_feeds_vortices),
        cmocka_unit_test(smoke_rises),
        cmocka_unit_test(a_value_that_is_not_finite_is_found_by_its_step),
        cmocka_unit_test(a_step_beyond_the_cfl_limit_is_named),
        cmocka_unit_test(too_many_cells_are_refused_with_their_memory),
        cmocka_unit_test(a_direct_solver_wants_an_empty_box),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
