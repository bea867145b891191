/* Impacts through packed rows, and through the contacts themselves where the memory has no room for all rows:
 * the bits are the same, also when the room ends in the middle of a sweep. */
#include "rigid/harness.h"

#include "rigid/solver/solver.h"

enum { side = 12, balls = side * (side + 1) / 2, substeps = 3, row_bytes = 128 };

/* An empty world without gravity and sleep. */
static ll_rigid *floating(int32_t bodies, size_t *size)
{
    ll_rigid_limits limits = small_limits(bodies);
    ll_rigid_params p = standard_params();
    p.gravity_y = 0;
    p.sleep = false;
    *size = ll_rigid_size(&limits);
    return world_of(&limits, &p);
}

/* Balls of three kinds in a triangle, each of which touches its neighbours, and two fast ones at its corners.
 * Of the contacts only those of the fast ones approach at first: the others are listed when an impact reaches
 * them. */
static ll_rigid *triangle(size_t *size)
{
    ll_rigid *w = floating(balls + 2, size);
    ll_material m = ll_material_defaults();
    ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
    for (int row = 0; row < side; row++)
        for (int k = 0; k <= row; k++) {
            m.restitution = 0.6 + 0.1 * ((row + 2 * k) % 4);
            m.density = 1 + (row + k) % 3;
            def.position = ll_vec(k - 0.5 * row, 0.8660254 * row);
            add_ball(w, def, 0.5, m);
        }
    def.position = ll_vec(0.1, -1);
    def.velocity = ll_vec(1, 40);
    add_ball(w, def, 0.5, m);
    def.position = ll_vec(0.5 * side + 0.4, 0.8660254 * side - 0.9);
    def.velocity = ll_vec(-25, 2);
    add_ball(w, def, 0.5, m);
    ok(ll_rigid_step(w, 1e-5, NULL)); /* finds the contacts, and moves nothing far */
    return w;
}

/* Balls in a square, each of which moves towards its neighbours: more impacts than a crowd has at least. */
static ll_rigid *stirred(size_t *size)
{
    enum { across = 36 };
    ll_rigid *w = floating(across * across, size);
    ll_material m = ll_material_defaults();
    ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
    for (int i = 0; i < across * across; i++) {
        int x = i % across, y = i / across;
        m.restitution = 0.2 + 0.1 * ((x + 2 * y) % 4);
        m.density = 1 + i % 3;
        def.position = ll_vec(1.01 * x, 1.01 * y);
        def.velocity = ll_vec(x % 2 == 0 ? 4 : -4, y % 2 == 0 ? 3 : -3);
        add_ball(w, def, 0.5, m);
    }
    ok(ll_rigid_step(w, 1e-5, NULL));
    return w;
}

typedef struct outcome {
    ll_rigid *world;
    int32_t first, last; /* contacts in the list at the beginning, and at the end */
    int32_t ended;       /* substep in which the room ended; -1: at the beginning, `substeps`: never */
} outcome;

/* The impacts of some substeps in a copy of the world. */
static outcome resolve(const ll_rigid *from, size_t size, bool crowded, void *memory, size_t bytes)
{
    outcome out = {.world = malloc(size), .ended = substeps};
    memcpy(out.world, from, size);
    ll_rigid *w = out.world;
    const double h = 1.0 / 240;
    ll_index_list bodies = {.at = ll_awake_bodies(w), .count = w->awake};
    ll_index_list contacts = {.at = ll_awake_contacts(w), .count = w->awake_contacts};
    w->dt = substeps * h;
    ll_prepare_body_steps(w, bodies, h);
    ll_bounces b = ll_begin_bounces(w, NULL, contacts, memory, bytes);
    b.crowded |= crowded;
    out.first = b.count;
    if (b.rows == NULL)
        out.ended = -1;
    for (int i = 0; i < substeps; i++) {
        ll_bounce(w, &b, h, 2 * h);
        if (b.rows == NULL && out.ended == substeps)
            out.ended = i;
        ll_integrate_positions(w, bodies, h);
    }
    out.last = b.count;
    ll_end_bounces(w, &b);
    return out;
}

/* The room is allocated as large as it is said to be: a sanitizer sees what is written behind it. */
static outcome resolve_in(const ll_rigid *from, size_t size, bool crowded, size_t bytes)
{
    void *memory = malloc(bytes > 0 ? bytes : 1);
    outcome out = resolve(from, size, crowded, memory, bytes);
    free(memory);
    return out;
}

static void same(const outcome *a, const outcome *expected, size_t bytes)
{
    assert_int_equal(a->first, expected->first);
    if (a->last != expected->last ||
        memcmp(a->world, expected->world, ll_rigid_state_size(expected->world)) != 0)
        fail_msg("%zu bytes for rows, which end in substep %d: %d contacts, and %d without rows; or others",
                 bytes, (int)a->ended, (int)a->last, (int)expected->last);
}

static void any_room_for_rows_gives_the_same_bits(void **state)
{
    (void)state;
    size_t size;
    ll_rigid *w = triangle(&size);
    outcome without = resolve(w, size, false, NULL, 0), out = {.ended = -1};
    int32_t in_step[substeps + 2] = {0}; /* by `ended` plus one */
    assert_in_range(without.first, 1, 8);
    assert_in_range(without.last, 128, 4 * balls);
    for (size_t bytes = 0; out.ended < substeps; bytes += 16) {
        assert_in_range(bytes, 0, (size_t)(without.last + 2) * row_bytes);
        out = resolve_in(w, size, false, bytes);
        same(&out, &without, bytes);
        in_step[out.ended + 1]++;
        free(out.world);
    }
    assert_in_range(in_step[0], 1, INT32_MAX);
    assert_in_range(in_step[1], 128, INT32_MAX); /* the contacts follow in the first substep */
    free(without.world);
    free(w);
}

/* Where many bounce the list does not grow, and each is tried once. `crowded`: or said to be so. */
static void crowd_of(ll_rigid *w, size_t size, bool crowded, int32_t least)
{
    outcome without = resolve(w, size, crowded, NULL, 0);
    assert_in_range(without.first, least, INT32_MAX);
    assert_int_equal(without.first, without.last);
    outcome with = resolve_in(w, size, crowded, (size_t)(without.last + 1) * row_bytes);
    assert_int_equal(with.ended, substeps);
    same(&with, &without, 0);
    free(with.world);
    free(without.world);
    free(w);
}

static void a_crowd_has_the_same_bits_with_and_without_rows(void **state)
{
    (void)state;
    size_t size;
    ll_rigid *w = triangle(&size);
    crowd_of(w, size, true, 1);
    w = stirred(&size);
    crowd_of(w, size, false, 1025);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_room_for_rows_gives_the_same_bits),
        cmocka_unit_test(a_crowd_has_the_same_bits_with_and_without_rows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
