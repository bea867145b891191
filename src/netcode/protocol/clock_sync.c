#include "netcode/protocol/clock_sync.h"

#include <stddef.h>

#include "base/assert.h"

/* ---- filters ---- */

static ll_time of_least_round_trip(const ll_clock_sample *samples, int count)
{
    const ll_clock_sample *best = samples;
    for (int i = 1; i < count; i++)
        if (samples[i].round_trip < best->round_trip)
            best = &samples[i];
    return best->offset;
}

static ll_time mean(const ll_clock_sample *samples, int count)
{
    ll_time sum = 0;
    for (int i = 0; i < count; i++)
        sum += samples[i].offset - samples[0].offset;
    return samples[0].offset + sum / count;
}

/* Of an even number the lower one. */
static ll_time median(const ll_clock_sample *samples, int count)
{
    ll_time sorted[LL_CLOCK_SAMPLES];
    for (int i = 0; i < count; i++) {
        int place = i;
        for (; place > 0 && sorted[place - 1] > samples[i].offset; place--)
            sorted[place] = sorted[place - 1];
        sorted[place] = samples[i].offset;
    }
    return sorted[(count - 1) / 2];
}

/* median: one late packet has no effect. min_rtt: best where delays have rare peaks. mean: best where they
 * are spread evenly. */
#define FILTERS(X) X(median, median) X(min_rtt, of_least_round_trip) X(mean, mean)
#define ROW(name, offset) &(const ll_clock_filter){offset},
#define NAME(name, offset) #name,

const ll_clock_filter *const ll_clock_filters[] = {FILTERS(ROW) NULL};
const char *const ll_clock_filter_names[] = {FILTERS(NAME) NULL};

/* ---- samples ---- */

static int kept(const ll_clock_sync *sync)
{
    return sync->count < LL_CLOCK_SAMPLES ? (int)sync->count : LL_CLOCK_SAMPLES;
}

/* Moves the offset in use towards `wanted`. */
static void follow(ll_clock_sync *sync, ll_time wanted, ll_time passed, bool snap)
{
    ll_time error = wanted - sync->offset, most = (ll_time)(LL_CLOCK_SLEW * (double)passed);
    if (snap || error >= LL_CLOCK_SNAP || error <= -LL_CLOCK_SNAP) {
        sync->snaps += !snap;
        sync->offset = wanted;
        return;
    }
    sync->offset += error > most ? most : error < -most ? -most : error;
}

void ll_clock_sync_add(ll_clock_sync *sync, const ll_clock_filter *filter, ll_time sent, ll_time server,
                       ll_time received, bool snap)
{
    ll_clock_sample *s = &sync->sample[sync->count % LL_CLOCK_SAMPLES];
    LL_ASSERT(received >= sent); /* times of one clock */
    s->round_trip = received - sent;
    s->offset = server - sent - s->round_trip / 2;
    sync->count++;
    follow(sync, filter->offset(sync->sample, kept(sync)), received - sync->at, snap);
    sync->at = received;
}

ll_time ll_clock_sync_round_trip(const ll_clock_sync *sync)
{
    ll_time longest = 0;
    for (int i = 0; i < kept(sync); i++)
        if (sync->sample[i].round_trip > longest)
            longest = sync->sample[i].round_trip;
    return longest;
}
