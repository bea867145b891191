/* Repeating is right while a single packet is missing, but leaves a car at full throttle when its player is
 * gone. Neutral releases the pedal for every lost packet. Decay repeats at the start and ends neutral,
 * without a jump between: the axes decrease linearly. */
#include "netcode/server/starve.h"

static ll_action decay(const ll_action *last, int64_t age, const ll_starve_config *config)
{
    double left = (double)age < config->tau ? 1 - (double)age / config->tau : 0;
    return (ll_action){.axis = {(float)(last->axis[0] * left), (float)(last->axis[1] * left)}};
}

static ll_action repeat(const ll_action *last, int64_t age, const ll_starve_config *config)
{
    (void)age, (void)config;
    return ll_held(last);
}

static ll_action repeat_n(const ll_action *last, int64_t age, const ll_starve_config *config)
{
    return age <= config->steps ? ll_held(last) : (ll_action){0};
}

static ll_action neutral(const ll_action *last, int64_t age, const ll_starve_config *config)
{
    (void)last, (void)age, (void)config;
    return (ll_action){0};
}

#define STARVES(X) X(decay) X(repeat) X(repeat_n) X(neutral)
#define ROW(name) &(const ll_starve){name},
#define NAME(name) #name,

const ll_starve *const ll_starves[] = {STARVES(ROW) NULL};
const char *const ll_starve_names[] = {STARVES(NAME) NULL};
