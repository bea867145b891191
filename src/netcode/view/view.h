/* What decides where a client draws the entities of others: the exchangeable parts, one table each. */
#pragma once

#include "netcode/state/client.h"

/* Between two states. */
typedef struct ll_interpolation {
    const char *name;
    const char *help;

    /* The entity at the share `alpha`, 0 to 1, of the way from `a` to `b`, which is `span_s` > 0 later. Sets
     * the pose and its speeds; flags are the caller's. */
    void (*between)(const ll_entity *a, const ll_entity *b, double alpha, double span_s, ll_entity *out);
} ll_interpolation;

extern const ll_interpolation ll_interpolation_linear;
extern const ll_interpolation ll_interpolation_hermite;

/* How far behind the server's clock, as the fastest recent state brought it, the others are drawn. */
typedef struct ll_interpolation_delay {
    const char *name;
    const char *help;
    ll_time (*delay)(const ll_client *client, const ll_player_config *config);
} ll_interpolation_delay;

extern const ll_interpolation_delay ll_interpolation_delay_ratio;
extern const ll_interpolation_delay ll_interpolation_delay_adaptive;

/* How the drawn time follows its target, which moves when the link or the delay changes. */
typedef struct ll_time_scale {
    const char *name;
    const char *help;

    /* By how much more than the frame's own length the drawn time moves, when it would be `error` behind its
     * target (negative: ahead) if it moved by that. */
    ll_time (*extra)(ll_client *client, ll_time error);

    /* Further behind than this it jumps to its target, further ahead it stands still. */
    ll_time (*limit)(const ll_client *client);
} ll_time_scale;

extern const ll_time_scale ll_time_scale_proportional;
extern const ll_time_scale ll_time_scale_catch_up;

/* NULL-terminated; the index is the choice of the player's row. */
extern const ll_interpolation *const ll_interpolations[];
extern const ll_interpolation_delay *const ll_interpolation_delays[];
extern const ll_time_scale *const ll_time_scales[];
extern const char *const ll_interpolation_names[];
extern const char *const ll_interpolation_delay_names[];
extern const char *const ll_time_scale_names[];
