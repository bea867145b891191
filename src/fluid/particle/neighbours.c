#include <string.h>

#include "fluid/particle/state.h"

#include "base/assert.h"

/* Cells are a little wider than the support radius, for methods that keep pairs while particles move. */
#define CELL_PER_SUPPORT 1.1

void ll_particle_cells_size(const ll_particle_setup *setup, double support, ll_particles *p)
{
    double side = CELL_PER_SUPPORT * support;
    double margin = 4 * setup->spacing; /* room for walls */
    p->cells.origin_x = setup->periodic ? 0 : -margin;
    p->cells.origin_y = -margin;
    double width = setup->periodic ? setup->width : setup->width + 2 * margin;
    p->columns = (int32_t)(width / side);
    p->rows = (int32_t)((setup->height + 2 * margin) / side) + 1;
    if (!setup->periodic)
        p->columns++;
    p->cells.per_m_x = setup->periodic ? p->columns / width : 1 / side;
    p->cells.per_m_y = 1 / side;
    p->wrap = setup->periodic ? width : 1e300;
}

/* Positions beyond the grid go to its edge cells: neighbours stay in neighbouring cells. NaN goes to 0. */
static int32_t slot(double at, double origin, double per_cell, int32_t count)
{
    double place = (at - origin) * per_cell;
    LL_VALIDATE(count > 0);
    double last = count - 1;
    return place > 0 ? (int32_t)(place < last ? place : last) : 0;
}

/* Stable counting sort: the order depends on the positions and the last order only. */
static void sort(ll_particles *p, int32_t begin, int32_t end, int32_t *start, ll_particle_field fields)
{
    const double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    int32_t *place = ll_part_cell(p), cells = p->columns * p->rows;
    memset(start, 0, (size_t)(cells + 1) * sizeof *start);
    for (int32_t i = begin; i < end; i++) {
        place[i] = slot(y[i], p->cells.origin_y, p->cells.per_m_y, p->rows) * p->columns +
                   slot(x[i], p->cells.origin_x, p->cells.per_m_x, p->columns);
        start[place[i]]++;
    }
    for (int32_t c = 0, sum = begin; c <= cells; c++) {
        int32_t count = start[c];
        start[c] = sum;
        sum += count;
        LL_VALIDATE(sum <= end); /* each particle is in one cell */
    }
    LL_ASSERT(start[cells] == end);
    for (int32_t i = begin; i < end; i++)
        place[i] = start[place[i]]++;
    memmove(start + 1, start, (size_t)cells * sizeof *start);
    start[0] = begin;

    double *order = ll_part_order(p);
    for (ll_particle_field f = 0; f < fields; f++) {
        double *value = ll_particle_values(p, f);
        for (int32_t i = begin; i < end; i++)
            order[place[i]] = value[i];
        memcpy(value + begin, order + begin, (size_t)(end - begin) * sizeof *value);
    }
    int32_t *id = ll_part_id(p), *ids = (int32_t *)(void *)order;
    for (int32_t i = begin; i < end; i++)
        ids[place[i]] = id[i];
    memcpy(id + begin, ids + begin, (size_t)(end - begin) * sizeof *id);
}

void ll_particle_sort_fluid(ll_particles *p)
{
    sort(p, 0, p->fluid, ll_part_fluid_start(p), LL_PARTICLE_SORTED);
}

void ll_particle_sort_walls(ll_particles *p)
{
    sort(p, p->fluid, ll_particle_total(p), ll_part_wall_start(p), LL_PARTICLE_STATES);
}

/* ---- pairs ---- */

typedef struct range {
    int32_t begin, end;
} range;

/* Particles of the cells (column - 1 .. column + 1) of a row: one range, or two at the end of a periodic
 * row. */
static int row_ranges(const ll_particles *p, const int32_t *start, int32_t column, int32_t row, range *out)
{
    if (row < 0 || row >= p->rows)
        return 0;
    int32_t first = row * p->columns, left = column - 1, right = column + 1;
    int count = 0;
    if (left < 0) {
        left = 0;
        if (p->setup.periodic)
            out[count++] = (range){start[first + p->columns - 1], start[first + p->columns]};
    }
    if (right >= p->columns) {
        right = p->columns - 1;
        if (p->setup.periodic)
            out[count++] = (range){start[first], start[first + 1]};
    }
    LL_VALIDATE(left <= right && start[first + left] <= start[first + right + 1]);
    out[count++] = (range){start[first + left], start[first + right + 1]};
    return count;
}

typedef struct search {
    const double *x, *y;
    double wrap, half, reach2;
    ll_particle_near *near; /* in a tank that is not periodic */
    bool periodic;
    int32_t *pair;
    int32_t at; /* the particle whose pairs are sought */
    int32_t count, capacity;
} search;

