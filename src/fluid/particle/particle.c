#include <math.h>
#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"
#include "base/hash.h"
#include "fluid/particle/state.h"

static const ll_particle_method *const methods[] = {&ll_particle_wcsph, &ll_particle_pbf, &ll_particle_dfsph};

/* In the order of `methods`; a test compares them. */
const char *const ll_particle_method_names[] = {"wcsph", "pbf", "dfsph", NULL};

const char *ll_particle_method_help(ll_particle_method_kind kind)
{
    return methods[kind]->help;
}

/* ---- the setup ---- */

#define WALL_LAYERS 3
#define PAIRS_PER_PARTICLE 28

static ll_status check_range(const char *field, double value, double least, double most)
{
    if (value >= least && value <= most)
        return ll_ok();
    return ll_field_error(LL_BAD_INPUT, field, "%s: must be %g to %g; got %g.", field, least, most, value);
}

static double support_of(const ll_particle_setup *setup)
{
    return 2 * setup->smoothing * setup->spacing;
}

static ll_status check_ranges(const ll_particle_setup *s)
{
    const struct {
        const char *field;
        double value, least, most;
    } rows[] = {
        {"spacing", s->spacing, 1e-6, 1e3},
        {"smoothing", s->smoothing, 1, 1.4}, /* at 1.4 the support equals three layers of walls */
        {"width", s->width, 4 * s->spacing, 1e5 * s->spacing},
        {"height", s->height, 4 * s->spacing, 1e5 * s->spacing},
        {"walls", s->walls, 0, 15},
        {"fill_count", s->fill_count, 1, LL_PARTICLE_FILLS},
        {"body.density", s->body.density, 0, 1e6},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ll_status status = check_range(rows[i].field, rows[i].value, rows[i].least, rows[i].most);
        if (ll_failed(&status))
            return status;
    }
    if (s->periodic && s->width < 4.4 * support_of(s)) /* at least three cells */
        return ll_field_error(LL_BAD_INPUT, "width",
                              "width: must be at least %g for a periodic tank; got %g.", 4.4 * support_of(s),
                              s->width);
    return ll_ok();
}

static ll_status check_rectangle(const ll_particle_setup *s, const char *field, double x, double y,
                                 double width, double height)
{
    double slack = 1e-9 * (s->width + s->height);
    if (width >= s->spacing && height >= s->spacing && x >= -slack && y >= -slack &&
        x + width <= s->width + slack && y + height <= s->height + slack)
        return ll_ok();
    return ll_field_error(
        LL_BAD_INPUT, field,
        "%s: must lie within the tank of %g x %g and be at least a particle of %g; got %g x %g at (%g, %g).",
        field, s->width, s->height, s->spacing, width, height, x, y);
}

static double particles_of(const ll_particle_setup *s)
{
    double area = 0, d = s->spacing;
    for (int i = 0; i < s->fill_count; i++)
        area += s->fill[i].width * s->fill[i].height;
    if (s->body.density > 0)
        area += s->body.width * s->body.height;
    return area / (d * d) + WALL_LAYERS * 2 * (s->width + s->height) / d;
}

ll_status ll_particles_check(const ll_particle_setup *s)
{
    ll_status status = check_ranges(s);
    for (int i = 0; !ll_failed(&status) && i < s->fill_count; i++) {
        char field[16] = "fill.0";
        field[5] = (char)('0' + i);
        const ll_particle_fill *f = &s->fill[i];
        status = check_rectangle(s, field, f->x, f->y, f->width, f->height);
        if (!ll_failed(&status) && !(fabs(f->u) <= 1e6 && fabs(f->v) <= 1e6 && fabs(f->strain) <= 1e6))
            status = ll_field_error(LL_BAD_INPUT, field,
                                    "%s: u, v and strain must be -1e6 to 1e6; got (%g, %g) and %g.", field,
                                    f->u, f->v, f->strain);
    }
    const ll_particle_float *b = &s->body;
    if (!ll_failed(&status) && b->density > 0)
        status = check_rectangle(s, "body", b->x - b->width / 2, b->y - b->height / 2, b->width, b->height);
    if (ll_failed(&status))
        return status;
    double count = particles_of(s);
    double cells = s->width * s->height / (support_of(s) * support_of(s));
    double bytes = count * (LL_PARTICLE_FIELDS * 8. + PAIRS_PER_PARTICLE * 36.) + 8 * cells;
    if (count > LL_PARTICLES_MAX || cells > 4. * LL_PARTICLES_MAX)
        return ll_field_error(LL_LIMIT, "spacing",
                              "spacing: %g makes %.0f particles in %.0f cells, which need %.0f MiB; at most "
                              "%d particles and %d cells are allowed.",
                              s->spacing, count, cells, bytes / 1048576, LL_PARTICLES_MAX,
                              4 * LL_PARTICLES_MAX);
    return status;
}

