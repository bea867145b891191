#include "rigid/scenes/all.h"

#include <string.h>

#define LL_SCENE_ROW(name) &ll_scene_##name,
const ll_scene *const ll_scenes[] = {LL_SCENES(LL_SCENE_ROW)};
const int ll_scene_count = sizeof ll_scenes / sizeof ll_scenes[0];
#define LL_SCENE_NAME(name) #name,
const char *const ll_scene_names[] = {"none", LL_SCENES(LL_SCENE_NAME) NULL};

#define REAL(field, low, high, of, text)                                                                     \
    {                                                                                                        \
        .name = #field, .type = LL_PARAM_REAL, .offset = offsetof(ll_scene_args, field), .min = low,         \
        .max = high, .unit = of, .help = text                                                                \
    }

static const ll_param rows[] = {
    {LL_PARAM_ROW("size", INT, ll_scene_args, size), .max = 100000,
     .help = "Rows, bodies per side or links; 0: the scene's default."},
    REAL(ratio, 0, 1e6, NULL, "Mass ratio; 0: the scene's default."),
    REAL(offset, 0, 1e7, "m", "Displacement; 0: the scene's default."),
    REAL(speed, 0, 1e5, NULL, "Speed in m/s or rad/s; 0: the scene's default."),
    REAL(friction, 0, 10, NULL, "Friction coefficient; 0: the scene's default."),
};

const ll_param_table ll_scene_args_table = {.name = "rigid_scene",
                                            .help = "Arguments of a scene of rigid bodies.",
                                            LL_PARAM_ROWS(rows, ll_scene_args)};

const ll_scene *ll_scene_named(const char *name)
{
    for (int i = 0; i < ll_scene_count; i++)
        if (strcmp(ll_scenes[i]->name, name) == 0)
            return ll_scenes[i];
    return NULL;
}

static double either(double given, double standard)
{
    return given != 0 ? given : standard;
}

ll_scene_args ll_scene_args_of(const ll_scene *scene, const ll_scene_args *given)
{
    const ll_scene_args *s = &scene->default_value;
    return (ll_scene_args){.size = given->size != 0 ? given->size : s->size,
                           .ratio = either(given->ratio, s->ratio),
                           .offset = either(given->offset, s->offset),
                           .speed = either(given->speed, s->speed),
                           .friction = either(given->friction, s->friction)};
}

double ll_scene_fall(const ll_scene *scene, const ll_scene_args *args)
{
    return scene->fall != NULL ? scene->fall(args) : 0;
}
