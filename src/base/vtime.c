/* Products such as k * 1e12 do not fit in 64 bits, so both directions divide before they multiply and carry
 * the remainders: every intermediate below is exact and below 2^63. */
#include "base/vtime.h"

#define TURN_NS INT64_C(1000000000000) /* `freq` ticks of `freq` mHz take 1000 s */
#define FREQ_MAX INT64_C(1000000000)

typedef struct quotient {
    int64_t whole, rest; /* rest >= 0 */
} quotient;

static quotient floor_divide(int64_t a, int64_t b)
{
    quotient q = {a / b, a % b};
    if (q.rest < 0) {
        q.whole--;
        q.rest += b;
    }
    return q;
}

ll_freq ll_freq_from_hz(double hz)
{
    double mhz = hz * 1000 + 0.5;
    if (!(mhz >= 1)) /* NaN too */
        return 1;
    return mhz >= (double)FREQ_MAX ? FREQ_MAX : (ll_freq)mhz;
}

/* floor(k * 1e12 / freq). `freq` ticks take 1e12 ns exactly; of the rest r < freq, 1e12 = a * freq + b gives
 * r * 1e12 / freq = r * a + r * b / freq with r, b < 1e9. */
ll_time ll_tick_time(int64_t k, ll_freq freq)
{
    if (k >= 0 && k <= INT64_MAX / TURN_NS) /* ticks of less than days: one division instead of three */
        return k * TURN_NS / freq;
    quotient turns = floor_divide(k, freq);
    int64_t a = TURN_NS / freq;
    int64_t b = TURN_NS % freq;
    return turns.whole * TURN_NS + turns.rest * a + turns.rest * b / freq;
}

/* Tick k is at or before t if and only if k * 1e12 < (t + 1) * freq, so k = floor(((t + 1) * freq - 1) /
 * 1e12). t + 1 is split into multiples of 1e12 ns and a rest of two digits to the base of 1e6. */
int64_t ll_tick_at(ll_time t, ll_freq freq)
{
    const int64_t base = 1000000;
    quotient turns = floor_divide(t, TURN_NS);
    int64_t rest = turns.rest + 1;
    int64_t high = rest / base * freq; /* in units of 1e6 */
    int64_t low = high % base * base + rest % base * freq - 1;
    return turns.whole * freq + high / base + floor_divide(low, TURN_NS).whole;
}
