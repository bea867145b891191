/* Particles against measurements, closed forms and themselves. */
#include "fluid/harness.h"

#include "fluid/particle/state.h"
#include "support/allocations.h"

typedef struct lab {
    const ll_particle_scene *scene;
    ll_particle_setup setup;
    ll_particle_params params;
    ll_particles *fluid;
    size_t size;
} lab;

static void ok(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

static lab lab_of(const char *scene, int method, double size)
{
    lab l = {.scene = ll_particle_scene_named(scene)};
    assert_non_null(l.scene);
    ll_particle_scene_setup(l.scene, size, &l.setup, &l.params);
    l.params.method = method;
    return l;
}

static void lab_open(lab *l)
{
    ok(ll_particles_check(&l->setup));
    l->size = ll_particles_size(&l->setup);
    void *block = malloc(l->size);
    memset(block, 0xa5, l->size); /* what is not set must not matter */
    l->fluid = ll_particles_init(block, &l->setup, &l->params);
}

static void lab_run(lab *l, double seconds)
{
    int steps = (int)(seconds / l->scene->dt + 0.5);
    for (int i = 0; i < steps; i++)
        ok(ll_particles_step(l->fluid, l->scene->dt));
}

static ll_particle_metrics lab_measure(const lab *l)
{
    return ll_particles_measure(l->fluid, l->scene->depth);
}

static void lab_close(lab *l)
{
    free(l->fluid);
}

/* ---- dam break ---- */

enum { FRONTS = 15, DAM_STEPS = 121 };
static const double front_time[FRONTS] = {.41,  .84,  1.19, 1.43, 1.63, 1.83, 1.98, 2.20,
                                          2.32, 2.51, 2.65, 2.83, 2.98, 3.11, 3.33};
static const double front_place[FRONTS] = {1.11, 1.22, 1.44, 1.67, 1.89, 2.11, 2.33, 2.56,
                                           2.78, 3.00, 3.22, 3.44, 3.67, 3.89, 4.11};
static const double gate = 0.175; /* the gate took so long to open, in the unit of front_time */

static double front_at(const double *front, double dt, double time)
{
    double at = time / sqrt(2) / dt;
    int i = (int)at;
    return front[i] + (at - i) * (front[i + 1] - front[i]);
}

/* Relative RMS distance from Martin and Moyce's table (n^2 = 2), and the late slope dZ/dT. */
static double compare_fronts(int method, double *slope)
{
    lab l = lab_of("dam_break", method, 20);
    l.params.iterations = method == LL_PARTICLE_PBF ? 4 : 100;
    lab_open(&l);
    double front[DAM_STEPS] = {1}, dt = l.scene->dt, squares = 0;
    for (int i = 1; i < DAM_STEPS; i++) {
        ok(ll_particles_step(l.fluid, dt));
        front[i] = lab_measure(&l).front;
        assert_between("front to Ritter's", front[i], 1, 1 + 2 * sqrt(2) * i * dt);
    }
    for (int k = 0; k < FRONTS; k++) {
        double error = front_at(front, dt, front_time[k] - gate) / front_place[k] - 1;
        squares += error * error;
    }
    *slope = (front_at(front, dt, 3.1) - front_at(front, dt, 2.1)) / 1.0;
    /* At most two through a corner, where nothing but the walls' particles holds them. */
    double lost = method == LL_PARTICLE_PBF ? 1e-12 : 2.1 / 400;
    assert_between("mass", lab_measure(&l).mass, 2 - lost, 2 + 1e-12);
    lab_close(&l);
    return sqrt(squares / FRONTS);
}

static void fronts_are_as_measured(void **state)
{
    (void)state;
    for (int method = 0; method < LL_PARTICLE_METHODS; method++) {
        double slope, rms = compare_fronts(method, &slope);
        assert_between("front", rms, 0, 0.05);
        assert_between("slope", slope, 1.2, 1.7);
    }
}

/* ---- hydrostatics ---- */

/* From a lattice that its own weight breaks up, over the last second of ten. */
static void pressure_grows_with_depth(void **state)
{
    (void)state;
    static const struct {
        int method, iterations;
        double compression;
    } rows[] = {{LL_PARTICLE_WCSPH, 1, 0.01}, {LL_PARTICLE_DFSPH, 100, 1e-3}, {LL_PARTICLE_PBF, 16, 0.01}};
    for (int i = 0; i < 3; i++) {
        lab l = lab_of("hydrostatic", rows[i].method, 20);
        l.params.iterations = rows[i].iterations;
        lab_open(&l);
        lab_run(&l, 9);
        for (int k = 0; k < 50; k++) {
            lab_run(&l, l.scene->dt);
            assert_between("pressure", lab_measure(&l).pressure_rms, 0, 0.02);
        }
        ll_particle_metrics m = lab_measure(&l);
        assert_between("compression", m.density_max, 0, rows[i].compression);
        assert_between("speed", m.speed_max, 0, 0.01);
        lab_close(&l);
    }
}

/* A particle that leaves its neighbours keeps nothing of the pressure that it had among them. */
static void what_parts_carries_no_pressure(void **state)
{
    (void)state;
    for (int method = LL_PARTICLE_PBF; method < LL_PARTICLE_METHODS; method++) {
        lab l = lab_of("hydrostatic", method, 20);
        lab_open(&l);
        lab_run(&l, 1);
        ll_particle_view view = ll_particles_view(l.fluid);
        int32_t id = view.id[0];
        assert_between("pressure among others", view.pressure[0], 0.1, 1.1);
        ((double *)(uintptr_t)view.y)[0] = 1.4; /* 0.4 above the others */
        lab_run(&l, l.scene->dt);
        for (int i = 0; i < view.count; i++)
            if (view.id[i] == id)
                assert_between("pressure of a lone particle", view.pressure[i], 0, 1e-12);
        lab_close(&l);
    }
}

static void solvers_keep_the_density(void **state)
{
    (void)state;
    static const struct {
        int method;
        int iterations;
        double compression;
    } rows[] = {{LL_PARTICLE_DFSPH, 100, 1e-3}, {LL_PARTICLE_PBF, 4, 0.015}};
    for (int i = 0; i < 2; i++) {
        lab l = lab_of("hydrostatic", rows[i].method, 20);
        l.params.iterations = rows[i].iterations;
        lab_open(&l);
        lab_run(&l, 4);
        ll_particle_metrics m = lab_measure(&l);
        assert_between("mean compression", m.density_mean, 0, rows[i].compression);
        assert_between("height", m.height, 0.97, 1.01);
        lab_close(&l);
    }
}

/* ---- Poiseuille ---- */

static void channels_flow_as_poiseuille(void **state)
{
    (void)state;
    const double middle = 0.769190642828260; /* at time 1, of width 1, force 1, viscosity 0.1 */
    for (int method = 0; method < LL_PARTICLE_METHODS; method++) {
        lab l = lab_of("poiseuille", method, 20);
        l.params.iterations = method == LL_PARTICLE_PBF ? 4 : 100;
        lab_open(&l);
        lab_run(&l, 1);
        ll_particle_view view = ll_particles_view(l.fluid);
        double squares = 0;
        for (int i = 0; i < view.count; i++) {
            double y = view.y[i], u = 5 * y * (1 - y);
            for (int k = 1; k < 40; k += 2)
                u -= 40 / pow(M_PI * k, 3) * sin(k * M_PI * y) * exp(-0.1 * k * k * M_PI * M_PI);
            squares += (view.u[i] - u) * (view.u[i] - u);
        }
        assert_between("velocity", sqrt(squares / view.count) / middle, 0, 0.01);
        assert_between("largest velocity", lab_measure(&l).speed_max / middle, 0.99, 1.01);
        lab_close(&l);
    }
}

/* ---- conservation ---- */

static void momentum_is_exact_without_walls(void **state)
{
    (void)state;
    for (int method = 0; method < LL_PARTICLE_METHODS; method++) {
        lab l = lab_of("drop", method, 20);
        l.params.iterations = method == LL_PARTICLE_PBF ? 4 : 100;
        l.params.smoothing = 0.1;
        lab_open(&l);
        lab_run(&l, 1);
        ll_particle_metrics m = lab_measure(&l);
        assert_between("mass", m.mass, 316. / 400 - 1e-12, 316. / 400 + 1e-12);
        assert_between("momentum", m.momentum_x / m.mass - 0.3, -1e-12, 1e-12);
        assert_between("momentum", m.momentum_y / m.mass + 0.8, -1e-12, 1e-12);
        /* Nothing else gives energy: at first strain 1 over the disc. */
        double fall = m.mass * (0.3 * 0.3 + 0.8 * 0.8) / 2, strain = m.mass * 0.25 * 0.25;
        assert_between("energy of deformation", m.kinetic_energy - fall, 0, strain * 1.01);
        lab_close(&l);
    }
}

static void boxes_float_by_their_density(void **state)
{
    (void)state;
    for (int method = 0; method < LL_PARTICLE_METHODS; method++) {
        lab l = lab_of("raft", method, 20);
        l.params.iterations = method == LL_PARTICLE_PBF ? 4 : 100;
        lab_open(&l);
        double sum = 0;
        int count = 0;
        for (int i = 0; i < 500; i++) {
            ok(ll_particles_step(l.fluid, l.scene->dt));
            if (i >= 200) { /* it has fallen in; it goes on heaving */
                sum += ll_particles_body(l.fluid).y;
                count++;
            }
        }
        /* The water stands at 0.7 + 0.6 * 0.5 * 0.4 / 2 = 0.76; 0.6 of 0.4 m is below. Particles of 0.05 m
         * keep half of their spacing between. */
        double sunk = 0.76 * lab_measure(&l).density_mean; /* the water, by what is compressed */
        assert_between("middle of the box", sum / count, 0.72 - sunk, 0.77);
        lab_close(&l);
    }
}

/* ---- what goes wrong is told ---- */

static void lagged_density_is_reported(void **state)
{
    (void)state;
    lab l = lab_of("dam_break", LL_PARTICLE_WCSPH, 30);
    l.params.lagged_density = true;
    lab_open(&l);
    ll_status status = ll_ok();
    int steps = 0;
    while (steps < 100 && !ll_failed(&status)) {
        status = ll_particles_step(l.fluid, l.scene->dt);
        steps++;
    }
    assert_between("steps to the end", steps, 20, 70); /* by t = 1.4 */
    assert_int_equal(status.code, LL_DIVERGED);
    assert_non_null(strstr(status.text, "step "));
    assert_non_null(strstr(status.text, "particle "));
    assert_non_null(strstr(status.text, "CFL"));
    lab_close(&l);
}

static void too_few_substeps_are_reported(void **state)
{
    (void)state;
    lab l = lab_of("dam_break", LL_PARTICLE_WCSPH, 12);
    l.params.substeps = 3;
    lab_open(&l);
    ll_status status = ll_particles_step(l.fluid, l.scene->dt);
    assert_int_equal(status.code, LL_DIVERGED);
    assert_non_null(strstr(status.text, "at most 3"));
    lab_close(&l);
}

static void values_that_are_not_finite_are_reported(void **state)
{
    (void)state;
    for (int method = 0; method < LL_PARTICLE_METHODS; method++) {
        lab l = lab_of("drop", method, 12);
        lab_open(&l);
        ll_particle_view view = ll_particles_view(l.fluid);
        ((double *)(uintptr_t)view.u)[7] = NAN;
        ll_status status = ll_particles_step(l.fluid, l.scene->dt);
        assert_int_equal(status.code, LL_DIVERGED);
        char wanted[40];
        snprintf(wanted, sizeof wanted, "step 0: particle %d", view.id[7]);
        assert_non_null(strstr(status.text, wanted));
        lab_close(&l);
    }
}

static void hostile_setups_are_refused(void **state)
{
    (void)state;
    ll_particle_setup good;
    ll_particle_params q;
    ll_particle_scene_setup(ll_particle_scene_named("raft"), 20, &good, &q);
    ok(ll_particles_check(&good));
    static const double bad[] = {NAN, INFINITY, -1, 0, 1e300};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        ll_particle_setup s[7] = {good, good, good, good, good, good, good};
        s[0].spacing = s[1].width = s[2].height = s[3].smoothing = bad[i];
        s[4].fill[0].width = bad[i];
        s[5].body.width = bad[i];
        s[6].fill[0].x = bad[i] == 0 ? -0.5 : bad[i];
        for (int k = 0; k < 7; k++) {
            ll_status status = ll_particles_check(&s[k]);
            assert_int_equal(status.code, LL_BAD_INPUT);
            assert_true(status.field[0] != '\0' && status.text[0] != '\0');
        }
    }
    ll_particle_setup large = good;
    large.spacing = 1e-3;
    ll_status status = ll_particles_check(&large);
    assert_int_equal(status.code, LL_LIMIT);
    assert_non_null(strstr(status.text, "MiB"));
}

