#include <stdio.h>
#include <stdlib.h>

#include <cjson/cJSON.h>

#include "rigid/engine.h"

static double number(const cJSON *object, const char *name)
{
    const cJSON *item = cJSON_GetObjectItem(object, name);
    if (!cJSON_IsNumber(item)) {
        fprintf(stderr, "rigid: the scene has no number %s\n", name);
        exit(2);
    }
    return item->valuedouble;
}

static int whole(const cJSON *object, const char *name)
{
    return (int)number(object, name);
}

/* Room for the list's items, with their count. */
static void *list(const cJSON *object, const char *name, size_t size, int *count)
{
    *count = cJSON_GetArraySize(cJSON_GetObjectItem(object, name));
    return calloc((size_t)*count + 1, size);
}

static bench_shape read_shape(const cJSON *from)
{
    bench_shape s = {.kind = whole(from, "kind"),
                     .radius = number(from, "radius"),
                     .density = number(from, "density"),
                     .friction = number(from, "friction"),
                     .restitution = number(from, "restitution"),
                     .category = (unsigned)number(from, "category"),
                     .mask = (unsigned)number(from, "mask"),
                     .group = whole(from, "group")};
    s.vertex = list(from, "vertices", sizeof *s.vertex, &s.count);
    int i = 0;
    for (const cJSON *at = cJSON_GetObjectItem(from, "vertices")->child; at != NULL; at = at->next, i++)
        for (int k = 0; k < 2; k++)
            s.vertex[i][k] = cJSON_GetArrayItem(at, k)->valuedouble;
    return s;
}

static bench_body read_body(const cJSON *from)
{
    bench_body b = {.type = whole(from, "type"),
                    .x = number(from, "x"),
                    .y = number(from, "y"),
                    .angle = number(from, "angle"),
                    .vx = number(from, "vx"),
                    .vy = number(from, "vy"),
                    .angular_velocity = number(from, "angular_velocity")};
    b.shapes = list(from, "shapes", sizeof *b.shapes, &b.shape_count);
    int i = 0;
    for (const cJSON *at = cJSON_GetObjectItem(from, "shapes")->child; at != NULL; at = at->next)
        b.shapes[i++] = read_shape(at);
    return b;
}

static bench_joint read_joint(const cJSON *from)
{
    return (bench_joint){.a = whole(from, "a"),
                         .b = whole(from, "b"),
                         .ax = number(from, "ax"),
                         .ay = number(from, "ay"),
                         .bx = number(from, "bx"),
                         .by = number(from, "by"),
                         .limited = number(from, "limited") != 0,
                         .motored = number(from, "motored") != 0,
                         .angle = number(from, "angle"),
                         .lower = number(from, "lower"),
                         .upper = number(from, "upper"),
                         .speed = number(from, "speed"),
                         .torque = number(from, "torque")};
}

static bench_event read_event(const cJSON *from)
{
    bench_event e = {.step = whole(from, "step")};
    int i = 0;
    e.removed = list(from, "removed", sizeof *e.removed, &e.removed_count);
    for (const cJSON *at = cJSON_GetObjectItem(from, "removed")->child; at != NULL; at = at->next)
        e.removed[i++] = at->valueint;
    i = 0;
    e.bodies = list(from, "bodies", sizeof *e.bodies, &e.body_count);
    for (const cJSON *at = cJSON_GetObjectItem(from, "bodies")->child; at != NULL; at = at->next)
        e.bodies[i++] = read_body(at);
    i = 0;
    e.joints = list(from, "joints", sizeof *e.joints, &e.joint_count);
    for (const cJSON *at = cJSON_GetObjectItem(from, "joints")->child; at != NULL; at = at->next)
        e.joints[i++] = read_joint(at);
    return e;
}

static cJSON *parse(const char *file)
{
    FILE *f = fopen(file, "rb");
    char *text = NULL;
    size_t size = 0, got = 0;
    if (f == NULL || fseek(f, 0, SEEK_END) != 0)
        return NULL;
    size = (size_t)ftell(f);
    rewind(f);
    text = malloc(size + 1);
    got = fread(text, 1, size, f);
    fclose(f);
    cJSON *json = cJSON_ParseWithLength(text, got);
    free(text);
    return json;
}

const bench_scene *read_scene(const char *file)
{
    cJSON *json = parse(file);
    if (json == NULL) {
        fprintf(stderr, "rigid: %s is not a scene\n", file);
        exit(2);
    }
    bench_scene *s = calloc(1, sizeof *s);
    s->world = (bench_world){.gravity_x = number(json, "gravity_x"),
                             .gravity_y = number(json, "gravity_y"),
                             .dt = number(json, "dt"),
                             .continuous = number(json, "continuous") != 0,
                             .bodies = whole(json, "bodies"),
                             .shapes = whole(json, "shapes"),
                             .contacts = whole(json, "contacts"),
                             .joints = whole(json, "joints")};
    s->events = list(json, "events", sizeof *s->events, &s->event_count);
    int i = 0;
    for (const cJSON *at = cJSON_GetObjectItem(json, "events")->child; at != NULL; at = at->next) {
        s->events[i] = read_event(at);
        s->world.made += s->events[i++].body_count;
    }
    cJSON_Delete(json);
    return s;
}
