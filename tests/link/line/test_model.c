/* Links against a second implementation of docs/links.md: random parameters, sizes and times, also parameters
 * that change during a run. The model keeps the history of every packet without limit; it shares nothing with
 * the link but the parameters, exp, log, sin and the normal distribution. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "base/detmath.h"
#include "base/rng.h"
#include "link/harness.h"

enum { MESSAGES = 600, SIZE = 3000, PACKETS = MESSAGES * 48, SLOTS = 90, ARENA = SLOTS * SIZE };

/* ---- the model ---- */

enum { LOSS, DUPLICATE, DELAY, REORDER = 4, CORRUPT, TRANSITION };

/* State left by a packet for the one after it. */
typedef struct past {
    bool duplicated, corrupted, reordered, deviates;
    int asked, state; /* the loss model, from 1; 0: none */
    double deviate;
} past;

typedef struct arrived {
    ll_time due;
    int64_t message;
} arrived;

typedef struct model {
    uint64_t seed, link;
    int64_t messages, packets;
    past past[PACKETS]; /* [k + 1] is of packet k */
    int64_t since;
    ll_time entrance, exit, latest;
    ll_time left[2 * PACKETS]; /* E of all packets that the rate sent */
    int rated;
    arrived way[2 * MESSAGES];
    int on_way;
} model;

/* One packet or copy. */
typedef struct way {
    const ll_link_params *p;
    double lag;
    ll_time now;
    uint64_t counter;
    const past *before;
    past *own; /* NULL of a copy */
    int64_t bytes;
    bool room;
} way;

typedef struct fate {
    ll_fate fate;
    ll_time due;
} fate;

static uint64_t hash(uint64_t seed, uint64_t stream, uint64_t counter)
{
    uint64_t x = seed + (stream + 1) * 0xd1e8d69ec377210fU;
    x ^= x >> 32;
    x *= 0xd60927fc6f0de0d1U;
    x ^= x >> 29;
    x += counter * 0x9e3779b97f4a7c15U;
    x ^= x >> 33;
    x *= 0xaa78f731403321bbU;
    x ^= x >> 26;
    x *= 0xee9daf582aec48adU;
    return x ^ x >> 30;
}

static double percent(const model *m, const way *w, int stage)
{
    return 100 *
           ((double)(hash(m->seed, 8 * m->link + (uint64_t)stage, w->counter) >> 11) / 9007199254740992.0);
}

static ll_time ns(double ms)
{
    return (ll_time)floor(ms * 1e6 + 0.5);
}

static bool open_at(double at, double every, double length, ll_time now)
{
    ll_time since = now - ns(at);
    if (length <= 0 || since < 0)
        return false;
    return (every > 0 ? since % ns(every) : since) < ns(length);
}

static bool chain(const model *m, const way *w, int stage, double pct, double corr, bool before)
{
    return percent(m, w, stage) < pct * (1 - corr / 100) + (before ? corr : 0);
}

static bool loses(const model *m, const way *w, int *state)
{
    const ll_link_params *p = w->p;
    double t = percent(m, w, TRANSITION), u = percent(m, w, LOSS);
    int from = *state;
    if (p->loss_model == LL_LOSS_RANDOM)
        return (*state = chain(m, w, LOSS, p->loss_pct, p->loss_corr_pct, from));
    if (p->loss_model == LL_LOSS_GEMODEL) { /* 0 good, 1 bad */
        *state = t < (from ? p->ge_r_pct : p->ge_p_pct) ? !from : from;
        return u < (from ? p->ge_1h_pct : p->ge_1k_pct);
    }
    static const int numbers[] = {1, 2, 3, 4}; /* the state is one less */
    int now = numbers[from];
    if (now == 1)
        now = t < p->p14_pct ? 4 : t < p->p14_pct + p->p13_pct ? 3 : 1;
    else if (now == 2)
        now = t < p->p23_pct ? 3 : 2;
    else if (now == 3)
        now = t < p->p32_pct ? 2 : t < p->p32_pct + p->p31_pct ? 1 : 3;
    else
        now = 1;
    *state = now - 1;
    return now >= 3;
}

