/* Runs of the adviser, and the test whether fresh seeds show that a setting holds. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/detmath.h"
#include "base/rng.h"
#include "experiment/advise/internal.h"

#define LOOKS 1.2       /* factor that widens an interval that is checked several times, to keep its level */
#define ROOMY 7         /* (limit - mean)^2 / variance from which the fewest seeds are enough */
#define ROOM 12         /* factor for the needed seeds otherwise */
#define NEVER_SEEN 3.7  /* bound of the expected events when none was seen, at 97.5 % (Poisson) */
#define UNSEEN 1.92     /* bound when k were seen: k + this + 1.96 sqrt(k + 1) */
#define FEW 30          /* events, up to which Student's t is too narrow */
#define WHOLE 1e-6      /* relative distance at which a count is a multiple of the smallest */
#define MOST_EVENTS 1e4 /* events in a run, of a metric that counts */
#define MANY 2          /* events in a run, or limits, up to which a setting has few */
#define LARGE 4         /* limits: assumed maximum of a rare event where the error is no count */

#define SAME 1e-12      /* relative: costs that are equal */
#define PRIOR_FREEDOM 3 /* degrees of freedom that the scatter of all settings has in the variance of one */

enum { FRESH_LEAST = 4, TWIN_LEAST = 6 };

const char ll_advise_undecided[] = "on fresh seeds the error is not certainly within the limit";

bool ll_advise_is_undecided(const ll_trial *t)
{
    return t->state == RULED_OUT && t->why == ll_advise_undecided;
}

void ll_advise_rule_out(ll_trial *t, const char *why)
{
    t->state = RULED_OUT;
    t->why = why;
}

/* ---- running ---- */

/* Updates the greatest common divisor of errors (Euclid), if they are counts. */
static void update_event(ll_advise_search *s, double error)
{
    if (error <= 0)
        return;
    s->largest = fmax(s->largest, error);
    double a = error, b = s->least > 0 ? s->event : error, small = s->largest * WHOLE;
    while (b > small) {
        double rest = fmod(a, b);
        a = b;
        b = rest < a - small ? rest : 0;
    }
    s->event = a;
    s->least = s->least > 0 ? fmin(s->least, error) : error;
}

/* Relative scatter of the error between seeds, over all runs, since a point's own runs are few. */
static double scatter(const ll_advise_search *s)
{
    double sum = 0, n = 0;
    for (int p = 0; p < s->points; p++)
        for (int fresh = 0; fresh < 2; fresh++) {
            const ll_sums *error = fresh ? &s->trials[p].fresh[ERROR] : &s->trials[p].own[ERROR];
            if (error->n < 2 || !(error->mean > 0))
                continue;
            sum += error->squares / (error->mean * error->mean);
            n += (double)(error->n - 1);
        }
    return n > 0 ? sqrt(sum / n) : 0;
}

/* Events in bursts scatter more than single ones: the ratio of their variance to Poisson's, over settings
 * with few events (quasi-Poisson). */
static double burst(const ll_advise_search *s)
{
    double few = MANY * fmax(s->request->max_error, s->event), squares = 0, alone = 0;
    for (int p = 0; p < s->points; p++)
        for (int fresh = 0; fresh < 2; fresh++) {
            const ll_sums *error = fresh ? &s->trials[p].fresh[ERROR] : &s->trials[p].own[ERROR];
            if (error->n < 2 || !(error->mean > 0) || error->mean > few)
                continue;
            squares += error->squares;
            alone += (double)(error->n - 1) * error->mean * s->event;
        }
    return alone > 0 ? fmax(1, squares / alone) : 1;
}

static bool keep_values(ll_values *v, double cost, double error)
{
    if (v->n == v->room) {
        int64_t room = v->room ? 2 * v->room : 4;
        double(*more)[2] = realloc(v->of, (size_t)room * sizeof *more);
        if (!more)
            return false;
        v->of = more;
        v->room = room;
    }
    v->of[v->n][COST] = cost;
    v->of[v->n++][ERROR] = error;
    return true;
}

