/* What is streamed of a simulation of rigid bodies: sections 32 to 37 of session/frame.h. */
#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "sim/rigid/rigid.h"

enum {
    SECTION_WORLDS = 32,
    SECTION_GEOMETRIES,
    SECTION_SHAPES,
    SECTION_CONTACTS,
    SECTION_JOINTS,
    SECTION_VOLUMES
};
enum { SHAPES_MOST = 65535, LINES_MOST = 8192 };
enum { FLAG_DYNAMIC = 1, FLAG_KINEMATIC = 2, FLAG_AWAKE = 4, FLAG_DRAGGED = 8 };

typedef struct world_record {
    uint8_t world, status, solver, dragging;
    uint32_t bodies, awake, pairs, touching, points, recycled, tested, islands, passed, stopped, joints;
    double energy, energy_start, kinetic, penetration, penetration_worst, sag, drift, tilt, joint_error,
        speed_max;
    double momentum_x, momentum_y;
    uint32_t swept, dynamic;
} world_record;

typedef struct geometry_record {
    uint8_t kind, count;
    uint16_t number;
    float radius;
    float vertex[LL_HULL_MAX][2];
    float circle[4]; /* centre and radius of the sphere around; 0 */
    float obb[4][2];
} geometry_record;

typedef struct shape_record {
    uint32_t body;
    uint16_t geometry;
    uint8_t world, flags;
    double x, y;
    float angle, vx, vy, spin;
    float box[4]; /* of the broad phase, from (x, y): left, bottom, right, top */
    uint32_t island;
    uint32_t reserved;
} shape_record;

typedef struct contact_record {
    uint32_t a, b;
    uint8_t world, count, recycled, reserved;
    float nx, ny;
    uint32_t padding;
    struct {
        double x, y;
        float separation, impulse;
    } at[2];
} contact_record;

typedef struct joint_record {
    uint32_t a, b;
    uint8_t world, type;
    uint16_t reserved[3];
    double ax, ay, bx, by;
} joint_record;

typedef struct volume_record {
    uint8_t world, volume;
    uint16_t reserved[3];
    double tests, hits, false_hits, missed_hits, gap_mean, gap_max;
} volume_record;

_Static_assert(sizeof(world_record) == 152 && sizeof(geometry_record) == 120 && sizeof(shape_record) == 64 &&
                   sizeof(contact_record) == 72 && sizeof(joint_record) == 48 && sizeof(volume_record) == 56,
               "the layout of session/frame.h");

/* A frame in the making. */
typedef struct picture {
    const ll_rigid_sim *sim;
    world_record worlds[LL_SIDE_BY_SIDE_MAX];
    volume_record volumes[LL_SIDE_BY_SIDE_MAX * LL_VOLUMES];
    geometry_record *geometries;
    shape_record *shapes;
    contact_record *contacts;
    joint_record *joints;
    int32_t *known; /* hash table of geometries: number + 1 */
    int32_t *parent;
    uint32_t known_mask;
    int geometry_count, shape_count, contact_count, joint_count, volume_count;
} picture;

/* ---- islands: what hangs together by touching and by joints ---- */

static int32_t root_of(int32_t *parent, int32_t i)
{
    for (; parent[i] != i; i = parent[i])
        parent[i] = parent[parent[i]];
    return i;
}

static bool can_move(const ll_rigid *w, ll_body_id id)
{
    ll_body_state b;
    ll_status status = ll_rigid_get_body(w, id, &b);
    return !ll_failed(&status) && b.type == LL_BODY_DYNAMIC;
}

static void join(picture *p, const ll_rigid *w, ll_body_id a, ll_body_id b)
{
    if (!can_move(w, a) || !can_move(w, b))
        return;
    int32_t i = root_of(p->parent, a.index - 1), k = root_of(p->parent, b.index - 1);
    p->parent[i > k ? i : k] = i > k ? k : i;
}

static void find_islands(picture *p, const ll_rigid *w)
{
    for (int32_t i = 0; i < ll_rigid_body_end(w); i++)
        p->parent[i] = i;
    for (int32_t i = 0; i < ll_rigid_contact_end(w); i++) {
        ll_contact_view c;
        if (ll_rigid_contact_at(w, i, &c))
            join(p, w, c.a, c.b);
    }
    for (int32_t i = 0; i < ll_rigid_joint_end(w); i++) {
        ll_joint_view j;
        if (ll_rigid_joint_at(w, i, &j))
            join(p, w, j.a, j.b);
    }
}

