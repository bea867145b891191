/* Surfaces of oceans against closed forms and sums. */
#include "fluid/harness.h"

#include "fluid/ocean/state.h"
#include "support/allocations.h"

#define TURN 6.283185307179586

static void ok(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

/* `settings`: `n=32 waves=1`, parted by spaces. */
static ll_status setup_by(const char *settings, ll_ocean_setup *setup)
{
    char text[200];
    snprintf(text, sizeof text, "%s", settings);
    ll_param_defaults(&ll_ocean_table, setup);
    for (char *word = strtok(text, " "); word; word = strtok(NULL, " ")) {
        char *value = strchr(word, '=');
        *value++ = '\0';
        ll_status status = ll_param_set(&ll_ocean_table, setup, word, value, false);
        if (ll_failed(&status))
            return status;
    }
    return ll_ocean_check(setup);
}

static ll_ocean *open(const char *settings)
{
    ll_ocean_setup setup;
    ok(setup_by(settings, &setup));
    size_t size = ll_ocean_size(&setup);
    void *block = malloc(size);
    memset(block, 0xa5, size);
    return ll_ocean_init(block, &setup);
}

static ll_wave wave_of(const ll_ocean *o, int64_t index)
{
    ll_wave waves[64];
    assert_true(ll_ocean_setup_of(o)->waves <= 64);
    ll_ocean_waves(ll_ocean_setup_of(o), waves);
    return waves[index];
}

static uint64_t surface_hash(const ll_ocean *o)
{
    ll_ocean_surface s = ll_ocean_surface_of(o);
    size_t bytes = (size_t)(s.n * s.n) * sizeof(double);
    return ll_hash(ll_hash(ll_hash(0, s.height, bytes), s.dx, bytes), s.dz, bytes);
}

static void frequencies_follow_dispersion(void **state)
{
    (void)state;
    static const double rows[][3] = {/* length, depth, frequency */
                                     {1, 0, 7.850990247},
                                     {10, 0, 2.482701107},
                                     {100, 0, 0.7850990247},
                                     {1000, 0, 0.2482701107},
                                     {100, 10, 0.5858823799}};
    for (int i = 0; i < 5; i++) {
        double w = ll_ocean_frequency(TURN / rows[i][0], 9.81, rows[i][1]);
        assert_between("frequency", w / rows[i][2], 1 - 1e-9, 1 + 1e-9);
    }
}

/* Phase of wave vector (mx, mz) on a surface. */
static double phase_of(const ll_ocean *o, int64_t mx, int64_t mz)
{
    ll_ocean_surface s = ll_ocean_surface_of(o);
    double c = 0, d = 0;
    for (int64_t j = 0; j < s.n; j++)
        for (int64_t i = 0; i < s.n; i++) {
            double angle = TURN * (double)(mx * i + mz * j) / (double)s.n, h = s.height[j * s.n + i];
            c += h * cos(angle);
            d += h * sin(angle);
        }
    return atan2(d, c);
}

static void crests_run_at_the_speed_of_dispersion(void **state)
{
    (void)state;
    for (int depth = 0; depth < 2; depth++) {
        ll_ocean *o =
            open(depth ? "method=gerstner n=64 waves=1 depth_m=10" : "method=gerstner n=64 waves=1");
        ll_wave w = wave_of(o, 0);
        int64_t mx = llround(w.kx * 200 / TURN), mz = llround(w.kz * 200 / TURN);
        double before = phase_of(o, mx, mz), t = 0.7;
        ll_ocean_evaluate(o, ll_ms(1e3 * t));
        double turned = remainder(phase_of(o, mx, mz) - before, TURN);
        double k = hypot(w.kx, w.kz), speed = turned / (k * t);
        double wanted = sqrt(9.81 / k * (depth ? tanh(k * 10) : 1));
        assert_between("speed", speed / wanted, 1 - 1e-9, 1 + 1e-9);
        free(o);
    }
}

static void gerstner_is_the_sum_of_its_waves(void **state)
{
    (void)state;
    ll_ocean *o = open("method=gerstner n=40 waves=7 choppiness=0.8");
    double t = 12.3;
    ll_ocean_evaluate(o, ll_ms(1e3 * t));
    ll_ocean_surface s = ll_ocean_surface_of(o);
    double steep = 0;
    for (int64_t at = 0; at < s.n * s.n; at += 37) {
        double x = 200. / 40 * (double)(at % s.n), z = 200. / 40 * (double)(at / s.n), h = 0, dx = 0, dz = 0;
        for (int i = 0; i < 7; i++) {
            ll_wave w = wave_of(o, i);
            double angle = w.kx * x + w.kz * z - w.frequency * t + w.phase;
            h += w.amplitude * cos(angle);
            dx -= 0.8 * w.kx / w.k * w.amplitude * sin(angle);
            dz -= 0.8 * w.kz / w.k * w.amplitude * sin(angle);
        }
        assert_between("height", s.height[at] - h, -1e-12, 1e-12);
        assert_between("dx", s.dx[at] - dx, -1e-12, 1e-12);
        assert_between("dz", s.dz[at] - dz, -1e-12, 1e-12);
    }
    for (int i = 0; i < 7; i++)
        steep += wave_of(o, i).k * wave_of(o, i).amplitude;
    assert_between("sum of k A", steep, 0.05, 1); /* no wave crosses itself */
    free(o);
}

/* One trochoid: the mean of its height over the water is -k A^2 / 2. */
static void trochoids_lie_low(void **state)
{
    (void)state;
    ll_ocean *o = open("method=gerstner n=64 waves=1 wind_angle_rad=0 seed=6");
    ll_wave w = wave_of(o, 0);
    ll_ocean_surface s = ll_ocean_surface_of(o);
    double sum = 0, step = 200. / 64;
    for (int64_t i = 0; i < 64; i++) { /* the integral of y dx, dx = (1 + d(dx)/dx0) dx0, along z = 0 */
        double angle = w.kx * step * (double)i + w.phase;
        sum += s.height[i] * (1 - w.kx * w.kx / w.k * w.amplitude * cos(angle)) / 64;
    }
    assert_between("mean level", sum / (-w.kx * w.kx / w.k * w.amplitude * w.amplitude / 2), 1 - 1e-9,
                   1 + 1e-9);
    free(o);
}

static void transforms_equal_the_direct_sum(void **state)
{
    (void)state;
    static const char *const settings[] = {"n=32", "n=30 depth_m=20 loop_s=20 seed=9"};
    for (int row = 0; row < 2; row++) {
        ll_ocean *o = open(settings[row]);
        ll_time t = ll_ms(3210);
        ll_ocean_evaluate(o, t);
        ll_ocean_surface s = ll_ocean_surface_of(o);
        double rms = 0;
        for (int64_t at = 0; at < s.n * s.n; at++)
            rms += s.height[at] * s.height[at] / (double)(s.n * s.n);
        double most = 1e-12 * sqrt(rms);
        assert_true(rms > 1e-3);
        for (int64_t at = 0; at < s.n * s.n; at += 13) {
            double h, dx, dz;
            ll_ocean_direct(o, t, at % s.n, at / s.n, &h, &dx, &dz);
            assert_between("height", s.height[at] - h, -most, most);
            assert_between("dx", s.dx[at] - dx, -most, most);
            assert_between("dz", s.dz[at] - dz, -most, most);
        }
        free(o);
    }
}

/* Pierson and Moskowitz: significant height 4 sqrt(m0) = 0.2092 U^2 / g for a sea that the grid resolves. */
static void seas_are_as_high_as_their_wind_makes_them(void **state)
{
    (void)state;
    double mean = 0;
    for (int seed = 1; seed <= 4; seed++) {
        char settings[80];
        snprintf(settings, sizeof settings, "n=128 length_m=800 wind_speed_mps=10 seed=%d", seed);
        ll_ocean *o = open(settings);
        ll_ocean_surface s = ll_ocean_surface_of(o);
        for (int64_t at = 0; at < s.n * s.n; at++)
            mean += s.height[at] * s.height[at] / (double)(s.n * s.n) / 4;
        free(o);
    }
    assert_between("significant height", 4 * sqrt(mean) / (0.2092 * 100 / 9.81), 0.9, 1.1);
}

static void loops_close_exactly(void **state)
{
    (void)state;
    static const char *const settings[] = {"method=gerstner n=32 loop_s=10", "method=spectrum n=32 loop_s=10",
                                           "n=64 tile=32 frames=16 loop_s=10 method=tiled"};
    for (int i = 0; i < 3; i++) {
        ll_ocean *o = open(settings[i]);
        ll_ocean_evaluate(o, ll_ms(3700));
        uint64_t first = surface_hash(o);
        ll_ocean_evaluate(o, ll_ms(8700));
        assert_true(surface_hash(o) != first);
        ll_ocean_evaluate(o, ll_ms(3700) + 1000000 * ll_ms(10000));
        assert_true(surface_hash(o) == first);
        free(o);
    }
}

static void tiles_repeat_the_spectrum(void **state)
{
    (void)state;
    ll_ocean *o = open("n=64 tile=32 frames=16 loop_s=16 length_m=100 method=tiled");
    ll_ocean *source = open("method=spectrum n=32 loop_s=16 length_m=50");
    ll_ocean_evaluate(o, ll_ms(5400)); /* picture 5 */
    ll_ocean_evaluate(source, ll_ms(5000));
    ll_ocean_surface a = ll_ocean_surface_of(o), b = ll_ocean_surface_of(source);
    for (int64_t j = 0; j < 64; j++)
        for (int64_t i = 0; i < 64; i++)
            assert_true(a.height[j * 64 + i] == b.height[j % 32 * 32 + i % 32]);
    free(o);
    free(source);
}

static void buoys_float_by_their_density(void **state)
{
    (void)state;
    ll_ocean *calm = open("method=gerstner n=16 wind_speed_mps=0");
    ll_buoy b = {.x = 50, .z = 50, .width = 2, .length = 3, .height = 1, .density = 0.4, .drag = 2, .y = 1};
    b.pitch = 0.1;
    for (int i = 0; i < 6000; i++)
        ll_buoy_step(&b, calm, 0.005);
    assert_between("middle above the water", b.y, 0.1 - 1e-9, 0.1 + 1e-9); /* 0.4 m of 1 m is below */
    assert_between("pitch", b.pitch, -1e-9, 1e-9);
    free(calm);
}

/* A wave of some 60 m carries a small box up and down as it does the water. */
static void buoys_follow_long_waves(void **state)
{
    (void)state;
    ll_ocean *o = open("method=gerstner n=64 waves=1 wind_speed_mps=8");
    ll_buoy b = {.x = 70, .z = 90, .width = 0.5, .length = 0.5, .height = 0.4, .density = 0.5, .drag = 2};
    double error = 0, height = 0;
    for (int i = 0; i < 6000; i++) {
        if (i % 4 == 0)
            ll_ocean_evaluate(o, ll_ms(5. * i));
        ll_buoy_step(&b, o, 0.005);
        if (i < 3000)
            continue;
        double water = ll_ocean_height_at(o, b.x, b.z);
        error += (b.y - water) * (b.y - water);
        height += water * water;
    }
    assert_between("distance to the water", sqrt(error / height), 0, 0.2);
    free(o);
}

static void hostile_setups_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {"n=7",
                                      "n=22",
                                      "n=34",
                                      "n=9999999",
                                      "length_m=nan",
                                      "length_m=0",
                                      "depth_m=-1",
                                      "waves=0",
                                      "wind_speed_mps=1e9",
                                      "method=tiled",
                                      "method=waves",
                                      "loop_s=4 tile=12 n=32 method=tiled",
                                      "gravity=false",
                                      "loop_s=-1",
                                      "loop_s=1e-9",
                                      "loop_s=1e-300 tile=8 n=32 method=tiled",
                                      "loop_s=4 tile=6 n=32 method=tiled",
                                      "tile=1e30",
                                      "choppiness=inf",
                                      "loop_s=4 n=512 tile=256 frames=99 method=tiled"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        ll_ocean_setup setup;
        ll_status status = setup_by(bad[i], &setup);
        if (!ll_failed(&status))
            fail_msg("%s is taken", bad[i]);
        assert_true(status.field[0] != '\0' && status.text[0] != '\0');
    }
}

