/* The tables of what is streamed of a simulation of rigid bodies. */
#include "sim/rigid/records.h"

#include "base/run_status.h"

enum { LL_BITS_BODY = 12, LL_BITS_SPEED = 8 }; /* 0.24 mm, 4 mm/s: there are many bodies */

/* ---- worlds ---- */

static const ll_record_field world_fields[] = {
    LL_ENUM(world_row, status, ll_run_status_names, "whether it goes on"),
    LL_ENUM(world_row, solver, ll_rigid_solver_names, "by which it is stepped"),
    LL_INT(world_row, dragging, NULL, "whether a person drags a body"),
    LL_INT(world_row, bodies, NULL, "in it"),
    LL_INT(world_row, awake, NULL, "bodies that are stepped"),
    LL_INT(world_row, pairs, NULL, "of overlapping boxes"),
    LL_INT(world_row, touching, NULL, "pairs that touch"),
    LL_INT(world_row, points, NULL, "in which they touch"),
    LL_INT(world_row, recycled, NULL, "pairs whose points are those of the step before"),
    LL_INT(world_row, tested, NULL, "pairs that were tested exactly"),
    LL_INT(world_row, islands, NULL, "groups of bodies that hang together"),
    LL_INT(world_row, tunnelled, NULL, "bodies that went through something"),
    LL_INT(world_row, stopped, NULL, "bodies that swept detection put where they first touched, in all"),
    LL_INT(world_row, joints, NULL, "in it"),
    LL_REAL(world_row, energy, 23, "J", "kinetic and potential"),
    LL_REAL(world_row, energy_start, 23, "J", "at the start"),
    LL_REAL(world_row, kinetic, 23, "J", "kinetic energy"),
    LL_REAL(world_row, penetration, 16, "m", "the largest overlap, now"),
    LL_REAL(world_row, penetration_worst, 16, "m", "the largest overlap until now"),
    LL_REAL(world_row, sag, 16, "m", "the most that a body of the scene has sunk"),
    LL_REAL(world_row, drift, 16, "m", "the most that a body of the scene has gone aside"),
    LL_REAL(world_row, tilt, 16, "rad", "the most that a body of the scene has turned"),
    LL_REAL(world_row, joint_error, 16, "m", "the most that a joint is apart"),
    LL_REAL(world_row, speed_max, 16, "m/s", "of the fastest body"),
    LL_REAL(world_row, momentum_x, 23, "kg m/s", "of all bodies"),
    LL_REAL(world_row, momentum_y, 23, "kg m/s", "of all bodies"),
    LL_INT(world_row, swept, NULL, "bodies that were checked along their way"),
    LL_INT(world_row, dynamic, NULL, "bodies that can move"),
};

const ll_record ll_rigid_world_record = {.id = 32,
                                         .name = "worlds",
                                         .channel = LL_CHANNEL_BODIES,
                                         .help = "The worlds side by side.",
                                         .form = LL_FORM_BY_INDEX,
                                         LL_ROWS_OF(world_row, world_fields)};

/* ---- geometries: each of those that differ once, in the frame of the centre of mass ---- */

static const char *const geometry_kinds[] = {"circle", "capsule", "polygon", "segment", "link", NULL};

static const ll_record_field geometry_fields[] = {
    LL_ENUM(geometry_row, kind, geometry_kinds, "link: of a chain"),
    LL_STEP(geometry_row, radius, LL_BITS_M, "m", "around its vertices"),
    LL_STEP(geometry_row, circle_x, LL_BITS_M, "m", "centre of the circle around it"),
    LL_STEP(geometry_row, circle_y, LL_BITS_M, "m", "centre of the circle around it"),
    LL_STEP(geometry_row, circle_radius, LL_BITS_M, "m", "of that circle"),
    LL_STEP(geometry_row, obb_x0, LL_BITS_M, "m", "a corner of its oriented bounding box"),
    LL_STEP(geometry_row, obb_y0, LL_BITS_M, "m", "a corner of its oriented bounding box"),
    LL_STEP(geometry_row, obb_x1, LL_BITS_M, "m", "the next"),
    LL_STEP(geometry_row, obb_y1, LL_BITS_M, "m", "the next"),
    LL_STEP(geometry_row, obb_x2, LL_BITS_M, "m", "the next"),
    LL_STEP(geometry_row, obb_y2, LL_BITS_M, "m", "the next"),
    LL_STEP(geometry_row, obb_x3, LL_BITS_M, "m", "the last"),
    LL_STEP(geometry_row, obb_y3, LL_BITS_M, "m", "the last"),
};

