/* Scenes of particles and of the ocean through the room's one interface. */
#include "fluid/harness.h"

#define FRAME (1. / 60)

static void fronts_are_held_against_the_table(void **state)
{
    (void)state;
    tank t = tank_open("dam_break", "params.size=16");
    tank_run(&t, 60, FRAME);
    assert_between("error of the front", tank_number(&t, "front_error"), -0.05, 0.05);
    assert_between("front over Ritter's", tank_number(&t, "front_over_ritter"), 0.3, 1);
    assert_between("mass", tank_number(&t, "mass"), 2 - 1e-9, 2 + 1e-9);
    tank_run(&t, 90, FRAME); /* beyond the table */
    assert_true(tank_number(&t, "front_measured_m") == 0 && tank_number(&t, "front_error") == 0);
    tank_close(&t);
}

static void channels_are_held_against_the_series(void **state)
{
    (void)state;
    double error = tank_result("poiseuille", "params.size=16", 60, FRAME, "velocity_error_rms");
    assert_between("error of the velocity", error, 0, 0.01);
}

static void columns_are_held_against_their_depth(void **state)
{
    (void)state;
    double error = tank_result("hydrostatic", "params.size=20", 600, FRAME, "pressure_error_rms");
    assert_between("error of the pressure", error, 0, 0.02);
}

static void solvers_change_while_it_runs(void **state)
{
    (void)state;
    tank t = tank_open("raft", "params.size=12");
    static const char *const methods[] = {"solver.method=wcsph", "solver.method=pbf solver.iterations=5",
                                          "solver.method=dfsph solver.iterations=100"};
    for (int i = 0; i < 3; i++) {
        ll_status status = tank_set(&t, methods[i]);
        assert_false(ll_failed(&status));
        t.scene->method->set_solver(t.block, t.solver);
        tank_run(&t, 10, FRAME);
    }
    assert_between("compression", tank_number(&t, "density_error_max"), 0, 0.05);
    tank_close(&t);

    tank s = tank_open("sea", "params.n=64 params.tile=32");
    for (int i = 0; i < 3; i++) {
        static const char *const kinds[] = {"solver.method=gerstner", "solver.method=tiled",
                                            "solver.method=spectrum"};
        tank_set(&s, kinds[i]);
        s.scene->method->set_solver(s.block, s.solver);
        tank_run(&s, 10, FRAME);
        assert_between("significant height", tank_number(&s, "significant_height_m"), 0.3, 3);
    }
    tank_close(&s);
}

static void fluid_is_drawn_along(void **state)
{
    (void)state;
    tank t = tank_open("pool", "params.size=80");
    ll_drag_force drag_force = {.x = 5, .y = 0.5, .velocity_x = 3, .radius = 0.8};
    t.scene->method->drag_force(t.block, &drag_force);
    double before = tank_number(&t, "momentum_x");
    tank_run(&t, 5, FRAME);
    assert_between("momentum", tank_number(&t, "momentum_x") - before, 500, 1e5);
    tank_close(&t);
}

static void a_box_floats_on_the_sea(void **state)
{
    (void)state;
    tank t = tank_open("sea", "params.n=64 params.tile=32");
    tank_run(&t, 600, FRAME);
    double above = tank_number(&t, "body_y_m") - tank_number(&t, "water_at_body_m");
    assert_between("box above the water", above, -1, 1);
    assert_between("pitch", tank_number(&t, "body_pitch_rad"), -0.5, 0.5);
    tank_close(&t);
}

static void hostile_sizes_are_refused(void **state)
{
    (void)state;
    static const char *const bad[][2] = {{"dam_break", "params.size=1000"},
                                         {"dam_break", "params.size=4"},
                                         {"pool", "params.size=1e99"},
                                         {"raft", "params.size=nan"},
                                         {"sea", "params.n=22"},
                                         {"sea", "params.n=64 params.tile=48"},
                                         {"sea", "params.loop_s=0"},
                                         {"sea", "params.n=16384"}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        tank t;
        ll_status status = tank_check(&t, bad[i][0], bad[i][1]);
        if (!ll_failed(&status))
            fail_msg("%s with %s is taken", bad[i][0], bad[i][1]);
        assert_true(status.field[0] != '\0' && status.text[0] != '\0');
    }
    tank t;
    ll_status large = tank_check(&t, "dam_break", "params.size=1000");
    assert_non_null(strstr(large.text, "MiB"));
}

