/* The rules of a game behind one interface.
 *
 * A world is a flat struct that can be copied by memcpy: a header, the entities (entity i belongs to player
 * i; later ones belong to no player), and the game's own tail. Steps are pure functions of (world,
 * environment, actions): the server and every client run the same code. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/vtime.h"
#include "input/action.h"
#include "param/param.h"
#include "record/metric.h"

#define LL_ENTITIES_MAX 1064                          /* LL_PLAYERS_MAX players and 1,000 more */
#define LL_ENTITY_WORDS ((LL_ENTITIES_MAX + 63) / 64) /* a bit per entity */
#define LL_TOUCHING_MAX 255                           /* entities of a game that is not `many` */
#define LL_GAME_WORLD_MAX 60000                       /* bytes, including the tail */
#define LL_GAME_PARAMS 13                             /* numbers in which a game's parameters lie */
#define LL_GAME_VALUES 4                              /* a game's own numbers per player, for views */

struct ll_past;
struct ll_weapons;

typedef enum ll_entity_flag {
    LL_ENTITY_FINISHED = 1,
    LL_ENTITY_ACTIVE = 16,    /* a projectile in flight */
    LL_ENTITY_AWAY = 128,     /* its player is not connected */
    LL_ENTITY_UNSETTLED = 64, /* zero velocity but not at rest: it overlaps something */
    LL_ENTITY_UNKNOWN = 256,  /* only at a client: snapshots do not contain it */
} ll_entity_flag;

typedef struct ll_entity {
    double x, y;             /* m */
    double vx, vy;           /* m/s */
    double angle;            /* rad */
    double angular_velocity; /* rad/s */
    uint64_t flags;
} ll_entity;

typedef struct ll_world {
    int32_t players;
    int32_t entities; /* players' first */
    int32_t tail;     /* bytes after the entities */
    int32_t reserved;
    ll_entity entity[];
} ll_world;

/* Sizes of a world beyond its header. */
typedef struct ll_extent {
    int entities; /* players <= entities <= LL_ENTITIES_MAX */
    int tail;     /* bytes, a multiple of 8 */
} ll_extent;

/* What a game keeps outside the world: parameters, and values derived from them for one length of step. */
typedef struct ll_game_env {
    double dt; /* s */
    ll_time dt_ns;
    int32_t fused; /* a * b + c is rounded once, like fused multiply-add */
    int32_t reserved;
    double params[16];
    double derived[16];
} ll_game_env;

/* Some of the entities of a world: of the first LL_TOUCHING_MAX. */
typedef struct ll_entity_set {
    uint64_t bits[(LL_TOUCHING_MAX + 63) / 64];
} ll_entity_set;

/* A game treats a script that it does not know as `varied`. */
typedef enum ll_script {
    LL_SCRIPT_VARIED,
    LL_SCRIPT_STEADY,
    LL_SCRIPT_IDLE,
    LL_SCRIPT_PEEK,
    LL_SCRIPT_HOLD,
    LL_SCRIPT_REACT,
    LL_SCRIPT_TURN
} ll_script;

extern const char *const ll_script_names[];

typedef struct ll_game_scene {
    double x_min, x_max, y_min, y_max;        /* m */
    bool wraps;                               /* x is drawn modulo x_max: laps of a track */
    double finish_m;                          /* 0: none */
    double target_x, target_y, target_radius; /* radius 0: none */
    double entity_length_m;
} ll_game_scene;

/* How an entity is drawn; or a fixed part of the scene, which also has a position. */
typedef struct ll_game_shape {
    const char *kind;     /* `player`, `target`, `crate`, `water`, `projectile`, `cover` */
    double width, height; /* m */
    bool round;           /* an ellipse, else a box */
    double x, y;          /* m, of the centre */
} ll_game_shape;

/* Of the table of a game's own numbers: where they stand in a run's metrics; and their values, from the
 * list. */
#define LL_GAME_METRICS .path = "players.*.game", .short_numbers = true
#define LL_GAME_VALUE(type, name, unit, value, help, null) (double)(value),
#define LL_GAME_TELL(values, LIST)                                                                           \
    memcpy(values, (const double[]){LIST(LL_GAME_VALUE)}, sizeof((const double[]){LIST(LL_GAME_VALUE)}))

