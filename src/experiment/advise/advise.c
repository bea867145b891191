#include "experiment/advise/internal.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/detmath.h"
#include "base/rng.h"

#define MORE_RUNS 40        /* and one of each point: to verify, and to settle equal costs */
#define EQUAL_LOG 1e-12     /* smaller differences of costs and errors count as zero */
#define CLOSE 0.01          /* relative saving that is worth runs, where costs differ by seed */
#define SURE_DEVIATIONS 2.5 /* standard deviations by which the mean of such differences may be off */
#define FEW_SEEDS 30        /* with fewer seeds the mean is not nearly normal */
#define PRIOR_FREEDOM 3     /* degrees of freedom that the variance of all settings has in that of one */
#define SPREAD 0.3          /* part of the runs for the even spread, where they are fewer than the points */
#define GOLDEN 0.6180339887498949

/* With one seed the error has no interval. A point that misses the limit by more than others scatter is not
 * run again before all others were. */
static bool is_hopeless(const ll_advise_search *s, const ll_trial *t)
{
    return t->runs == 1 && t->own[ERROR].mean > 2 * s->request->max_error;
}

/* A point that misses the limit by no more than its seeds scatter may hold on other seeds. */
static void classify(const ll_advise_search *s, ll_trial *t)
{
    double error = t->own[ERROR].mean, limit = s->request->max_error;
    bool all = t->runs == s->experiment->head.repeats;
    bool single = all && t->runs == 1 && s->experiment->base.kind->no_rare_events;
    if (t->failed > 0)
        ll_advise_rule_out(t, t->missing == t->failed ? "a run lacks this error or cost" : "a run failed");
    else if (error > limit && (single || error - ll_advise_half_width(s, t) > limit))
        ll_advise_rule_out(t, "the error is above the limit");
    else if (all)
        t->state = ll_advise_is_clear(s, t) ? HOLDS : UNCLEAR;
    else
        t->state = is_hopeless(s, t) ? HOPELESS : OPEN;
}

static bool holds(const ll_trial *t)
{
    return t->state == HOLDS || t->state == VERIFIED;
}

static void find_best(ll_advise_search *s)
{
    for (int p = 0; p < s->points; p++) {
        ll_trial *t = &s->trials[p];
        if (t->state == HOLDS || t->state == UNCLEAR)
            t->state = ll_advise_is_clear(s, t) ? HOLDS : UNCLEAR;
    }
    s->best = ll_advise_cheapest(s, holds);
}

/* Whether its cost may still turn out below that of the best. */
static bool may_beat(const ll_advise_search *s, const ll_trial *t)
{
    if (s->best < 0)
        return true;
    const ll_trial *best = &s->trials[s->best];
    bool sure = t->runs == s->experiment->head.repeats || t->own[COST].mean > 2 * best->own[COST].mean ||
                ll_advise_costs_more(t, best);
    return !sure || ll_advise_beats(t, best);
}

/* Doubles the seeds each time while the point may be the best; stops after the first check if it is
 * hopeless. */
static ll_status try_point(ll_advise_search *s, int point)
{
    ll_trial *t = &s->trials[point];
    ll_status status = ll_ok();
    int64_t repeats = s->experiment->head.repeats, next = t->runs > 0 ? 2 * t->runs : 1;
    do {
        next = next < repeats ? next : repeats;
        while (!ll_failed(&status) && t->runs + t->failed < next && s->runs < s->most - s->kept)
            status = ll_advise_run(s, point, false);
        classify(s, t);
        next *= 2;
    } while (!ll_failed(&status) && t->state == OPEN && s->runs < s->most - s->kept &&
             (s->best < 0 || ll_advise_beats(t, &s->trials[s->best])));
    find_best(s);
    return status;
}

static ll_status verify(ll_advise_search *s, int point)
{
    ll_status status = ll_advise_verify(s, point);
    find_best(s);
    return status;
}

/* ---- selection ---- */