static bool loss_is_on(const ll_link_params *p)
{
    return p->loss_model != LL_LOSS_RANDOM || p->loss_pct > 0 || p->blackout_length_ms > 0;
}

static double variate(int distribution, double u)
{
    const double a = 3.16712418331199e-05;
    double normal = ll_normal_quantile(a + u * (1 - 2 * a)) / 0.999464501807080;
    double pareto = (ll_exp(ll_detmath_log(1 - u * 0.999) * (-1.0 / 3)) - 55.0 / 37) / 0.702182759825220524;
    double values[] = {2 * u - 1, normal, pareto, (normal + 3 * pareto) / (4 * 0.957961055882941)};
    _Static_assert(sizeof values / sizeof values[0] == LL_DISTRIBUTIONS, "a formula of each");
    return values[distribution];
}

static double corr_of(int distribution, double c)
{
    double values[] = {2 * ll_sin(c * (3.14159265358979323846 / 6)), c,
                       c * (1.63449 + c * (-1.24896 + c * (1.10949 + c * (-0.678146 + c * 0.183126)))),
                       c * (1.3142 + c * (-0.4234 + c * (0.140642 + c * -0.031442)))};
    _Static_assert(sizeof values / sizeof values[0] == LL_DISTRIBUTIONS, "a formula of each");
    return values[distribution];
}

static double delay_of(const model *m, const way *w)
{
    const ll_link_params *p = w->p;
    double d = w->lag + p->delay_ms;
    if (p->jitter_ms > 0) {
        double u = percent(m, w, DELAY) / 100;
        if (p->delay_corr_pct > 0) {
            uint64_t word = hash(m->seed, 8 * m->link + DELAY, w->counter);
            double z = ll_normal_quantile(((double)(word >> 12) + 0.5) / 4503599627370496.0);
            double r = corr_of(p->distribution, p->delay_corr_pct / 100);
            if (w->before->deviates)
                z = r * w->before->deviate + sqrt(1 - r * r) * z;
            if (w->own) {
                w->own->deviates = true;
                w->own->deviate = z;
            }
            u = ll_normal_cdf(z);
        }
        d += p->jitter_ms * variate(p->distribution, u);
    }
    d = larger(d, 0);
    if (open_at(p->spike_at_ms, p->spike_every_ms, p->spike_length_ms, w->now))
        d += p->spike_add_ms;
    return d;
}

static bool too_full(const model *m, const way *w, double t)
{
    const ll_link_params *p = w->p;
    int waiting = 0, places = SLOTS + ARENA / 1200 < 1000 ? SLOTS + ARENA / 1200 : 1000;
    for (int i = m->rated - 1; i >= 0 && m->left[i] > w->now; i--)
        waiting++;
    ll_time begin = m->entrance > w->now ? m->entrance : w->now;
    return t > p->limit_ms || begin - w->now + ns(t) > ns(p->limit_ms) || waiting >= p->limit_packets ||
           waiting >= places;
}

static bool goes_ahead(model *m, const way *w)
{
    const ll_link_params *p = w->p;
    if (p->reorder_pct <= 0)
        return false;
    bool happens = chain(m, w, REORDER, p->reorder_pct, p->reorder_corr_pct, w->before->reordered);
    bool ahead = happens && m->since >= p->reorder_gap - 1;
    if (w->own) {
        w->own->reordered = happens;
        m->since = ahead ? 0 : m->since + 1;
    }
    return ahead;
}

/* The stages after the loss. */
static fate goes(model *m, const way *w, bool lost)
{
    const ll_link_params *p = w->p;
    bool damaged =
        p->corrupt_pct > 0 && chain(m, w, CORRUPT, p->corrupt_pct, p->corrupt_corr_pct, w->before->corrupted);
    if (w->own)
        w->own->corrupted = damaged;
    double t = p->rate_kbps > 0 ? 8.0 * (double)(w->bytes + p->packet_overhead_bytes) / p->rate_kbps : 0;
    bool dropped = !w->room || (p->rate_kbps > 0 && too_full(m, w, t));
    double d = delay_of(m, w);
    bool ahead = goes_ahead(m, w);
    if (lost || dropped)
        return (fate){lost ? LL_FATE_LOST : LL_FATE_OVERFLOW, w->now};
    ll_time due = w->now + ns(ahead ? w->lag : d);
    if (p->rate_kbps > 0 && !ahead) {
        m->exit = (m->exit > due ? m->exit : due) + ns(t);
        m->entrance = (m->entrance > w->now ? m->entrance : w->now) + ns(t);
        m->left[m->rated++] = m->entrance;
        due = m->exit;
    }
    if (damaged)
        return (fate){LL_FATE_CORRUPTED, due};
    if (p->order == LL_ORDER_FIFO && due < m->latest)
        due = m->latest;
    m->latest = due > m->latest ? due : m->latest;
    return (fate){LL_FATE_DELIVERED, due};
}

