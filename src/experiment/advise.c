#include "experiment/advise_internal.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/detmath.h"
#include "base/rng.h"

#define LEAST_RUNS 40 /* below that a fifth says little of nine methods */
#define TINY 1e-12    /* below it, costs and errors are equal */
#define FAR 15        /* errors are told apart up to so many factors of e from the limit */
#define WORTH 2e-3    /* a saving, as a part of the cost, before which what is found is verified */
#define MARGIN                                                                                               \
    0.8 /* standard deviations of a run by which a bound over some fresh seeds is above the mean             \
         */
#define FIRST_PART 0.3  /* of the runs that may be spent go to an even spread */
#define NEVER_SEEN 3.69 /* events that may be expected where none was seen, at 97.5 % (Poisson) */

enum { FRESH_LEAST = 4, FRESH_MOST = 64 }; /* seeds that no search has seen, for a setting that is advised */

/* ---- running ---- */

/* One run more, of a fresh seed or of the repeats. */
static ll_status run_once(ll_advise_search *s, int point, bool fresh)
{
    ll_trial *t = &s->trials[point];
    const ll_experiment *e = fresh ? &s->fresh : s->experiment;
    ll_sums *sums = fresh ? t->fresh : t->own;
    int64_t repeat = fresh ? s->experiment->head.repeats + sums[ERROR].n : t->runs + t->failed;
    ll_row row;
    ll_status status = ll_experiment_run(e, point * e->head.repeats + repeat, s->order->interrupt, &row);
    if (ll_failed(&status))
        return status;
    s->runs++;
    if (s->order->runs)
        atomic_store(s->order->runs, s->runs);
    double cost = fabs(row.metrics[e->cost_metric]), error = fabs(row.metrics[e->error_metric]);
    bool good = ll_row_good(&row) && isfinite(cost) && isfinite(error);
    t->failed += !good;
    t->runs += good && !fresh;
    if (good) {
        ll_sums_add(&sums[COST], cost);
        ll_sums_add(&sums[ERROR], error);
    }
    return status;
}

static bool same(const ll_sums *a, const ll_sums *b)
{
    return a->squares == 0 && b->squares == 0 && a->mean == b->mean;
}

static void rule_out(ll_trial *t, const char *why)
{
    t->state = RULED_OUT;
    t->why = why;
}

/* With a single seed the error has no interval: a point that misses by so much more than others scatter is
 * not run again before all others are. */
static bool is_hopeless(const ll_advise_search *s, const ll_trial *t)
{
    return t->runs == 1 && t->own[ERROR].mean > 2 * s->order->max_error;
}

/* The relative scatter of the error between seeds, over all that was run: a point's own few tell little. */
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

static bool ends_with(const char *member, size_t size, const char *end)
{
    size_t n = strlen(end);
    return size >= n && strncmp(member + size - n, end, n) == 0;
}

/* Whether a member of the path names a length, a time or the like: it counts nothing. */
static bool has_unit(const char *path)
{
    static const char *const units[] = {"_m", "_ms", "_s", "_mps", "_px", "_rad", "_pct", "_arcmin"};
    for (const char *member = path; *member;) {
        size_t size = strcspn(member, ".");
        for (size_t i = 0; i < sizeof units / sizeof units[0]; i++)
            if (ends_with(member, size, units[i]) && !ends_with(member, size, "_per_s"))
                return true;
        member += size + (member[size] == '.');
    }
    return false;
}

/* Whether the error counts something that may be rare: then equal values say little. */
static bool is_count(const ll_advise_search *s, const ll_trial *t)
{
    const ll_experiment *e = s->experiment;
    return !has_unit(e->metrics[e->error_metric]) && !s->experiment->base.kind->no_rare_events &&
           t->own[ERROR].mean == floor(t->own[ERROR].mean);
}

/* Of all seeds of a point. */
static ll_sums pooled(const ll_trial *t)
{
    const ll_sums *a = &t->own[ERROR], *b = &t->fresh[ERROR];
    double n = (double)(a->n + b->n), apart = a->mean - b->mean;
    if (n == 0)
        return *a;
    return (ll_sums){.n = a->n + b->n,
                     .mean = ((double)a->n * a->mean + (double)b->n * b->mean) / n,
                     .squares = a->squares + b->squares + apart * apart * (double)a->n * (double)b->n / n};
}