void ll_advise_free_trials(ll_advise_search *s)
{
    for (int p = 0; s->trials && p < s->points; p++) {
        free(s->trials[p].own_values.of);
        free(s->trials[p].fresh_values.of);
    }
    free(s->trials);
    s->trials = NULL;
}

ll_status ll_advise_run(ll_advise_search *s, int point, bool fresh)
{
    ll_trial *t = &s->trials[point];
    const ll_experiment *e = fresh ? &s->fresh : s->experiment;
    ll_sums *sums = fresh ? t->fresh : t->own;
    int64_t repeat = fresh ? s->experiment->head.repeats + sums[ERROR].n : t->runs + t->failed;
    ll_row row;
    LL_TRY(ll_experiment_run(e, point * e->head.repeats + repeat, s->request->interrupt, NULL, &row));
    s->runs++;
    if (s->request->runs)
        atomic_store(s->request->runs, s->runs);
    double cost = fabs(row.metrics[e->cost_metric]), error = fabs(row.metrics[e->error_metric]);
    bool good = ll_row_good(&row) && isfinite(cost) && isfinite(error);
    t->failed += !good;
    t->missing += !good && ll_row_good(&row);
    t->runs += good && !fresh;
    if (good) {
        ll_sums_add(&sums[COST], cost);
        ll_sums_add(&sums[ERROR], error);
        if (!keep_values(fresh ? &t->fresh_values : &t->own_values, cost, error))
            return ll_error(LL_NO_MEMORY, "out of memory: adviser");
        update_event(s, error);
        s->scatter = scatter(s);
        s->burst = burst(s);
    }
    return ll_ok();
}

/* ---- estimates from seeds ---- */

static int64_t shared(const ll_values *a, const ll_values *b)
{
    return a->n < b->n ? a->n : b->n;
}

static double mean_of(const ll_values *v, int64_t n, int output)
{
    double sum = 0;
    for (int64_t k = 0; k < n; k++)
        sum += v->of[k][output];
    return n > 0 ? sum / (double)n : 0;
}

static double differences_of(double a, double b)
{
    return fabs(a - b) > SAME * fmax(a, b) ? a - b : 0;
}

/* Mean over `n` repeats, and over `fresh` fresh seeds. */
static double mean_over(const ll_trial *t, int64_t n, int64_t fresh, int output)
{
    double own = mean_of(&t->own_values, n, output), other = mean_of(&t->fresh_values, fresh, output);
    return fresh == 0 ? own : own + (other - own) * (double)fresh / (double)(n + fresh);
}

bool ll_advise_beats(const ll_trial *a, const ll_trial *b)
{
    int64_t n = shared(&a->own_values, &b->own_values), fresh = shared(&a->fresh_values, &b->fresh_values);
    int64_t own = n > 0 ? n : a->own_values.n, others = n > 0 ? n : b->own_values.n;
    double apart = differences_of(mean_over(a, own, fresh, COST), mean_over(b, others, fresh, COST));
    if (apart != 0)
        return apart < 0;
    return mean_over(a, own, fresh, ERROR) < mean_over(b, others, fresh, ERROR);
}

ll_sums ll_advise_cost_difference(const ll_trial *a, const ll_trial *b)
{
    const ll_values *pairs[2][2] = {{&a->own_values, &b->own_values}, {&a->fresh_values, &b->fresh_values}};
    ll_sums apart = {0};
    for (int fresh = 0; fresh < 2; fresh++)
        for (int64_t k = 0; k < shared(pairs[fresh][0], pairs[fresh][1]); k++)
            ll_sums_add(&apart, differences_of(pairs[fresh][0]->of[k][COST], pairs[fresh][1]->of[k][COST]));
    return apart;
}

bool ll_advise_costs_more(const ll_trial *a, const ll_trial *b)
{
    ll_sums apart = ll_advise_cost_difference(a, b);
    return apart.n > 1 && apart.mean - half(&apart) > 0;
}