/* Result of a packet and its copy. Whole messages take their place at once. */
static ll_sending model_packet(model *m, way w, bool whole)
{
    const ll_link_params *p = w.p;
    int64_t k = m->packets++;
    past *own = &m->past[k + 1];
    w.before = &m->past[k];
    w.own = own;
    own->duplicated = p->duplicate_pct > 0 &&
                      chain(m, &w, DUPLICATE, p->duplicate_pct, p->duplicate_corr_pct, w.before->duplicated);
    bool lost = false, dark = open_at(p->blackout_at_ms, p->blackout_every_ms, p->blackout_length_ms, w.now);
    if (loss_is_on(p)) {
        own->asked = p->loss_model + 1;
        own->state = w.before->asked == own->asked ? w.before->state : 0;
        lost = loses(m, &w, &own->state);
    }
    bool rescued = lost && own->duplicated && !dark;
    fate first = goes(m, &w, dark || (lost && !rescued));
    if (whole && first.fate == LL_FATE_DELIVERED)
        m->way[m->on_way++] = (arrived){first.due, m->messages};
    ll_sending s = {.fate = first.fate, .due = first.due, .duplicated = own->duplicated, .rescued = rescued};
    if (!own->duplicated || rescued)
        return s;
    int state = own->state;
    w.counter = UINT64_MAX - w.counter;
    w.before = own;
    w.own = NULL;
    w.room = w.room && (!whole || m->on_way < SLOTS);
    lost = loss_is_on(p) && loses(m, &w, &state);
    fate second = goes(m, &w, lost || dark);
    if (whole && second.fate == LL_FATE_DELIVERED)
        m->way[m->on_way++] = (arrived){second.due, m->messages};
    s.copy_fate = second.fate;
    s.copy_due = second.due;
    return s;
}

static ll_sending model_send(model *m, const ll_link_params *p, double lag, ll_time now, int size)
{
    int64_t n = p->mtu_bytes > 0 && size > p->mtu_bytes ? (size - 1) / p->mtu_bytes + 1 : 1;
    bool room = m->on_way < SLOTS;
    ll_sending all = {.fate = LL_FATE_DELIVERED, .due = now};
    for (int64_t f = 0; f < n; f++) {
        int64_t rest = size - f * p->mtu_bytes;
        way w = {.p = p, .lag = lag, .now = now, .room = room};
        w.counter = (uint64_t)(m->messages + f * (INT64_C(1) << 40));
        w.bytes = n == 1 ? size : (rest < p->mtu_bytes ? rest : p->mtu_bytes) + 4;
        ll_sending s = model_packet(m, w, n == 1);
        if (n == 1) {
            all = s;
            break;
        }
        bool a = s.fate == LL_FATE_DELIVERED,
             b = s.duplicated && !s.rescued && s.copy_fate == LL_FATE_DELIVERED;
        ll_time when = a && b ? (s.due < s.copy_due ? s.due : s.copy_due) : a ? s.due : s.copy_due;
        if (all.fate == LL_FATE_DELIVERED && (a || b))
            all.due = when > all.due ? when : all.due;
        else if (all.fate == LL_FATE_DELIVERED)
            all = (ll_sending){.fate = s.fate, .due = s.due};
    }
    if (n > 1 && all.fate == LL_FATE_DELIVERED)
        m->way[m->on_way++] = (arrived){all.due, m->messages};
    all.fragments = (int32_t)n;
    m->messages++;
    return all;
}