/* Fresh seeds after which the upper bound is below the limit, by how errors scatter. */
static double needed(const ll_advise_search *s, const ll_trial *t)
{
    ll_sums error = pooled(t);
    double room = s->order->max_error - error.mean, deviation = scatter(s) * error.mean;
    double variance =
        error.n >= 2 * FRESH_LEAST ? error.squares / (double)(error.n - 1) : deviation * deviation;
    if (is_count(s, t) && variance < error.mean)
        variance = error.mean;
    if (room <= 0)
        return INFINITY;
    if (variance == 0)
        return s->experiment->base.kind->no_rare_events ? 1 : FRESH_LEAST;
    return fmax(FRESH_LEAST, 5 * variance / (room * room));
}

/* Whether fresh seeds may show it, with the runs that are left. */
static bool can_be_shown(const ll_advise_search *s, const ll_trial *t)
{
    double wanted = needed(s, t);
    return wanted <= FRESH_MOST && wanted - (double)t->fresh[ERROR].n <= (double)(s->most - s->runs);
}

/* Whether it holds so surely that it is worth to verify it. */
static bool is_clear(const ll_advise_search *s, const ll_trial *t)
{
    double off = scatter(s) / sqrt((double)t->runs);
    return t->own[ERROR].mean * (1 + off) <= s->order->max_error && can_be_shown(s, t);
}

static void judge(const ll_advise_search *s, ll_trial *t)
{
    double error = t->own[ERROR].mean, limit = s->order->max_error;
    if (t->failed > 0)
        rule_out(t, "a run failed");
    else if (t->runs == s->experiment->head.repeats && error <= limit)
        t->state = is_clear(s, t) ? HOLDS : UNCLEAR;
    else if (t->runs == s->experiment->head.repeats || error - half(&t->own[ERROR]) > limit)
        rule_out(t, "the error is above the limit");
    else
        t->state = is_hopeless(s, t) ? HOPELESS : OPEN;
}

/* Whether nothing random reaches the setting: fresh seeds give what the others gave. Where events may be
 * rare, equal counts say little. */
bool ll_advise_is_certain(const ll_advise_search *s, const ll_trial *t)
{
    return t->fresh[ERROR].n > 0 && !is_count(s, t) && same(&t->own[ERROR], &t->fresh[ERROR]) &&
           same(&t->own[COST], &t->fresh[COST]);
}

double ll_advise_doubt(const ll_advise_search *s, const ll_trial *t)
{
    const ll_sums *error = &t->fresh[ERROR];
    if (ll_advise_is_certain(s, t))
        return 0;
    if (error->n < FRESH_LEAST)
        return INFINITY;
    return error->squares > 0 || !is_count(s, t) ? half(error) : NEVER_SEEN / (double)error->n;
}

static const char unsure[] = "on fresh seeds the error is not surely within the limit";

static void judge_fresh(const ll_advise_search *s, ll_trial *t)
{
    double error = t->fresh[ERROR].mean, off = ll_advise_doubt(s, t), limit = s->order->max_error;
    if (t->failed > 0)
        rule_out(t, "a run failed on a fresh seed");
    else if (error + off <= limit)
        t->state = VERIFIED;
    else if (error - off > limit)
        rule_out(t, "on fresh seeds the error is above the limit");
    else if (t->fresh[ERROR].n >= FRESH_MOST || (t->fresh[ERROR].n >= 2 * FRESH_LEAST && !can_be_shown(s, t)))
        rule_out(t, unsure);
}

static void find_best(ll_advise_search *s)
{
    s->best = -1;
    for (int p = 0; p < s->points; p++) {
        ll_trial *t = &s->trials[p];
        if (t->state == HOLDS || t->state == UNCLEAR)
            t->state = is_clear(s, t) ? HOLDS : UNCLEAR;
        if ((t->state == HOLDS || t->state == VERIFIED) && (s->best < 0 || beats(t, &s->trials[s->best])))
            s->best = p;
    }
}

static void tell(ll_advise_search *s, int point)
{
    const ll_trial *t = &s->trials[point];
    double limit = ll_log(s->order->max_error), values[2];
    double seen = pooled(t).mean * (1 + MARGIN * scatter(s));
    double error = t->runs == 0 ? limit + FAR : ll_log(fmax(seen, TINY));
    values[COST] = ll_log(fmax(t->own[COST].mean, TINY));
    values[ERROR] = fmin(fmax(error, limit - FAR), limit + FAR);
    if (t->runs == 0) { /* it failed: its cost says nothing */
        double deviation[2], mean[2];
        ll_surrogate_expect(s->surrogate, point, mean, deviation);
        values[COST] = mean[COST];
    }
    ll_surrogate_tell(s->surrogate, point, values);
    ll_surrogate_fit(s->surrogate);
}