/* The setting with most runs: differences to it have the most common seeds. */
static int reference(const ll_advise_search *s, bool wanted(const ll_trial *t))
{
    int found = -1;
    int64_t most = -1;
    for (int p = 0; p < s->points; p++) {
        int64_t runs = s->trials[p].own_values.n + s->trials[p].fresh_values.n;
        if (wanted(&s->trials[p]) && runs > most) {
            found = p;
            most = runs;
        }
    }
    return found;
}

int ll_advise_cheapest(const ll_advise_search *s, bool wanted(const ll_trial *t))
{
    int found = -1, to = reference(s, wanted);
    double least = 0;
    for (int p = 0; p < s->points; p++) {
        const ll_trial *t = &s->trials[p];
        if (!wanted(t))
            continue;
        double apart = ll_advise_cost_difference(t, &s->trials[to]).mean,
               close = SAME * s->trials[to].own[COST].mean;
        bool same = found >= 0 && fabs(apart - least) <= close;
        if (found < 0 || (same ? ll_advise_beats(t, &s->trials[found]) : apart < least)) {
            found = p;
            least = apart;
        }
    }
    return found;
}

int ll_advise_least_error(const ll_advise_search *s)
{
    int found = -1;
    for (int p = 0; p < s->points; p++) {
        const ll_trial *t = &s->trials[p];
        if (t->runs > 0 && t->failed == 0 &&
            (found < 0 || t->own[ERROR].mean < s->trials[found].own[ERROR].mean))
            found = p;
    }
    return found;
}

static bool have_equal_results(const ll_values *a, const ll_values *b)
{
    for (int64_t k = 0; k < shared(a, b); k++)
        if (a->of[k][COST] != b->of[k][COST] || a->of[k][ERROR] != b->of[k][ERROR])
            return false;
    return true;
}

/* Whether two settings gave the same at every common seed, so that they cannot be distinguished. */
static bool is_indistinguishable(const ll_trial *a, const ll_trial *b)
{
    int64_t n = shared(&a->own_values, &b->own_values), fresh = shared(&a->fresh_values, &b->fresh_values);
    bool varies = a->own[ERROR].squares > 0 && b->own[ERROR].squares > 0;
    return varies && n > 1 && fresh >= FRESH_LEAST && n + fresh >= TWIN_LEAST &&
           have_equal_results(&a->own_values, &b->own_values) &&
           have_equal_results(&a->fresh_values, &b->fresh_values);
}

static bool same(const ll_sums *a, const ll_sums *b)
{
    return a->squares == 0 && b->squares == 0 && a->mean == b->mean;
}

static bool ends_with(const char *member, size_t size, const char *end)
{
    size_t n = strlen(end);
    return size >= n && strncmp(member + size - n, end, n) == 0;
}

/* Whether a member of the path has a unit such as a length or a time: then it counts nothing. */
static bool has_unit(const char *path)
{
    static const char *const units[] = {"_m", "_ms", "_s", "_mps", "_px", "_rad", "_pct", "_arcmin"};
    for (const char *member = path; *member;) {
        size_t size = strcspn(member, ".@");
        for (size_t i = 0; i < sizeof units / sizeof units[0]; i++)
            if (ends_with(member, size, units[i]) && !ends_with(member, size, "_per_s"))
                return true;
        member += size + (member[size] != '\0');
    }
    return false;
}

static bool is_exact(const ll_advise_search *s)
{
    return s->experiment->base.kind->no_rare_events;
}

/* Whether the error counts events, or their rate. */
static bool is_count(const ll_advise_search *s)
{
    const ll_experiment *e = s->experiment;
    return !is_exact(s) && !has_unit(e->metrics[e->error_metric]) && s->largest <= MOST_EVENTS * s->event;
}

/* What a rare event, or a burst, adds to the error of a run. Before any was seen, counts are taken to be
 * whole. */
static double event(const ll_advise_search *s)
{
    double size = s->least > 0 ? is_count(s) ? s->event : s->least : 1;
    return is_count(s) ? size * fmax(1, s->burst) : fmin(size, LARGE * s->request->max_error);
}

