#include <string.h>

#include "fluid/particle/parameters.h"
#include "fluid/scenes/scenes.h"

/* ---- dam break: a column of a x 2 a; all in units of a and g ---- */

static const ll_param dam_break_rows[] = {
    LL_PARTICLE_ROWS(LL_PARTICLE_WCSPH, 0, -1, 1, 20, 0.05, 0, 0, 0.4, 100, 0)};
const ll_param_table ll_fluid_dam_break_solver = LL_PARTICLE_TABLE("dam_break_solver", dam_break_rows);

static void dam_break(double size, ll_particle_setup *s)
{
    s->spacing = 1 / size;
    s->width = 6;
    s->height = 3;
    s->walls = LL_WALL_LEFT | LL_WALL_RIGHT | LL_WALL_BOTTOM;
    s->fill[0] = (ll_particle_fill){.width = 1, .height = 2};
}

/* ---- hydrostatic column ---- */

static const ll_param hydrostatic_rows[] = {
    LL_PARTICLE_ROWS(LL_PARTICLE_WCSPH, 0, -1, 1, 14, 0.05, 0, 0, 0.4, 100,
                     0)}; /* the speed of sound is ten times sqrt(2 g H) */
const ll_param_table ll_fluid_hydrostatic_solver = LL_PARTICLE_TABLE("hydrostatic_solver", hydrostatic_rows);

static void hydrostatic(double size, ll_particle_setup *s)
{
    s->spacing = 1 / size;
    s->width = 0.5;
    s->height = 1.5;
    s->walls = LL_WALL_LEFT | LL_WALL_RIGHT | LL_WALL_BOTTOM;
    s->fill[0] = (ll_particle_fill){.width = 0.5, .height = 1, .settled = 1};
}

/* ---- Poiseuille: a channel of width 1, force 1, viscosity 0.1 ---- */

static const ll_param poiseuille_rows[] = {
    LL_PARTICLE_ROWS(LL_PARTICLE_WCSPH, 1, 0, 1, 12.5, 0, 0.1, 1, 0.4, 100, 0)};
const ll_param_table ll_fluid_poiseuille_solver = LL_PARTICLE_TABLE("poiseuille_solver", poiseuille_rows);

static void poiseuille(double size, ll_particle_setup *s)
{
    s->spacing = 1 / size;
    s->height = 1;
    s->width = 0.75;

    s->periodic = 1;
    s->walls = LL_WALL_BOTTOM | LL_WALL_TOP;
    s->fill[0] = (ll_particle_fill){.width = s->width, .height = 1};
}

/* ---- a free drop ---- */

static const ll_param drop_rows[] = {
    LL_PARTICLE_ROWS(LL_PARTICLE_DFSPH, 0, -1, 1, 20, 0.01, 0, 0, 0.4, 100, 0)};
const ll_param_table ll_fluid_drop_solver = LL_PARTICLE_TABLE("drop_solver", drop_rows);

static void drop(double size, ll_particle_setup *s)
{
    s->spacing = 1 / size;
    s->width = 4;
    s->height = 4;
    s->fill[0] = (ll_particle_fill){
        .x = 1.5, .y = 2.5, .width = 1, .height = 1, .u = 0.3, .v = 0.2, .strain = 1, .round = 1};
}

/* ---- a floating box ---- */

static const ll_param raft_rows[] = {
    LL_PARTICLE_ROWS(LL_PARTICLE_DFSPH, 0, -1, 1, 14, 0.05, 0, 0, 0.4, 100, 0)};
const ll_param_table ll_fluid_raft_solver = LL_PARTICLE_TABLE("raft_solver", raft_rows);

static void raft(double size, ll_particle_setup *s)
{
    s->spacing = 1 / size;
    s->width = 2;
    s->height = 1.5;
    s->walls = LL_WALL_LEFT | LL_WALL_RIGHT | LL_WALL_BOTTOM;
    s->fill[0] = (ll_particle_fill){.width = 2, .height = 0.7};
    s->body = (ll_particle_float){.x = 1, .y = 0.95, .width = 0.5, .height = 0.4, .density = 0.6};
}

/* ---- a game's pool: 20 m, shallow, in SI units ---- */