/* ---- the block ---- */

static void blocks_are_relocatable(void **state)
{
    (void)state;
    for (int method = 0; method < LL_PARTICLE_METHODS; method++) {
        lab l = lab_of("raft", method, 12), copy;
        l.params.iterations = 4;
        lab_open(&l);
        lab_run(&l, 0.3);
        assert_true(ll_particles_valid(l.fluid));
        copy = l;
        copy.fluid = malloc(l.size);
        memset((void *)copy.fluid, 0x5a, l.size); /* what is beyond the state must not matter */
        memcpy((void *)copy.fluid, l.fluid, ll_particles_state_size(l.fluid));
        lab_run(&l, 0.3);
        lab_run(&copy, 0.3);
        assert_true(ll_particles_hash(l.fluid) == ll_particles_hash(copy.fluid));
        assert_true(ll_particles_valid(copy.fluid));
        lab_close(&l);
        lab_close(&copy);
    }
}

static void steps_do_not_allocate(void **state)
{
    (void)state;
    for (int method = 0; method < LL_PARTICLE_METHODS; method++) {
        lab l = lab_of("raft", method, 12);
        lab_open(&l);
        long before = allocations();
        lab_run(&l, 0.1);
        assert_int_equal(allocations() - before, 0);
        lab_close(&l);
    }
}

