/* Exact solutions, for every solver: slopes, bounces, cradles, and columns without a preferred side. Each
 * error has a limit; a solver that cannot solve the case has none, and is marked so in the table of
 * docs/accuracy.md, which is made from closed_forms.csv. `test_rigid closed_forms --update` writes that file.
 */
#include "rigid/harness.h"

#define TABLE "tests/rigid/closed_forms.csv"
#define CANNOT NAN

static const double rounding = 1e-6; /* shown as 0 in the table; the units are cm, % and m/s */

static const double pi = 3.14159265358979323846;

typedef struct trial {
    const char *what, *unit;
    double (*error)(const struct trial *t, const ll_rigid_params *p); /* NAN: the solver diverged */
    double number, gap;
    double limit[LL_SOLVERS];
} trial;

static void steps(ll_rigid *w, double seconds)
{
    for (int i = 0; i < (int)(60 * seconds + 0.5); i++)
        ok(ll_rigid_step(w, 1.0 / 60, NULL));
}

/* ---- slopes: `number` degrees ---- */

static ll_rigid *slope(const ll_rigid_params *p, double angle, double friction, bool disc,
                       ll_body_id *body_id)
{
    ll_rigid_limits limits = small_limits(2);
    ll_rigid *w = world_of(&limits, p);
    ll_material m = ll_material_defaults();
    m.friction = friction;
    ll_body_def def = ll_body_defaults(LL_BODY_STATIC);
    def.angle = angle;
    add_box(w, def, 200, 2, m);
    def = ll_body_defaults(LL_BODY_DYNAMIC);
    def.angle = angle;
    def.position = ll_vec(-1.5 * sin(angle), 1.5 * cos(angle));
    *body_id = disc ? add_ball(w, def, 0.5, m) : add_box(w, def, 1, 1, m);
    return w;
}

/* Rolls without slipping, since tan(angle) < 3 mu: the distance is a third of g sin(angle) t^2. Returns the
 * larger of the relative errors of distance and rotation. */
static double disc_rolls(const trial *t, const ll_rigid_params *p)
{
    double angle = t->number * pi / 180, way = 10 * sin(angle) * 4 / 3;
    ll_body_id id;
    ll_rigid *w = slope(p, angle, 0.5, true, &id);
    ll_body_state first = body(w, id);
    steps(w, 2);
    ll_body_state s = body(w, id);
    free(w);
    double moved = ll_length(ll_sub(s.position, first.position)), turned = fabs(s.angle - first.angle);
    return 100 * larger(fabs(moved / way - 1), fabs(turned / (2 * way) - 1));
}

/* Slides with g (sin - mu cos), or rests. */
static double box_slides(const trial *t, const ll_rigid_params *p)
{
    double angle = t->number * pi / 180, mu = 0.3;
    double way = 20 * larger(0, sin(angle) - mu * cos(angle));
    ll_body_id id;
    ll_rigid *w = slope(p, angle, mu, false, &id);
    ll_body_state first = body(w, id);
    steps(w, 2);
    double moved = ll_length(ll_sub(body(w, id).position, first.position));
    free(w);
    return 100 * fabs(moved - way);
}

/* ---- bounces: restitution `number`, dropped from 5 m ---- */

static const double drop = 5;

static ll_rigid *ball_over_ground(const ll_rigid_params *p, double restitution, ll_body_id *ball)
{
    ll_rigid_limits limits = small_limits(2);
    ll_rigid *w = world_of(&limits, p);
    ll_material m = ll_material_defaults();
    ll_body_def def = ll_body_defaults(LL_BODY_STATIC);
    def.position = ll_vec(0, -1);
    add_box(w, def, 20, 2, m);
    m.restitution = restitution;
    def = ll_body_defaults(LL_BODY_DYNAMIC);
    def.position = ll_vec(0, drop + 0.3);
    *ball = add_ball(w, def, 0.3, m);
    return w;
}

/* The next apex is at e^2 of the height. */
static double first_apex(const trial *t, const ll_rigid_params *p)
{
    ll_body_id ball;
    ll_rigid *w = ball_over_ground(p, t->number, &ball);
    double apex = 0;
    steps(w, 0.5);
    while (body(w, ball).velocity.y < -0.5)
        ok(ll_rigid_step(w, 1.0 / 60, NULL));
    for (int i = 0; i < 110; i++) {
        ok(ll_rigid_step(w, 1.0 / 60, NULL));
        apex = larger(apex, body(w, ball).position.y - 0.3);
    }
    free(w);
    return 100 * fabs(apex - t->number * t->number * drop);
}