/* ---- filling ---- */

/* Places particles; with `p` NULL it only counts them. */
typedef struct filler {
    ll_particles *p;
    int32_t count, body;
} filler;

static int32_t put(filler *f, int32_t id, double x, double y)
{
    int32_t i = f->count++;
    if (f->p == NULL)
        return i;
    ll_particle_values(f->p, LL_PARTICLE_X)[i] = x;
    ll_particle_values(f->p, LL_PARTICLE_Y)[i] = y;
    ll_part_id(f->p)[i] = id;
    return i;
}

static int32_t whole(double length, double spacing)
{
    return (int32_t)(length / spacing + 0.5);
}

/* (rx, ry): position relative to the fill's centre. */
static void set_motion(const ll_particles *p, int32_t i, const ll_particle_fill *f, double rx, double ry)
{
    double c = p->params.sound_speed, above = f->settled ? f->height / 2 - ry : 0;
    ll_particle_values(p, LL_PARTICLE_U)[i] = f->u - f->strain * rx;
    ll_particle_values(p, LL_PARTICLE_V)[i] = f->v + f->strain * ry;
    ll_particle_values(p, LL_PARTICLE_DENSITY)[i] =
        p->params.density * ll_exp(ll_detmath_log(1 - 7 * p->params.gravity_y * above / (c * c)) / 7);
    ll_particle_values(p, LL_PARTICLE_PRESSURE_FACTOR)[i] = -p->params.gravity_y * above / p->params.density;
}

static void fill_fluid(filler *to, const ll_particle_setup *s)
{
    for (int i = 0; i < s->fill_count; i++) {
        const ll_particle_fill *f = &s->fill[i];
        int32_t columns = whole(f->width, s->spacing), rows = whole(f->height, s->spacing);
        for (int32_t row = 0; row < rows; row++)
            for (int32_t column = 0; column < columns; column++) {
                double rx = (column + 0.5) * s->spacing - f->width / 2;
                double ry = (row + 0.5) * s->spacing - f->height / 2;
                double ex = 2 * rx / f->width, ey = 2 * ry / f->height;
                if (f->round && ex * ex + ey * ey > 1)
                    continue;
                int32_t at = put(to, to->count, f->x + f->width / 2 + rx, f->y + f->height / 2 + ry);
                if (to->p != NULL)
                    set_motion(to->p, at, f, rx, ry);
            }
    }
}

typedef struct lattice {
    int32_t columns, rows;
    bool periodic;
} lattice;

/* Walls that a lattice position is behind: bits of LL_WALL_, 0 inside. */
static int behind(const lattice *l, int32_t column, int32_t row)
{
    int side = l->periodic ? 0 : column < 0 ? LL_WALL_LEFT : column >= l->columns ? LL_WALL_RIGHT : 0;
    return side | (row < 0 ? LL_WALL_BOTTOM : row >= l->rows ? LL_WALL_TOP : 0);
}

static void fill_walls(filler *to, const ll_particle_setup *s)
{
    lattice l = {whole(s->width, s->spacing), whole(s->height, s->spacing), s->periodic != 0};
    int32_t side = l.periodic ? 0 : WALL_LAYERS;
    for (int32_t row = -WALL_LAYERS; row < l.rows + WALL_LAYERS; row++)
        for (int32_t column = -side; column < l.columns + side; column++) {
            if ((behind(&l, column, row) & s->walls) == 0)
                continue;
            put(to, -1, (column + 0.5) * s->spacing, (row + 0.5) * s->spacing);
        }
}

static void fill_body(filler *to, const ll_particle_setup *s)
{
    const ll_particle_float *b = &s->body;
    if (!(b->density > 0))
        return;
    lattice l = {whole(b->width, s->spacing), whole(b->height, s->spacing), false};
    for (int32_t row = 0; row < l.rows; row++)
        for (int32_t column = 0; column < l.columns; column++) {
            if (to->p != NULL) {
                double *local = ll_part_local(to->p) + 2 * to->body;
                local[0] = (column + 0.5) * b->width / l.columns - b->width / 2;
                local[1] = (row + 0.5) * b->height / l.rows - b->height / 2;
            }
            put(to, -2 - to->body++, 0, 0);
        }
}