/* Branch-free, since the results are random. */
int32_t ll_particle_near_base(const double *x, const double *y, int32_t a, int32_t begin, int32_t end,
                              double reach2, int32_t *restrict pair)
{
    double xa = x[a], ya = y[a];
    int32_t count = 0;
    for (int32_t b = begin; b < end; b++) {
        double ex = xa - x[b], ey = ya - y[b];
        pair[count] = b;
        count += ex * ex + ey * ey < reach2;
    }
    return count;
}

static int32_t near_in_period(const search *s, int32_t a, range r, int32_t *restrict pair)
{
    const double *x = s->x, *y = s->y;
    double xa = x[a], ya = y[a], reach2 = s->reach2;
    int32_t count = 0;
    for (int32_t b = r.begin; b < r.end; b++) {
        double ex = ll_particle_shortest(xa - x[b], s->half, s->wrap), ey = ya - y[b];
        pair[count] = b;
        count += ex * ex + ey * ey < reach2;
    }
    return count;
}

/* Keeps those in the range that are near enough. */
static inline bool keep(search *s, int32_t a, range r)
{
    int32_t left = s->capacity - s->count, most = r.end - r.begin;
    if (left < most)
        return false;
    int32_t *to = s->pair + s->count;
    ll_particle_near *near = left < most + LL_PARTICLE_NEAR_LANES ? ll_particle_near_base : s->near;
    s->count +=
        s->periodic ? near_in_period(s, a, r, to) : near(s->x, s->y, a, r.begin, r.end, s->reach2, to);
    LL_VALIDATE(s->count <= s->capacity);
    return true;
}

static ll_particle_near *near_of_cpu(void)
{
#if defined(__x86_64__)
    return __builtin_cpu_supports("avx2") ? ll_particle_near_avx2 : ll_particle_near_base;
#else
    return ll_particle_near_base;
#endif
}

/* Half of the neighbouring fluid: the rest of the own cell, the one to the right, the row above. */
static int fluid_ranges(const ll_particles *p, int32_t column, int32_t row, range *out)
{
    const int32_t *start = ll_part_fluid_start(p);
    int32_t cell = row * p->columns + column, right = cell + 1;
    int count = 1;
    out[0] = (range){start[cell], start[cell + 1]};
    if (column + 1 < p->columns)
        out[0].end = start[right + 1];
    if (column == 0 && p->setup.periodic) /* not from the last cell: the other must have the higher index */
        out[count++] = (range){start[cell + p->columns - 1], start[cell + p->columns]};
    return count + row_ranges(p, start, column, row + 1, out + count);
}

static int wall_ranges(const ll_particles *p, int32_t column, int32_t row, range *out)
{
    int count = 0;
    range found[6];
    for (int32_t r = row - 1; r <= row + 1; r++) {
        int n = row_ranges(p, ll_part_wall_start(p), column, r, found);
        for (int i = 0; i < n; i++)
            if (found[i].end > found[i].begin)
                out[count++] = found[i];
    }
    return count;
}

static bool cell_pairs(ll_particles *p, search *s, int32_t column, int32_t row)
{
    range fluid[5], wall[6];
    int fluids = fluid_ranges(p, column, row, fluid), walls = wall_ranges(p, column, row, wall);
    int32_t *rows = ll_part_row(p), end = ll_part_fluid_start(p)[row * p->columns + column + 1];
    for (; s->at < end; s->at++) {
        int32_t a = s->at;
        rows[2 * a] = s->count;
        fluid[0].begin = a + 1;
        for (int i = 0; i < fluids; i++)
            if (!keep(s, a, fluid[i]))
                return false;
        rows[2 * a + 1] = s->count;
        for (int i = 0; i < walls; i++)
            if (!keep(s, a, wall[i]))
                return false;
    }
    return true;
}

static bool cells_pairs(ll_particles *p, search *s, int32_t first, int32_t last)
{
    for (int32_t cell = first; cell < last; cell++)
        if (!cell_pairs(p, s, cell % p->columns, cell / p->columns))
            return false;
    return true;
}

/* ---- parts ---- */

