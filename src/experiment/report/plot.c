#include "experiment/report/plot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEFT = 70, RIGHT = 14, TOP = 8, BOTTOM = 64 };

/* ---- axes ---- */

typedef struct scale {
    bool log;
    double low, high;  /* of values, or of their logarithms */
    double from, size; /* pixels */
} scale;

static double position(const scale *s, double value)
{
    return s->from + s->size * ((s->log ? log10(value) : value) - s->low) / (s->high - s->low);
}

static scale make_scale(double low, double high, bool logarithmic, double from, double size)
{
    scale s = {.log = logarithmic, .low = low, .high = high, .from = from, .size = size};
    if (s.log) {
        s.low = log10(low);
        s.high = log10(high);
    }
    double margin = s.high > s.low ? 0.04 * (s.high - s.low) : s.log ? 0.5 : fmax(fabs(s.low) * 0.1, 0.5);
    s.low -= margin;
    s.high += margin;
    return s;
}

/* Step for at most `labels` labels: 1, 2 or 5 times a power of ten; for a logarithmic axis at least whole
 * decades. */
static double step_of(const scale *s, int labels)
{
    double raw = (s->high - s->low) / labels, power = pow(10, floor(log10(raw))), lead = raw / power;
    double step = power * (lead <= 1 ? 1 : lead <= 2 ? 2 : lead <= 5 ? 5 : 10);
    return s->log ? fmax(1, ceil(step)) : step;
}

typedef void draw_tick(FILE *file, const ll_plot *plot, double at, const char *label);

static void tick_x(FILE *file, const ll_plot *plot, double at, const char *label)
{
    fprintf(file,
            "<path class=\"g\" d=\"M%.1f %dV%d\"/><text x=\"%.1f\" y=\"%d\" text-anchor=\"%s\">%s</text>\n",
            at, TOP, plot->height - BOTTOM, at, plot->height - BOTTOM + 15,
            at > plot->width - 2 * RIGHT ? "end" : "middle", label);
}

/* Slanted: names are long. */
static void tick_choice(FILE *file, const ll_plot *plot, double at, const char *label)
{
    int y = plot->height - BOTTOM + 12;
    fprintf(file,
            "<path class=\"g\" d=\"M%.1f %dV%d\"/><text x=\"%.1f\" y=\"%d\" transform=\"rotate(-18 %.1f "
            "%d)\" text-anchor=\"end\">",
            at, TOP, plot->height - BOTTOM, at + 4, y, at + 4, y);
    ll_html_text(label, file);
    fputs("</text>\n", file);
}

static void tick_y(FILE *file, const ll_plot *plot, double at, const char *label)
{
    fprintf(file,
            "<path class=\"g\" d=\"M%d %.1fH%d\"/><text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%s</text>\n",
            LEFT, at, plot->width - RIGHT, LEFT - 6, at + 4, label);
}

static void draw_axis(FILE *file, const ll_plot *plot, const scale *s, int labels, draw_tick *tick)
{
    double step = step_of(s, labels), only = 0; /* position of the last label */
    int drawn = 0;
    for (double k = ceil(s->low / step); k * step <= s->high; k++, drawn++) {
        char label[32];
        double value = s->log ? pow(10, k * step) : k * step;
        snprintf(label, sizeof label, "%.4g", value == 0 ? 0 : value);
        only = position(s, value);
        tick(file, plot, only, label);
    }
    for (int end = 0; drawn < 2 && end < 2; end++) { /* less than two decades: labels both ends */
        char label[32];
        double value = end ? s->high : s->low;
        value = s->log ? pow(10, value) : value;
        snprintf(label, sizeof label, value >= 1000 && value < 1e6 ? "%.0f" : "%.3g", value);
        if (drawn == 0 || fabs(position(s, value) - only) > fabs(s->size) / 6)
            tick(file, plot, position(s, value), label);
    }
}

/* ---- points ---- */

static bool drawable(const ll_plot_point *p)
{
    return isfinite(p->x) && isfinite(p->y);
}

static bool above_zero(const ll_plot *plot, bool x)
{
    for (int i = 0; i < plot->count; i++)
        if (drawable(&plot->points[i]) && (x ? plot->points[i].x : plot->points[i].y) <= 0)
            return false;
    return true;
}