/* ---- the block ---- */

static void place(int64_t *at, int64_t *end, size_t count, size_t size)
{
    *at = *end;
    *end = (*end + (int64_t)(count * size) + 63) & ~INT64_C(63);
}

static ll_particles layout_of(const ll_particle_setup *s)
{
    ll_particles p = {.setup = *s};
    p.kernel.h = s->smoothing * s->spacing;
    p.kernel.support = support_of(s);
    filler f = {0};
    fill_fluid(&f, s);
    p.fluid = f.count;
    fill_walls(&f, s);
    fill_body(&f, s);
    p.wall = f.count - p.fluid;
    p.body_count = f.body;
    p.stride = (f.count + 7) & ~7;
    p.capacity = PAIRS_PER_PARTICLE * p.fluid + 64;
    ll_particle_cells_size(s, p.kernel.support, &p);

    size_t total = (size_t)p.stride, cells = (size_t)(p.columns * p.rows), pairs = (size_t)p.capacity;
    int64_t end = 0, ignored;
    place(&ignored, &end, 1, sizeof p);
    place(&p.at.id, &end, total, sizeof(int32_t));
    place(&p.at.local, &end, 2 * (size_t)p.body_count, sizeof(double));
    place(&p.at.wall_start, &end, cells + 1, sizeof(int32_t));
    place(&p.at.field, &end, total * LL_PARTICLE_STATES, sizeof(double));
    p.at.state_end = end;
    place(&ignored, &end, total * (LL_PARTICLE_FIELDS - LL_PARTICLE_STATES), sizeof(double));
    place(&p.at.fluid_start, &end, cells + 1, sizeof(int32_t));
    place(&p.at.cell, &end, total, sizeof(int32_t));
    place(&p.at.order, &end, total, sizeof(double));
    place(&p.at.row, &end, 2 * (size_t)p.fluid + 2, sizeof(int32_t));
    place(&p.at.pair, &end, pairs, sizeof(int32_t));
    place(&p.at.ex, &end, pairs, sizeof(double));
    place(&p.at.ey, &end, pairs, sizeof(double));
    place(&p.at.slope, &end, pairs, sizeof(double));
    place(&p.at.kernel, &end, pairs, sizeof(double));
    p.at.end = end;
    return p;
}

size_t ll_particles_size(const ll_particle_setup *setup)
{
    return (size_t)layout_of(setup).at.end;
}

size_t ll_particles_state_size(const ll_particles *p)
{
    return (size_t)p->at.state_end;
}

/* Scales for which the sums of a square lattice are exact: of the kernel, of the gradient of a linear field,
 * and of viscosity. With the kernel's own derivative pressure would be 4 % too high. */
static void normalise(ll_particles *p)
{
    double d = p->setup.spacing, h = p->kernel.h, sum = 0, slope = 0, viscous = 0;
    int reach = (int)(p->kernel.support / d) + 1;
    for (int row = -reach; row <= reach; row++)
        for (int column = -reach; column <= reach; column++) {
            double x = column * d, y = row * d, e2 = x * x + y * y, q = sqrt(e2) / h, s = 1 - q / 2;
            if (s <= 0)
                continue;
            sum += s * s * s * s * (2 * q + 1);
            slope += s * s * s * y * y;
            viscous += s * s * s * e2 / (e2 + 0.01 * h * h) * y * y;
        }
    p->kernel.scale = 1 / (sum * d * d);
    p->kernel.slope_scale = -1 / (slope * d * d);
    p->kernel.gradient_scale = p->kernel.slope_scale * h * h / (-5 * p->kernel.scale);
    p->kernel.viscous_scale = slope / viscous;
}

ll_particles *ll_particles_init(void *block, const ll_particle_setup *setup, const ll_particle_params *params)
{
    ll_particles *p = block;
    ll_particles head = layout_of(setup);
    memset(block, 0, (size_t)head.at.end);
    *p = head;
    p->params = *params;
    p->mass = params->density * setup->spacing * setup->spacing;
    normalise(p);
    const ll_particle_float *b = &setup->body;
    if (b->density > 0) {
        double mass = b->density * b->width * b->height;
        p->body = (ll_particle_body){.x = b->x, .y = b->y, .mass = mass};
        p->body.inertia = mass * (b->width * b->width + b->height * b->height) / 12;
    }
    filler f = {.p = p};
    fill_fluid(&f, setup);
    fill_walls(&f, setup);
    fill_body(&f, setup);
    ll_particle_body_place(p);
    ll_particle_sort_walls(p);
    ll_particle_sort_fluid(p);
    return p;
}