/* For e = 1 over 30 s: height above 5 m. */
static double gained_height(const trial *t, const ll_rigid_params *p)
{
    (void)t;
    ll_body_id ball;
    ll_rigid *w = ball_over_ground(p, 1, &ball);
    double most = 0;
    for (int i = 0; i < 1800; i++) {
        ok(ll_rigid_step(w, 1.0 / 60, NULL));
        most = larger(most, body(w, ball).position.y - 0.3 - drop);
    }
    free(w);
    return 100 * most;
}

/* Height of the last apex below 5 m. */
static double lost_height(const trial *t, const ll_rigid_params *p)
{
    (void)t;
    ll_body_id ball;
    ll_rigid *w = ball_over_ground(p, 1, &ball);
    double apex = 0;
    steps(w, 28);
    for (int i = 0; i < 120; i++) {
        ok(ll_rigid_step(w, 1.0 / 60, NULL));
        apex = larger(apex, body(w, ball).position.y - 0.3);
    }
    free(w);
    return 100 * larger(0, drop - apex);
}

/* ---- Newton's cradle: `number` balls; the last one takes the speed of the first ---- */

static double cradle(const trial *t, const ll_rigid_params *p)
{
    int n = (int)t->number;
    ll_rigid_limits limits = small_limits(n);
    ll_rigid_params weightless = *p;
    weightless.gravity_y = 0;
    ll_rigid *w = world_of(&limits, &weightless);
    ll_material m = ll_material_defaults();
    ll_body_id balls[8];
    m.restitution = 1;
    m.friction = 0;
    for (int i = 0; i < n; i++) {
        ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
        def.position = ll_vec((1 + t->gap) * i - (i == 0), 0);
        def.velocity = ll_vec(i == 0 ? 3 : 0, 0);
        balls[i] = add_ball(w, def, 0.5, m);
    }
    steps(w, 2);
    double worst = 0;
    for (int i = 0; i < n; i++)
        worst = larger(worst, fabs(body(w, balls[i]).velocity.x - (i == n - 1 ? 3 : 0)));
    free(w);
    return worst;
}

/* ---- columns: `number` boxes at x = 0, each dropped by `gap` ---- */

static double column_leans(const trial *t, const ll_rigid_params *p)
{
    int n = (int)t->number;
    ll_rigid_limits limits = small_limits(n + 1);
    ll_rigid *w = world_of(&limits, p);
    ll_body_id boxes[40];
    ll_body_def def = ll_body_defaults(LL_BODY_STATIC);
    def.position = ll_vec(0, -1);
    add_box(w, def, 20, 2, ll_material_defaults());
    for (int i = 0; i < n; i++) {
        def = ll_body_defaults(LL_BODY_DYNAMIC);
        def.position = ll_vec(0, 0.5 + t->gap + (1 + t->gap) * i);
        boxes[i] = add_box(w, def, 1, 1, ll_material_defaults());
    }
    double worst = 0;
    for (int k = 0; k < 720; k++) {
        ll_status status = ll_rigid_step(w, 1.0 / 60, NULL);
        for (int i = 0; i < n && !ll_failed(&status); i++)
            worst = larger(worst, fabs(body(w, boxes[i]).position.x));
    }
    free(w);
    return 100 * worst;
}

/* ---- the table ---- */