static void lagged_density_is_told_by_tick_and_particle(void **state)
{
    (void)state;
    tank t = tank_open("dam_break", "params.size=30 solver.lagged_density=true");
    ll_status status = tank_try(&t, 100, FRAME);
    assert_int_equal(status.code, LL_DIVERGED);
    assert_non_null(strstr(status.text, "particle"));
    tank_close(&t);
}

static void layers_are_as_large_as_they_say(void **state)
{
    (void)state;
    static const char *const scenes[] = {"raft", "drop", "sea"};
    for (int i = 0; i < 3; i++) {
        tank t = tank_open(scenes[i], i == 2 ? "params.n=16 params.tile=8" : "params.size=12");
        const ll_fluid_method *m = t.scene->method;
        double x0, y0, x1, y1;
        m->extent(t.block, &x0, &y0, &x1, &y1);
        for (int layer = 0; layer < m->layer_count; layer++) {
            int32_t width, height;
            int columns = 0;
            m->layer_size(t.block, layer, &width, &height);
            while (m->layers[layer].columns[columns])
                columns++;
            size_t count = (size_t)(width * height * columns);
            float *values = malloc((count + 1) * sizeof *values);
            values[count] = 1234;
            m->layer_values(t.block, layer, values);
            assert_true(values[count] == 1234);
            for (size_t k = 0; k < count; k += (size_t)columns)
                if (m->layers[layer].shape == LL_FLUID_POINTS)
                    assert_between("x", values[k], x0, x1);
            free(values);
        }
        tank_close(&t);
    }
}

/* What a page draws: the caller frees it. */
static float *layer_of(const tank *t, const char *name, int32_t *width, int32_t *height)
{
    const ll_fluid_method *m = t->scene->method;
    int layer = 0, columns = 0;
    while (layer < m->layer_count && strcmp(m->layers[layer].name, name) != 0)
        layer++;
    assert_true(layer < m->layer_count);
    m->layer_size(t->block, layer, width, height);
    while (m->layers[layer].columns[columns])
        columns++;
    float *values = malloc((size_t)*width * (size_t)*height * (size_t)columns * sizeof *values);
    assert_non_null(values);
    m->layer_values(t->block, layer, values);
    return values;
}

static void a_seas_numbers_are_those_of_the_heights_that_are_drawn(void **state)
{
    (void)state;
    tank t = tank_open("sea", "params.n=64 params.tile=32 params.length_m=300");
    tank_run(&t, 45, FRAME);
    int32_t width, height;
    float *values = layer_of(&t, "height", &width, &height);
    double sum = 0, low = INFINITY, high = -INFINITY, second = 0, fourth = 0, points = (double)width * height;
    assert_true(width == 64 && height == 64);
    for (int i = 0; i < width * height; i++) {
        sum += (double)values[i];
        low = smaller(low, (double)values[i]);
        high = larger(high, (double)values[i]);
    }
    for (int i = 0; i < width * height; i++) {
        double square = ((double)values[i] - sum / points) * ((double)values[i] - sum / points);
        second += square / points;
        fourth += square * square / points;
    }
    assert_near(tank_number(&t, "height_min_m"), low, 1e-6);
    assert_near(tank_number(&t, "height_max_m"), high, 1e-6);
    assert_near(tank_number(&t, "height_mean_m"), sum / points, 1e-6);
    assert_near(tank_number(&t, "significant_height_m"), 4 * sqrt(second), 1e-6);
    assert_near(tank_number(&t, "excess_kurtosis"), fourth / (second * second) - 3, 1e-5);
    assert_near(tank_number(&t, "height_error"), 4 * sqrt(second) / tank_number(&t, "wind_sea_height_m") - 1,
                1e-6);
    assert_between("a share", tank_number(&t, "wind_sea_share_in_box"), 0.1, 1);
    free(values);
    float *body = layer_of(&t, "body", &width, &height); /* x, z, y, pitch, roll */
    assert_near(tank_number(&t, "body_y_m"), body[2], 1e-6);
    assert_near(tank_number(&t, "body_pitch_rad"), body[3], 1e-6);
    assert_near(tank_number(&t, "body_roll_rad"), body[4], 1e-6);
    assert_true(fabs((double)(body[3] - body[4])) > 1e-3 && fabs((double)body[4]) > 1e-3);
    free(body);
    tank_close(&t);
}