static void methods_can_be_changed_while_it_runs(void **state)
{
    (void)state;
    lab l = lab_of("dam_break", LL_PARTICLE_WCSPH, 12);
    lab_open(&l);
    for (int i = 0; i < 2 * LL_PARTICLE_METHODS; i++) {
        l.params.method = i % LL_PARTICLE_METHODS;
        ll_particles_set_params(l.fluid, &l.params);
        lab_run(&l, 0.2);
    }
    ll_particle_metrics m = lab_measure(&l);
    assert_between("mass", m.mass, 2 - 1e-9, 2 + 1e-9);
    assert_between("front", m.front, 2, 1 + 2 * sqrt(2) * 1.2);
    lab_close(&l);
}

static void tables_agree(void **state)
{
    (void)state;
    ok(ll_param_table_valid(&ll_particle_table));
    assert_string_equal(ll_particle_method_names[LL_PARTICLE_WCSPH], "wcsph");
    assert_string_equal(ll_particle_method_names[LL_PARTICLE_PBF], "pbf");
    assert_string_equal(ll_particle_method_names[LL_PARTICLE_DFSPH], "dfsph");
}

/* The same on every compiler and optimisation level: fluids of every method after 0.3 s, walls, a body, a
 * periodic tank and all. */
static void hashes_are_the_same_everywhere(void **state)
{
    (void)state;
    static const struct {
        const char *scene;
        uint64_t hash[LL_PARTICLE_METHODS];
    } rows[] = {
        {"raft", {0xe78fca5bb9666f31, 0x349d2bb74da78fc1, 0x97c8f52e29215131}},
        {"poiseuille", {0xe1c0933be655aa74, 0x151a7ee123f080ea, 0x0a1a3b8fa86e7d64}},
    };
    for (int i = 0; i < 2; i++)
        for (int method = 0; method < LL_PARTICLE_METHODS; method++) {
            lab l = lab_of(rows[i].scene, method, 16);
            l.params.iterations = 6;
            l.params.smoothing = 0.05;
            lab_open(&l);
            lab_run(&l, 0.3);
            uint64_t hash = ll_particles_hash(l.fluid);
            if (hash != rows[i].hash[method])
                fail_msg("%s by %s: 0x%016llx", rows[i].scene, ll_particle_method_names[method],
                         (unsigned long long)hash);
            lab_close(&l);
        }
}

