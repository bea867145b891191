/* Cannon: players fire one projectile each at a target, in turn.
 *
 * Axis 0 is the elevation (0: level, 1: vertical), axis 1 the muzzle speed (relative to the largest);
 * LL_BUTTON_FIRE fires. Flight under gravity and linear drag is solved exactly per step. A shot ends at the
 * target or on the ground; then it is the next player's turn. */
#include "base/detmath.h"
#include "game/core/script.h"
#include "game/games/games.h"

typedef struct cannon_params {
    double gravity, drag, muzzle_speed, target, target_radius, pause;
} cannon_params;

typedef struct cannon_tail {
    int32_t turn;
    int32_t reserved;
    ll_time wait; /* ns until the player of this turn may fire */
    struct {
        int32_t shots, hits;
        double miss; /* of the last shot: landing position minus target, m */
    } score[];       /* per player */
} cannon_tail;

static const double half_pi = 1.5707963267948966;

static const ll_param rows[] = {
    {LL_PARAM_ROW("gravity_mps2", REAL, cannon_params, gravity), .min = 0.1, .max = 100,
     .default_value = 9.81, .unit = "m/s2", .help = "Gravity, downwards."},
    {LL_PARAM_ROW("drag_per_s", REAL, cannon_params, drag), .min = 0, .max = 10, .default_value = 0,
     .unit = "1/s", .help = "Linear drag of the projectile; 0: a parabola."},
    {LL_PARAM_ROW("muzzle_speed_mps", REAL, cannon_params, muzzle_speed), .min = 1, .max = 1000,
     .default_value = 30, .unit = "m/s", .help = "Largest muzzle speed."},
    {LL_PARAM_ROW("target_m", REAL, cannon_params, target), .min = 1, .max = 10000, .default_value = 60,
     .unit = "m", .help = "Distance of the target."},
    {LL_PARAM_ROW("target_radius_m", REAL, cannon_params, target_radius), .min = 0.1, .max = 100,
     .default_value = 2, .unit = "m", .help = "Largest miss that counts as a hit."},
    {LL_PARAM_ROW("pause_s", REAL, cannon_params, pause), .min = 0, .max = 60, .default_value = 1,
     .unit = "s", .help = "Time between a landing and the next shot."},
};

const ll_param_table ll_cannon_table = {
    .name = "cannon", .help = "Parameters of the cannon.", LL_PARAM_ROWS(rows, cannon_params)};

static const cannon_params *params_of(const ll_game_env *env)
{
    return (const cannon_params *)env->params;
}

static ll_extent extent(const void *params, int players)
{
    (void)params;
    const cannon_tail *t = NULL;
    return (ll_extent){players, (int)(sizeof *t + (size_t)players * sizeof t->score[0])};
}

static void prepare(ll_game_env *env, const void *params)
{
    *(cannon_params *)env->params = *(const cannon_params *)params;
    *(ll_drag *)env->derived = ll_drag_over(params_of(env)->drag, env->dt);
}

static void init(ll_world *world, const ll_game_env *env, const int32_t *lanes)
{
    (void)lanes;
    ((cannon_tail *)ll_world_tail(world))->wait = (ll_time)(params_of(env)->pause * 1e9);
}

static double along(double x) /* remaining fraction of a step, clamped to [0, 1] */
{
    return x < 0 ? 0 : x > 1 ? 1 : x;
}

/* Whether the chord of this step passes the target. The path of a step of 1/60 s deviates by less than 0.4 mm
 * from it. */
static bool hits(const cannon_params *p, double x0, double y0, double x1, double y1)
{
    double dx = x1 - x0, dy = y1 - y0, length2 = dx * dx + dy * dy;
    double s = length2 > 0 ? along(((p->target - x0) * dx - y0 * dy) / length2) : 0;
    double ex = x0 + s * dx - p->target, ey = y0 + s * dy;
    return ex * ex + ey * ey <= p->target_radius * p->target_radius;
}

static void fly(ll_world *world, const ll_game_env *env, int player)
{
    const cannon_params *p = params_of(env);
    const ll_drag *d = (const ll_drag *)env->derived;
    cannon_tail *t = ll_world_tail(world);
    ll_entity *shell = &world->entity[player];
    double x = shell->x, y = shell->y;
    ll_drag_move(env, d, 0, &shell->x, &shell->vx);
    ll_drag_move(env, d, -p->gravity, &shell->y, &shell->vy);
    bool hit = hits(p, x, y, shell->x, shell->y);
    if (!hit && shell->y > 0)
        return;
    if (shell->y < 0) { /* lands where the chord crosses the ground */
        shell->x = x + (shell->x - x) * (y / (y - shell->y));
        shell->y = 0;
    }
    shell->vx = shell->vy = 0;
    shell->flags &= ~(uint64_t)LL_ENTITY_ACTIVE;
    t->score[player].shots++;
    t->score[player].hits += hit;
    t->score[player].miss = shell->x - p->target;
    t->turn = (t->turn + 1) % world->players;
    t->wait = (ll_time)(p->pause * 1e9);
}