ll_sums ll_advise_all_sums(const ll_trial *t)
{
    const ll_sums *a = &t->own[ERROR], *b = &t->fresh[ERROR];
    double n = (double)(a->n + b->n), apart = a->mean - b->mean;
    if (n == 0)
        return *a;
    return (ll_sums){.n = a->n + b->n,
                     .mean = ((double)a->n * a->mean + (double)b->n * b->mean) / n,
                     .squares = a->squares + b->squares + apart * apart * (double)a->n * (double)b->n / n};
}

bool ll_advise_is_certain(const ll_advise_search *s, const ll_trial *t)
{
    bool rare = is_count(s) || (!is_exact(s) && t->own[ERROR].mean == 0);
    return t->fresh[ERROR].n > 0 && !rare && same(&t->own[ERROR], &t->fresh[ERROR]) &&
           same(&t->own[COST], &t->fresh[COST]);
}

/* Half width of the 95 % interval of the mean over fresh seeds, with the scatter of all seeds of the
 * setting. */
static double fresh_half_width(const ll_trial *t)
{
    const ll_sums *own = &t->own[ERROR], *fresh = &t->fresh[ERROR];
    int64_t degrees = own->n + fresh->n - 2;
    if (degrees < 1)
        return INFINITY;
    return ll_interval_95(degrees + 1, own->squares + fresh->squares) *
           sqrt((double)(degrees + 1) / (double)fresh->n);
}

/* Variance of single runs: of the setting's own seeds, moderated by the scatter of all settings (as for
 * genes: Smyth, Stat. Appl. Genet. Mol. Biol. 3, 2004); of counts at least Poisson's. */
static double variance_of(const ll_advise_search *s, const ll_sums *error)
{
    double other = s->scatter * error->mean;
    double variance = (error->squares + PRIOR_FREEDOM * other * other) /
                      (double)(error->n > 0 ? error->n - 1 + PRIOR_FREEDOM : PRIOR_FREEDOM);
    return is_count(s) ? fmax(variance, error->mean * event(s)) : variance;
}

double ll_advise_half_width(const ll_advise_search *s, const ll_trial *t)
{
    const ll_sums *error = &t->own[ERROR];
    double n = (double)error->n;
    if (is_exact(s) || error->n < 2)
        return half(error);
    int64_t degrees = error->n - 1 + PRIOR_FREEDOM;
    double moderated = ll_interval_95(degrees + 1, variance_of(s, error) * (double)degrees) *
                       sqrt((double)(degrees + 1) / n);
    return moderated;
}

double ll_advise_uncertainty(const ll_advise_search *s, const ll_trial *t)
{
    const ll_sums *error = &t->fresh[ERROR];
    double n = (double)error->n, off = fresh_half_width(t), seen = error->mean * n / event(s);
    if (ll_advise_is_certain(s, t))
        return 0;
    if (error->n < FRESH_LEAST)
        return INFINITY;
    if (is_exact(s) || (error->mean > 0 && (!is_count(s) || seen > FEW)))
        return off;
    if (error->squares == 0)
        return NEVER_SEEN * event(s) / n;
    return fmax(off, event(s) * (UNSEEN + 1.96 * sqrt(seen + 1)) / n);
}

/* For a setting whose mean error is `mean`. */
static double needed_at(const ll_advise_search *s, const ll_sums *error, double mean)
{
    double room = s->request->max_error - mean, variance = variance_of(s, error);
    bool rare = is_count(s) || (!is_exact(s) && error->mean == 0);
    if (variance == 0 && is_exact(s))
        return room >= 0 ? 1 : INFINITY;
    if (room <= 0)
        return INFINITY;
    double events = rare ? LOOKS * NEVER_SEEN * event(s) / room : 0;
    double ratio = room * room / variance; /* infinite when all are equal */
    return ceil(fmax(events, ratio >= ROOMY ? FRESH_LEAST : fmax(2 * FRESH_LEAST, ROOM / ratio)));
}

double ll_advise_needed(const ll_advise_search *s, const ll_trial *t)
{
    ll_sums error = ll_advise_all_sums(t);
    return needed_at(s, &error, error.mean);
}

