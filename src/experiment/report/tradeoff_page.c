#include "experiment/report/tradeoff_page.h"

#include <stdlib.h>

#include "experiment/report/tradeoff_internal.h"

/* ---- the table of choices ---- */

static void write_row_name(const ll_tradeoff_drawing *d, int row, FILE *file)
{
    if (row < 0) {
        fputs("none", file);
        return;
    }
    fputs("<a href=\"", file);
    d->plot.write_address(d, row, file);
    fputs("\">", file);
    d->plot.write_name(d, row, file);
    fputs("</a>", file);
}

static void write_choice(const ll_tradeoff_drawing *d, const ll_tradeoff_choice *c, FILE *file)
{
    const ll_tradeoff *t = d->tradeoff;
    fputs("<tr><td class=\"l\">", file);
    ll_html_text(t->family->costs[c->cost].title, file);
    fprintf(file, "</td><td>%.2g</td><td class=\"l\">", c->level);
    write_row_name(d, c->row, file);
    fputs("</td>", file);
    if (c->row >= 0) {
        const ll_tradeoff_values *v = &t->rows[c->row].values;
        fprintf(file, "<td>%.4g</td><td>%.4g</td><td>%.4g</td>", v->error.value, v->error.high,
                v->costs[c->cost].value);
    } else {
        fputs("<td></td><td></td><td></td>", file);
    }
    fprintf(file, "<td class=\"l\">%s</td><td class=\"l\">", ll_tradeoff_verdict(c));
    ll_html_text(c->why, file);
    fputs("</td><td class=\"l\">", file);
    ll_html_text(c->tied, file);
    fputs("</td></tr>\n", file);
}

static void write_choices(const ll_tradeoff_drawing *d, int problem, FILE *file)
{
    const ll_tradeoff *t = d->tradeoff;
    fputs("<table><thead><tr><th>Cost</th><th>Error at most</th><th>Cheapest</th><th>Its "
          "error</th><th>95 % to</th><th>Its cost</th><th>Measured again</th><th>Figures</th><th>As "
          "cheap</th></tr></thead><tbody>\n",
          file);
    for (int i = 0; i < t->choice_count; i++)
        if (t->choices[i].problem == problem)
            write_choice(d, &t->choices[i], file);
    fputs("</tbody></table>\n", file);
}

/* ---- families ---- */

static ll_status write_problem(ll_tradeoff_drawing *d, int problem, FILE *file)
{
    const ll_tradeoff_family *family = d->tradeoff->family;
    fputs("<h3>", file);
    ll_html_text(family->problems[problem].scenario, file);
    fputs(": ", file);
    ll_html_text(family->problems[problem].title, file);
    fputs("</h3>\n", file);
    ll_tradeoff_draw(d, problem, 0);
    write_choices(d, problem, file);
    for (int c = 0; c < ll_tradeoff_cost_count(family); c++) {
        ll_tradeoff_draw(d, problem, c);
        d->plot.title = family->costs[c].title;
        d->plot.width = 760;
        d->plot.height = 420;
        d->plot.where = "the rows of <code>--out</code>";
        LL_TRY(ll_plot_write(&d->plot, file));
    }
    return ll_ok();
}

static ll_status write_family(const ll_tradeoff *t, const char *address, FILE *file)
{
    ll_tradeoff_drawing d = {
        .tradeoff = t, .address = address, .points = malloc((size_t)t->count * sizeof(ll_plot_point) + 1)};
    ll_status status = d.points ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: plots");
    fprintf(file, "<h2 id=\"%s\">", t->family->name);
    ll_html_text(t->family->title, file);
    fputs("</h2>\n<p>", file);
    ll_html_text(t->family->text, file);
    fputs("</p>\n", file);
    for (int p = 0; p < ll_tradeoff_problem_count(t->family) && !ll_failed(&status); p++)
        status = write_problem(&d, p, file);
    free(d.points);
    return status;
}

static void write_introduction(const ll_tradeoff_page *page, FILE *file)
{
    fputs("<p>Left is cheap, low is accurate. Marked points are the Pareto front: no other point is better "
          "in both. Dashed lines are three levels of error, in equal steps on a logarithmic scale between "
          "the least and the largest upper bound on the fronts of the counted costs, rounded up. A ring is "
          "the cheapest setting whose 95 % interval ends within a level. Then every setting was measured "
          "again, those with randomness on fresh seeds: a choice holds if it is within the level again and "
          "nothing else within it is cheaper beyond the intervals of both. Costs of what is as cheap do not "
          "differ "
          "certainly. A point leads to a live session. Times are of this machine. Repeated by <code>",
          file);
    ll_html_text(page->command, file);
    fputs("</code>.</p>\n", file);
}

ll_status ll_tradeoff_page_write(const ll_tradeoff_page *page, const char *path)
{
    ll_status status = ll_ok();
    FILE *file = fopen(path, "wb");
    if (!file)
        return ll_error(LL_IO, "cannot write %.200s", path);
    ll_html_begin("Speed against error", file);
    write_introduction(page, file);
    for (int i = 0; i < page->count && !ll_failed(&status); i++)
        status = write_family(&page->families[i], page->address, file);
    fputs("</body></html>\n", file);
    bool bad = fflush(file) != 0 || ferror(file);
    if ((fclose(file) != 0 || bad) && !ll_failed(&status))
        status = ll_error(LL_IO, "cannot write %.200s", path);
    return status;
}
