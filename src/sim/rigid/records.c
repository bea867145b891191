/* Tables of the streamed rows of a simulation of rigid bodies. */
#include "sim/rigid/records.h"

#include "record/integers.h"

#include "base/run_status.h"

enum { LL_BITS_BODY = 12, LL_BITS_SPEED = 8 }; /* 0.24 mm, 4 mm/s: there are many bodies */

/* ---- worlds ---- */

static const ll_record_field world_fields[] = {
    LL_ENUM(world_row, status, ll_run_status_names, "ok, or why it has stopped"),
    LL_ENUM(world_row, solver, ll_rigid_solver_names, "its contact solver"),
    LL_INT(world_row, dragging, NULL, "whether a person drags a body"),
    LL_INT(world_row, bodies, NULL, "number in the world"),
    LL_INT(world_row, awake, NULL, "bodies that are stepped"),
    LL_INT(world_row, pairs, NULL, "overlapping bounding boxes"),
    LL_INT(world_row, touching, NULL, "pairs that touch"),
    LL_INT(world_row, points, NULL, "contact points"),
    LL_INT(world_row, recycled, NULL, "pairs with contact recycling: the points of the step before"),
    LL_INT(world_row, tested, NULL, "pairs tested by the narrow phase"),
    LL_INT(world_row, islands, NULL, "islands: groups of connected bodies"),
    LL_INT(world_row, tunnelled, NULL, "bodies that tunnelled"),
    LL_INT(world_row, stopped, NULL, "total number of bodies that CCD stopped at their time of impact"),
    LL_INT(world_row, joints, NULL, "number in the world"),
    LL_REAL(world_row, energy, 23, "J", "kinetic and potential"),
    LL_REAL(world_row, energy_start, 23, "J", "at the start"),
    LL_REAL(world_row, kinetic, 23, "J", "kinetic energy"),
    LL_REAL(world_row, penetration, 16, "m", "present largest penetration"),
    LL_REAL(world_row, penetration_worst, 16, "m", "largest penetration so far"),
    LL_REAL(world_row, sag, 16, "m", "largest distance that a body of the scene has sunk"),
    LL_REAL(world_row, drift, 16, "m", "largest sideways distance of a body of the scene"),
    LL_REAL(world_row, tilt, 16, "rad", "largest angle by which a body of the scene has turned"),
    LL_REAL(world_row, joint_error, 16, "m", "largest joint error"),
    LL_REAL(world_row, speed_max, 16, "m/s", "of the fastest body"),
    LL_REAL(world_row, momentum_x, 23, "kg m/s", "of all bodies"),
    LL_REAL(world_row, momentum_y, 23, "kg m/s", "of all bodies"),
    LL_INT(world_row, swept, NULL, "bodies with CCD in this step"),
    LL_INT(world_row, dynamic, NULL, "bodies that can move"),
};

const ll_record ll_rigid_world_record = {.id = 32,
                                         .name = "worlds",
                                         .channel = LL_CHANNEL_BODIES,
                                         .help = "The worlds side by side.",
                                         .form = LL_FORM_BY_INDEX,
                                         LL_ROWS_OF(world_row, world_fields)};

/* ---- geometries: each distinct one once, in the frame of the centre of mass ---- */

static const char *const geometry_kinds[] = {"circle", "capsule", "polygon", "segment", "link", NULL};

static const ll_record_field geometry_fields[] = {
    LL_ENUM(geometry_row, kind, geometry_kinds, "link: of a chain"),
    LL_STEP(geometry_row, radius, LL_BITS_M, "m", "around its vertices"),
    LL_STEP(geometry_row, circle_x, LL_BITS_M, "m", "centre of its bounding circle"),
    LL_STEP(geometry_row, circle_y, LL_BITS_M, "m", "centre of its bounding circle"),
    LL_STEP(geometry_row, circle_radius, LL_BITS_M, "m", "of that circle"),
    LL_STEP(geometry_row, obb_x0, LL_BITS_M, "m", "a corner of its oriented bounding box"),
    LL_STEP(geometry_row, obb_y0, LL_BITS_M, "m", "a corner of its oriented bounding box"),
    LL_STEP(geometry_row, obb_x1, LL_BITS_M, "m", "the next corner"),
    LL_STEP(geometry_row, obb_y1, LL_BITS_M, "m", "the next corner"),
    LL_STEP(geometry_row, obb_x2, LL_BITS_M, "m", "the next corner"),
    LL_STEP(geometry_row, obb_y2, LL_BITS_M, "m", "the next corner"),
    LL_STEP(geometry_row, obb_x3, LL_BITS_M, "m", "the last corner"),
    LL_STEP(geometry_row, obb_y3, LL_BITS_M, "m", "the last corner"),
};