/* Its cost may yet turn out to be below that of the best. */
static bool may_beat(const ll_advise_search *s, const ll_trial *t)
{
    if (s->best < 0)
        return true;
    const ll_trial *best = &s->trials[s->best];
    bool sure = t->runs == s->experiment->head.repeats || t->own[COST].mean > 2 * best->own[COST].mean ||
                (t->runs > 1 && t->own[COST].mean - half(&t->own[COST]) > best->own[COST].mean);
    return !sure || beats(t, best);
}

/* Twice as many seeds each time, as long as it may be the best; the first look ends when it is hopeless. */
static ll_status try_point(ll_advise_search *s, int point)
{
    ll_trial *t = &s->trials[point];
    ll_status status = ll_ok();
    int64_t repeats = s->experiment->head.repeats, next = t->runs > 0 ? 2 * t->runs : 1;
    if (t->state == UNTRIED)
        status = ll_surrogate_see(s->surrogate, point);
    do {
        next = next < repeats ? next : repeats;
        while (!ll_failed(&status) && t->runs + t->failed < next && s->runs < s->most - s->kept)
            status = run_once(s, point, false);
        judge(s, t);
        next *= 2;
    } while (!ll_failed(&status) && t->state == OPEN && s->runs < s->most - s->kept &&
             (s->best < 0 || beats(t, &s->trials[s->best])));
    if (!ll_failed(&status))
        tell(s, point);
    find_best(s);
    return status;
}

/* A first fresh seed shows whether anything is random; then there are twice as many each time. */
static ll_status verify(ll_advise_search *s, int point)
{
    ll_trial *t = &s->trials[point];
    int64_t n = t->fresh[ERROR].n, next = n == 0 ? 1 : n < FRESH_LEAST ? FRESH_LEAST : 2 * n;
    ll_status status = ll_ok();
    while (!ll_failed(&status) && t->failed == 0 && t->fresh[ERROR].n < next && s->runs < s->most)
        status = run_once(s, point, true);
    judge_fresh(s, t);
    if (!ll_failed(&status))
        tell(s, point);
    find_best(s);
    return status;
}

/* ---- choosing ---- */

static double density(double z)
{
    return 0.3989422804014327 * ll_exp(-z * z / 2);
}

/* Expected saving in log cost against the best, times the chance to hold; before one holds, that chance, and
 * of equal chances the cheaper. */
static double promise(const ll_advise_search *s, int point)
{
    double mean[2], deviation[2];
    ll_surrogate_expect(s->surrogate, point, mean, deviation);
    double chance = ll_normal_cdf((ll_log(s->order->max_error) - mean[ERROR]) / deviation[ERROR]);
    if (s->best < 0)
        return chance * ll_exp(-0.02 * (mean[COST] - ll_log(TINY)));
    double saved = ll_log(fmax(s->trials[s->best].own[COST].mean, TINY)) - mean[COST],
           z = saved / deviation[COST];
    return chance * (saved * ll_normal_cdf(z) + deviation[COST] * density(z));
}

/* Of those not tried; -1: all were. Where nothing promises anything, the one that seems cheapest. */
static int most_promising(const ll_advise_search *s, double *most)
{
    int found = -1;
    double cheapest = INFINITY;
    *most = 0;
    for (int p = 0; p < s->points; p++) {
        if (s->trials[p].state != UNTRIED)
            continue;
        double value = promise(s, p), mean[2], deviation[2];
        ll_surrogate_expect(s->surrogate, p, mean, deviation);
        if (value > *most || (*most == 0 && mean[COST] < cheapest))
            found = p;
        *most = fmax(*most, value);
        cheapest = fmin(cheapest, mean[COST]);
    }
    return found;
}

static int most_doubtful(const ll_advise_search *s)
{
    int found = -1;
    for (int p = 0; p < s->points; p++)
        if (s->trials[p].state == UNTRIED &&
            (found < 0 ||
             ll_surrogate_doubt(s->surrogate, p) > ll_surrogate_doubt(s->surrogate, found) * (1 + 1e-9)))
            found = p;
    return found;
}

/* The cheapest of those that more seeds may show to be the best; -1: there is none. */
static int cheapest_open(const ll_advise_search *s)
{
    int found = -1;
    for (int p = 0; p < s->points; p++) {
        const ll_trial *t = &s->trials[p], *other = found < 0 ? NULL : &s->trials[found];
        bool open = t->state == OPEN || t->state == UNCLEAR || t->state == HOPELESS;
        if (open && may_beat(s, t) &&
            (!other || t->state < other->state || (t->state == other->state && beats(t, other))))
            found = p;
    }
    return found;
}

