#include <stdlib.h>

#include "experiment/report/tradeoff_internal.h"

enum { WIDTH = 440, HEIGHT = 320, COLUMNS = 2, HEADING = 26, KEY_LINE = 18, KEY_COLUMNS = 4 };

static int methods_of(ll_tradeoff_drawing *d, int problem)
{
    ll_tradeoff_draw(d, problem, 0);
    return d->method_count;
}

static int height_of(const ll_tradeoff *t, int methods)
{
    int drawings = (ll_tradeoff_cost_count(t->family) + COLUMNS - 1) / COLUMNS;
    return HEADING + drawings * HEIGHT + (methods + KEY_COLUMNS - 1) / KEY_COLUMNS * KEY_LINE + HEADING / 2;
}

static void write_key(const ll_tradeoff_drawing *d, int y, FILE *file)
{
    for (int k = 0; k < d->method_count; k++) {
        double x = 14 + (COLUMNS * WIDTH - 14.) * (k % KEY_COLUMNS) / KEY_COLUMNS;
        double line = y + KEY_LINE * (k / KEY_COLUMNS + 0.5);
        ll_plot_draw_mark(k, x, line, file);
        fprintf(file, "<text x=\"%.1f\" y=\"%.1f\">", x + 10, line + 4);
        ll_html_text(d->methods[k], file);
        fputs("</text>\n", file);
    }
}

static ll_status write_problem(ll_tradeoff_drawing *d, int problem, int y, FILE *file)
{
    const ll_tradeoff_family *family = d->tradeoff->family;
    int costs = ll_tradeoff_cost_count(family);
    fprintf(file, "<text class=\"heading\" x=\"8\" y=\"%d\">", y + 17);
    ll_html_text(family->problems[problem].scenario, file);
    fputs(": ", file);
    ll_html_text(family->problems[problem].title, file);
    fputs("</text>\n", file);
    y += HEADING;
    for (int c = 0; c < costs; c++) {
        ll_tradeoff_draw(d, problem, c);
        d->plot.title = family->costs[c].title;
        d->plot.width = WIDTH;
        d->plot.height = HEIGHT;
        LL_TRY(ll_plot_draw_at(&d->plot, WIDTH * (c % COLUMNS), y + HEIGHT * (c / COLUMNS), file));
    }
    write_key(d, y + (costs + COLUMNS - 1) / COLUMNS * HEIGHT, file);
    return ll_ok();
}

static ll_status write_all(ll_tradeoff_drawing *d, FILE *file)
{
    const ll_tradeoff *t = d->tradeoff;
    int problems = ll_tradeoff_problem_count(t->family), height = 0, y = 0;
    for (int p = 0; p < problems; p++)
        height += height_of(t, methods_of(d, p));
    fprintf(file,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" width=\"%d\" height=\"%d\" "
            "role=\"img\" aria-label=\"",
            COLUMNS * WIDTH, height, COLUMNS * WIDTH, height);
    ll_html_text(t->family->title, file);
    fputs(": error against cost\"><style>", file);
    ll_html_plot_style(file);
    fputs("svg text.heading{font-weight:600}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
          file);
    for (int p = 0; p < problems; p++) {
        LL_TRY(write_problem(d, p, y, file));
        y += height_of(t, d->method_count);
    }
    fputs("</svg>\n", file);
    return ll_ok();
}

ll_status ll_tradeoff_image_write(const ll_tradeoff *t, const char *path)
{
    ll_tradeoff_drawing d = {.tradeoff = t, .points = malloc((size_t)t->count * sizeof(ll_plot_point) + 1)};
    FILE *file = d.points ? fopen(path, "wb") : NULL;
    ll_status status = file       ? write_all(&d, file)
                       : d.points ? ll_error(LL_IO, "cannot write %.200s", path)
                                  : ll_error(LL_NO_MEMORY, "out of memory: image");
    free(d.points);
    bool bad = file && (fflush(file) != 0 || ferror(file));
    if (file && (fclose(file) != 0 || bad) && !ll_failed(&status))
        status = ll_error(LL_IO, "cannot write %.200s", path);
    return status;
}