const ll_record ll_rigid_geometry_record = {.id = 33,
                                            .name = "geometries",
                                            .channel = LL_CHANNEL_BODIES,
                                            .help = "Geometries of the shapes; equal ones once.",
                                            .form = LL_FORM_BY_INDEX,
                                            LL_ROWS_OF(geometry_row, geometry_fields)};

static const ll_record_field vertex_fields[] = {
    LL_INT(vertex_row, geometry, NULL, "index of the geometry"),
    LL_STEP(vertex_row, x, LL_BITS_M, "m", "from the centre of mass"),
    LL_STEP(vertex_row, y, LL_BITS_M, "m", "from the centre of mass"),
};

const ll_record ll_rigid_vertex_record = {
    .id = 34,
    .name = "vertices",
    .channel = LL_CHANNEL_BODIES,
    .help = "Vertices of the geometries; of a link its two, then its ghosts.",
    .form = LL_FORM_BY_INDEX,
    LL_ROWS_OF(vertex_row, vertex_fields)};

/* ---- shapes ---- */

static const char *const shape_flags[] = {"dynamic", "kinematic", "awake", NULL};

static const ll_record_field shape_fields[] = {
    LL_INT(shape_row, world, NULL, "index of the world"),
    LL_INT(shape_row, body, NULL, "its body; from 1 on"),
    LL_INT(shape_row, geometry, NULL, "index of its geometry"),
    LL_FLAGS(shape_row, flags, shape_flags, "of its body"),
    LL_STEP(shape_row, x, LL_BITS_BODY, "m", "of the centre of mass"),
    LL_STEP(shape_row, y, LL_BITS_BODY, "m", "of the centre of mass"),
    LL_STEP(shape_row, angle, LL_BITS_RAD, "rad", "orientation"),
    LL_STEP(shape_row, vx, LL_BITS_SPEED, "m/s", "velocity"),
    LL_STEP(shape_row, vy, LL_BITS_SPEED, "m/s", "velocity"),
    LL_STEP(shape_row, angular_velocity, LL_BITS_SPEED, "rad/s", "angular velocity"),
    LL_STEP(shape_row, left, LL_BITS_SPEED, "m", "box of the broad phase, relative to x and y"),
    LL_STEP(shape_row, bottom, LL_BITS_SPEED, "m", "box of the broad phase, relative to x and y"),
    LL_STEP(shape_row, right, LL_BITS_SPEED, "m", "box of the broad phase, relative to x and y"),
    LL_STEP(shape_row, top, LL_BITS_SPEED, "m", "box of the broad phase, relative to x and y"),
    LL_INT(shape_row, island, NULL, "number of its body's island; 0: none"),
};

LL_INTEGERS(shape_integers, shape_row, shape_fields)

const ll_record ll_rigid_shape_record = {.id = 35,
                                         .name = "shapes",
                                         .channel = LL_CHANNEL_BODIES,
                                         .help = "Shapes of all bodies, at most 65,535.",
                                         .form = LL_FORM_BY_INDEX,
                                         LL_ROWS_OF(shape_row, shape_fields),
                                         .integers = shape_integers};

/* ---- contacts ---- */

