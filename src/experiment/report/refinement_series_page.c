#include "experiment/report/refinement_series_page.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/report/plot.h"
#include "experiment/statistics/front.h"

enum { SERIES_MAX = 64 };

struct ll_refinement_series_page {
    ll_drawn_level *refinement_levels;
    int count, room;
    bool short_of_memory;
};

ll_refinement_series_page *ll_refinement_series_page_make(void)
{
    return calloc(1, sizeof(ll_refinement_series_page));
}

void ll_refinement_series_page_free(ll_refinement_series_page *page)
{
    if (page)
        free(page->refinement_levels);
    free(page);
}

void ll_refinement_series_page_add(ll_refinement_series_page *page, const ll_drawn_level *refinement_level)
{
    if (!page)
        return;
    if (page->count == page->room) {
        int room = page->room ? 2 * page->room : 64;
        ll_drawn_level *more = realloc(page->refinement_levels, (size_t)room * sizeof *more);
        page->short_of_memory |= more == NULL;
        if (!more)
            return;
        page->refinement_levels = more;
        page->room = room;
    }
    page->refinement_levels[page->count++] = *refinement_level;
}

/* ---- one refinement series ---- */

typedef struct refinement_series {
    const ll_refinement_series_page *page;
    int first, count; /* its levels are consecutive */
    const char *series[SERIES_MAX];
    int series_count;
    ll_plot_point *points; /* space for all levels */
    const char *where;
    FILE *file;
} refinement_series;

static void write_point_name(const void *context, int64_t point, FILE *file)
{
    const ll_drawn_level *r = &((const ll_refinement_series_page *)context)->refinement_levels[point];
    ll_html_text(r->series, file);
    fputs(", ", file);
    ll_html_text(r->setting, file);
    fprintf(file, " %.6g", r->value);
}

static int series_of(refinement_series *l, const char *name)
{
    int k = 0;
    while (k < l->series_count && strcmp(l->series[k], name) != 0)
        k++;
    if (k == l->series_count && k < SERIES_MAX)
        l->series[l->series_count++] = name;
    return k < SERIES_MAX ? k : SERIES_MAX - 1;
}

static int by_x(const void *a, const void *b)
{
    const ll_plot_point *p = a, *q = b;
    if (p->x != q->x)
        return (p->x > q->x) - (p->x < q->x);
    return (p->y > q->y) - (p->y < q->y);
}

static ll_status mark_front(ll_plot_point *points, int count)
{
    ll_front_point *places = malloc((size_t)count * sizeof *places + 1);
    if (!places)
        return ll_error(LL_NO_MEMORY, "out of memory: front");
    for (int i = 0; i < count; i++)
        places[i] = (ll_front_point){.cost = points[i].x, .error = points[i].y};
    ll_status status = ll_front_mark(places, count);
    for (int i = 0; i < count; i++)
        points[i].front = places[i].front;
    free(places);
    return status;
}

static ll_status write_plot(refinement_series *l, bool counted, const char *title)
{
    const ll_drawn_level *first = &l->page->refinement_levels[l->first];
    for (int i = 0; i < l->count; i++) {
        const ll_drawn_level *r = &first[i];
        l->points[i] = (ll_plot_point){.x = fabs(counted ? r->count : r->cpu_s),
                                       .y = r->y,
                                       .low = r->low,
                                       .high = r->high,
                                       .point = l->first + i,
                                       .series = series_of(l, r->series)};
    }
    qsort(l->points, (size_t)l->count, sizeof *l->points, by_x);
    LL_TRY(mark_front(l->points, l->count));
    return ll_plot_write(&(ll_plot){.title = title,
                                    .x_name = counted ? first->counter : "CPU time of a run, minimum, s",
                                    .y_name = first->error,
                                    .points = l->points,
                                    .count = l->count,
                                    .series = l->series,
                                    .series_count = l->series_count,
                                    .series_name = first->title,
                                    .log_x = true,
                                    .log_y = true,
                                    .apart = true,
                                    .joined = true,
                                    .width = 760,
                                    .height = 420,
                                    .write_name = write_point_name,
                                    .context = l->page,
                                    .where = l->where},
                         l->file);
}

static ll_status write_refinement_series(refinement_series *l)
{
    const ll_drawn_level *first = &l->page->refinement_levels[l->first];
    fputs("<h2>", l->file);
    ll_html_text(first->title, l->file);
    fputs(" by ", l->file);
    ll_html_text(first->setting, l->file);
    fputs("</h2>\n", l->file);
    ll_status status = write_plot(l, false, "Error against processor time");
    return ll_failed(&status) ? status : write_plot(l, true, "Error against counted cost");
}

/* ---- the page ---- */

static ll_status write_series(ll_refinement_series_page *page, const char *where, FILE *file)
{
    ll_status status = ll_ok();
    ll_plot_point *points = malloc((size_t)page->count * sizeof *points + 1);
    if (!points)
        return ll_error(LL_NO_MEMORY, "out of memory: plots");
    for (int i = 0; i < page->count && !ll_failed(&status);) {
        refinement_series l = {.page = page, .first = i, .points = points, .where = where, .file = file};
        while (i < page->count && page->refinement_levels[i].refinement_series ==
                                      page->refinement_levels[l.first].refinement_series)
            i++;
        l.count = i - l.first;
        status = write_refinement_series(&l);
    }
    free(points);
    return status;
}

ll_status ll_refinement_series_page_write(ll_refinement_series_page *page, const char *title,
                                          const char *command, const char *path)
{
    char where[400];
    FILE *file = page->short_of_memory ? NULL : fopen(path, "wb");
    if (!file)
        return page->short_of_memory ? ll_error(LL_NO_MEMORY, "out of memory: page")
                                     : ll_error(LL_IO, "cannot write %.200s", path);
    snprintf(where, sizeof where, "the rows of <code>%.300s</code>", command);
    ll_html_begin(title, file);
    fputs("<p>Left is cheap, low is accurate; each line is a method whose setting is varied. Marked points "
          "are the Pareto front: no other point is better in both. Failed runs and runs without a known "
          "error are not drawn. Times are of this machine.</p>\n",
          file);
    ll_status status = write_series(page, where, file);
    fputs("</body></html>\n", file);
    bool bad = fflush(file) != 0 || ferror(file);
    if ((fclose(file) != 0 || bad) && !ll_failed(&status))
        status = ll_error(LL_IO, "cannot write %.200s", path);
    return status;
}