/* Steps between two points: one for each value between them on a numeric axis, one for another choice. */
static int64_t steps_between(const ll_experiment *e, int64_t p, int64_t q)
{
    int64_t steps = 0;
    for (int a = e->axis_count - 1; a >= 0; a--) {
        const ll_axis *axis = &e->axes[a];
        if (a > 0 && e->dimension[a - 1] == e->dimension[a]) /* zipped: the first axis represents all */
            continue;
        int64_t apart = llabs(p % axis->count - q % axis->count);
        bool choice = axis->type == LL_CELL_BOOL || axis->type == LL_CELL_TEXT;
        steps += choice ? apart != 0 : apart;
        p /= axis->count;
        q /= axis->count;
    }
    return steps;
}

/* The point nearest to the best one that was not tried; before any holds, to the one with the smallest error.
 * -1: all were tried. */
static int nearest_untried(const ll_advise_search *s)
{
    int found = -1, to = s->best >= 0 ? s->best : ll_advise_least_error(s);
    int64_t nearest = INT64_MAX;
    for (int p = 0; p < s->points; p++) {
        int64_t steps = to < 0 ? p : steps_between(s->experiment, p, to);
        if (s->trials[p].state == UNTRIED && steps < nearest) {
            found = p;
            nearest = steps;
        }
    }
    return found;
}

/* The cheapest point that more seeds may show to be the best; -1: none. */
static int cheapest_open(const ll_advise_search *s)
{
    int found = -1;
    for (int p = 0; p < s->points; p++) {
        const ll_trial *t = &s->trials[p], *other = found < 0 ? NULL : &s->trials[found];
        bool open = t->state == OPEN || t->state == HOPELESS;
        if (open && may_beat(s, t) &&
            (!other || t->state < other->state || (t->state == other->state && ll_advise_beats(t, other))))
            found = p;
    }
    return found;
}

/* Of the unverified points that hold or may hold, the one whose verification takes the fewest runs; -1: too
 * few runs are left, or one was verified already. */
static int safest(const ll_advise_search *s)
{
    int found = -1;
    double fewest = (double)(s->most - s->runs);
    for (int p = 0; p < s->points; p++) {
        const ll_trial *t = &s->trials[p];
        if (t->state == VERIFIED)
            return -1;
        double wanted = t->state == HOLDS || t->state == UNCLEAR
                            ? ll_advise_needed(s, t) - (double)t->fresh[ERROR].n
                            : INFINITY;
        if (wanted < fewest || (wanted == fewest && found < 0)) {
            found = p;
            fewest = wanted;
        }
    }
    return found;
}

static double most_expensive(const ll_advise_search *s)
{
    double most = EQUAL_LOG;
    for (int p = 0; p < s->points; p++)
        most = fmax(most, s->trials[p].own[COST].mean);
    return most;
}

/* Variance of cost differences by seed, over all settings that may be advised. */
static double variance_of_costs(const ll_advise_search *s, const ll_trial *against)
{
    double squares = 0, n = 0;
    for (int p = 0; p < s->points; p++) {
        const ll_trial *t = &s->trials[p];
        if (t->state != HOLDS && t->state != UNCLEAR && t->state != VERIFIED)
            continue;
        ll_sums apart = ll_advise_cost_difference(t, against);
        squares += apart.squares;
        n += apart.n > 1 ? (double)(apart.n - 1) : 0;
    }
    return n > 0 ? squares / n : 0;
}

/* Plausible relative saving of a setting over the advised one; 0: not worth runs. Where costs differ by seed
 * it is a bound of the mean difference, whose variance is moderated by that of all settings and, with few
 * seeds, is no smaller than that: they may agree by chance. */
static double saving(const ll_trial *t, const ll_trial *against, double variance)
{
    ll_sums apart = ll_advise_cost_difference(t, against);
    double n = (double)apart.n, cost = fmax(against->own[COST].mean, EQUAL_LOG);
    double own = (apart.squares + PRIOR_FREEDOM * variance) / (n - 1 + PRIOR_FREEDOM);
    double deviation = sqrt((apart.n < FEW_SEEDS ? fmax(own, variance) : own) / n);
    double saved = (SURE_DEVIATIONS * deviation - apart.mean) / cost;
    if (deviation > 0)
        return saved > CLOSE ? saved : 0;
    return saved > 0 ? saved : ll_advise_beats(t, against) ? EQUAL_LOG : 0;
}