/* Masses do not change: a new rest density changes the density only through mass. */
void ll_particles_set_params(ll_particles *p, const ll_particle_params *params)
{
    bool changed = p->params.method != params->method;
    double scale = params->density / p->params.density;
    p->params = *params;
    p->mass = params->density * p->setup.spacing * p->setup.spacing;
    double *density = ll_particle_values(p, LL_PARTICLE_DENSITY);
    for (int32_t a = 0; a < p->fluid; a++)
        density[a] *= scale;
    if (!changed)
        return;
    /* Values of another method have another meaning. */
    memset(ll_particle_values(p, LL_PARTICLE_PRESSURE_FACTOR), 0,
           (size_t)ll_particle_total(p) * sizeof(double));
    memset(ll_particle_values(p, LL_PARTICLE_DIVERGENCE), 0, (size_t)ll_particle_total(p) * sizeof(double));
    for (int32_t a = 0; a < p->fluid; a++)
        density[a] = params->density;
}

const ll_particle_params *ll_particles_get_params(const ll_particles *p)
{
    return &p->params;
}

const ll_particle_setup *ll_particles_get_setup(const ll_particles *p)
{
    return &p->setup;
}

/* ---- a step ---- */

static ll_status failed(const ll_particles *p, ll_particle_fault fault)
{
    int32_t id = ll_part_id(p)[fault.particle];
    return ll_error(LL_DIVERGED, "step %lld: particle %d %s (%.4g, at most %.4g).", (long long)p->tick, id,
                    fault.reason, fault.value, fault.limit);
}

/* The particle of the largest speed; the first whose state is not finite, if any. */
static int32_t fastest(const ll_particles *p, double *speed)
{
    const double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    const double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    const double *density = ll_particle_values(p, LL_PARTICLE_DENSITY);
    double most = -1;
    int32_t at = 0;
    for (int32_t a = 0; a < p->fluid; a++) {
        double square = u[a] * u[a] + v[a] * v[a];
        if (!(square + x[a] * x[a] + y[a] * y[a] + density[a] * density[a] < 1e300)) {
            *speed = NAN;
            return a;
        }
        if (square > most) {
            most = square;
            at = a;
        }
    }
    *speed = sqrt(most);
    return at;
}

static double dt_limit(const ll_particles *p, double speed)
{
    const ll_particle_params *q = &p->params;
    double limit = methods[q->method]->dt_limit(p, speed);
    double gravity = sqrt(q->gravity_x * q->gravity_x + q->gravity_y * q->gravity_y);
    double viscosity = q->viscosity + q->artificial_viscosity * p->kernel.h * q->sound_speed / 8;
    if (viscosity > 0)
        limit = fmin(limit, 0.125 * p->kernel.h * p->kernel.h / viscosity);
    if (gravity > 0)
        limit = fmin(limit, 0.25 * sqrt(p->kernel.h / gravity));
    return limit;
}

static void wrap(ll_particles *p)
{
    double *x = ll_particle_values(p, LL_PARTICLE_X);
    for (int32_t a = 0; p->setup.periodic && a < p->fluid; a++)
        x[a] += x[a] < 0 ? p->wrap : x[a] >= p->wrap ? -p->wrap : 0;
}

static ll_particle_fault not_finite(int32_t particle)
{
    return (ll_particle_fault){
        .reason = "has a value that is not finite", .particle = particle, .value = NAN};
}

static ll_particle_fault check(const ll_particles *p, double dt)
{
    double speed, travel = methods[p->params.method]->travel;
    int32_t at = fastest(p, &speed);
    double spacings = speed * dt / p->setup.spacing;
    if (isnan(speed))
        return not_finite(at);
    if (spacings > travel)
        return (ll_particle_fault){.reason = "broke the CFL condition: spacings moved in one substep",
                                   .particle = at,
                                   .value = spacings,
                                   .limit = travel};
    return (ll_particle_fault){0};
}

void ll_particles_drag(ll_particles *p, const ll_drag_force *drag_force)
{
    p->drag_force = *drag_force;
}

