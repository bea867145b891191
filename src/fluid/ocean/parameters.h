/* Rows of ll_ocean_setup, without method and choppiness, which are live. */
#pragma once

#include "fluid/ocean/ocean.h"

#define LL_OCEAN_ROW(member, name_, ...)                                                                     \
    {                                                                                                        \
        .name = name_, .offset = offsetof(ll_ocean_setup, member), __VA_ARGS__                               \
    }
#define LL_OCEAN_REAL(member, name_, low, high, value, of, text)                                             \
    LL_OCEAN_ROW(member, name_, .type = LL_PARAM_REAL, .min = low, .max = high, .default_value = value,      \
                 .unit = of, .help = text)
#define LL_OCEAN_WHOLE(member, low, high, value, text)                                                       \
    LL_OCEAN_ROW(member, #member, .type = LL_PARAM_INT, .min = low, .max = high, .default_value = value,     \
                 .help = text)

#define LL_OCEAN_ROWS(n_, loop_)                                                                             \
    LL_OCEAN_WHOLE(n, 8, 2048, n_, "Points per side of the square; even, without prime factors above 5."),   \
        LL_OCEAN_REAL(length, "length_m", 1, 1e5, 200, "m", "Side of the square, which repeats."),           \
        LL_OCEAN_REAL(depth, "depth_m", 0, 1e5, 0, "m", "Water depth; 0: infinite."),                        \
        LL_OCEAN_REAL(gravity, "gravity", 0.1, 100, 9.81, "m/s^2", "Gravity."),                              \
        LL_OCEAN_REAL(wind_speed, "wind_speed_mps", 0, 40, 8, "m/s", "Wind of a fully developed sea."),      \
        LL_OCEAN_REAL(wind_angle, "wind_angle_rad", -7, 7, 0.5, "rad",                                       \
                      "Direction of the wind, from x towards z."),                                           \
        LL_OCEAN_REAL(loop_s, "loop_s", 0, 3600, loop_, "s",                                                 \
                      "All frequencies are rounded to multiples of one over this; 0: not rounded."),         \
        LL_OCEAN_WHOLE(waves, 1, 64, 8, "Number of waves of gerstner."),                                     \
        LL_OCEAN_WHOLE(tile, 4, 512, 64, "Points per side of the tile of tiled; divides n."),                \
        LL_OCEAN_WHOLE(frames, 2, 256, 32, "Frames in the loop of tiled."),                                  \
        LL_OCEAN_WHOLE(seed, 0, 9007199254740991, 1, "Random seed of phases and amplitudes.")