/* ---- geometries: each of those that differ once ---- */

static void add_volumes(geometry_record *r, const ll_geometry *g)
{
    const ll_rot upright = {1, 0};
    ll_geometry circle = ll_bound_of(LL_VOLUME_SPHERE, g, upright),
                obb = ll_bound_of(LL_VOLUME_OBB, g, upright);
    r->circle[0] = (float)circle.centre.x;
    r->circle[1] = (float)circle.centre.y;
    r->circle[2] = (float)circle.radius;
    for (int i = 0; i < 4; i++) {
        r->obb[i][0] = (float)obb.vertex[i].x;
        r->obb[i][1] = (float)obb.vertex[i].y;
    }
}

static uint16_t number_of(picture *p, const ll_geometry *g)
{
    geometry_record r = {.kind = (uint8_t)g->kind, .count = (uint8_t)g->count, .radius = (float)g->radius};
    for (int i = 0; i < g->count; i++) {
        r.vertex[i][0] = (float)g->vertex[i].x;
        r.vertex[i][1] = (float)g->vertex[i].y;
    }
    const size_t size = offsetof(geometry_record, circle);
    uint32_t at = (uint32_t)ll_hash(0, &r, size) & p->known_mask;
    for (; p->known[at] != 0; at = (at + 1) & p->known_mask) {
        r.number = (uint16_t)(p->known[at] - 1);
        if (memcmp(&p->geometries[r.number], &r, size) == 0)
            return r.number;
    }
    r.number = (uint16_t)p->geometry_count++;
    add_volumes(&r, g);
    p->geometries[r.number] = r;
    p->known[at] = r.number + 1;
    return r.number;
}

/* ---- records ---- */

static void add_shape(picture *p, int world, const ll_shape_view *v)
{
    const ll_rigid *w = ll_rigid_sim_world(p->sim, world);
    ll_body_state b;
    ll_status status = ll_rigid_get_body(w, v->body, &b);
    if (ll_failed(&status))
        return;
    ll_vec2 at = v->pose.p;
    p->shapes[p->shape_count++] = (shape_record){
        .body = (uint32_t)v->body.index,
        .geometry = number_of(p, &v->geometry),
        .world = (uint8_t)world,
        .flags = (uint8_t)((b.type == LL_BODY_DYNAMIC ? FLAG_DYNAMIC : 0) |
                           (b.type == LL_BODY_KINEMATIC ? FLAG_KINEMATIC : 0) | (b.awake ? FLAG_AWAKE : 0)),
        .x = at.x,
        .y = at.y,
        .angle = (float)b.angle,
        .vx = (float)b.velocity.x,
        .vy = (float)b.velocity.y,
        .spin = (float)b.spin,
        .box = {(float)(v->box.lower.x - at.x), (float)(v->box.lower.y - at.y),
                (float)(v->box.upper.x - at.x), (float)(v->box.upper.y - at.y)},
        .island = b.type == LL_BODY_DYNAMIC ? (uint32_t)root_of(p->parent, v->body.index - 1) + 1 : 0};
}

static void add_contact(picture *p, int world, int32_t index)
{
    const ll_rigid *w = ll_rigid_sim_world(p->sim, world);
    ll_body_id a, b;
    ll_contact_view c;
    if (p->contact_count == LINES_MOST || !ll_rigid_pair_at(w, index, &a, &b))
        return;
    contact_record *r = &p->contacts[p->contact_count++];
    *r = (contact_record){.a = (uint32_t)a.index, .b = (uint32_t)b.index, .world = (uint8_t)world};
    if (!ll_rigid_contact_at(w, index, &c))
        return;
    r->count = (uint8_t)c.count;
    r->recycled = c.recycled != 0;
    r->nx = (float)c.normal.x;
    r->ny = (float)c.normal.y;
    for (int i = 0; i < c.count; i++) {
        r->at[i].x = c.at[i].point.x;
        r->at[i].y = c.at[i].point.y;
        r->at[i].separation = (float)c.at[i].separation;
        r->at[i].impulse = (float)c.at[i].impulse;
    }
}