/* The point whose fresh seeds are worth most: its saving over the verified one (before one is verified: twice
 * that over the most expensive), times the probability that it holds, per run that this may take to show. -1:
 * nothing more can be shown. */
static int best_to_verify(const ll_advise_search *s, int shown)
{
    int found = -1;
    double most = 0, none = ll_detmath_log(2 * most_expensive(s));
    double variance = shown < 0 ? 0 : variance_of_costs(s, &s->trials[shown]);
    for (int p = 0; p < s->points; p++) {
        const ll_trial *t = &s->trials[p];
        if (t->state != HOLDS && t->state != UNCLEAR)
            continue;
        double saved = shown < 0 ? none - ll_detmath_log(fmax(t->own[COST].mean, EQUAL_LOG))
                                 : saving(t, &s->trials[shown], variance);
        double value = saved * ll_advise_chance(s, t) / ll_advise_price(s, t);
        bool same = found >= 0 && fabs(value - most) <= EQUAL_LOG * most;
        if (same ? ll_advise_beats(t, &s->trials[found]) : value > most) {
            most = value;
            found = p;
        }
    }
    return found;
}

/* Of the verified points, where costs differ by seed, the one that may save most over the cheapest of them;
 * or that one, if it has fewer seeds. -1: none is worth runs. */
static int next_rival(const ll_advise_search *s, int shown)
{
    int found = -1;
    double most = 0, variance = shown < 0 ? 0 : variance_of_costs(s, &s->trials[shown]);
    for (int p = 0; shown >= 0 && p < s->points; p++) {
        const ll_trial *t = &s->trials[p];
        double saved = t->state == VERIFIED && p != shown ? saving(t, &s->trials[shown], variance) : 0;
        if (saved > most && t->fresh[ERROR].n < LL_ADVISE_FRESH_MAX) {
            most = saved;
            found = p;
        }
    }
    return found >= 0 && s->trials[shown].fresh[ERROR].n < s->trials[found].fresh[ERROR].n ? shown : found;
}

/* The point worth most, as long as enough runs are left to verify the safest one, so that the search ends
 * with advice. */
static int to_verify(const ll_advise_search *s, int sure, int shown)
{
    int worth = best_to_verify(s, shown);
    if (worth < 0 || sure < 0 || sure == worth)
        return worth < 0 ? sure : worth;
    double left = (double)(s->most - s->runs) - ll_advise_next(s, &s->trials[worth]);
    return left < ll_advise_needed(s, &s->trials[sure]) ? sure : worth;
}

/* Runs reserved for verifying. */
static int64_t keep(const ll_advise_search *s, int sure)
{
    bool found = s->best >= 0 && s->trials[s->best].state == HOLDS;
    double wanted = found ? ll_advise_needed(s, &s->trials[s->best]) + 1 : 0;
    if (sure >= 0 && sure != s->best)
        wanted += ll_advise_needed(s, &s->trials[sure]);
    return (int64_t)fmin(wanted, (double)(s->most - s->runs));
}

/* The cheapest point that would be the best if more fresh seeds showed that it holds; -1: none. */
static int cheapest_undecided(const ll_advise_search *s)
{
    int found = -1;
    for (int p = 0; p < s->points; p++) {
        const ll_trial *t = &s->trials[p];
        if (ll_advise_is_undecided(t) && (s->best < 0 || ll_advise_beats(t, &s->trials[s->best])) &&
            (found < 0 || ll_advise_beats(t, &s->trials[found])))
            found = p;
    }
    return found;
}

/* One step of the search: tries, repeats or verifies a point. False: nothing is left to find out.
 * Verification begins when all points were tried, or when only the runs reserved for it are left. */