static void extremes(const ll_plot *plot, bool x, double *low, double *high)
{
    *low = INFINITY;
    *high = -INFINITY;
    for (int i = 0; i < plot->count; i++) {
        if (!drawable(&plot->points[i]))
            continue;
        double value = x ? plot->points[i].x : plot->points[i].y;
        *low = fmin(*low, value);
        *high = fmax(*high, value);
    }
}

/* ---- marks ---- */

/* A mark: one point, or several close points of a series. */
typedef struct mark {
    double x, y; /* px: of the mean */
    int count, first;
} mark;

typedef struct marks {
    mark *marks;
    int count;
    double cell; /* px: points closer than that share a mark; 0: one mark per point */
} marks;

/* Assignment of points to cells. */
typedef struct cells {
    int columns, rows, series;
    int *of; /* index of each cell's mark; -1: none yet */
} cells;

static int *cell_of(const cells *c, const ll_plot_point *p, double x, double y, double size)
{
    int column = (int)fmin(fmax(x / size, 0), c->columns - 1),
        row = (int)fmin(fmax(y / size, 0), c->rows - 1);
    return &c->of[((row * c->columns + column) * c->series + p->series) * 2 + p->front];
}

/* Groups points into marks by cells of this size; false: too many marks, or no memory. */
static int marks_max(const ll_plot *plot)
{
    return plot->marks_max ? plot->marks_max : LL_PLOT_MARKS_MAX;
}

static ll_status gather(const ll_plot *plot, const scale *sx, const scale *sy, double size, marks *m)
{
    cells c = {1, 1, plot->series_count > 0 ? plot->series_count : 1, NULL};
    if (size > 0) {
        c.columns = (int)(plot->width / size) + 1;
        c.rows = (int)(plot->height / size) + 1;
        size_t all = (size_t)(c.columns * c.rows * c.series * 2);
        if (!(c.of = malloc(all * sizeof *c.of)))
            return ll_error(LL_NO_MEMORY, "out of memory: plot");
        memset(c.of, 0xff, all * sizeof *c.of);
    }
    *m = (marks){.marks = m->marks, .cell = size};
    for (int i = 0; i < plot->count && m->count <= marks_max(plot); i++) {
        const ll_plot_point *p = &plot->points[i];
        if (!drawable(p))
            continue;
        double x = position(sx, p->x), y = position(sy, p->y);
        int *cell = c.of ? cell_of(&c, p, x, y, size) : NULL, at = cell && *cell >= 0 ? *cell : m->count;
        if (at == m->count) {
            if (m->count++ == marks_max(plot))
                break;
            m->marks[at] = (mark){.first = i};
        }
        if (cell)
            *cell = at;
        mark *one = &m->marks[at];
        one->count++;
        one->x += (x - one->x) / one->count;
        one->y += (y - one->y) / one->count;
    }
    free(c.of);
    return ll_ok();
}

/* One mark per point if these are few enough, else the smallest cells that give few enough marks. */
static ll_status make_marks(const ll_plot *plot, const scale *x, const scale *y, marks *m)
{
    *m = (marks){.marks = malloc(LL_PLOT_MARKS_MAX * sizeof *m->marks)};
    ll_status status = m->marks ? gather(plot, x, y, 0, m) : ll_error(LL_NO_MEMORY, "out of memory: plot");
    for (double size = 4; !ll_failed(&status) && m->count > marks_max(plot); size *= 1.25)
        status = gather(plot, x, y, size, m);
    return status;
}

static void draw_interval(FILE *file, const ll_plot *plot, const scale *y, const ll_plot_point *p, double px)
{
    double lowest = plot->height - BOTTOM;
    if (p->low < p->high)
        fprintf(file, "<path class=\"ci\" d=\"M%.1f %.1fV%.1f\"/>", px,
                y->log && p->low <= 0 ? lowest : fmin(position(y, p->low), lowest),
                isinf(p->high) ? TOP : fmax(position(y, p->high), TOP));
}