static void add_joint(picture *p, int world, int32_t index)
{
    ll_joint_view j;
    if (p->joint_count == LINES_MOST || !ll_rigid_joint_at(ll_rigid_sim_world(p->sim, world), index, &j))
        return;
    p->joints[p->joint_count++] = (joint_record){.a = (uint32_t)j.a.index,
                                                 .b = (uint32_t)j.b.index,
                                                 .world = (uint8_t)world,
                                                 .type = (uint8_t)j.type,
                                                 .ax = j.anchor_a.x,
                                                 .ay = j.anchor_a.y,
                                                 .bx = j.anchor_b.x,
                                                 .by = j.anchor_b.y};
}

static world_record world_of(const ll_rigid_sim *s, int i)
{
    const ll_rigid_record *r = &s->record[i];
    const ll_rigid_metrics *m = &r->now;
    ll_rigid_stats t = ll_rigid_get_stats(ll_rigid_sim_world(s, i));
    return (world_record){.world = (uint8_t)i,
                          .status = r->diverged_at >= 0,
                          .solver = (uint8_t)ll_rigid_sim_params(&s->setup, i).solver,
                          .dragging = r->mouse.index != 0,
                          .bodies = (uint32_t)t.bodies,
                          .awake = (uint32_t)t.awake,
                          .pairs = (uint32_t)t.pairs,
                          .touching = (uint32_t)t.touching,
                          .points = (uint32_t)t.points,
                          .recycled = (uint32_t)t.recycled,
                          .tested = (uint32_t)t.tested,
                          .islands = (uint32_t)t.islands,
                          .passed = (uint32_t)m->passed,
                          .stopped = (uint32_t)r->stopped,
                          .joints = (uint32_t)t.joints,
                          .energy = m->kinetic_energy + m->potential_energy,
                          .energy_start = r->energy_start,
                          .kinetic = m->kinetic_energy,
                          .penetration = m->penetration_max,
                          .penetration_worst = r->penetration_worst,
                          .sag = m->sag_max,
                          .drift = m->drift_max,
                          .tilt = m->tilt_max,
                          .joint_error = m->joint_error,
                          .speed_max = m->speed_max,
                          .momentum_x = m->momentum.x,
                          .momentum_y = m->momentum.y,
                          .swept = (uint32_t)t.swept,
                          .dynamic = (uint32_t)m->bodies};
}

static void add_volume_records(picture *p, int world)
{
    if (!p->sim->setup.compare_volumes)
        return;
    for (int v = 0; v < LL_VOLUMES; v++) {
        const ll_volume_record *r = &p->sim->record[world].volume[v];
        p->volumes[p->volume_count++] =
            (volume_record){.world = (uint8_t)world,
                            .volume = (uint8_t)v,
                            .tests = (double)r->tests,
                            .hits = (double)r->hits,
                            .false_hits = (double)r->false_hits,
                            .missed_hits = (double)r->missed_hits,
                            .gap_mean = r->false_hits > 0 ? r->gap_sum / (double)r->false_hits : 0,
                            .gap_max = r->gap_max};
    }
}

static void add_world(picture *p, int i)
{
    const ll_rigid *w = ll_rigid_sim_world(p->sim, i);
    int32_t shapes = ll_rigid_shape_end(w);
    p->worlds[i] = world_of(p->sim, i);
    find_islands(p, w);
    for (int32_t k = 0; k < shapes && p->shape_count < SHAPES_MOST; k++) {
        ll_shape_view v;
        if (ll_rigid_shape_at(w, k, &v))
            add_shape(p, i, &v);
    }
    for (int32_t k = 0; k < ll_rigid_contact_end(w); k++)
        add_contact(p, i, k);
    for (int32_t k = 0; k < ll_rigid_joint_end(w); k++)
        add_joint(p, i, k);
    add_volume_records(p, i);
}

static void discard(picture *p)
{
    free(p->geometries);
    free(p->shapes);
    free(p->contacts);
    free(p->joints);
    free(p->known);
    free(p->parent);
}

