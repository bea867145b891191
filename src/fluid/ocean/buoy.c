/* A box on the surface: sixteen vertical columns, each lifted by the water that it displaces. */
#include "fluid/ocean/ocean.h"

enum { COLUMNS = 4 };

void ll_buoy_step(ll_buoy *b, const ll_ocean *o, double dt)
{
    double g = ll_ocean_setup_of(o)->gravity, lift = 0, right = 0, far = 0;
    for (int j = 0; j < COLUMNS; j++)
        for (int i = 0; i < COLUMNS; i++) {
            double x = ((i + 0.5) / COLUMNS - 0.5) * b->width, z = ((j + 0.5) / COLUMNS - 0.5) * b->length;
            double bottom = b->y + b->pitch * x + b->roll * z - b->height / 2;
            double wet = ll_ocean_height_at(o, b->x + x, b->z + z) - bottom;
            wet = wet > 0 ? (wet < b->height ? wet : b->height) : 0;
            double speed = b->speed + b->pitch_rate * x + b->roll_rate * z;
            /* Force on a column over the mass of the whole box: its weight is 1 g in total. */
            double force = (wet / b->height) / b->density * (g - b->drag * speed) / (COLUMNS * COLUMNS);
            lift += force;
            right += force * x;
            far += force * z;
        }
    double square = b->height * b->height;
    b->speed += dt * (lift - g);
    b->pitch_rate += dt * 12 * right / (b->width * b->width + square);
    b->roll_rate += dt * 12 * far / (b->length * b->length + square);
    b->y += dt * b->speed;
    b->pitch += dt * b->pitch_rate;
    b->roll += dt * b->roll_rate;
}