/* In the order of the solvers: impulse, pgs, pgs_ngs, soft_step, tgs_sticky, xpbd, avbd. */
static const trial trials[] = {
    {"Disc rolls down 10°, μ 0.5, 2 s", "%", disc_rolls, 10, 0, {1, 1, 1, 0.2, 1, 0.1, 1}},
    {"Disc rolls down 20°", "%", disc_rolls, 20, 0, {1, 1, 1, 0.2, 1, 0.1, 1}},
    {"Disc rolls down 30°", "%", disc_rolls, 30, 0, {1, 1, 1, 0.2, 1, 0.1, 1}},
    {"Disc rolls down 40°", "%", disc_rolls, 40, 0, {1, 1, 1, 0.2, 1, 0.1, 1}},
    {"Box on 10°, μ 0.3, 2 s", "cm", box_slides, 10, 0, {CANNOT, 0.01, 0.01, 0.01, 0.01, 1, 0.01}},
    {"Box on 20°", "cm", box_slides, 20, 0, {CANNOT, 2, 2, 0.5, 0.5, 1, 2}},
    {"Box on 30°", "cm", box_slides, 30, 0, {CANNOT, 5, 5, 0.5, 0.5, 1, 8}},
    {"Box on 40°", "cm", box_slides, 40, 0, {CANNOT, 8, 8, 0.5, 0.5, 1, 8}},
    {"First apex from 5 m, e = 0", "cm", first_apex, 0, 0, {1, 0.1, 0.1, 0.1, 0.1, 0.1, 3}},
    {"First apex from 5 m, e = 0.25", "cm", first_apex, 0.25, 0, {2, 0.1, 3, 0.1, 0.1, 0.1, 0.1}},
    {"First apex from 5 m, e = 0.5", "cm", first_apex, 0.5, 0, {2, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1}},
    {"First apex from 5 m, e = 0.75", "cm", first_apex, 0.75, 0, {CANNOT, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1}},
    {"First apex from 5 m, e = 1", "cm", first_apex, 1, 0, {CANNOT, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1}},
    {"Height gained in 30 s, e = 1",
     "cm",
     gained_height,
     1,
     0,
     {CANNOT, 0.001, 0.001, 0.001, 0.001, 0.001, 0.001}},
    {"Height lost in 30 s, e = 1", "cm", lost_height, 1, 0, {0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1}},
    {"Cradle of 3, gaps of 1 cm, 3 m/s", "m/s", cradle, 3, 0.01, {1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9}},
    {"Cradle of 4, gaps of 1 cm", "m/s", cradle, 4, 0.01, {1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9}},
    {"Cradle of 5, gaps of 1 cm", "m/s", cradle, 5, 0.01, {1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9}},
    {"Cradle of 6, gaps of 1 cm", "m/s", cradle, 6, 0.01, {1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9}},
    {"Cradle of 7, gaps of 1 cm", "m/s", cradle, 7, 0.01, {1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9}},
    {"Cradle of 5, touching", "m/s", cradle, 5, 0, {1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9}},
    {"Cradle of 5, gaps of 10 cm", "m/s", cradle, 5, 0.1, {1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9}},
    {"Column of 10, gaps of 0 cm", "cm", column_leans, 10, 0, {CANNOT, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6}},
    {"Column of 10, gaps of 2 cm",
     "cm",
     column_leans,
     10,
     0.02,
     {CANNOT, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6}},
    {"Column of 10, gaps of 5 cm",
     "cm",
     column_leans,
     10,
     0.05,
     {CANNOT, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6}},
    {"Column of 20, gaps of 0 cm", "cm", column_leans, 20, 0, {CANNOT, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6}},
    {"Column of 20, gaps of 2 cm",
     "cm",
     column_leans,
     20,
     0.02,
     {CANNOT, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6}},
    {"Column of 20, gaps of 5 cm",
     "cm",
     column_leans,
     20,
     0.05,
     {CANNOT, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6}},
    {"Column of 30, gaps of 0 cm", "cm", column_leans, 30, 0, {CANNOT, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6}},
    {"Column of 30, gaps of 2 cm",
     "cm",
     column_leans,
     30,
     0.02,
     {CANNOT, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6}},
    {"Column of 30, gaps of 5 cm",
     "cm",
     column_leans,
     30,
     0.05,
     {CANNOT, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6}},
    {"Column of 40, gaps of 0 cm", "cm", column_leans, 40, 0, {CANNOT, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6}},
    {"Column of 40, gaps of 2 cm",
     "cm",
     column_leans,
     40,
     0.02,
     {CANNOT, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6}},
    {"Column of 40, gaps of 5 cm",
     "cm",
     column_leans,
     40,
     0.05,
     {CANNOT, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6}},
};
enum { count = sizeof trials / sizeof trials[0] };

/* As in the file: three digits. */
static void row_of(const trial *t, int32_t solver, double error, char *line, size_t size)
{
    char limit[32] = "";
    if (!isnan(t->limit[solver]))
        snprintf(limit, sizeof limit, "%g", t->limit[solver]);
    snprintf(line, size, "\"%s\",%s,%s,%.3g,%s\n", t->what, t->unit, ll_rigid_solver_names[solver],
             error < rounding ? 0 : error, limit);
}

static double error_of(const trial *t, int32_t solver)
{
    ll_rigid_params p = standard_params();
    p.sleep = false;
    p.solver = solver;
    return t->error(t, &p);
}

static void update(void)
{
    FILE *f = fopen(TABLE, "w");
    if (f == NULL)
        abort();
    fprintf(f, "case,unit,solver,error,limit\n");
    for (int i = 0; i < count; i++)
        for (int32_t s = 0; s < LL_SOLVERS; s++) {
            char line[200];
            row_of(&trials[i], s, error_of(&trials[i], s), line, sizeof line);
            fputs(line, f);
        }
    fclose(f);
}