typedef struct ll_game {
    const char *name;
    const char *help;
    const ll_param_table *params;   /* its struct has at most LL_GAME_PARAMS numbers */
    const ll_metric_table *metrics; /* at most LL_GAME_VALUES numbers, which `describe` reports per player */

    bool many; /* up to LL_PLAYERS_MAX players and LL_ENTITIES_MAX entities, none of which touch; otherwise
                  LL_PEERS_MAX and LL_TOUCHING_MAX */

    ll_extent (*extent)(const void *params, int players);
    void (*prepare)(ll_game_env *env, const void *params); /* derives values for env->dt */
    void (*init)(ll_world *world, const ll_game_env *env, const int32_t *lanes);

    /* Advances all entities by env->dt, to `now`. `past` is what a server may look into to judge shots
     * (game/core/compensate.h); NULL elsewhere. */
    void (*step)(ll_world *world, const ll_game_env *env, const ll_action *actions, ll_time now,
                 const struct ll_past *past);

    /* Advances only what belongs to `player` by env->dt: a client's prediction from its own inputs. Cost: one
     * entity. `own_reads_world`: the outcome also depends on the game's tail or on other entities. */
    bool own_reads_world;
    /* `step_own` reads the entity alone, and each coordinate grows with the axes: after any inputs the entity
     * is within what full axes of either sign lead to. */
    bool own_is_bounded;
    void (*step_own)(ll_world *world, const ll_game_env *env, int player, const ll_action *action);

    /* Extrapolates another player's entity by `dt` seconds under the world's own forces. NULL: it keeps its
     * velocity and angular velocity. */
    void (*coast)(const ll_game_env *env, ll_entity *entity, double dt);

    /* Adds to the non-empty `set` all that may touch one of its entities within `horizon_s`, directly or
     * through others, for any inputs: never too few. NULL: nothing touches. */
    void (*reach)(const ll_world *world, const ll_game_env *env, double horizon_s, ll_entity_set *set);

    /* `step` for the entities of `set` as if they were alone; others do not change. NULL if `reach` is. Cost:
     * a step of that many entities. */
    void (*step_some)(ll_world *world, const ll_game_env *env, const ll_action *actions, ll_time now,
                      const ll_entity_set *set);

    /* Largest distance that a player's entity can cover in `seconds` by itself within the rules: from rest,
     * or from any speed. NULL: unknown. */
    double (*farthest)(const ll_game_env *env, double seconds, bool from_rest);

    /* An autopilot: what `player` does at t >= 0, having seen `world` as its client draws it. What varies is
     * drawn from the session's `seed` (game/core/script.h); nothing is kept from one call to the next. */
    ll_action (*drive)(const ll_world *world, const ll_game_env *env, uint64_t seed, int player,
                       ll_script script, ll_time t);

    /* Up to this time, not including it, `drive` answers as at `t`, for any world; `t` itself if that is not
     * sure. NULL: it never is. */
    ll_time (*same_until)(const ll_game_env *env, uint64_t seed, int player, ll_script script, ll_time t);

    void (*describe)(const ll_world *world, const ll_game_env *env, int player, double *values);

    /* The background of a view. */
    ll_game_scene (*scene)(const ll_game_env *env, int players);

    /* Shape of entity `index`; from the number of entities on, the fixed parts of the scene. False if there
     * is none. NULL: every entity is a player, drawn by entity_length_m. */
    bool (*shape)(const ll_game_env *env, int players, int index, ll_game_shape *shape);

    const struct ll_weapons *weapons; /* game/core/weapons.h; NULL in a game without */
} ll_game;

/* The functions that every game has, by the names that they have in its file. */
#define LL_GAME_FUNCTIONS                                                                                    \
    .extent = extent, .prepare = prepare, .init = init, .step = step, .step_own = step_own,                  \
    .describe = describe, .scene = scene

extern const ll_game *const ll_games[]; /* NULL-terminated; the index is the choice `game` */
extern const char *const ll_game_names[];
extern const ll_param_table *const ll_game_tables[];

static inline bool ll_entity_set_has(const ll_entity_set *set, int entity)
{
    return set->bits[entity >> 6] >> (entity & 63) & 1;
}

static inline void ll_entity_set_add(ll_entity_set *set, int entity)
{
    set->bits[entity >> 6] |= UINT64_C(1) << (entity & 63);
}

/* The first entity of the set from `from` on; `end`: there is none before it. */
static inline int ll_entity_set_next(const ll_entity_set *set, int from, int end)
{
    for (; from < end; from = (from | 63) + 1) {
        uint64_t left = set->bits[from >> 6] >> (from & 63);
        if (left != 0)
            return from + __builtin_ctzll(left) < end ? from + __builtin_ctzll(left) : end;
    }
    return end;
}

static inline size_t ll_extent_size(ll_extent extent)
{
    return sizeof(ll_world) + (size_t)extent.entities * sizeof(ll_entity) + (size_t)extent.tail;
}

static inline size_t ll_world_size(const ll_world *world)
{
    return ll_extent_size((ll_extent){world->entities, world->tail});
}

static inline void *ll_world_tail(ll_world *world)
{
    return &world->entity[world->entities];
}

static inline const void *ll_world_tail_const(const ll_world *world)
{
    return &world->entity[world->entities];
}

/* Replaces a missing action: controls stay, presses are not repeated. */
static inline ll_action ll_held(const ll_action *last)
{
    return (ll_action){.axis = {last->axis[0], last->axis[1]}};
}

static inline double ll_clamp(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}
