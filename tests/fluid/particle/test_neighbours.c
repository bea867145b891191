/* The search for neighbours where rounding decides: distances exactly at the radius, one ulp below and one
 * above it; particles on the borders of cells; ranges and counts that are no multiple of the vector's lanes.
 * The references are loops over all pairs. */
#include "fluid/harness.h"

#include "fluid/particle/state.h"

static uint32_t random_below(uint64_t *state, uint32_t count)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)((*state >> 32) * count >> 32);
}

/* One ulp down, the value, or one ulp up, for -1, 0 and 1. */
static double by_ulp(double value, int ulp)
{
    return ulp == 0 ? value : nextafter(value, ulp < 0 ? -INFINITY : INFINITY);
}

/* The plain search, and the CPU's. */
static int searches(ll_particle_near *out[2])
{
    out[0] = ll_particle_near_base;
#if defined(__x86_64__)
    out[1] = ll_particle_near_avx2;
    return __builtin_cpu_supports("avx2") ? 2 : 1;
#else
    return 1;
#endif
}

/* ---- one range ---- */

enum { most = 43, room = most + LL_PARTICLE_NEAR_LANES, guard = -77 };

static const double radius = 5; /* the points have whole coordinates, up to an ulp */

/* One of the twelve whole points at the radius; its larger coordinate an ulp smaller for -1, larger for 1. */
static void point(uint64_t *seed, int side, double *x, double *y)
{
    static const double at[2][2] = {{5, 0}, {4, 3}}; /* an ulp of the 3 would be lost in the sum of squares */
    const double *p = at[random_below(seed, 2)];
    double along = by_ulp(p[0], side);
    int turn = (int)random_below(seed, 4);
    *x = turn & 1 ? p[1] : along;
    *y = turn & 1 ? along : p[1];
    *x *= turn & 2 ? -1 : 1;
    *y *= random_below(seed, 2) ? -1 : 1;
}

static void compare_range(ll_particle_near *near, const double *x, const double *y, const int *side,
                          int32_t begin, int32_t length)
{
    int32_t found[room + 1], wanted[most], count = 0;
    for (int32_t b = begin; b < begin + length; b++)
        if (side[b] < 0)
            wanted[count++] = b;
    for (int i = 0; i <= room; i++)
        found[i] = guard;
    assert_int_equal(near(x, y, 0, begin, begin + length, radius * radius, found), count);
    assert_memory_equal(found, wanted, (size_t)count * sizeof *wanted);
    for (int i = length + LL_PARTICLE_NEAR_LANES; i <= room; i++)
        assert_int_equal(found[i], guard); /* writes no farther than it says */
}

/* Of the points at the radius and one ulp farther, none is a neighbour; all one ulp nearer are. */
static void a_neighbour_is_nearer_than_the_radius(void **state)
{
    (void)state;
    enum { points = 8 + most + LL_PARTICLE_NEAR_LANES };
    double x[points] = {0}, y[points] = {0};
    int side[points] = {0};
    ll_particle_near *near[2];
    int sets = searches(near);
    for (uint64_t round = 1; round <= 50; round++) {
        uint64_t seed = round;
        for (int i = 1; i < points; i++) { /* half of them are neighbours: every pattern of lanes */
            side[i] = random_below(&seed, 2) ? -1 : (int)random_below(&seed, 2);
            point(&seed, side[i], &x[i], &y[i]);
        }
        for (int32_t begin = 1; begin <= 8; begin++)
            for (int32_t length = 0; length <= most - 8; length++)
                for (int k = 0; k < sets; k++)
                    compare_range(near[k], x, y, side, begin, length);
    }
}

/* ---- all pairs of a tank ---- */

typedef struct tally { /* pairs at the radius, and a few ulps below and above it */
    int64_t below, at, above;
} tally;

static ll_particles *tank_of(int32_t columns, bool periodic)
{
    ll_particle_setup setup = {.width = 22,
                               .height = 16,
                               .spacing = 1,
                               .smoothing = 1.25, /* a support of 2.5 */
                               .walls = LL_WALL_BOTTOM | LL_WALL_TOP,
                               .periodic = periodic,
                               .fill_count = 1,
                               .fill = {{.width = columns, .height = 13}}};
    if (!periodic)
        setup.walls |= LL_WALL_LEFT | LL_WALL_RIGHT;
    ll_particle_params params;
    ll_param_defaults(&ll_particle_table, &params);
    ll_status status = ll_particles_check(&setup);
    if (ll_failed(&status))
        fail_msg("%s", status.text);
    ll_particles *p = ll_particles_init(malloc(ll_particles_size(&setup)), &setup, &params);
    assert_int_equal(p->fluid, 13 * columns);
    return p;
}