static void a_rafts_numbers_are_those_of_what_is_drawn(void **state)
{
    (void)state;
    tank t = tank_open("raft", "params.size=24");
    double left = tank_number(&t, "body_x_m") - 0.4; /* its left half is drawn down */
    t.scene->method->drag_force(
        t.block,
        &(ll_drag_force){.x = left, .y = tank_number(&t, "body_y_m"), .velocity_y = -2, .radius = 0.5});
    tank_run(&t, 20, FRAME);
    int32_t width, height;
    float *corner = layer_of(&t, "body", &width, &height), *particle = NULL;
    assert_true(width == 4 && height == 1);
    double x = 0, y = 0, right = -INFINITY;
    for (int i = 0; i < 4; i++) {
        x += (double)corner[2 * i] / 4;
        y += (double)corner[2 * i + 1] / 4;
    }
    assert_near(tank_number(&t, "body_x_m"), x, 1e-6);
    assert_near(tank_number(&t, "body_y_m"), y, 1e-6);
    assert_near(tank_number(&t, "body_angle_rad"),
                atan2((double)(corner[3] - corner[1]), (double)(corner[2] - corner[0])), 1e-5);
    assert_true(fabs(tank_number(&t, "body_angle_rad")) > 1e-4);
    particle = layer_of(&t, "particles", &width, &height);
    for (int i = 0; i < width; i++)
        right = larger(right, (double)particle[5 * i]);
    assert_between("half a particle", tank_number(&t, "front_m") - right, 1e-4, 0.1);
    free(corner);
    free(particle);
    tank_close(&t);
}

/* Only where something does not fit is something told. */
static void what_does_not_fit_is_told(void **state)
{
    (void)state;
    static const struct {
        const char *scene, *settings;
        int told;
    } rows[] = {
        {"sea", "params.n=64 params.length_m=400 params.wind_speed_mps=9", 0},
        {"sea", "params.n=64 params.length_m=150 params.wind_speed_mps=18", 1},
        {"sea", "params.n=64 params.length_m=3000 params.wind_speed_mps=6", 1},
        {"cavity", "params.n=32 params.re=400", 0},
        {"cavity", "params.n=32 params.re=2000", 1},
        {"cylinder", "params.n=64 params.re=30", 1},
        {"cylinder", "params.n=64 params.re=3000", 2},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        tank t = tank_open(rows[i].scene, rows[i].settings);
        ll_fluid_notice all[LL_FLUID_NOTICES_MAX];
        int told = t.scene->notices(t.block, all);
        if (told != rows[i].told)
            fail_msg("%s %s: %d", rows[i].scene, rows[i].settings, told);
        for (int k = 0; k < told; k++)
            assert_in_range(strlen(all[k].text), 60, sizeof all[k].text - 2);
        tank_close(&t);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_does_not_fit_is_told),
        cmocka_unit_test(fronts_are_held_against_the_table),
        cmocka_unit_test(channels_are_held_against_the_series),
        cmocka_unit_test(columns_are_held_against_their_depth),
        cmocka_unit_test(solvers_change_while_it_runs),
        cmocka_unit_test(fluid_is_drawn_along),
        cmocka_unit_test(a_box_floats_on_the_sea),
        cmocka_unit_test(hostile_sizes_are_refused),
        cmocka_unit_test(lagged_density_is_told_by_tick_and_particle),
        cmocka_unit_test(layers_are_as_large_as_they_say),
        cmocka_unit_test(a_rafts_numbers_are_those_of_what_is_drawn),
        cmocka_unit_test(a_seas_numbers_are_those_of_the_heights_that_are_drawn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