static void evaluating_does_not_allocate(void **state)
{
    (void)state;
    static const char *const settings[] = {"method=gerstner n=32", "method=spectrum n=32",
                                           "n=64 tile=32 loop_s=10 method=tiled"};
    for (int i = 0; i < 3; i++) {
        ll_ocean *o = open(settings[i]);
        long before = allocations();
        ll_ocean_evaluate(o, ll_ms(100));
        assert_int_equal(allocations() - before, 0);
        size_t size = ll_ocean_size(ll_ocean_setup_of(o));
        ll_ocean *copy = malloc(size); /* and a copy elsewhere does the same */
        memcpy((void *)copy, o, size);
        ll_ocean_evaluate(o, ll_ms(200));
        ll_ocean_evaluate(copy, ll_ms(200));
        assert_true(surface_hash(o) == surface_hash(copy));
        free(o);
        free(copy);
    }
}

/* The shares of energy are those of the spectrum, summed up; what does not fit has no amplitude. */
static void what_does_not_fit_is_told(void **state)
{
    (void)state;
    static const char *const settings[] = {"n=64 length_m=120 wind_speed_mps=14",
                                           "n=96 length_m=500 wind_speed_mps=6 method=gerstner waves=40",
                                           "n=64 tile=16 loop_s=12 wind_speed_mps=9 method=tiled"};
    for (int row = 0; row < 3; row++) {
        ll_ocean *o = open(settings[row]);
        const ll_ocean_setup *s = ll_ocean_setup_of(o);
        ll_ocean_fit fit = ll_ocean_fit_of(s);
        double length = row == 2 ? s->length * 16 / 64 : s->length, cell = s->length / (double)s->n;
        double slow = sqrt(TURN * s->gravity / length), fast = sqrt(TURN * s->gravity / (2 * cell));
        double all = 0, longer = 0, shorter = 0, step = 1e-4;
        for (double f = 0.05; f < 60; f += step) {
            double e = ll_ocean_energy(s, f + step / 2) * step;
            all += e;
            longer += f < slow ? e : 0;
            shorter += f > fast ? e : 0;
        }
        assert_between("longer", fit.longer, longer / all - 1e-3, longer / all + 1e-3);
        assert_between("shorter", fit.shorter, shorter / all - 1e-3, shorter / all + 1e-3);
        assert_between("height", fit.height, 4 * sqrt(all) * 0.999, 4 * sqrt(all) * 1.001);
        if (row == 1) { /* no more energy than the box has room for, within what 40 bands make of it */
            double carried = 0;
            for (int64_t i = 0; i < s->waves; i++)
                carried += pow(wave_of(o, i).amplitude, 2) / 2;
            assert_between("carried", carried / all, 0.5, 1 - fit.shorter + 0.02);
        }
        free(o);
    }
}

