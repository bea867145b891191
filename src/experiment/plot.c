#include "experiment/plot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEFT = 70, RIGHT = 14, TOP = 8, BOTTOM = 64 };

void ll_html_text(const char *text, FILE *file)
{
    for (; *text; text++) {
        switch (*text) {
        case '&':
            fputs("&amp;", file);
            break;
        case '<':
            fputs("&lt;", file);
            break;
        case '>':
            fputs("&gt;", file);
            break;
        case '"':
            fputs("&quot;", file);
            break;
        default:
            fputc(*text, file);
        }
    }
}

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

/* Room for this many labels; steps of 1, 2 or 5 times a power of ten, whole decades at least for a logarithm.
 */
static double step_of(const scale *s, int labels)
{
    double raw = (s->high - s->low) / labels, power = pow(10, floor(log10(raw))), lead = raw / power;
    double step = power * (lead <= 1 ? 1 : lead <= 2 ? 2 : lead <= 5 ? 5 : 10);
    return s->log ? fmax(1, ceil(step)) : step;
}

typedef void draw_tick(FILE *file, const ll_plot *plot, double at, const char *label);

static void tick_x(FILE *file, const ll_plot *plot, double at, const char *label)
{
    fprintf(
        file,
        "<path class=\"g\" d=\"M%.1f %dV%d\"/><text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%s</text>\n",
        at, TOP, plot->height - BOTTOM, at, plot->height - BOTTOM + 15, label);
}

/* Names are long: they lean. */
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
    double step = step_of(s, labels);
    int drawn = 0;
    for (double k = ceil(s->low / step); k * step <= s->high; k++, drawn++) {
        char label[32];
        double value = s->log ? pow(10, k * step) : k * step;
        snprintf(label, sizeof label, "%.4g", value == 0 ? 0 : value);
        tick(file, plot, position(s, value), label);
    }
    for (int end = 0; drawn < 2 && end < 2; end++) { /* less than two decades: both ends are told */
        char label[32];
        double value = end ? s->high : s->low;
        value = s->log ? pow(10, value) : value;
        snprintf(label, sizeof label, "%.3g", value);
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

static void draw_points(FILE *file, const ll_plot *plot, const scale *x, const scale *y)
{
    bool begun = false;
    fputs("<path class=\"front\" d=\"", file);
    for (int i = 0; i < plot->count; i++) {
        const ll_plot_point *p = &plot->points[i];
        if (!p->front || plot->apart || !drawable(p))
            continue;
        fprintf(file, "%c%.1f %.1f", begun ? 'L' : 'M', position(x, p->x), position(y, p->y));
        begun = true;
    }
    fputs("\"/>\n", file);
    for (int i = 0; i < plot->count; i++) {
        const ll_plot_point *p = &plot->points[i];
        if (!drawable(p))
            continue;
        double px = position(x, p->x), py = position(y, p->y);
        double lowest = plot->height - BOTTOM;
        if (p->low < p->high)
            fprintf(file, "<path class=\"ci\" d=\"M%.1f %.1fV%.1f\"/>", px,
                    y->log && p->low <= 0 ? lowest : fmin(position(y, p->low), lowest),
                    isinf(p->high) ? TOP : fmax(position(y, p->high), TOP));
        fprintf(file, "<circle%s cx=\"%.1f\" cy=\"%.1f\" r=\"%s\"><title>", p->front ? " class=\"on\"" : "",
                px, py, p->front ? "4.5" : "3");
        ll_html_text(p->name, file);
        fputs("</title></circle>\n", file);
    }
}

static void draw_choices(FILE *file, const ll_plot *plot, const scale *x)
{
    double last = -1;
    for (int i = 0; i < plot->count; i++)
        if (plot->points[i].x > last) {
            last = plot->points[i].x;
            tick_choice(file, plot, position(x, last), plot->points[i].label);
        }
}

static void draw(FILE *file, const ll_plot *plot)
{
    double low, high;
    extremes(plot, true, &low, &high);
    scale x = make_scale(low, high, plot->log_x && above_zero(plot, true), LEFT, plot->width - LEFT - RIGHT);
    extremes(plot, false, &low, &high);
    scale y = make_scale(low, high, plot->log_y && above_zero(plot, false), plot->height - BOTTOM,
                         -(plot->height - BOTTOM - TOP));
    fprintf(file, "<svg viewBox=\"0 0 %d %d\" width=\"%d\" role=\"img\" aria-label=\"", plot->width,
            plot->height, plot->width);
    ll_html_text(plot->title, file);
    fputs("\">\n", file);
    if (plot->points[0].label)
        draw_choices(file, plot, &x);
    else
        draw_axis(file, plot, &x, plot->width / 110, tick_x);
    draw_axis(file, plot, &y, plot->height / 55, tick_y);
    draw_points(file, plot, &x, &y);
    fprintf(file, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">", (LEFT + plot->width - RIGHT) / 2,
            plot->height - 8);
    ll_html_text(plot->x_name, file);
    fprintf(file, "%s</text>\n<text transform=\"translate(14 %d) rotate(-90)\" text-anchor=\"middle\">",
            x.log ? " (log)" : "", (TOP + plot->height - BOTTOM) / 2);
    ll_html_text(plot->y_name, file);
    fprintf(file, "%s</text></svg>\n", y.log ? " (log)" : "");
}

/* ---- the table ---- */

static void write_cell(FILE *file, double value)
{
    if (isfinite(value))
        fprintf(file, "<td>%.6g</td>", value);
    else
        fputs("<td>none</td>", file);
}

static void write_table(FILE *file, const ll_plot *plot)
{
    fputs("<div class=\"data\"><table><thead><tr><th>Point</th><th>", file);
    ll_html_text(plot->x_name, file);
    fputs("</th><th>", file);
    ll_html_text(plot->y_name, file);
    fputs("</th><th>95 % from</th><th>to</th></tr></thead><tbody>\n", file);
    for (int i = 0; i < plot->count; i++) {
        const ll_plot_point *p = &plot->points[i];
        fprintf(file, "<tr%s><td class=\"l\">", p->front ? " class=\"on\"" : "");
        ll_html_text(p->name, file);
        fputs("</td>", file);
        if (p->label) {
            fputs("<td>", file);
            ll_html_text(p->label, file);
            fputs("</td>", file);
        } else {
            write_cell(file, p->x);
        }
        write_cell(file, p->y);
        write_cell(file, p->low);
        write_cell(file, p->high);
        fputs("</tr>\n", file);
    }
    fputs("</tbody></table></div>\n", file);
}

void ll_plot_write(const ll_plot *plot, FILE *file)
{
    bool any = false;
    for (int i = 0; i < plot->count; i++)
        any |= drawable(&plot->points[i]);
    fputs("<figure><figcaption>", file);
    ll_html_text(plot->title, file);
    fputs("</figcaption>\n", file);
    if (any)
        draw(file, plot);
    else
        fputs("<p>There is no value to draw.</p>\n", file);
    write_table(file, plot);
    fputs("</figure>\n", file);
}
