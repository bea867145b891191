/* Every scene: scenes.c makes the table of them. */
#pragma once

#include "rigid/scene.h"

#define LL_SCENES(X)                                                                                         \
    X(column) X(pyramid) X(many_pyramids) X(tiny_pyramid) X(heavy_on_two) X(heavy_tops) X(inverse_pyramid)

#define LL_SCENE_DECLARE(name) extern const ll_scene ll_scene_##name;
LL_SCENES(LL_SCENE_DECLARE)
#undef LL_SCENE_DECLARE