/* Standard error of the mean over all seeds. */
static double deviation_of_mean(const ll_advise_search *s, const ll_sums *error)
{
    double n = (double)error->n, variance = variance_of(s, error);
    if (!is_exact(s) && (is_count(s) || error->mean == 0)) /* events that were not seen may still occur */
        variance = fmax(variance, event(s) * event(s) / (n + 1));
    return sqrt(variance / n);
}

double ll_advise_chance(const ll_advise_search *s, const ll_trial *t)
{
    ll_sums error = ll_advise_all_sums(t);
    double room = s->request->max_error - error.mean, off = deviation_of_mean(s, &error);
    return off > 0 ? ll_normal_cdf(room / off) : room >= 0;
}

double ll_advise_price(const ll_advise_search *s, const ll_trial *t)
{
    ll_sums error = ll_advise_all_sums(t);
    double mean = fmax(0, error.mean - deviation_of_mean(s, &error));
    double wanted = needed_at(s, &error, fmin(mean, error.mean)) - (double)t->fresh[ERROR].n;
    return fmax(wanted, 1);
}

double ll_advise_next(const ll_advise_search *s, const ll_trial *t)
{
    double n = (double)t->fresh[ERROR].n;
    if (n < FRESH_LEAST)
        return n == 0 ? 1 : FRESH_LEAST - n;
    return fmin(fmax(ll_advise_needed(s, t) - n, n / 2), n); /* at most doubles the seeds */
}

/* Whether fresh seeds may show that it holds, with the runs that are left. */
static bool can_be_shown(const ll_advise_search *s, const ll_trial *t)
{
    double wanted = ll_advise_needed(s, t);
    return wanted <= LL_ADVISE_FRESH_MAX && wanted - (double)t->fresh[ERROR].n <= (double)(s->most - s->runs);
}

bool ll_advise_is_clear(const ll_advise_search *s, const ll_trial *t)
{
    ll_sums error = ll_advise_all_sums(t);
    double off = s->scatter / sqrt((double)error.n);
    return error.mean * (1 + off) <= s->request->max_error && can_be_shown(s, t);
}

/* ---- verifying ---- */

/* Whether an indistinguishable setting was verified as far. */
static bool has_indistinguishable(const ll_advise_search *s, const ll_trial *t)
{
    for (int p = 0; p < s->points; p++) {
        const ll_trial *other = &s->trials[p];
        if (other != t && other->fresh[ERROR].n >= t->fresh[ERROR].n && is_indistinguishable(other, t))
            return true;
    }
    return false;
}

static void classify(const ll_advise_search *s, ll_trial *t)
{
    double error = t->fresh[ERROR].mean, off = ll_advise_uncertainty(s, t), limit = s->request->max_error;
    if (t->failed > 0)
        ll_advise_rule_out(t, "a run failed on a fresh seed");
    else if (has_indistinguishable(s, t))
        ll_advise_rule_out(t, "same result as another setting");
    else if (error + LOOKS * off <= limit && ll_advise_all_sums(t).mean <= limit)
        t->state = VERIFIED;
    else if (error - LOOKS * off > limit)
        ll_advise_rule_out(t, "on fresh seeds the error is above the limit");
    else if (t->fresh[ERROR].n >= LL_ADVISE_FRESH_MAX)
        ll_advise_rule_out(t, ll_advise_undecided);
    else if (t->state == VERIFIED) /* more seeds have shown that it held by chance */
        t->state = UNCLEAR;
}

ll_status ll_advise_verify(ll_advise_search *s, int point)
{
    ll_trial *t = &s->trials[point];
    double next = (double)t->fresh[ERROR].n + ll_advise_next(s, t);
    ll_status status = ll_ok();
    next = fmin(next, LL_ADVISE_FRESH_MAX);
    while (!ll_failed(&status) && t->failed == 0 && (double)t->fresh[ERROR].n < next && s->runs < s->most)
        status = ll_advise_run(s, point, true);
    classify(s, t);
    return status;
}
