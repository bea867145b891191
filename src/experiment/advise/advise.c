#include "experiment/advise/internal.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/detmath.h"
#include "base/rng.h"

#define LEAST_RUNS 40  /* below that a fifth says little of nine methods */
#define TINY 1e-12     /* below it, costs and errors are equal */
#define FAR 15         /* errors are told apart up to so many factors of e from the limit */
#define FAILED 2       /* factors of e by which a failed run is worse than the worst that was seen */
#define WORTH 2e-3     /* a saving, as a part of the cost, before which what is found is verified */
#define CLOSE 0.01     /* a saving that is worth to be looked at, where costs differ by seed */
#define SURE 2.5       /* deviations by which the mean of such differences may be off */
#define FEW_SEEDS 30   /* of fewer the mean is not near to normal */
#define FREEDOM 3      /* degrees of freedom that the variance of all settings counts for in that of one */
#define MARGIN 0.8     /* deviations of a run by which a bound over some fresh seeds is above the mean */
#define FIRST_PART 0.3 /* of the runs that may be spent go to an even spread */

/* With a single seed the error has no interval: a point that misses by so much more than others scatter is
 * not run again before all others are. */
static bool is_hopeless(const ll_advise_search *s, const ll_trial *t)
{
    return t->runs == 1 && t->own[ERROR].mean > 2 * s->order->max_error;
}

/* What missed the limit by no more than its seeds scatter may hold on others. */
static void judge(const ll_advise_search *s, ll_trial *t)
{
    double error = t->own[ERROR].mean, limit = s->order->max_error;
    bool all = t->runs == s->experiment->head.repeats;
    bool single = all && t->runs == 1 && s->experiment->base.kind->no_rare_events;
    if (t->failed > 0)
        ll_advise_rule_out(t, t->lacking == t->failed ? "a run has no such error or cost" : "a run failed");
    else if (error > limit && (single || error - ll_advise_half(s, t) > limit))
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

/* Where a run fails, errors are no less than the worst that was seen. */
static double worst_error(const ll_advise_search *s)
{
    double worst = s->order->max_error;
    for (int p = 0; p < s->points; p++)
        worst = fmax(worst, s->trials[p].own[ERROR].mean);
    return ll_detmath_log(worst) + FAILED;
}

static void tell(ll_advise_search *s, int point)
{
    const ll_trial *t = &s->trials[point];
    double limit = ll_detmath_log(s->order->max_error), values[2];
    double seen = ll_advise_pooled(t).mean * (1 + MARGIN * s->scatter);
    double error =
        t->runs == 0 ? worst_error(s) : ll_detmath_log(fmax(seen, TINY)) + ll_advise_shift(s, t, ERROR);
    values[COST] = ll_detmath_log(fmax(t->own[COST].mean, TINY)) + ll_advise_shift(s, t, COST);
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
                ll_advise_is_dearer(t, best);
    return !sure || ll_advise_beats(t, best);
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
            status = ll_advise_run(s, point, false);
        judge(s, t);
        next *= 2;
    } while (!ll_failed(&status) && t->state == OPEN && s->runs < s->most - s->kept &&
             (s->best < 0 || ll_advise_beats(t, &s->trials[s->best])));
    if (!ll_failed(&status))
        tell(s, point);
    find_best(s);
    return status;
}

static ll_status verify(ll_advise_search *s, int point)
{
    ll_status status = ll_advise_verify(s, point);
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
    double chance = ll_normal_cdf((ll_detmath_log(s->order->max_error) - mean[ERROR]) / deviation[ERROR]);
    if (s->best < 0)
        return chance * ll_exp(-0.02 * (mean[COST] - ll_detmath_log(TINY)));
    double saved = ll_detmath_log(fmax(s->trials[s->best].own[COST].mean, TINY)) - mean[COST],
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
        bool open = t->state == OPEN || t->state == HOPELESS;
        if (open && may_beat(s, t) &&
            (!other || t->state < other->state || (t->state == other->state && ll_advise_beats(t, other))))
            found = p;
    }
    return found;
}

/* Of those that hold or may hold, and were not verified, the one for which that takes the fewest runs; -1:
 * there is none for which they are left, or one was verified. */