/* Circle, square, triangle or diamond, by series. */
static void draw_shape(FILE *file, int series, const char *more, double x, double y, double r)
{
    static const char *const shapes[] = {
        "M%.1f %.1fm-%.1f 0a%.1f %.1f 0 1 0 %.1f 0a%.1f %.1f 0 1 0 -%.1f 0z",
        "M%.1f %.1fm-%.1f -%.1fh%.1fv%.1fh-%.1fz",
        "M%.1f %.1fm0 -%.1fl%.1f %.1fh-%.1fz",
        "M%.1f %.1fm0 -%.1fl%.1f %.1fl-%.1f %.1fl-%.1f -%.1fz",
    };
    double d = 2 * r, s = 0.9 * r, t = 1.2 * r;
    int shape = (series + series / LL_PLOT_COLOURS) % 4;
    fprintf(file, "<path class=\"s s%d%s\" d=\"", series % LL_PLOT_COLOURS, more);
    if (shape == 0)
        fprintf(file, shapes[0], x, y, r, r, r, d, r, r, d);
    else if (shape == 1)
        fprintf(file, shapes[1], x, y, s, s, 2 * s, 2 * s, 2 * s);
    else if (shape == 2)
        fprintf(file, shapes[2], x, y, t, t, 2 * t, 2 * t);
    else
        fprintf(file, shapes[3], x, y, t, t, t, t, t, t, t);
    fputs("\">", file);
}

/* Of a single point. */
static bool begin_address(FILE *file, const ll_plot *plot, const ll_plot_point *p, int count)
{
    if (!plot->write_address || count > 1)
        return false;
    fputs("<a href=\"", file);
    plot->write_address(plot->context, p->point, file);
    fputs("\">", file);
    return true;
}

static void draw_mark(FILE *file, const ll_plot *plot, const scale *y, const mark *m)
{
    const ll_plot_point *p = &plot->points[m->first];
    if (m->count == 1)
        draw_interval(file, plot, y, p, m->x);
    double r = fmin((p->front ? 4.5 : 3) + 0.5 * log2(m->count), 8);
    if (p->chosen)
        fprintf(file, "<circle class=\"chosen\" cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\"/>", m->x, m->y, r + 4);
    bool leads = begin_address(file, plot, p, m->count);
    draw_shape(file, p->series, p->front ? " on" : "", m->x, m->y, r);
    fputs("<title>", file);
    if (m->count > 1) {
        ll_html_count(m->count, file);
        fputs(" points, such as ", file);
    }
    plot->write_name(plot->context, p->point, file);
    fputs(leads ? "</title></path></a>\n" : "</title></path>\n", file);
}

/* ---- lines ---- */

static void draw_front(FILE *file, const ll_plot *plot, const scale *x, const scale *y)
{
    bool started = false;
    char last[40] = "";
    for (int i = 0; i < plot->count; i++) {
        const ll_plot_point *p = &plot->points[i];
        char at[40];
        if (!p->front || plot->apart || !drawable(p))
            continue;
        snprintf(at, sizeof at, "%.0f %.0f", position(x, p->x), position(y, p->y));
        if (strcmp(at, last) == 0)
            continue;
        fprintf(file, "%s%s", started ? "L" : "<path class=\"front\" d=\"M", at);
        snprintf(last, sizeof last, "%s", at);
        started = true;
    }
    fputs(started ? "\"/>\n" : "", file);
}

/* The point of the series with the smallest number above `after`; NULL: none. */
static const ll_plot_point *next_of(const ll_plot *plot, int series, int64_t after)
{
    const ll_plot_point *found = NULL;
    for (int i = 0; i < plot->count; i++) {
        const ll_plot_point *p = &plot->points[i];
        if (p->series == series && p->point > after && drawable(p) && (!found || p->point < found->point))
            found = p;
    }
    return found;
}

static void draw_series(FILE *file, const ll_plot *plot, int series, const scale *x, const scale *y)
{
    const ll_plot_point *p = next_of(plot, series, -1);
    if (!p)
        return;
    fprintf(file, "<path class=\"line s%d\" d=\"", series % LL_PLOT_COLOURS);
    for (const ll_plot_point *before = NULL; p; before = p, p = next_of(plot, series, p->point))
        fprintf(file, "%c%.1f %.1f", before && before->line == p->line ? 'L' : 'M', position(x, p->x),
                position(y, p->y));
    fputs("\"/>\n", file);
}