const ll_record ll_rigid_geometry_record = {.id = 33,
                                            .name = "geometries",
                                            .channel = LL_CHANNEL_BODIES,
                                            .help = "Of the shapes: those that are the same stand once.",
                                            .form = LL_FORM_BY_INDEX,
                                            LL_ROWS_OF(geometry_row, geometry_fields)};

static const ll_record_field vertex_fields[] = {
    LL_INT(vertex_row, geometry, NULL, "whose: its place among the geometries"),
    LL_STEP(vertex_row, x, LL_BITS_M, "m", "from the centre of mass"),
    LL_STEP(vertex_row, y, LL_BITS_M, "m", "from the centre of mass"),
};

const ll_record ll_rigid_vertex_record = {.id = 34,
                                          .name = "vertices",
                                          .channel = LL_CHANNEL_BODIES,
                                          .help = "Of the geometries; of a link its two, then its ghosts.",
                                          .form = LL_FORM_BY_INDEX,
                                          LL_ROWS_OF(vertex_row, vertex_fields)};

/* ---- shapes ---- */

static const char *const shape_flags[] = {"dynamic", "kinematic", "awake", NULL};

static const ll_record_field shape_fields[] = {
    LL_INT(shape_row, world, NULL, "in which it is"),
    LL_INT(shape_row, body, NULL, "to which it belongs; from 1 on"),
    LL_INT(shape_row, geometry, NULL, "its place among the geometries"),
    LL_FLAGS(shape_row, flags, shape_flags, "of its body"),
    LL_STEP(shape_row, x, LL_BITS_BODY, "m", "of the centre of mass"),
    LL_STEP(shape_row, y, LL_BITS_BODY, "m", "of the centre of mass"),
    LL_STEP(shape_row, angle, LL_BITS_RAD, "rad", "orientation"),
    LL_STEP(shape_row, vx, LL_BITS_SPEED, "m/s", "velocity"),
    LL_STEP(shape_row, vy, LL_BITS_SPEED, "m/s", "velocity"),
    LL_STEP(shape_row, angular_velocity, LL_BITS_SPEED, "rad/s", "angular velocity"),
    LL_STEP(shape_row, left, LL_BITS_SPEED, "m", "box of the broad phase, from x and y"),
    LL_STEP(shape_row, bottom, LL_BITS_SPEED, "m", "box of the broad phase, from x and y"),
    LL_STEP(shape_row, right, LL_BITS_SPEED, "m", "box of the broad phase, from x and y"),
    LL_STEP(shape_row, top, LL_BITS_SPEED, "m", "box of the broad phase, from x and y"),
    LL_INT(shape_row, island, NULL, "bodies that hang together have the same; 0: none"),
};

const ll_record ll_rigid_shape_record = {.id = 35,
                                         .name = "shapes",
                                         .channel = LL_CHANNEL_BODIES,
                                         .help = "Of all bodies, at most 65,535.",
                                         .form = LL_FORM_BY_INDEX,
                                         LL_ROWS_OF(shape_row, shape_fields)};

/* ---- contacts ---- */