/* One step of the search: a point is tried, run again or verified. False: nothing is left to be known. What
 * is found is verified when nothing promises to be better, or when no more runs are left than that takes. */
static bool act(ll_advise_search *s, ll_status *status)
{
    double most;
    int untried = most_promising(s, &most), open = cheapest_open(s);
    bool found = s->best >= 0 && s->trials[s->best].state == HOLDS;
    bool promising = untried >= 0 && (s->best < 0 || most >= WORTH);
    bool more = promising || (open >= 0 && s->trials[open].state == OPEN);
    double verifying = found ? needed(s, &s->trials[s->best]) + 1 : 0;
    s->kept = (int64_t)fmin(verifying, (double)(s->most - s->runs));
    if (found && (!more || s->most - s->runs <= s->kept))
        *status = verify(s, s->best);
    else if (promising)
        *status = try_point(s, untried);
    else if (open >= 0 && s->trials[open].state == UNCLEAR)
        *status = verify(s, open);
    else if (open >= 0 && (s->trials[open].state == OPEN || untried < 0))
        *status = try_point(s, open);
    else if (untried >= 0)
        *status = try_point(s, untried);
    else
        return false;
    return !ll_failed(status);
}

/* An even spread first; then until the runs are spent, or the answer is proven. */
static ll_status look(ll_advise_search *s, bool *proven)
{
    ll_status status = ll_ok();
    int64_t spread = (int64_t)(FIRST_PART * (double)s->most);
    *proven = false;
    for (int first = 0; !ll_failed(&status) && s->runs < spread && first < s->most / 3; first++) {
        int point = most_doubtful(s);
        if (point < 0)
            break;
        status = try_point(s, point);
    }
    while (!ll_failed(&status) && !*proven && s->runs < s->most)
        *proven = !act(s, &status) && !ll_failed(&status);
    for (int p = 0; p < s->points; p++) /* what may hold, and may be the best, is no proof */
        *proven = *proven && s->trials[p].why != unsure;
    return status.code == LL_LIMIT ? ll_ok() : status;
}

ll_status ll_advise_check(const ll_advice_order *order)
{
    const ll_experiment *e = order->experiment;
    if (!(order->max_error > 0 && isfinite(order->max_error)))
        return ll_field_error(LL_BAD_INPUT, "max_error", "max_error must be above 0; got %g",
                              order->max_error);
    if (e->cost_metric < 0)
        return ll_field_error(LL_BAD_INPUT, "cost",
                              "cost must name a metric: the adviser weighs it against the error");
    if (e->head.sample.method != LL_SAMPLE_NONE)
        return ll_field_error(LL_BAD_INPUT, "sample",
                              "sample is not for the adviser, which chooses its points itself");
    if (e->points > LL_SURROGATE_POINTS_MAX)
        return ll_field_error(LL_BAD_INPUT, "axes", "axes give %lld points; the adviser takes at most %d",
                              (long long)e->points, LL_SURROGATE_POINTS_MAX);
    return ll_ok();
}

int64_t ll_advise_runs(const ll_advice_order *order)
{
    int64_t fifth = order->experiment->runs / 5;
    return order->most_runs > 0 ? order->most_runs : fifth > LEAST_RUNS ? fifth : LEAST_RUNS;
}

ll_status ll_advise(const ll_advice_order *order, cJSON **answer)
{
    const ll_experiment *e = order->experiment;
    ll_status status = ll_advise_check(order);
    *answer = NULL;
    if (ll_failed(&status))
        return status;
    bool proven = false;
    ll_advise_search s = {.order = order, .experiment = e, .fresh = *e, .points = (int)e->points, .best = -1};
    s.fresh.head.repeats = e->head.repeats + FRESH_MOST;
    s.most = ll_advise_runs(order);
    s.trials = calloc((size_t)e->points, sizeof *s.trials);
    status =
        s.trials ? ll_surrogate_create(e, &s.surrogate) : ll_error(LL_NO_MEMORY, "no memory for the adviser");
    if (!ll_failed(&status))
        status = look(&s, &proven);
    if (!ll_failed(&status))
        *answer = ll_advise_answer(&s, proven);
    ll_surrogate_free(s.surrogate);
    free(s.trials);
    return status;
}
