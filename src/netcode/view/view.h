/* Exchangeable parts that decide where a client draws the entities of others, one table each. */
#pragma once

#include "netcode/state/client.h"

struct ll_stretch;

/* Between two snapshots. */
typedef struct ll_interpolation {
    /* The entity at fraction `alpha`, 0 to 1, of the way from `a` to `b`, which is `span_s` > 0 later. Sets
     * the pose and its velocities; the caller sets the flags. */
    void (*between)(const ll_entity *a, const ll_entity *b, double alpha, double span_s, ll_entity *out);

    bool settles; /* between equal states an entity is at rest, at any velocity */

    /* The same for all entities of a stretch, flags too: a call for each would cost more than its work. */
    void (*all)(const struct ll_stretch *stretch);
} ll_interpolation;

/* From the entities of one snapshot to those of another. */
typedef struct ll_stretch {
    const ll_entity *a, *b;
    ll_entity *out;
    int count, self; /* `self` is left out */
    double alpha, span_s;
} ll_stretch;

/* A method's `all`, of its `between`. */
static inline void ll_interpolate_all(const ll_stretch *stretch,
                                      void (*between)(const ll_entity *, const ll_entity *, double, double,
                                                      ll_entity *))
{
    const ll_stretch p = *stretch; /* a copy: what is written to an entity cannot change it */
    for (int i = 0; i < p.count; i++) {
        const ll_entity *a = &p.a[i], *b = &p.b[i];
        ll_entity *out = &p.out[i];
        if (i == p.self)
            continue;
        if (p.alpha > 0 && ((a->flags ^ b->flags) & LL_ENTITY_ACTIVE) == 0) {
            between(a, b, p.alpha, p.span_s, out);
            out->flags = a->flags;
        } else { /* at a, or a flight began or ended */
            *out = *a;
        }
    }
}

extern const ll_interpolation ll_interpolation_linear, ll_interpolation_hermite;

/* How far behind the server's clock, as brought by the fastest recent snapshot, the others are drawn. */
typedef struct ll_interpolation_delay {
    ll_time (*delay)(const ll_client *client, const ll_player_config *config);
} ll_interpolation_delay;

/* How render time follows its target, which moves when the link or the delay changes. */
typedef struct ll_time_scale {
    /* Correction of this frame's advance of render time, beyond the frame's own length. `error`: how far it
     * would be behind its target (negative: ahead) without correction. */
    ll_time (*extra)(ll_client *client, ll_time error);

    /* Further behind than this it jumps to its target, further ahead it stands still. */
    ll_time (*limit)(const ll_client *client);
} ll_time_scale;

/* NULL-terminated; the index is the choice of the player's parameter. */
extern const ll_interpolation *const ll_interpolations[];
extern const ll_interpolation_delay *const ll_interpolation_delays[];
extern const ll_time_scale *const ll_time_scales[];
extern const char *const ll_interpolation_names[];
extern const char *const ll_interpolation_delay_names[];
extern const char *const ll_time_scale_names[];