/* The next due at or before `now`; -1 without any. */
static int64_t model_receive(model *m, ll_time now, ll_time *due)
{
    int best = -1;
    for (int i = 0; i < m->on_way; i++)
        if (m->way[i].due <= now && (best < 0 || m->way[i].due < m->way[best].due))
            best = i;
    if (best < 0)
        return -1;
    int64_t message = m->way[best].message;
    *due = m->way[best].due;
    m->on_way--;
    memmove(&m->way[best], &m->way[best + 1], (size_t)(m->on_way - best) * sizeof m->way[0]);
    return message;
}

/* ---- random parameters ---- */

typedef struct dice {
    uint64_t trial, next;
} dice;

static double roll(dice *d, double from, double to)
{
    return from + (to - from) * ll_rng_unit(4711, d->trial, d->next++);
}

static bool with(dice *d, double share)
{
    return roll(d, 0, 1) < share;
}

static double pct(dice *d, double share)
{
    return with(d, share) ? roll(d, 0, 60) : 0;
}

static ll_link_params random_params(dice *d)
{
    ll_link_params p = link_params();
    p.delay_ms = roll(d, 1, 120);
    p.jitter_ms = with(d, 0.7) ? roll(d, 0, 90) : 0;
    p.distribution = (int)roll(d, 0, LL_DISTRIBUTIONS);
    p.delay_corr_pct = with(d, 0.4) ? roll(d, 0, 99) : 0;
    p.loss_model = (int)roll(d, 0, LL_LOSSES);
    p.loss_pct = pct(d, 0.6);
    p.loss_corr_pct = pct(d, 0.4);
    p.ge_p_pct = pct(d, 1), p.ge_r_pct = pct(d, 1), p.ge_1h_pct = pct(d, 1), p.ge_1k_pct = pct(d, 0.5);
    p.p13_pct = roll(d, 0, 50), p.p14_pct = roll(d, 0, 50), p.p31_pct = roll(d, 0, 50);
    p.p32_pct = roll(d, 0, 50), p.p23_pct = roll(d, 0, 100);
    p.duplicate_pct = pct(d, 0.6);
    p.duplicate_corr_pct = pct(d, 0.4);
    p.corrupt_pct = pct(d, 0.3);
    p.corrupt_corr_pct = pct(d, 0.4);
    if (with(d, 0.3)) {
        p.blackout_at_ms = roll(d, 0, 3000), p.blackout_length_ms = roll(d, 1, 700);
        p.blackout_every_ms = with(d, 0.5) ? 1500 : 0;
    }
    if (with(d, 0.3)) {
        p.spike_at_ms = roll(d, 0, 3000), p.spike_length_ms = roll(d, 1, 700),
        p.spike_add_ms = roll(d, 0, 200);
        p.spike_every_ms = with(d, 0.5) ? 900 : 0;
    }
    if (with(d, 0.5)) {
        p.rate_kbps = pow(10, roll(d, 1.5, 4));
        p.limit_ms = roll(d, 1, with(d, 0.5) ? 300 : 1250);
        p.limit_packets = (int64_t)(with(d, 0.5) ? 1000 : roll(d, 1, 30));
        p.packet_overhead_bytes = (int64_t)roll(d, 0, 100);
    }
    p.order = with(d, 0.3) ? LL_ORDER_FIFO : LL_ORDER_FREE;
    if (p.order == LL_ORDER_FREE && with(d, 0.4)) {
        p.reorder_pct = roll(d, 1, 100);
        p.reorder_corr_pct = pct(d, 0.4);
        p.reorder_gap = (int64_t)roll(d, 1, 6);
    }
    p.mtu_bytes = with(d, 0.3) ? 0 : with(d, 0.5) ? 1200 : (int64_t)(64 + 900 * pow(roll(d, 0, 1), 3));
    assert_string_equal(ll_link_table.check(&p, "").text, "");
    return p;
}

typedef struct totals {
    int64_t fates[4], split, rescued, copies, received;
} totals;