static const ll_record_field contact_fields[] = {
    LL_INT(contact_row, world, NULL, "in which they are"),
    LL_INT(contact_row, a, NULL, "a body"),
    LL_INT(contact_row, b, NULL, "the other body"),
    LL_INT(contact_row, count, NULL, "points in which they touch; 0: only their boxes overlap"),
    LL_INT(contact_row, recycled, NULL, "whether the points are those of the step before"),
    LL_STEP(contact_row, nx, 10, NULL, "normal, from a to b; null: they do not touch"),
    LL_STEP(contact_row, ny, 10, NULL, "normal, from a to b; null: they do not touch"),
    LL_STEP(contact_row, x0, LL_BITS_BODY, "m", "the first point; null: there is none"),
    LL_STEP(contact_row, y0, LL_BITS_BODY, "m", "the first point; null: there is none"),
    LL_STEP(contact_row, separation0, LL_BITS_BODY, "m",
            "there; negative: they overlap; null: there is none"),
    LL_REAL(contact_row, impulse0, 5, "N s", "normal impulse there; null: there is none"),
    LL_STEP(contact_row, x1, LL_BITS_BODY, "m", "the second point; null: there is none"),
    LL_STEP(contact_row, y1, LL_BITS_BODY, "m", "the second point; null: there is none"),
    LL_STEP(contact_row, separation1, LL_BITS_BODY, "m",
            "there; negative: they overlap; null: there is none"),
    LL_REAL(contact_row, impulse1, 5, "N s", "normal impulse there; null: there is none"),
};

const ll_record ll_rigid_contact_record = {.id = 36,
                                           .name = "contacts",
                                           .channel = LL_CHANNEL_CONTACTS,
                                           .help = "Pairs of overlapping boxes, at most 8,192.",
                                           .form = LL_FORM_KEYED,
                                           .keys = 3,
                                           LL_ROWS_OF(contact_row, contact_fields)};

/* ---- joints ---- */

static const ll_record_field joint_fields[] = {
    LL_INT(joint_row, world, NULL, "in which it is"),
    LL_INT(joint_row, a, NULL, "a body"),
    LL_INT(joint_row, b, NULL, "the other body"),
    LL_ENUM(joint_row, type, ll_joint_type_names, "what it holds"),
    LL_STEP(joint_row, ax, LL_BITS_BODY, "m", "anchor on a"),
    LL_STEP(joint_row, ay, LL_BITS_BODY, "m", "anchor on a"),
    LL_STEP(joint_row, bx, LL_BITS_BODY, "m", "anchor on b"),
    LL_STEP(joint_row, by, LL_BITS_BODY, "m", "anchor on b"),
};

const ll_record ll_rigid_joint_record = {.id = 37,
                                         .name = "joints",
                                         .channel = LL_CHANNEL_JOINTS,
                                         .help = "At most 8,192.",
                                         .form = LL_FORM_BY_INDEX,
                                         LL_ROWS_OF(joint_row, joint_fields)};

/* ---- bounding volumes ---- */

static const ll_record_field volume_fields[] = {
    LL_INT(volume_row, world, NULL, "in which they were compared"),
    LL_ENUM(volume_row, volume, ll_volume_names, "which"),
    LL_INT(volume_row, tests, NULL, "of pairs of shapes, over all steps"),
    LL_INT(volume_row, hits, NULL, "pairs whose volumes overlap"),
    LL_INT(volume_row, false_hits, NULL, "those whose shapes do not"),
    LL_INT(volume_row, missed_hits, NULL, "pairs whose shapes overlap but their volumes do not"),
    LL_REAL(volume_row, gap_mean, 16, "m", "between the shapes at false hits; 0: there was none"),
    LL_REAL(volume_row, gap_max, 16, "m", "the largest of these"),
};

const ll_record ll_rigid_volume_record = {.id = 38,
                                          .name = "volumes",
                                          .channel = LL_CHANNEL_BODIES,
                                          .help = "How the bounding volumes judge, where they are compared.",
                                          .form = LL_FORM_BY_INDEX,
                                          LL_ROWS_OF(volume_row, volume_fields)};

const ll_record *const ll_rigid_sim_records[] = {
    &ll_rigid_world_record,   &ll_rigid_geometry_record, &ll_rigid_vertex_record, &ll_rigid_shape_record,
    &ll_rigid_contact_record, &ll_rigid_joint_record,    &ll_rigid_volume_record, NULL};