static void step_own(ll_world *world, const ll_game_env *env, int player, const ll_action *action)
{
    const cannon_params *p = params_of(env);
    cannon_tail *t = ll_world_tail(world);
    ll_entity *shell = &world->entity[player];
    if (shell->flags & LL_ENTITY_ACTIVE) {
        fly(world, env, player);
    } else if (t->turn == player) {
        if (t->wait > 0) {
            t->wait -= env->dt_ns;
        } else if (action->buttons & LL_BUTTON_FIRE) {
            double angle = along(action->axis[0]) * half_pi, speed = along(action->axis[1]) * p->muzzle_speed;
            *shell = (ll_entity){
                .vx = speed * ll_cos(angle), .vy = speed * ll_sin(angle), .flags = LL_ENTITY_ACTIVE};
        }
    }
}

static void step(ll_world *world, const ll_game_env *env, const ll_action *actions, ll_time now,
                 const struct ll_past *past)
{
    (void)past;
    (void)now;
    int turn = ((cannon_tail *)ll_world_tail(world))->turn; /* one turn per step */
    step_own(world, env, turn, &actions[turn]);
}

/* A projectile flies on under gravity and drag, and stays where it would go underground. */
static void coast(const ll_game_env *env, ll_entity *shell, double dt)
{
    if (!(shell->flags & LL_ENTITY_ACTIVE))
        return;
    const cannon_params *p = params_of(env);
    ll_drag over = ll_drag_over(p->drag, dt);
    ll_drag_move(env, &over, 0, &shell->x, &shell->vx);
    ll_drag_move(env, &over, -p->gravity, &shell->y, &shell->vy);
    if (shell->y < 0)
        shell->y = shell->vx = shell->vy = 0;
}

/* Fires when it is its turn. `varied`: angle and speed are random per shot. */
static ll_action drive(const ll_world *world, const ll_game_env *env, uint64_t seed, int player,
                       ll_script script, ll_time t)
{
    const cannon_tail *tail = ll_world_tail_const(world);
    (void)env;
    (void)t;
    ll_action a = {.axis = {0.5f, 0.8f}};
    if (script == LL_SCRIPT_IDLE || tail->turn != player)
        return a;
    a.buttons = LL_BUTTON_FIRE;
    if (script != LL_SCRIPT_STEADY) {
        uint64_t draw = ll_script_draw(seed, player, LL_SCRIPT_OWN, (int64_t)tail->score[player].shots);
        a.axis[0] = 0.4f + 0.025f * (float)(draw % 9);
        a.axis[1] = 0.75f + 0.02f * (float)(draw / 9 % 8);
    }
    return a;
}

#define VALUES(X)                                                                                            \
    X(count, turn, NULL, t->turn == player, "1: it is the player's turn; 0: it is not", NULL)                \
    X(count, shots, NULL, t->score[player].shots, "shots of the player so far", NULL)                        \
    X(count, hits, NULL, t->score[player].hits, "hits of the player so far", NULL)                           \
    X(number, miss_m, "m", t->score[player].miss,                                                            \
      "distance by which the player's last shot missed: landing position less target", NULL)

const ll_metric_table ll_cannon_metrics = {LL_GAME_METRICS, .when = "Only in the game cannon.",
                                           .help = "Values of the game for this player, now.",
                                           LL_METRICS_FROM(VALUES)};

static void describe(const ll_world *world, const ll_game_env *env, int player, double *values)
{
    const cannon_tail *t = ll_world_tail_const(world);
    (void)env;
    LL_GAME_TELL(values, VALUES);
}

static ll_game_scene scene(const ll_game_env *env, int players)
{
    const cannon_params *p = params_of(env);
    (void)players;
    double reach = p->muzzle_speed * p->muzzle_speed / p->gravity; /* without drag, at 45 degrees */
    double width = reach > p->target ? reach : p->target;
    return (ll_game_scene){.x_min = 0,
                           .x_max = width,
                           .y_min = 0,
                           .y_max = reach / 2,
                           .target_x = p->target,
                           .target_radius = p->target_radius,
                           .entity_length_m = 1};
}

const ll_game ll_game_cannon = {
    .name = "cannon",
    .help = "Players fire a projectile in turn at a target.",
    .params = &ll_cannon_table,
    .metrics = &ll_cannon_metrics,
    LL_GAME_FUNCTIONS,
    .own_reads_world = true,
    .coast = coast,
    .drive = drive,
};
