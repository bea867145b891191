/* The start of a fluid of particles: checks its setup, lays out the block, and fills it. */
#include <math.h>
#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"
#include "fluid/particle/state.h"

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
        LL_TRY(check_range(rows[i].field, rows[i].value, rows[i].least, rows[i].most));
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
    place(&p.at.beside, &end, (size_t)p.fluid, sizeof(int32_t));
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
    LL_ASSERT(sum > 0 && slope > 0 && viscous > 0); /* the support reaches neighbours */
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
    LL_ASSERT(p->mass > 0);
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
    LL_ASSERT(f.count == ll_particle_total(p) && f.body == p->body_count); /* as counted for the layout */
    ll_particle_body_place(p);
    ll_particle_sort_walls(p);
    ll_particle_sort_fluid(p);
    return p;
}