/* Half of the coordinates are multiples of 0.5, so that many distances are 2.5; the others on a border of
 * cells; all up to an ulp. Some are beyond the grid. */
static double coordinate(uint64_t *seed, double origin, double per_m, double size)
{
    int ulp = (int)random_below(seed, 3) - 1;
    double value = random_below(seed, 2)
                       ? 0.5 * random_below(seed, (uint32_t)(2 * size + 24)) - 6
                       : origin + (random_below(seed, (uint32_t)((size - 2 * origin) * per_m) + 2)) / per_m;
    return by_ulp(value, ulp);
}

static void scatter(ll_particles *p, uint64_t *seed)
{
    double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    for (int32_t a = 0; a < p->fluid; a++) {
        x[a] = coordinate(seed, p->cells.origin_x, p->cells.per_m_x, p->setup.width);
        y[a] = coordinate(seed, p->cells.origin_y, p->cells.per_m_y, p->setup.height);
        if (p->setup.periodic && !(x[a] >= 0 && x[a] < p->wrap))
            x[a] = 0;
    }
    ll_particle_sort_fluid(p);
}

static bool close_pair(const ll_particles *p, int32_t a, int32_t b, double reach2, tally *t)
{
    const double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    double ex = x[a] - x[b], ey = y[a] - y[b];
    if (p->setup.periodic)
        ex = ex > p->wrap / 2 ? ex - p->wrap : ex < -p->wrap / 2 ? ex + p->wrap : ex;
    double square = ex * ex + ey * ey;
    t->at += square == reach2;
    t->below += square < reach2 && square > reach2 * (1 - 1e-15);
    t->above += square > reach2 && square < reach2 * (1 + 1e-15);
    return square < reach2;
}

static int by_index(const void *a, const void *b)
{
    return *(const int32_t *)a - *(const int32_t *)b;
}

/* The list of pairs against the loop over all, and that against the plain and the vector search. */
static void compare_pairs(ll_particles *p, double reach, tally *t)
{
    const double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    size_t ints = (size_t)ll_particle_total(p) + LL_PARTICLE_NEAR_LANES;
    int32_t *wanted = malloc(ints * sizeof *wanted), *found = malloc(ints * sizeof *found);
    ll_particle_near *near[2];
    int sets = p->setup.periodic ? 0 : searches(near);
    ll_particle_fault fault = ll_particle_pairs(p, reach, NULL);
    assert_null(fault.reason);
    for (int32_t a = 0; a < p->fluid; a++)
        for (int walls = 0; walls < 2; walls++) {
            int32_t begin = walls ? p->fluid : a + 1, end = walls ? ll_particle_total(p) : p->fluid;
            const int32_t *row = ll_part_row(p) + 2 * a + walls;
            int32_t count = 0, listed = row[1] - row[0];
            for (int32_t b = begin; b < end; b++)
                if (close_pair(p, a, b, reach * reach, t))
                    wanted[count++] = b;
            memcpy(found, ll_part_pair(p) + row[0], (size_t)listed * sizeof *found);
            if (p->setup.periodic) /* the cells around the tank's end come first */
                qsort(found, (size_t)listed, sizeof *found, by_index);
            assert_int_equal(listed, count);
            assert_memory_equal(found, wanted, (size_t)count * sizeof *wanted);
            for (int k = 0; k < sets; k++) {
                assert_int_equal(near[k](x, y, a, begin, end, reach * reach, found), count);
                assert_memory_equal(found, wanted, (size_t)count * sizeof *wanted);
            }
        }
    free(wanted);
    free(found);
}

static void compare_tanks(bool periodic)
{
    tally t = {0};
    uint64_t seed = 11;
    for (int32_t columns = 1; columns <= 16; columns++) { /* 13 to 208 particles */
        ll_particles *p = tank_of(columns, periodic);
        for (int i = 0; i < 20; i++) {
            scatter(p, &seed);
            compare_pairs(p, p->kernel.support, &t);
        }
        free(p);
    }
    assert_in_range(t.below, 100, INT32_MAX);
    assert_in_range(t.at, 100, INT32_MAX);
    assert_in_range(t.above, 100, INT32_MAX);
}

static void the_list_has_the_pairs_of_a_loop_over_all(void **state)
{
    (void)state;
    compare_tanks(false);
}

static void the_list_of_a_periodic_tank_too(void **state)
{
    (void)state;
    compare_tanks(true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_neighbour_is_nearer_than_the_radius),
        cmocka_unit_test(the_list_has_the_pairs_of_a_loop_over_all),
        cmocka_unit_test(the_list_of_a_periodic_tank_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