/* False without memory. */
static bool take(picture *p, const ll_rigid_sim *s)
{
    size_t shapes = 1, contacts = 1, joints = 1, bodies = 1, table = 16;
    *p = (picture){.sim = s};
    for (int i = 0; i < ll_rigid_sim_worlds(&s->setup); i++) {
        const ll_rigid *w = ll_rigid_sim_world(s, i);
        shapes += (size_t)ll_rigid_shape_end(w);
        contacts += (size_t)ll_rigid_contact_end(w);
        joints += (size_t)ll_rigid_joint_end(w);
        bodies += (size_t)ll_rigid_body_end(w);
    }
    shapes = shapes < SHAPES_MOST ? shapes : SHAPES_MOST;
    contacts = contacts < LINES_MOST ? contacts : LINES_MOST;
    joints = joints < LINES_MOST ? joints : LINES_MOST;
    while (table < 2 * shapes)
        table *= 2;
    p->known_mask = (uint32_t)table - 1;
    p->geometries = malloc(shapes * sizeof *p->geometries);
    p->shapes = malloc(shapes * sizeof *p->shapes);
    p->contacts = malloc(contacts * sizeof *p->contacts);
    p->joints = malloc(joints * sizeof *p->joints);
    p->known = calloc(table, sizeof *p->known);
    p->parent = malloc(bodies * sizeof *p->parent);
    if (!p->geometries || !p->shapes || !p->contacts || !p->joints || !p->known || !p->parent) {
        discard(p);
        return false;
    }
    for (int i = 0; i < ll_rigid_sim_worlds(&s->setup); i++)
        add_world(p, i);
    return true;
}

/* ---- binary ---- */

void ll_rigid_sim_sections(const void *block,
                           void (*section)(void *context, int type, int count, const void *bytes,
                                           size_t size),
                           void *context)
{
    const ll_rigid_sim *s = block;
    picture p;
    if (!take(&p, s))
        return;
    int worlds = ll_rigid_sim_worlds(&s->setup);
    section(context, SECTION_WORLDS, worlds, p.worlds, (size_t)worlds * sizeof *p.worlds);
    section(context, SECTION_GEOMETRIES, p.geometry_count, p.geometries,
            (size_t)p.geometry_count * sizeof *p.geometries);
    section(context, SECTION_SHAPES, p.shape_count, p.shapes, (size_t)p.shape_count * sizeof *p.shapes);
    section(context, SECTION_CONTACTS, p.contact_count, p.contacts,
            (size_t)p.contact_count * sizeof *p.contacts);
    section(context, SECTION_JOINTS, p.joint_count, p.joints, (size_t)p.joint_count * sizeof *p.joints);
    section(context, SECTION_VOLUMES, p.volume_count, p.volumes, (size_t)p.volume_count * sizeof *p.volumes);
    discard(&p);
}

/* ---- JSON: the same records, by the names of their fields ---- */

typedef enum field_type { U8, U16, U32, F32, F64 } field_type;

typedef struct field {
    const char *name;
    size_t offset;
    field_type type;
} field;

static const field world_fields[] = {
#define AT(type, name)                                                                                       \
    {                                                                                                        \
#name, offsetof(world_record, name), type                                                            \
    }
    AT(U8, world),         AT(U8, status),      AT(U8, solver),       AT(U8, dragging),
    AT(U32, bodies),       AT(U32, awake),      AT(U32, pairs),       AT(U32, touching),
    AT(U32, points),       AT(U32, recycled),   AT(U32, tested),      AT(U32, islands),
    AT(U32, passed),       AT(U32, stopped),    AT(U32, joints),      AT(F64, energy),
    AT(F64, energy_start), AT(F64, kinetic),    AT(F64, penetration), AT(F64, penetration_worst),
    AT(F64, sag),          AT(F64, drift),      AT(F64, tilt),        AT(F64, joint_error),
    AT(F64, speed_max),    AT(F64, momentum_x), AT(F64, momentum_y),  AT(U32, swept),
    AT(U32, dynamic)
#undef AT
};

static const field geometry_fields[] = {
#define AT(type, name, member)                                                                               \
    {                                                                                                        \
        name, offsetof(geometry_record, member), type                                                        \
    }
#define VERTEX(i) AT(F32, "x" #i, vertex[i][0]), AT(F32, "y" #i, vertex[i][1])
#define CORNER(i) AT(F32, "obb_x" #i, obb[i][0]), AT(F32, "obb_y" #i, obb[i][1])
    AT(U8, "kind", kind),
    AT(U8, "count", count),
    AT(U16, "number", number),
    AT(F32, "radius", radius),
    VERTEX(0),
    VERTEX(1),
    VERTEX(2),
    VERTEX(3),
    VERTEX(4),
    VERTEX(5),
    VERTEX(6),
    VERTEX(7),
    AT(F32, "circle_x", circle[0]),
    AT(F32, "circle_y", circle[1]),
    AT(F32, "circle_radius", circle[2]),
    CORNER(0),
    CORNER(1),
    CORNER(2),
    CORNER(3)
#undef CORNER
#undef VERTEX
#undef AT
};