void ll_particles_put(ll_particles *p, const ll_particle_place *places)
{
    for (int32_t a = 0; a < p->fluid; a++) {
        const ll_particle_place *to = &places[ll_part_id(p)[a]];
        ll_particle_values(p, LL_PARTICLE_X)[a] = to->x;
        ll_particle_values(p, LL_PARTICLE_Y)[a] = to->y;
        ll_particle_values(p, LL_PARTICLE_U)[a] = to->u;
        ll_particle_values(p, LL_PARTICLE_V)[a] = to->v;
    }
}

static void draw_along(ll_particles *p)
{
    const ll_drag_force *s = &p->drag_force;
    const double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    for (int32_t a = 0; s->radius > 0 && a < p->fluid; a++) {
        double ex = x[a] - s->x, ey = y[a] - s->y;
        if (ex * ex + ey * ey > s->radius * s->radius)
            continue;
        u[a] = s->velocity_x;
        v[a] = s->velocity_y;
    }
}

ll_status ll_particles_step_paced(ll_particles *p, double dt, ll_pace *pace)
{
    const ll_particle_params *q = &p->params;
    double left = dt;
    draw_along(p);
    for (int64_t done = 0; left > 0 && ll_goes_on(pace); done++) {
        double speed;
        int32_t at = fastest(p, &speed);
        if (isnan(speed))
            return failed(p, not_finite(at));
        double parts = ceil(left / dt_limit(p, speed) * (1 - 1e-12));
        if (parts + (double)done > (double)q->substeps)
            return failed(p, (ll_particle_fault){.reason = "needs too many substeps by the CFL condition",
                                                 .particle = at,
                                                 .value = parts + (double)done,
                                                 .limit = (double)q->substeps});
        double part = parts > 1 ? left / parts : left;
        ll_particle_fault fault = methods[q->method]->substep(p, part, pace);
        if (fault.reason == NULL) {
            ll_particle_body_move(p, part);
            wrap(p);
            fault = check(p, part);
        }
        if (fault.reason != NULL)
            return failed(p, fault);
        left = parts > 1 ? left - part : 0;
        p->substeps++;
    }
    p->time += dt;
    p->tick++;
    LL_VALIDATE(ll_broken_off(pace) || ll_particles_valid(p));
    return ll_ok();
}

ll_status ll_particles_step(ll_particles *p, double dt)
{
    return ll_particles_step_paced(p, dt, NULL);
}

uint64_t ll_particles_hash(const ll_particles *p)
{
    return ll_hash(0, p, (size_t)p->at.state_end);
}

bool ll_particles_valid(const ll_particles *p)
{
    const int32_t *id = ll_part_id(p);
    double ids = 0, total = p->fluid;
    for (int32_t a = 0; a < p->fluid; a++) {
        if (id[a] < 0 || id[a] >= p->fluid)
            return false;
        ids += id[a];
    }
    if (ids != total * (total - 1) / 2)
        return false;
    for (int32_t b = p->fluid; b < ll_particle_total(p); b++)
        if (id[b] >= 0 || id[b] < -1 - p->body_count)
            return false;
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    for (int32_t a = 0; p->substeps > 0 && a < p->fluid; a++)
        for (int32_t k = row[2 * a]; k < row[2 * a + 2]; k++)
            if (pair[k] <= a || pair[k] >= ll_particle_total(p) ||
                (pair[k] < p->fluid) != (k < row[2 * a + 1]))
                return false;
    return true;
}

/* ---- queries ---- */

ll_particle_view ll_particles_view(const ll_particles *p)
{
    return (ll_particle_view){.count = p->fluid,
                              .id = ll_part_id(p),
                              .x = ll_particle_values(p, LL_PARTICLE_X),
                              .y = ll_particle_values(p, LL_PARTICLE_Y),
                              .u = ll_particle_values(p, LL_PARTICLE_U),
                              .v = ll_particle_values(p, LL_PARTICLE_V),
                              .density = ll_particle_values(p, LL_PARTICLE_DENSITY),
                              .pressure = ll_particle_values(p, LL_PARTICLE_PRESSURE)};
}

ll_particle_body ll_particles_body(const ll_particles *p)
{
    return p->body;
}

ll_particle_stats ll_particles_stats(const ll_particles *p)
{
    return (ll_particle_stats){.tick = p->tick,
                               .time = p->time,
                               .substeps = p->substeps,
                               .iterations = p->iterations,
                               .fluid = p->fluid,
                               .wall = p->wall - p->body_count,
                               .body = p->body_count,
                               .pairs = p->pairs};
}
