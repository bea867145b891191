#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/report/tradeoff_internal.h"

typedef struct text_end {
    char *text;
    int size, used;
} text_end;

static void add(text_end *t, const char *text)
{
    for (; *text && t->used + 1 < t->size; text++)
        t->text[t->used++] = *text;
    t->text[t->used] = '\0';
}

/* As encodeURIComponent, so that the page reads what it writes itself. */
static void add_encoded(text_end *t, const char *text, int length)
{
    static const char hex[] = "0123456789ABCDEF", plain[] = "-_.!~*'()";
    for (int i = 0; i < length; i++) {
        unsigned char c = (unsigned char)text[i];
        bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
        char code[] = {'%', hex[c >> 4], hex[c & 15], '\0'}, one[] = {(char)c, '\0'};
        add(t, letter || (c && strchr(plain, c)) ? one : code);
    }
}

void ll_tradeoff_address(const ll_tradeoff *tradeoff, const ll_tradeoff_row *row, const char *page,
                         char *text, int size)
{
    text_end t = {text, size, 0};
    add(&t, page);
    add(&t, "?scenario=");
    add(&t, tradeoff->family->problems[row->problem].scenario);
    for (const char *pair = row->sets; *pair;) {
        int length = (int)strcspn(pair, " "), name = (int)strcspn(pair, "=");
        add(&t, "&set=");
        add_encoded(&t, pair, name);
        add(&t, ":");
        add_encoded(&t, pair + name + 1, length - name - 1);
        pair += length + (pair[length] == ' ');
    }
    if (row->random) {
        char seed[32];
        snprintf(seed, sizeof seed, "&seed=%lld", (long long)row->values.seed);
        add(&t, seed);
    }
}

/* ---- points ---- */

static void write_name(const void *context, int64_t point, FILE *file)
{
    const ll_tradeoff_row *row = &((const ll_tradeoff_drawing *)context)->tradeoff->rows[point];
    const char *setting = strrchr(row->setting, '.');
    ll_html_text(row->method, file);
    fputs(", ", file);
    ll_html_text(setting ? setting + 1 : row->setting, file);
    fprintf(file, " %.6g", strtod(row->value, NULL));
}

static void write_address(const void *context, int64_t point, FILE *file)
{
    const ll_tradeoff_drawing *d = context;
    char text[1500];
    ll_tradeoff_address(d->tradeoff, &d->tradeoff->rows[point], d->address, text, sizeof text);
    ll_html_text(text, file);
}

static int method_of(ll_tradeoff_drawing *d, const char *name)
{
    int k = 0;
    while (k < d->method_count && strcmp(d->methods[k], name) != 0)
        k++;
    if (k == d->method_count && k < LL_TRADEOFF_METHODS_MAX)
        d->methods[d->method_count++] = name;
    return k < LL_TRADEOFF_METHODS_MAX ? k : LL_TRADEOFF_METHODS_MAX - 1;
}

static int by_x(const void *a, const void *b)
{
    const ll_plot_point *p = a, *q = b;
    return (p->x > q->x) - (p->x < q->x);
}

static bool is_chosen(const ll_tradeoff *t, int row, int cost)
{
    for (int i = 0; i < t->choice_count; i++)
        if (t->choices[i].row == row && t->choices[i].cost == cost)
            return true;
    return false;
}

/* Means over seeds may be 0, and the axis is linear then. A single error of 0 would make an axis of many
 * decades linear, and is left out. */
static void add_points(ll_tradeoff_drawing *d, int problem, int cost)
{
    int line = 0; /* one per setting that is varied */
    for (int i = 0; i < d->tradeoff->count; i++) {
        const ll_tradeoff_row *row = &d->tradeoff->rows[i];
        const ll_tradeoff_values *v = &row->values;
        if (row->problem != problem)
            continue;
        d->rows++;
        int series = method_of(d, row->method);
        line += i > 0 && strcmp(row->setting, d->tradeoff->rows[i - 1].setting) != 0;
        if (!isfinite(v->error.value) || !isfinite(v->costs[cost].value))
            continue;
        d->points[d->count++] = (ll_plot_point){.x = v->costs[cost].value,
                                                .y = v->error.value > 0 || row->random ? v->error.value : NAN,
                                                .low = row->random ? v->error.low : NAN,
                                                .high = row->random ? v->error.high : NAN,
                                                .point = i,
                                                .series = series,
                                                .line = line,
                                                .front = row->front[cost],
                                                .chosen = is_chosen(d->tradeoff, i, cost)};
    }
    qsort(d->points, (size_t)d->count, sizeof *d->points, by_x);
}

void ll_tradeoff_draw(ll_tradeoff_drawing *d, int problem, int cost)
{
    const ll_tradeoff *t = d->tradeoff;
    d->count = d->rows = d->method_count = d->level_count = 0;
    add_points(d, problem, cost);
    for (int i = 0; i < t->choice_count && d->level_count < LL_FRONT_LEVELS; i++)
        if (t->choices[i].problem == problem && t->choices[i].cost == cost)
            d->levels[d->level_count++] = t->choices[i].level;
    d->plot = (ll_plot){.x_name = t->family->costs[cost].title,
                        .y_name = t->family->problems[problem].title,
                        .points = d->points,
                        .count = d->count,
                        .series = d->methods,
                        .series_count = d->method_count,
                        .series_name = "method",
                        .log_x = true,
                        .log_y = true,
                        .joined = true,
                        .apart = true,
                        .write_name = write_name,
                        .write_address = d->address ? write_address : NULL,
                        .context = d,
                        .levels = d->levels,
                        .level_count = d->level_count};
}