static const ll_param pool_rows[] = {
    LL_PARTICLE_ROWS(LL_PARTICLE_PBF, 0, -10, 1000, 50, 0.02, 0, 0, 1, 4, 0.1)};
const ll_param_table ll_fluid_pool_solver = LL_PARTICLE_TABLE("pool_solver", pool_rows);

static void pool(double size, ll_particle_setup *s)
{
    s->spacing = 20 / size;
    s->width = 20;
    s->height = 4;
    s->walls = LL_WALL_LEFT | LL_WALL_RIGHT | LL_WALL_BOTTOM;
    s->fill_count = 2;
    s->fill[0] = (ll_particle_fill){.width = 10, .height = 1.5, .settled = 1};
    s->fill[1] = (ll_particle_fill){.x = 10, .width = 10, .height = 1, .settled = 1};
}

static const ll_particle_scene dam_break_scene = {
    .name = "dam_break",
    .title = "Dam break",
    .help = "A column of width 1 and height 2 falls into a dry tank; lengths in its width a, times in sqrt(a "
            "/ g). Compared with Martin and Moyce (1952) and Ritter's front 1 + 2 sqrt(2) t.",
    .size = 20,
    .dt = 0.02,
    .duration = 2.4,
    .solver = &ll_fluid_dam_break_solver,
    .configure = dam_break,
};

static const ll_particle_scene hydrostatic_scene = {
    .name = "hydrostatic",
    .title = "Hydrostatic column",
    .help = "A column of height 1 comes to rest under gravity 1; pressure is compared with density g depth.",
    .size = 40,
    .depth = 1,
    .dt = 0.02,
    .duration = 10,
    .solver = &ll_fluid_hydrostatic_solver,
    .configure = hydrostatic,
};

static const ll_particle_scene poiseuille_scene = {
    .name = "poiseuille",
    .title = "Poiseuille flow",
    .help = "Fluid at rest between two walls is driven by a constant force: width 1, force 1, viscosity 0.1. "
            "In the middle 0.769190642828260 at time 1, and 1.25 in the limit.",
    .size = 32,
    .dt = 0.02,
    .duration = 1,
    .solver = &ll_fluid_poiseuille_solver,
    .configure = poiseuille,
};

static const ll_particle_scene drop_scene = {
    .name = "drop",
    .title = "Falling drop",
    .help = "A disc in free fall that moves sideways and is stretched: momentum is mass (0.3, 0.2 - t).",
    .size = 30,
    .dt = 0.02,
    .duration = 1,
    .solver = &ll_fluid_drop_solver,
    .configure = drop,
};

static const ll_particle_scene raft_scene = {
    .name = "raft",
    .title = "Floating box",
    .help = "A box of 0.6 of the fluid's density falls in and floats with 0.6 of its height under water.",
    .size = 30,
    .dt = 0.02,
    .duration = 10,
    .solver = &ll_fluid_raft_solver,
    .configure = raft,
};

static const ll_particle_scene pool_scene = {
    .name = "pool",
    .title = "Pool",
    .help = "A step of half a metre in the level of a pool of 20 m runs to and fro: water at a game's scale "
            "and cost, by position-based fluids. 400 along the pool are 10,000 particles.",
    .size = 200,
    .dt = 1. / 60,
    .duration = 10,
    .solver = &ll_fluid_pool_solver,
    .configure = pool,
};

const ll_particle_scene *const ll_particle_scenes[] = {
    &dam_break_scene, &hydrostatic_scene, &poiseuille_scene, &drop_scene, &raft_scene, &pool_scene, NULL};

const ll_particle_scene *ll_particle_scene_named(const char *name)
{
    for (int i = 0; ll_particle_scenes[i] != NULL; i++)
        if (strcmp(ll_particle_scenes[i]->name, name) == 0)
            return ll_particle_scenes[i];
    return NULL;
}

void ll_particle_scene_setup(const ll_particle_scene *scene, double size, ll_particle_setup *setup,
                             ll_particle_params *params)
{
    *setup = (ll_particle_setup){.smoothing = 1.3, .fill_count = 1};
    ll_param_defaults(scene->solver, params);
    scene->configure(size > 0 ? size : scene->size, setup);
}