/* Whatever the CPU has, and whether a tank is periodic or not. */
static void geometry_is_the_same_by_every_instruction_set(void **state)
{
    (void)state;
#if defined(__x86_64__)
    if (!__builtin_cpu_supports("avx2"))
        skip();
#endif
    static const char *const scenes[] = {"raft", "poiseuille"};
    for (int i = 0; i < 2; i++) {
        lab l = lab_of(scenes[i], LL_PARTICLE_PBF, 16);
        lab_open(&l);
        lab_run(&l, 0.3);
        const int64_t at[] = {l.fluid->at.ex, l.fluid->at.ey, l.fluid->at.slope, l.fluid->at.kernel};
        size_t bytes = (size_t)l.fluid->pairs * sizeof(double);
        char *base = malloc(4 * bytes), *block = (char *)l.fluid;
        assert_true(l.fluid->pairs > 1000 && base != NULL);
        ll_particle_geometry_base(l.fluid, 0, l.fluid->fluid);
        for (int k = 0; k < 4; k++) {
            memcpy(base + k * bytes, block + at[k], bytes);
            memset(block + at[k], 0, bytes);
        }
        ll_particle_geometry_avx2(l.fluid, 0, l.fluid->fluid);
        for (int k = 0; k < 4; k++)
            assert_memory_equal(base + k * bytes, block + at[k], bytes);
        free(base);
        lab_close(&l);
    }
}