static void compare(const ll_sending *a, const ll_sending *b, uint64_t trial, int64_t i)
{
    bool same = a->fate == b->fate && a->due == b->due && a->fragments == b->fragments;
    if (b->fragments == 1) {
        same = same && a->duplicated == b->duplicated && a->rescued == b->rescued;
        if (b->duplicated && !b->rescued)
            same = same && a->copy_fate == b->copy_fate && a->copy_due == b->copy_due;
    }
    if (!same)
        fail_msg("trial %d, message %d: fate %d, due %lld; by the model %d, %lld", (int)trial, (int)i,
                 (int)a->fate, (long long)a->due, (int)b->fate, (long long)b->due);
}

static void receive_all(ll_link *link, model *m, ll_time now, totals *t)
{
    static char bytes[SIZE];
    for (;;) {
        ll_time sent, due = 0, wanted = 0;
        int64_t message = model_receive(m, now, &wanted), got = -1;
        int size = ll_link_receive(link, now, bytes, SIZE, &sent, &due);
        if (size >= 0)
            memcpy(&got, bytes, sizeof got);
        assert_int_equal(got, message);
        if (got < 0)
            return;
        assert_int_equal(due, wanted);
        t->received++;
    }
}

static void one_trial(uint64_t trial, model *m, totals *t)
{
    static char bytes[SIZE];
    dice d = {.trial = trial};
    ll_link_params params = random_params(&d);
    double lag = roll(&d, 0, 100), pace = roll(&d, 1, 40), longest = roll(&d, 8, SIZE);
    bool changes = with(&d, 0.4);
    uint64_t seed = ll_rng_u64(99, trial, 0), number = trial % 16;
    memset(m, 0, sizeof *m);
    m->seed = seed;
    m->link = number;
    ll_link *link = link_open(SLOTS, ARENA, seed, number);
    ll_time now = 0;
    for (int64_t i = 0; i < MESSAGES; i++) {
        now += with(&d, 0.1) ? 0 : ns(roll(&d, 0, 2 * pace));
        if (changes && with(&d, 0.02))
            params = random_params(&d);
        receive_all(link, m, now, t);
        int size = (int)roll(&d, 8, longest);
        memcpy(bytes, &i, sizeof i);
        ll_sending b = model_send(m, &params, lag, now, size);
        ll_sending a = link_send(link, &params, lag, now, bytes, size);
        compare(&a, &b, trial, i);
        t->fates[a.fate]++;
        t->split += a.fragments > 1;
        t->rescued += a.rescued;
        t->copies += a.duplicated && !a.rescued;
    }
    receive_all(link, m, LL_NEVER - 1, t);
    assert_int_equal(m->packets, ll_link_get_stats(link)->sent);
    free(link);
}

static void links_do_what_the_docs_say(void **state)
{
    (void)state;
    model *m = malloc(sizeof *m);
    totals t = {0};
    for (uint64_t trial = 0; trial < 1000; trial++)
        one_trial(trial, m, &t);
    for (int i = 0; i < 4; i++) /* the test covers the case */
        assert_true(t.fates[i] > 20000);
    assert_true(t.split > 100000 && t.rescued > 5000 && t.copies > 20000 && t.received > 100000);
    free(m);
}

/* The draws that docs/links.md lists. */
static void draws_are_those_of_the_docs(void **state)
{
    (void)state;
    static const struct {
        uint64_t seed, stream, counter, draw;
        double unit;
    } rows[] = {
        {1, 0, 0, 0x031d980289ad1c32, 0.012170315379695373},
        {1, 0, 1, 0x459d7a916305a578, 0.2719341854999784},
        {1, 2, 0, 0x14242058c52fe36c, 0.07867624442332},
        {7, 12, 12345, 0xba815bdabb904261, 0.7285363587394054},
        {1, 8, 5 + (UINT64_C(3) << 40), 0x55fb3b8581967234, 0.33586475381306413},
        {1, 0, UINT64_MAX - 5, 0x4c78a29342d922eb, 0.29871574492685626},
    };
    for (int i = 0; i < 6; i++) {
        assert_true(hash(rows[i].seed, rows[i].stream, rows[i].counter) == rows[i].draw);
        assert_true(ll_rng_u64(rows[i].seed, rows[i].stream, rows[i].counter) == rows[i].draw);
        assert_true(ll_rng_unit(rows[i].seed, rows[i].stream, rows[i].counter) == rows[i].unit);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(links_do_what_the_docs_say),
        cmocka_unit_test(draws_are_those_of_the_docs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
