/* Repeating is right while a single packet is missing, but leaves a car at full throttle when its player is
 * gone. Neutral releases the pedal for every lost packet. Decay repeats at the start and ends neutral,
 * without a jump between. */
#include "netcode/server/starve.h"

static ll_action decay(const ll_action *last, int64_t age, const ll_starve_config *config)
{
    double left = (double)age < config->tau ? 1 - (double)age / config->tau : 0;
    return (ll_action){.axis = {(float)(last->axis[0] * left), (float)(last->axis[1] * left)}};
}

static ll_action repeat(const ll_action *last, int64_t age, const ll_starve_config *config)
{
    (void)age;
    (void)config;
    return ll_held(last);
}

static ll_action repeat_n(const ll_action *last, int64_t age, const ll_starve_config *config)
{
    return age <= config->steps ? ll_held(last) : (ll_action){0};
}

static ll_action neutral(const ll_action *last, int64_t age, const ll_starve_config *config)
{
    (void)last;
    (void)age;
    (void)config;
    return (ll_action){0};
}

const ll_starve ll_starve_decay = {
    .name = "decay",
    .help = "The axes decrease linearly to zero within starved_tau_ms.",
    .act = decay,
};

const ll_starve ll_starve_repeat = {
    .name = "repeat",
    .help = "The axes are kept without limit.",
    .act = repeat,
};

const ll_starve ll_starve_repeat_n = {
    .name = "repeat_n",
    .help = "The axes are kept for starved_ticks, then they are zero.",
    .act = repeat_n,
};

const ll_starve ll_starve_neutral = {
    .name = "neutral",
    .help = "The axes are zero at once.",
    .act = neutral,
};

const ll_starve *const ll_starves[] = {&ll_starve_decay, &ll_starve_repeat, &ll_starve_repeat_n,
                                       &ll_starve_neutral, NULL};

/* In the order of ll_starves; a test compares both. */
const char *const ll_starve_names[] = {"decay", "repeat", "repeat_n", "neutral", NULL};