/* The same particles in the same order, of ranges of every length. */
static void neighbours_are_the_same_by_every_instruction_set(void **state)
{
    (void)state;
    enum { most = 41 };
    ll_particle_near *other = ll_particle_near_base;
#if defined(__x86_64__)
    if (!__builtin_cpu_supports("avx2"))
        skip();
    other = ll_particle_near_avx2;
#endif
    lab l = lab_of("pool", LL_PARTICLE_PBF, 40);
    lab_open(&l);
    lab_run(&l, 0.1);
    const double *x = ll_particle_values(l.fluid, LL_PARTICLE_X),
                 *y = ll_particle_values(l.fluid, LL_PARTICLE_Y);
    double reach = 1.1 * l.fluid->kernel.support;
    int32_t base[most + LL_PARTICLE_NEAR_LANES], vector[most + LL_PARTICLE_NEAR_LANES], found = 0;
    assert_true(l.fluid->fluid > 60);
    for (int32_t begin = 1; begin < 20; begin++)
        for (int32_t length = 0; length <= most; length++) {
            int32_t count = ll_particle_near_base(x, y, 0, begin, begin + length, reach * reach, base);
            assert_int_equal(other(x, y, 0, begin, begin + length, reach * reach, vector), count);
            assert_memory_equal(base, vector, (size_t)count * sizeof *base);
            found += count;
        }
    assert_true(found > 100);
    lab_close(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fronts_are_as_measured),
        cmocka_unit_test(pressure_grows_with_depth),
        cmocka_unit_test(what_parts_carries_no_pressure),
        cmocka_unit_test(solvers_keep_the_density),
        cmocka_unit_test(channels_flow_as_poiseuille),
        cmocka_unit_test(momentum_is_exact_without_walls),
        cmocka_unit_test(boxes_float_by_their_density),
        cmocka_unit_test(lagged_density_is_reported),
        cmocka_unit_test(too_few_substeps_are_reported),
        cmocka_unit_test(values_that_are_not_finite_are_reported),
        cmocka_unit_test(hostile_setups_are_refused),
        cmocka_unit_test(blocks_are_relocatable),
        cmocka_unit_test(steps_do_not_allocate),
        cmocka_unit_test(methods_can_be_changed_while_it_runs),
        cmocka_unit_test(tables_agree),
        cmocka_unit_test(hashes_are_the_same_everywhere),
        cmocka_unit_test(geometry_is_the_same_by_every_instruction_set),
        cmocka_unit_test(neighbours_are_the_same_by_every_instruction_set),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