static void draw_levels(FILE *file, const ll_plot *plot, const scale *y)
{
    for (int k = 0; k < plot->level_count; k++) {
        double at = position(y, plot->levels[k]);
        if (at >= TOP && at <= plot->height - BOTTOM)
            fprintf(file,
                    "<path class=\"level\" d=\"M%d %.1fH%d\"/><text x=\"%d\" y=\"%.1f\" "
                    "text-anchor=\"end\">%.2g</text>\n",
                    LEFT, at, plot->width - RIGHT, plot->width - RIGHT, at - 3, plot->levels[k]);
    }
}

static ll_status draw_points(FILE *file, const ll_plot *plot, const scale *x, const scale *y, marks *m)
{
    LL_TRY(make_marks(plot, x, y, m));
    for (int k = 0; k < plot->series_count && plot->joined && m->cell == 0; k++)
        draw_series(file, plot, k, x, y);
    draw_front(file, plot, x, y);
    for (int on = 0; on < 2; on++) /* the front is drawn last */
        for (int i = 0; i < m->count; i++)
            if (plot->points[m->marks[i].first].front == on)
                draw_mark(file, plot, y, &m->marks[i]);
    return ll_ok();
}

static void draw_choices(FILE *file, const ll_plot *plot, const scale *x)
{
    for (int k = 0; k < plot->choice_count; k++)
        tick_choice(file, plot, position(x, k), plot->choices[k]);
}

/* Key of the series, and a note when marks have several points. */
static void write_key(FILE *file, const ll_plot *plot, const marks *m)
{
    if (plot->series_count > 1) {
        fputs("<p class=\"key note\">", file);
        ll_html_text(plot->series_name, file);
        fputs(": ", file);
    }
    for (int k = 0; k < plot->series_count && plot->series_count > 1; k++) {
        fputs("<span><svg width=\"14\" height=\"14\">", file);
        draw_shape(file, k, "", 7, 7, 4);
        fputs("</path></svg> ", file);
        ll_html_text(plot->series[k], file);
        fputs("</span>", file);
    }
    fputs(plot->series_count > 1 ? "</p>\n" : "", file);
    int points = 0;
    for (int i = 0; i < m->count; i++)
        points += m->marks[i].count;
    if (points == m->count)
        return;
    fputs("<p class=\"note\">", file);
    ll_html_count(points, file);
    fputs(" points are drawn as ", file);
    ll_html_count(m->count, file);
    fprintf(
        file,
        " marks: points within %.3g px of each other share one, which is larger the more there are.</p>\n",
        m->cell);
}

/* The attributes `at` place it in another drawing. */
static ll_status draw(FILE *file, const ll_plot *plot, const char *at, marks *m)
{
    double low, high;
    extremes(plot, true, &low, &high);
    scale x = make_scale(plot->choices ? 0 : low, plot->choices ? plot->choice_count - 1 : high,
                         plot->log_x && above_zero(plot, true), LEFT, plot->width - LEFT - RIGHT);
    extremes(plot, false, &low, &high);
    scale y = make_scale(low, high, plot->log_y && above_zero(plot, false), plot->height - BOTTOM,
                         -(plot->height - BOTTOM - TOP));
    fprintf(file, "<svg viewBox=\"0 0 %d %d\" width=\"%d\"%s role=\"img\" aria-label=\"", plot->width,
            plot->height, plot->width, at);
    ll_html_text(plot->title, file);
    fputs("\">\n", file);
    if (plot->choices)
        draw_choices(file, plot, &x);
    else
        draw_axis(file, plot, &x, plot->width / 110, tick_x);
    draw_axis(file, plot, &y, plot->height / 55, tick_y);
    draw_levels(file, plot, &y);
    ll_status status = draw_points(file, plot, &x, &y, m);
    fprintf(file, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">", (LEFT + plot->width - RIGHT) / 2,
            plot->height - 8);
    ll_html_text(plot->x_name, file);
    fprintf(file, "%s</text>\n<text transform=\"translate(14 %d) rotate(-90)\" text-anchor=\"middle\">",
            x.log ? " (log)" : "", (TOP + plot->height - BOTTOM) / 2);
    ll_html_text(plot->y_name, file);
    fprintf(file, "%s</text></svg>\n", y.log ? " (log)" : "");
    return status;
}