static const ll_record_field contact_fields[] = {
    LL_INT(contact_row, world, NULL, "index of the world"),
    LL_INT(contact_row, a, NULL, "a body"),
    LL_INT(contact_row, b, NULL, "the other body"),
    LL_INT(contact_row, count, NULL, "contact points; 0: only their boxes overlap"),
    LL_INT(contact_row, recycled, NULL, "contact recycling: whether the points are those of the step before"),
    LL_STEP(contact_row, nx, 10, NULL, "normal, from a to b; null: they do not touch"),
    LL_STEP(contact_row, ny, 10, NULL, "normal, from a to b; null: they do not touch"),
    LL_STEP(contact_row, x0, LL_BITS_BODY, "m", "the first point; null: there is none"),
    LL_STEP(contact_row, y0, LL_BITS_BODY, "m", "the first point; null: there is none"),
    LL_STEP(contact_row, separation0, LL_BITS_BODY, "m",
            "separation there; negative: they overlap; null: there is none"),
    LL_REAL(contact_row, impulse0, 5, "N s", "normal impulse there; null: there is none"),
    LL_STEP(contact_row, x1, LL_BITS_BODY, "m", "the second point; null: there is none"),
    LL_STEP(contact_row, y1, LL_BITS_BODY, "m", "the second point; null: there is none"),
    LL_STEP(contact_row, separation1, LL_BITS_BODY, "m",
            "separation there; negative: they overlap; null: there is none"),
    LL_REAL(contact_row, impulse1, 5, "N s", "normal impulse there; null: there is none"),
};

LL_INTEGERS(contact_integers, contact_row, contact_fields)

const ll_record ll_rigid_contact_record = {.id = 36,
                                           .name = "contacts",
                                           .channel = LL_CHANNEL_CONTACTS,
                                           .help = "Pairs of overlapping boxes, at most 8,192.",
                                           .form = LL_FORM_KEYED,
                                           .keys = 3,
                                           LL_ROWS_OF(contact_row, contact_fields),
                                           .integers = contact_integers};

/* ---- joints ---- */

static const ll_record_field joint_fields[] = {
    LL_INT(joint_row, world, NULL, "index of the world"),
    LL_INT(joint_row, a, NULL, "a body"),
    LL_INT(joint_row, b, NULL, "the other body"),
    LL_ENUM(joint_row, type, ll_joint_type_names, "joint type"),
    LL_STEP(joint_row, ax, LL_BITS_BODY, "m", "anchor on a"),
    LL_STEP(joint_row, ay, LL_BITS_BODY, "m", "anchor on a"),
    LL_STEP(joint_row, bx, LL_BITS_BODY, "m", "anchor on b"),
    LL_STEP(joint_row, by, LL_BITS_BODY, "m", "anchor on b"),
};

LL_INTEGERS(joint_integers, joint_row, joint_fields)

const ll_record ll_rigid_joint_record = {.id = 37,
                                         .name = "joints",
                                         .channel = LL_CHANNEL_JOINTS,
                                         .help = "At most 8,192.",
                                         .form = LL_FORM_BY_INDEX,
                                         LL_ROWS_OF(joint_row, joint_fields),
                                         .integers = joint_integers};

/* ---- bounding volumes ---- */

static const ll_record_field volume_fields[] = {
    LL_INT(volume_row, world, NULL, "index of the world"),
    LL_ENUM(volume_row, volume, ll_volume_names, "which"),
    LL_INT(volume_row, tests, NULL, "tests of pairs of shapes, over all steps"),
    LL_INT(volume_row, hits, NULL, "pairs whose volumes overlap"),
    LL_INT(volume_row, false_hits, NULL, "hits whose shapes do not overlap"),
    LL_INT(volume_row, missed_hits, NULL, "pairs whose shapes overlap but their volumes do not"),
    LL_REAL(volume_row, gap_mean, 16, "m", "mean distance of the shapes at false hits; 0: no false hits"),
    LL_REAL(volume_row, gap_max, 16, "m", "the largest of these"),
};

const ll_record ll_rigid_volume_record = {.id = 38,
                                          .name = "volumes",
                                          .channel = LL_CHANNEL_BODIES,
                                          .help = "Results of the bounding volumes, where they are compared.",
                                          .form = LL_FORM_BY_INDEX,
                                          LL_ROWS_OF(volume_row, volume_fields)};

const ll_record *const ll_rigid_sim_records[] = {
    &ll_rigid_world_record,   &ll_rigid_geometry_record, &ll_rigid_vertex_record, &ll_rigid_shape_record,
    &ll_rigid_contact_record, &ll_rigid_joint_record,    &ll_rigid_volume_record, NULL};