/* The first cell that begins at particle `a` or behind it. */
static int32_t cell_from(const ll_particles *p, int32_t a)
{
    const int32_t *start = ll_part_fluid_start(p);
    int32_t low = 0, high = p->columns * p->rows;
    while (low < high) {
        int32_t middle = low + (high - low) / 2;
        if (start[middle] < a)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Pairs reach from a cell to the right one and to the three above, in a periodic tank around its end. */
static int32_t reaches_from(const ll_particles *p, int32_t cell)
{
    int32_t first = p->setup.periodic ? (cell / p->columns - 1) * p->columns : cell - p->columns - 1;
    return ll_part_fluid_start(p)[first > 0 ? first : 0];
}

ll_particle_share ll_particle_share_of(const ll_particles *p, int part, int parts)
{
    ll_share even = ll_share_of(p->fluid, part, parts);
    ll_particle_share s = {.end = p->fluid, .tail = p->fluid, .last_cell = p->columns * p->rows};
    const int32_t *start = ll_part_fluid_start(p);
    if (part > 0) {
        s.first_cell = cell_from(p, even.begin);
        s.begin = start[s.first_cell];
        s.halo = reaches_from(p, s.first_cell);
    }
    if (part < parts - 1) {
        s.last_cell = cell_from(p, even.end);
        s.end = start[s.last_cell];
        s.tail = reaches_from(p, s.last_cell);
        s.tail = s.tail > s.begin ? s.tail : s.begin;
    }
    return s;
}

/* Each part searches the pairs of its cells into a piece of the room. */
typedef struct searches {
    ll_particles *p;
    search of[LL_TEAM_PARTS_MAX];
    int32_t first[LL_TEAM_PARTS_MAX]; /* pair of each part */
    double reach2;
    int parts;
    bool full; /* a piece was */
} searches;

static int32_t piece_of(const ll_particles *p, int32_t from)
{
    return (int32_t)((int64_t)p->capacity * from / (p->fluid > 0 ? p->fluid : 1));
}

static search search_of(const searches *all, ll_particle_share share)
{
    ll_particles *p = all->p;
    return (search){.x = ll_particle_values(p, LL_PARTICLE_X),
                    .y = ll_particle_values(p, LL_PARTICLE_Y),
                    .wrap = p->wrap,
                    .half = p->wrap / 2,
                    .periodic = p->setup.periodic != 0,
                    .reach2 = all->reach2,
                    .near = near_of_cpu(),
                    .pair = ll_part_pair(p),
                    .at = share.begin,
                    .count = piece_of(p, share.begin),
                    .capacity = piece_of(p, share.end)};
}

static void search_part(void *context, int part, int parts)
{
    searches *all = context;
    ll_particle_share share = ll_particle_share_of(all->p, part, parts);
    search s = search_of(all, share);
    all->first[part] = s.count;
    if (!cells_pairs(all->p, &s, share.first_cell, share.last_cell))
        s.capacity = -1;
    all->of[part] = s;
    if (part == 0)
        all->parts = parts;
}

/* Closes the gaps between the pieces. */
static void gather(searches *all)
{
    ll_particles *p = all->p;
    int32_t *pair = ll_part_pair(p), *row = ll_part_row(p), count = all->of[0].count;
    for (int i = 1; i < all->parts; i++) {
        const search *s = &all->of[i];
        ll_particle_share share = ll_particle_share_of(p, i, all->parts);
        int32_t shift = all->first[i] - count;
        memmove(pair + count, pair + all->first[i], (size_t)(s->count - all->first[i]) * sizeof *pair);
        for (int32_t k = 2 * share.begin; k < 2 * share.end; k++)
            row[k] -= shift;
        count += s->count - all->first[i];
    }
    row[2 * p->fluid] = count;
    p->pairs = count;
}

static void list_beside(ll_particles *p)
{
    const int32_t *row = ll_part_row(p);
    int32_t *beside = ll_part_beside(p), count = 0;
    for (int32_t a = 0; a < p->fluid; a++) {
        beside[count] = a;
        count += row[2 * a + 2] > row[2 * a + 1];
    }
    p->beside = count;
}

static void geometry_part(void *context, int part, int parts)
{
    ll_particles *p = context;
    ll_particle_share share = ll_particle_share_of(p, part, parts);
    for (int32_t from = share.begin; from < share.end; from += LL_PARTICLE_BLOCK)
        ll_particle_geometry(p, from, ll_particle_block_end(from, share.end));
}

ll_particle_fault ll_particle_pairs(ll_particles *p, double reach, ll_team *team)
{
    searches all = {.p = p, .reach2 = reach * reach};
    ll_team_run(team, p->fluid, LL_PARTICLE_TEAM, search_part, &all);
    for (int i = 0; i < all.parts; i++)
        all.full |= all.of[i].capacity < 0;
    if (all.full && all.parts > 1) /* crowded in one piece: there may be room in all */
        search_part(&all, 0, 1);
    if (all.of[0].capacity < 0)
        return (ll_particle_fault){.reason = "has more neighbours than the room for pairs",
                                   .particle = all.of[0].at,
                                   .value = all.of[0].count,
                                   .limit = p->capacity};
    gather(&all);
    list_beside(p);
    ll_team_run(team, p->fluid, LL_PARTICLE_TEAM, geometry_part, p);
    return (ll_particle_fault){0};
}