static bool has_points(const ll_plot *plot)
{
    bool any = false;
    for (int i = 0; i < plot->count; i++)
        any |= drawable(&plot->points[i]);
    return any;
}

ll_status ll_plot_draw_at(const ll_plot *plot, double x, double y, FILE *file)
{
    char at[96];
    marks m = {0};
    snprintf(at, sizeof at, " height=\"%d\" x=\"%.0f\" y=\"%.0f\"", plot->height, x, y);
    ll_status status = has_points(plot) ? draw(file, plot, at, &m) : ll_ok();
    free(m.marks);
    return status;
}

void ll_plot_draw_mark(int series, double x, double y, FILE *file)
{
    draw_shape(file, series, "", x, y, 4);
    fputs("</path>", file);
}

/* ---- the table ---- */

static void write_every(int every, const char *of, FILE *file)
{
    if (every == 1)
        fprintf(file, "%s", of);
    else if (every > 1)
        fprintf(file, "one in %d of %s", every, of);
}

void ll_plot_shown(const ll_choice *choice, int count, const char *where, FILE *file)
{
    if (choice->shown == count)
        return;
    fputs("<p class=\"note\">", file);
    ll_html_count(choice->shown, file);
    fputs(" of ", file);
    ll_html_count(count, file);
    fputs(" points are listed: ", file);
    write_every(choice->every_first, "those on the front", file);
    fputs(choice->every_first && choice->every_other ? " and " : "", file);
    write_every(choice->every_other, choice->every_first ? "the others" : "all", file);
    fprintf(file, ". All are in %s.</p>\n", where);
}

static void write_cell(FILE *file, double value)
{
    if (isfinite(value))
        fprintf(file, "<td>%.6g</td>", value);
    else
        fputs("<td>none</td>", file);
}

static void write_row(FILE *file, const ll_plot *plot, const ll_plot_point *p)
{
    fprintf(file, "<tr%s><td class=\"l\">", p->front ? " class=\"on\"" : "");
    bool leads = begin_address(file, plot, p, 1);
    plot->write_name(plot->context, p->point, file);
    fputs(leads ? "</a></td>" : "</td>", file);
    if (plot->choices) {
        fputs("<td>", file);
        ll_html_text(plot->choices[(int)p->x], file);
        fputs("</td>", file);
    } else {
        write_cell(file, p->x);
    }
    write_cell(file, p->y);
    write_cell(file, p->low);
    write_cell(file, p->high);
    fputs("</tr>\n", file);
}

static ll_status write_table(FILE *file, const ll_plot *plot)
{
    bool *front = malloc((size_t)plot->count + 1), *shown = malloc((size_t)plot->count + 1);
    if (!front || !shown) {
        free(front);
        free(shown);
        return ll_error(LL_NO_MEMORY, "out of memory: table");
    }
    for (int i = 0; i < plot->count; i++)
        front[i] = plot->points[i].front;
    ll_choice choice =
        ll_choose_shown(front, plot->count, plot->rows_max ? plot->rows_max : LL_PLOT_ROWS_MAX, shown);
    fputs("<div class=\"data\"><table><thead><tr><th>Point</th><th>", file);
    ll_html_text(plot->x_name, file);
    fputs("</th><th>", file);
    ll_html_text(plot->y_name, file);
    fputs("</th><th>95 % from</th><th>to</th></tr></thead><tbody>\n", file);
    for (int i = 0; i < plot->count; i++)
        if (shown[i])
            write_row(file, plot, &plot->points[i]);
    fputs("</tbody></table></div>\n", file);
    ll_plot_shown(&choice, plot->count, plot->where, file);
    free(front);
    free(shown);
    return ll_ok();
}

ll_status ll_plot_write(const ll_plot *plot, FILE *file)
{
    marks m = {0};
    ll_status status = ll_ok();
    fputs("<figure><figcaption>", file);
    ll_html_text(plot->title, file);
    fputs("</figcaption>\n", file);
    if (has_points(plot))
        status = draw(file, plot, "", &m);
    else
        fputs("<p>No values to draw.</p>\n", file);
    if (!ll_failed(&status) && m.count > 0)
        write_key(file, plot, &m);
    free(m.marks);
    LL_THEN(status, write_table(file, plot));
    fputs("</figure>\n", file);
    return status;
}