/* The same on every compiler and optimisation level. */
static void hashes_are_the_same_everywhere(void **state)
{
    (void)state;
    static const struct {
        const char *settings;
        uint64_t hash;
    } rows[] = {{"method=gerstner n=64 depth_m=30", 0x3e6a55575f9dafd5},
                {"method=spectrum n=60 loop_s=12", 0x755e59c328b2e54c},
                {"n=64 tile=32 loop_s=12 method=tiled", 0x37c5d124c435b964}};
    for (int i = 0; i < 3; i++) {
        ll_ocean *o = open(rows[i].settings);
        ll_ocean_evaluate(o, ll_ms(4321));
        if (surface_hash(o) != rows[i].hash)
            fail_msg("%s: 0x%016llx", rows[i].settings, (unsigned long long)surface_hash(o));
        free(o);
    }
}

static void tables_agree(void **state)
{
    (void)state;
    ok(ll_param_table_valid(&ll_ocean_table));
}

/* A point by itself is the grid's, and moves at the speed that it tells. */
static void points_without_a_grid_are_the_grids(void **state)
{
    (void)state;
    ll_ocean_setup s;
    ll_param_defaults(&ll_ocean_table, &s);
    s.method = LL_OCEAN_GERSTNER;
    s.n = 16;
    s.waves = 5;
    ll_wave waves[5];
    ll_ocean_waves(&s, waves);
    void *block = aligned_alloc(64, (ll_ocean_size(&s) + 63) & ~(size_t)63);
    ll_ocean *o = ll_ocean_init(block, &s);
    ll_time t = 12345 * LL_MS, h = LL_MS;
    ll_ocean_evaluate(o, t);
    ll_ocean_surface f = ll_ocean_surface_of(o);
    for (int64_t j = 0; j < s.n; j++)
        for (int64_t i = 0; i < s.n; i++) {
            double x = s.length * (double)i / (double)s.n, z = s.length * (double)j / (double)s.n;
            ll_ocean_point p = ll_ocean_point_of(&s, waves, x, z, t),
                           next = ll_ocean_point_of(&s, waves, x, z, t + h),
                           last = ll_ocean_point_of(&s, waves, x, z, t - h);
            int64_t at = j * s.n + i;
            assert_near(p.height, f.height[at], 1e-11);
            assert_near(p.dx, f.dx[at], 1e-11);
            assert_near(p.dz, f.dz[at], 1e-11);
            assert_near((next.height - last.height) / 0.002, p.v, 1e-5);
            assert_near((next.dx - last.dx) / 0.002, p.u, 1e-5);
            assert_near((next.dz - last.dz) / 0.002, p.w, 1e-5);
        }
    free(block);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frequencies_follow_dispersion),
        cmocka_unit_test(crests_run_at_the_speed_of_dispersion),
        cmocka_unit_test(gerstner_is_the_sum_of_its_waves),
        cmocka_unit_test(what_does_not_fit_is_told),
        cmocka_unit_test(points_without_a_grid_are_the_grids),
        cmocka_unit_test(trochoids_lie_low),
        cmocka_unit_test(transforms_equal_the_direct_sum),
        cmocka_unit_test(seas_are_as_high_as_their_wind_makes_them),
        cmocka_unit_test(loops_close_exactly),
        cmocka_unit_test(tiles_repeat_the_spectrum),
        cmocka_unit_test(buoys_float_by_their_density),
        cmocka_unit_test(buoys_follow_long_waves),
        cmocka_unit_test(hostile_setups_are_refused),
        cmocka_unit_test(evaluating_does_not_allocate),
        cmocka_unit_test(hashes_are_the_same_everywhere),
        cmocka_unit_test(tables_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