static bool search_step(ll_advise_search *s, ll_status *status)
{
    int untried = nearest_untried(s), open = cheapest_open(s), sure = safest(s);
    s->kept = keep(s, sure);
    bool last = s->kept > 0 && s->most - s->runs <= s->kept;
    int shown = ll_advise_cheapest(s, ll_advise_is_verified);
    int next = to_verify(s, sure, shown), close = next < 0 ? next_rival(s, shown) : -1;
    if (next < 0 && close < 0) { /* nothing is left to verify: no runs need be reserved */
        s->kept = 0;
        last = false;
    }
    if (untried >= 0 && !last)
        *status = try_point(s, untried);
    else if (open >= 0 && s->trials[open].state == OPEN && !last)
        *status = try_point(s, open);
    else if (next >= 0)
        *status = verify(s, next);
    else if (close >= 0)
        *status = verify(s, close);
    else if (open >= 0)
        *status = try_point(s, open);
    else
        return false;
    return !ll_failed(status);
}

/* One seed of every point if there are runs for it; else of points spread evenly over the grid, by multiples
 * of the golden section of its length. */
static ll_status spread(ll_advise_search *s)
{
    ll_status status = ll_ok();
    bool all = s->points < s->most;
    int64_t count = all ? s->points : (int64_t)(SPREAD * (double)s->most);
    for (int64_t k = 0; k < count && !ll_failed(&status); k++) {
        int p = (int)(all ? k : (int64_t)(fmod(GOLDEN * (double)k, 1) * s->points));
        if (s->trials[p].state != UNTRIED)
            continue;
        status = ll_advise_run(s, p, false);
        classify(s, &s->trials[p]);
    }
    find_best(s);
    return status;
}

/* First the spread, then steps until the runs are used up or the optimum is proven. */
static ll_status search(ll_advise_search *s, bool *proven)
{
    *proven = false;
    ll_status status = spread(s);
    while (!ll_failed(&status) && !*proven && s->runs < s->most)
        *proven = !search_step(s, &status) && !ll_failed(&status);
    *proven =
        *proven && cheapest_undecided(s) < 0; /* not proven while another point may hold and be the best */
    return status;
}

ll_status ll_advise_check(const ll_advise_request *request)
{
    const ll_experiment *e = request->experiment;
    if (!(request->max_error > 0 && isfinite(request->max_error)))
        return ll_field_error(LL_BAD_INPUT, "max_error", "max_error: must be above 0; got %g",
                              request->max_error);
    if (e->cost_metric < 0)
        return ll_field_error(LL_BAD_INPUT, "cost",
                              "cost: required; must name a metric to weigh against the error");
    if (e->head.sample.method != LL_SAMPLE_NONE)
        return ll_field_error(LL_BAD_INPUT, "sample",
                              "sample: must be absent, since the adviser chooses its points");
    if (e->points > LL_ADVISE_POINTS_MAX)
        return ll_field_error(LL_BAD_INPUT, "axes", "axes: has %lld points; must have at most %d",
                              (long long)e->points, LL_ADVISE_POINTS_MAX);
    return ll_ok();
}

int64_t ll_advise_runs(const ll_advise_request *request)
{
    const ll_experiment *e = request->experiment;
    if (request->most_runs > 0)
        return request->most_runs;
    bool matter = e->head.repeats > 1 && !e->base.kind->no_rare_events;
    int64_t once = e->points + MORE_RUNS, part = matter ? e->runs / 5 * 2 + 2 * LL_ADVISE_FRESH_MAX : 0;
    return part > once ? part : once;
}

ll_status ll_advise(const ll_advise_request *request, cJSON **answer)
{
    const ll_experiment *e = request->experiment;
    ll_status status = ll_advise_check(request);
    *answer = NULL;
    if (ll_failed(&status))
        return status;
    bool proven = false;
    ll_advise_search s = {
        .request = request, .experiment = e, .fresh = *e, .points = (int)e->points, .best = -1};
    s.fresh.head.repeats = e->head.repeats + LL_ADVISE_FRESH_MAX;
    s.most = ll_advise_runs(request);
    s.trials = calloc((size_t)e->points, sizeof *s.trials);
    status = s.trials ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: adviser");
    LL_THEN(status, search(&s, &proven));
    if (!ll_failed(&status))
        *answer = ll_advise_answer(&s, proven);
    ll_advise_free_trials(&s);
    return status;
}