static int surest(const ll_advise_search *s)
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

static double dearest(const ll_advise_search *s)
{
    double most = TINY;
    for (int p = 0; p < s->points; p++)
        most = fmax(most, s->trials[p].own[COST].mean);
    return most;
}

/* The variance of differences of costs by seed, over all settings that may be advised. */
static double variance_of_costs(const ll_advise_search *s, const ll_trial *against)
{
    double squares = 0, n = 0;
    for (int p = 0; p < s->points; p++) {
        const ll_trial *t = &s->trials[p];
        if (t->state != HOLDS && t->state != UNCLEAR && t->state != VERIFIED)
            continue;
        ll_sums apart = ll_advise_apart(t, against);
        squares += apart.squares;
        n += apart.n > 1 ? (double)(apart.n - 1) : 0;
    }
    return n > 0 ? squares / n : 0;
}

/* What a setting may well save against the one that is advised, as a part of the cost; 0: it is not worth to
 * be looked at. Where costs differ by seed that is a bound of the mean of their differences, whose variance
 * is moderated by that of all settings, and of few seeds no less: they may be alike by chance. */
static double saving(const ll_trial *t, const ll_trial *against, double variance)
{
    ll_sums apart = ll_advise_apart(t, against);
    double n = (double)apart.n, cost = fmax(against->own[COST].mean, TINY);
    double own = (apart.squares + FREEDOM * variance) / (n - 1 + FREEDOM);
    double deviation = sqrt((apart.n < FEW_SEEDS ? fmax(own, variance) : own) / n);
    double saved = (SURE * deviation - apart.mean) / cost;
    if (deviation > 0)
        return saved > CLOSE ? saved : 0;
    return saved > 0 ? saved : ll_advise_beats(t, against) ? TINY : 0;
}

/* The one whose fresh seeds are worth most: the saving against what is verified (before that against the
 * dearest, and twice as much), times the chance that it holds, for each run that it may take to show that.
 * -1: nothing more can be shown. */
static int worthiest(const ll_advise_search *s, int shown)
{
    int found = -1;
    double most = 0, none = ll_detmath_log(2 * dearest(s));
    double variance = shown < 0 ? 0 : variance_of_costs(s, &s->trials[shown]);
    for (int p = 0; p < s->points; p++) {
        const ll_trial *t = &s->trials[p];
        if (t->state != HOLDS && t->state != UNCLEAR)
            continue;
        double saved = shown < 0 ? none - ll_detmath_log(fmax(t->own[COST].mean, TINY))
                                 : saving(t, &s->trials[shown], variance);
        double value = saved * ll_advise_chance(s, t) / ll_advise_price(s, t);
        bool same = found >= 0 && fabs(value - most) <= TINY * most;
        if (same ? ll_advise_beats(t, &s->trials[found]) : value > most) {
            most = value;
            found = p;
        }
    }
    return found;
}

/* Of the verified the one that may yet save most against the cheapest of them, where costs differ by seed; or
 * that one, if it has fewer seeds. -1: none is worth it. */
static int rival(const ll_advise_search *s, int shown)
{
    int found = -1;
    double most = 0, variance = shown < 0 ? 0 : variance_of_costs(s, &s->trials[shown]);
    for (int p = 0; shown >= 0 && p < s->points; p++) {
        const ll_trial *t = &s->trials[p];
        double saved = t->state == VERIFIED && p != shown ? saving(t, &s->trials[shown], variance) : 0;
        if (saved > most && t->fresh[ERROR].n < LL_ADVISE_FRESH_MOST) {
            most = saved;
            found = p;
        }
    }
    return found >= 0 && s->trials[shown].fresh[ERROR].n < s->trials[found].fresh[ERROR].n ? shown : found;
}

/* The worthiest, as long as enough runs are left for the surest, so that in the end something is advised. */
static int to_verify(const ll_advise_search *s, int sure, int shown)
{
    int worth = worthiest(s, shown);
    if (worth < 0 || sure < 0 || sure == worth)
        return worth < 0 ? sure : worth;
    double left = (double)(s->most - s->runs) - ll_advise_next(s, &s->trials[worth]);
    return left < ll_advise_needed(s, &s->trials[sure]) ? sure : worth;
}