static const field shape_fields[] = {
#define AT(type, name, member)                                                                               \
    {                                                                                                        \
        name, offsetof(shape_record, member), type                                                           \
    }
    AT(U32, "body", body),    AT(U16, "geometry", geometry),
    AT(U8, "world", world),   AT(U8, "flags", flags),
    AT(F64, "x", x),          AT(F64, "y", y),
    AT(F32, "angle", angle),  AT(F32, "vx", vx),
    AT(F32, "vy", vy),        AT(F32, "spin", spin),
    AT(F32, "left", box[0]),  AT(F32, "bottom", box[1]),
    AT(F32, "right", box[2]), AT(F32, "top", box[3]),
    AT(U32, "island", island)
#undef AT
};

static const field contact_fields[] = {
#define AT(type, name, member)                                                                               \
    {                                                                                                        \
        name, offsetof(contact_record, member), type                                                         \
    }
#define POINT(i)                                                                                             \
    AT(F64, "x" #i, at[i].x), AT(F64, "y" #i, at[i].y), AT(F32, "separation" #i, at[i].separation),          \
        AT(F32, "impulse" #i, at[i].impulse)
    AT(U32, "a", a),
    AT(U32, "b", b),
    AT(U8, "world", world),
    AT(U8, "count", count),
    AT(U8, "recycled", recycled),
    AT(F32, "nx", nx),
    AT(F32, "ny", ny),
    POINT(0),
    POINT(1)
#undef POINT
#undef AT
};

static const field joint_fields[] = {
#define AT(type, name)                                                                                       \
    {                                                                                                        \
#name, offsetof(joint_record, name), type                                                            \
    }
    AT(U32, a),  AT(U32, b),  AT(U8, world), AT(U8, type), AT(F64, ax),
    AT(F64, ay), AT(F64, bx), AT(F64, by)
#undef AT
};

static const field volume_fields[] = {
#define AT(type, name)                                                                                       \
    {                                                                                                        \
#name, offsetof(volume_record, name), type                                                           \
    }
    AT(U8, world),        AT(U8, volume),    AT(F64, tests),  AT(F64, hits), AT(F64, false_hits),
    AT(F64, missed_hits), AT(F64, gap_mean), AT(F64, gap_max)
#undef AT
};

static double value_of(const char *record, const field *f)
{
    uint16_t u16;
    uint32_t u32;
    float f32;
    double f64;
    switch (f->type) {
    case U8:
        return (uint8_t)record[f->offset];
    case U16:
        memcpy(&u16, record + f->offset, sizeof u16);
        return u16;
    case U32:
        memcpy(&u32, record + f->offset, sizeof u32);
        return u32;
    case F32:
        memcpy(&f32, record + f->offset, sizeof f32);
        return (double)f32;
    default:
        memcpy(&f64, record + f->offset, sizeof f64);
        return f64;
    }
}

static void records_json(cJSON *frame, const char *name, const field *fields, size_t field_count,
                         const void *records, int count, size_t size)
{
    cJSON *array = cJSON_AddArrayToObject(frame, name);
    for (int i = 0; i < count; i++) {
        const char *record = (const char *)records + (size_t)i * size;
        cJSON *o = cJSON_CreateObject();
        for (size_t k = 0; k < field_count; k++) {
            double value = value_of(record, &fields[k]);
            cJSON_AddItemToObject(o, fields[k].name,
                                  value - value == 0 ? ll_param_number(value) : cJSON_CreateNull());
        }
        cJSON_AddItemToArray(array, o);
    }
}

#define RECORDS(name, fields, records, count)                                                                \
    records_json(frame, name, fields, sizeof fields / sizeof fields[0], records, count, sizeof *records)

void ll_rigid_sim_sections_json(const void *block, cJSON *frame)
{
    picture p;
    if (!take(&p, block))
        return;
    RECORDS("worlds", world_fields, p.worlds, ll_rigid_sim_worlds(&p.sim->setup));
    RECORDS("geometries", geometry_fields, p.geometries, p.geometry_count);
    RECORDS("shapes", shape_fields, p.shapes, p.shape_count);
    RECORDS("contacts", contact_fields, p.contacts, p.contact_count);
    RECORDS("joints", joint_fields, p.joints, p.joint_count);
    RECORDS("volumes", volume_fields, p.volumes, p.volume_count);
    discard(&p);
}
