#include "daemon/stream/pace.h"

#include "base/assert.h"

static const int divisors[] = {1, 2, 3, 4, 6, 8, 12, 16};

enum {
    STEPS = sizeof divisors / sizeof divisors[0],
    SLOW_PART = 5,      /* more than a fifth missed: too many */
    GOOD_PART = 20,     /* at most a twentieth missed: hardly any */
    PATIENCE_MOST = 15, /* half a minute, with the window itself */
    ATTEMPT = 3,        /* windows after which a higher rate has proved itself */
};

int ll_ws_pace_divisor(const ll_ws_pace *pace)
{
    LL_ASSERT(pace->step >= 0 && pace->step < STEPS);
    return divisors[pace->step];
}

int ll_ws_pace_worst_divisor(const ll_ws_pace *pace)
{
    LL_ASSERT(pace->worst >= pace->step && pace->worst < STEPS);
    return divisors[pace->worst];
}

/* The least divisor of the table with which the frames that came in this window would have been all, within
 * twice the present one: a page that stood still for a second is not a page that draws one frame a second. */
static int slower_step(const ll_ws_pace *pace)
{
    int now = divisors[pace->step], came = pace->due - pace->missed, step = pace->step;
    do {
        step++;
    } while (step + 1 < STEPS && divisors[step] * came < now * pace->due && divisors[step + 1] <= 2 * now);
    return step;
}

static void change(ll_ws_pace *pace, int step)
{
    pace->tried = step < pace->step;
    pace->step = step;
    pace->windows = pace->good = 0;
}

static void slow_down(ll_ws_pace *pace)
{
    bool failed = pace->tried && pace->windows <= ATTEMPT;
    pace->patience = failed ? 2 * pace->patience + 1 : 0;
    pace->patience = pace->patience < PATIENCE_MOST ? pace->patience : PATIENCE_MOST;
    change(pace, slower_step(pace));
}

static void remember(ll_ws_pace *pace, int64_t now_ns)
{
    if (pace->step >= pace->worst || now_ns - pace->worst_ns > LL_WS_PACE_MEMORY_NS) {
        pace->worst = pace->step;
        pace->worst_ns = now_ns;
    }
}

static void judge_window(ll_ws_pace *pace)
{
    pace->windows++;
    pace->good = pace->missed * GOOD_PART <= pace->due ? pace->good + 1 : 0;
    if (pace->missed * SLOW_PART > pace->due && pace->step + 1 < STEPS)
        slow_down(pace);
    else if (pace->step > 0 && pace->good > pace->patience)
        change(pace, pace->step - 1);
}

bool ll_ws_pace_count(ll_ws_pace *pace, bool missed, int64_t now_ns)
{
    int before = pace->step;
    pace->due++;
    pace->missed += missed;
    if (pace->since_ns != 0 && now_ns - pace->since_ns < LL_WS_PACE_WINDOW_NS)
        return false;
    if (pace->since_ns != 0) { /* the first frame of all only begins a window */
        judge_window(pace);
        remember(pace, now_ns);
    }
    pace->since_ns = now_ns;
    pace->due = pace->missed = 0;
    return pace->step != before;
}
