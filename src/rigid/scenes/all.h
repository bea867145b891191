/* Every scene: scenes.c makes the table of them. */
#pragma once

#include "rigid/scenes/scene.h"

/* clang-format 14 does not converge on this. */
/* clang-format off */
#define LL_SCENES(X) \
    X(column) X(pyramid) X(many_pyramids) X(tiny_pyramid) X(heavy_on_two) X(heavy_on_triangles) \
    X(heavy_tops) X(inverse_pyramid) X(tilted_stack) X(overlap) X(total_overlap) X(confined) \
    X(circle_stack) X(warm_start) X(rush) X(far_pyramid) X(card_house) X(arch) X(domino) X(ramps) \
    X(rugged_wall) X(collapsing_stack) X(figure_5) X(ball_chain) X(stretched_chain) X(joint_grid) \
    X(bridge) X(cantilever) X(scissor_lift) X(cart) X(unstable_prismatic) X(windmill) X(bullets) \
    X(bullets_moving) X(bullets_loose) X(skinny_box) X(drop) X(pinball) X(ghost_bumps) X(wedge) \
    X(pixel_imperfect) X(sliver) X(smash) X(tumbler) X(washer) X(spinner) X(junkyard) X(compounds) X(rain)
/* clang-format on */

#define LL_SCENE_DECLARE(name) extern const ll_scene ll_scene_##name;
LL_SCENES(LL_SCENE_DECLARE)
#undef LL_SCENE_DECLARE
