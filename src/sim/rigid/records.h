/* Rows of what is streamed of a simulation of rigid bodies; frame.c fills them. */
#pragma once

#include "sim/rigid/rigid.h"

typedef struct world_row {
    uint8_t status, solver;
    bool dragging;
    uint32_t bodies, awake, pairs, touching, points, recycled, tested, islands, tunnelled, stopped, joints;
    double energy, energy_start, kinetic, penetration, penetration_worst, sag, drift, tilt, joint_error,
        speed_max;
    double momentum_x, momentum_y;
    uint32_t swept, dynamic;
} world_row;

typedef struct geometry_row {
    uint8_t kind;
    float radius, circle_x, circle_y, circle_radius;
    float obb_x0, obb_y0, obb_x1, obb_y1, obb_x2, obb_y2, obb_x3, obb_y3;
} geometry_row;

typedef struct vertex_row {
    uint16_t geometry;
    float x, y;
} vertex_row;

enum { LL_SHAPE_DYNAMIC = 1, LL_SHAPE_KINEMATIC = 2, LL_SHAPE_AWAKE = 4 }; /* flags */

typedef struct shape_row {
    uint8_t world, flags;
    uint16_t geometry;
    uint32_t body, island;
    double x, y;
    float angle, vx, vy, angular_velocity, left, bottom, right, top;
} shape_row;

typedef struct contact_row {
    uint8_t world, count;
    bool recycled;
    uint32_t a, b;
    float nx, ny;
    double x0, y0, separation0, impulse0, x1, y1, separation1, impulse1;
} contact_row;

typedef struct joint_row {
    uint8_t world, type;
    uint32_t a, b;
    double ax, ay, bx, by;
} joint_row;

typedef struct volume_row {
    uint8_t world, volume;
    int64_t tests, hits, false_hits, missed_hits;
    double gap_mean, gap_max;
} volume_row;

extern const ll_record ll_rigid_world_record, ll_rigid_geometry_record, ll_rigid_vertex_record,
    ll_rigid_shape_record, ll_rigid_contact_record, ll_rigid_joint_record, ll_rigid_volume_record;