/* Runs that are kept for verifying what was found. */
static int64_t keep(const ll_advise_search *s, int sure)
{
    bool found = s->best >= 0 && s->trials[s->best].state == HOLDS;
    double wanted = found ? ll_advise_needed(s, &s->trials[s->best]) + 1 : 0;
    if (sure >= 0 && sure != s->best)
        wanted += ll_advise_needed(s, &s->trials[sure]);
    return (int64_t)fmin(wanted, (double)(s->most - s->runs));
}

/* The cheapest that would be the best if more fresh seeds showed that it holds; -1: there is none. */
static int cheapest_unsure(const ll_advise_search *s)
{
    int found = -1;
    for (int p = 0; p < s->points; p++) {
        const ll_trial *t = &s->trials[p];
        if (ll_advise_is_unsure(t) && (s->best < 0 || ll_advise_beats(t, &s->trials[s->best])) &&
            (found < 0 || ll_advise_beats(t, &s->trials[found])))
            found = p;
    }
    return found;
}

/* One step of the search: a point is tried, run again or verified. False: nothing is left to be known. What
 * is found is verified when nothing promises to be better, or when no more runs are left than that takes. */
static bool act(ll_advise_search *s, ll_status *status)
{
    double most;
    int untried = most_promising(s, &most), open = cheapest_open(s), sure = surest(s);
    bool promising = untried >= 0 && (s->best < 0 || most >= WORTH);
    s->kept = keep(s, sure);
    bool last = s->kept > 0 && s->most - s->runs <= s->kept;
    int shown = ll_advise_cheapest(s, ll_advise_is_verified);
    int next = to_verify(s, sure, shown), close = next < 0 ? rival(s, shown) : -1;
    if (next < 0 && close < 0) { /* nothing is left to be verified: runs are kept for nothing */
        s->kept = 0;
        last = false;
    }
    if (promising && !last)
        *status = try_point(s, untried);
    else if (open >= 0 && s->trials[open].state == OPEN && !last)
        *status = try_point(s, open);
    else if (next >= 0)
        *status = verify(s, next);
    else if (close >= 0)
        *status = verify(s, close);
    else if (open >= 0)
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
    *proven = *proven && cheapest_unsure(s) < 0; /* what may hold, and may be the best, is no proof */
    return status.code == LL_LIMIT ? ll_ok() : status;
}

ll_status ll_advise_check(const ll_advise_request *order)
{
    const ll_experiment *e = order->experiment;
    if (!(order->max_error > 0 && isfinite(order->max_error)))
        return ll_field_error(LL_BAD_INPUT, "max_error", "max_error: must be above 0; got %g",
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

int64_t ll_advise_runs(const ll_advise_request *order)
{
    const ll_experiment *e = order->experiment;
    if (order->most_runs > 0)
        return order->most_runs;
    bool matter = e->head.repeats > 1 && !e->base.kind->no_rare_events;
    int64_t part = e->runs / (matter ? 5 : 10) * 2;
    return (part > LEAST_RUNS ? part : LEAST_RUNS) + (matter ? 2 * LL_ADVISE_FRESH_MOST : 0);
}

ll_status ll_advise(const ll_advise_request *order, cJSON **answer)
{
    const ll_experiment *e = order->experiment;
    ll_status status = ll_advise_check(order);
    *answer = NULL;
    if (ll_failed(&status))
        return status;
    bool proven = false;
    ll_advise_search s = {.order = order, .experiment = e, .fresh = *e, .points = (int)e->points, .best = -1};
    s.fresh.head.repeats = e->head.repeats + LL_ADVISE_FRESH_MOST;
    s.most = ll_advise_runs(order);
    s.trials = calloc((size_t)e->points, sizeof *s.trials);
    status = s.trials ? ll_surrogate_create(e, s.most, &s.surrogate)
                      : ll_error(LL_NO_MEMORY, "no memory for the adviser");
    if (!ll_failed(&status))
        status = look(&s, &proven);
    if (!ll_failed(&status))
        *answer = ll_advise_answer(&s, proven);
    ll_surrogate_free(s.surrogate);
    ll_advise_free_trials(&s);
    return status;
}