/* Every error is within its limit, and the file has the errors of this build. */
static void errors_are_within_their_limits(void **state)
{
    (void)state;
    char line[200], told[200];
    int failed = 0;
    FILE *f = fopen(TABLE, "r");
    assert_non_null(f);
    assert_non_null(fgets(told, sizeof told, f));
    for (int i = 0; i < count; i++)
        for (int32_t s = 0; s < LL_SOLVERS; s++) {
            double error = error_of(&trials[i], s);
            row_of(&trials[i], s, error, line, sizeof line);
            assert_non_null(fgets(told, sizeof told, f));
            if (!isnan(trials[i].limit[s]) && !(error <= trials[i].limit[s]) && ++failed)
                print_error("over its limit: %s", line);
            if (strcmp(line, told) != 0 && ++failed)
                print_error("%s has %sinstead of %s", TABLE, told, line);
        }
    fclose(f);
    assert_int_equal(failed, 0);
}

/* XPBD: more substeps do not make friction worse, and a pile of 820 boxes stays in place. */
static void xpbd_gets_better_with_substeps(void **state)
{
    (void)state;
    ll_rigid_params p = standard_params();
    p.sleep = false;
    p.solver = LL_SOLVER_XPBD;
    double before = INFINITY;
    for (p.substeps = 4; p.substeps <= 64; p.substeps *= 4) {
        double worst = 0;
        for (double degrees = 5; degrees <= 45; degrees += 8) {
            trial t = {.number = degrees};
            worst = larger(worst, disc_rolls(&t, &p));
        }
        assert_at_most("error of the discs, %", worst, smaller(0.3, before));
        before = worst;
    }
}

static void a_pile_stays_by_xpbd(void **state)
{
    (void)state;
    static const double drift[] = {0.2, 0.03};
    for (int k = 0; k < 2; k++) {
        ll_rigid_params p = scene_params("pyramid", (ll_scene_args){.size = 40});
        p.solver = LL_SOLVER_XPBD;
        p.substeps = 8 << k;
        lab l = lab_open("pyramid", (ll_scene_args){.size = 40}, &p, LL_BROAD_GRID);
        double energy = lab_measure(&l).potential_energy, most = energy;
        for (int i = 0; i < 300; i++) {
            lab_run(&l, 1);
            ll_rigid_metrics m = lab_measure(&l);
            most = larger(most, m.potential_energy + m.kinetic_energy);
        }
        assert_at_most("drift", lab_measure(&l).drift_max, drift[k]);
        assert_at_most("sag", lab_measure(&l).sag_max, 0.03);
        assert_at_most("energy gained, J", most - energy, 1e-6);
        lab_close(&l);
    }
}

/* A gas of balls of restitution 1: every solver but `impulse` conserves momentum and energy. */
static void elastic_gases_keep_momentum_and_energy(void **state)
{
    (void)state;
    for (int32_t solver = LL_SOLVER_PGS; solver < LL_SOLVERS; solver++) {
        ll_rigid_limits limits = small_limits(24);
        ll_rigid_params p = standard_params();
        p.gravity_y = 0;
        p.restitution_threshold = 0;
        p.sleep = false;
        p.solver = solver;
        ll_rigid *w = world_of(&limits, &p);
        ll_material m = ll_material_defaults();
        m.restitution = 1;
        m.friction = 0;
        for (int i = 0; i < 24; i++) {
            ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
            def.position = ll_vec(1.1 * (i % 6) + 0.03 * (i / 6), 1.1 * (i / 6));
            def.velocity = ll_vec(3 * sin(2.3 * i + 1) - 0.3 * (i % 6), 3 * cos(1.9 * i) - 0.5 * (i / 6));
            add_ball(w, def, 0.4 + 0.1 * (i % 2), m);
        }
        ll_rigid_metrics first = ll_rigid_measure(w, NULL, 0, INFINITY);
        steps(w, 2);
        ll_rigid_metrics last = ll_rigid_measure(w, NULL, 0, INFINITY);
        int turned = 0;
        for (int i = 0; i < 24; i++)
            turned +=
                fabs(body(w, ll_rigid_body_at(w, i)).velocity.y - 3 * cos(1.9 * i) + 0.5 * (i / 6)) > 0.01;
        assert_true(turned > 12);
        assert_near(last.kinetic_energy, first.kinetic_energy, 1e-12 * first.kinetic_energy);
        assert_near(ll_length(ll_sub(last.momentum, first.momentum)), 0, 1e-12 * first.kinetic_energy);
        free(w);
    }
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "--update") == 0) {
        update();
        return 0;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_are_within_their_limits),
        cmocka_unit_test(xpbd_gets_better_with_substeps),
        cmocka_unit_test(a_pile_stays_by_xpbd),
        cmocka_unit_test(elastic_gases_keep_momentum_and_energy),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
