#include "game/floor_contact.h"

#include "base/detmath.h"

typedef struct point {
    double x, y;
} point;

double ll_floor_bound(const ll_floor_body *b)
{
    return b->round ? b->half : b->half * 1.4142135623730951;
}

static point turned(const ll_floor_frame *f, point p) /* into the world's directions */
{
    return (point){f->cos * p.x - f->sin * p.y, f->sin * p.x + f->cos * p.y};
}

static point turned_back(const ll_floor_frame *f, point p)
{
    return (point){f->cos * p.x + f->sin * p.y, f->cos * p.y - f->sin * p.x};
}

static double magnitude(double x)
{
    return x < 0 ? -x : x;
}

/* ---- discs ---- */

static int disc_disc(const ll_floor_body *a, const ll_floor_body *b, double margin, ll_floor_point *p)
{
    double dx = b->x - a->x, dy = b->y - a->y, apart2 = dx * dx + dy * dy, reach = a->half + b->half + margin;
    if (apart2 > reach * reach)
        return 0;
    double apart = ll_sqrt(apart2);
    p->nx = apart > 0 ? dx / apart : 1;
    p->ny = apart > 0 ? dy / apart : 0;
    p->x = a->x + p->nx * a->half;
    p->y = a->y + p->ny * a->half;
    p->gap = apart - a->half - b->half;
    return 1;
}

/* From the box's side: the point of the box that is nearest to the disc's centre, or, with the centre inside,
 * the nearest face. */
static int box_disc(const ll_floor_body *box, const ll_floor_frame *f, const ll_floor_body *disc,
                    double margin, ll_floor_point *p)
{
    point c = turned_back(f, (point){disc->x - box->x, disc->y - box->y});
    point near = {ll_clamp(c.x, -box->half, box->half), ll_clamp(c.y, -box->half, box->half)}, n;
    double dx = c.x - near.x, dy = c.y - near.y, apart2 = dx * dx + dy * dy, reach = disc->half + margin,
           apart;
    if (apart2 > reach * reach)
        return 0;
    if (apart2 > 0) {
        apart = ll_sqrt(apart2);
        n = (point){dx / apart, dy / apart};
    } else if (magnitude(c.x) >= magnitude(c.y)) {
        n = (point){c.x < 0 ? -1 : 1, 0};
        apart = magnitude(c.x) - box->half;
    } else {
        n = (point){0, c.y < 0 ? -1 : 1};
        apart = magnitude(c.y) - box->half;
    }
    point normal = turned(f, n), at = turned(f, near);
    *p = (ll_floor_point){box->x + at.x, box->y + at.y, normal.x, normal.y, apart - disc->half};
    return 1;
}

/* ---- boxes ---- */

/* The face of box `a` that is furthest from `b`: the axis of a separation, as far as a's faces go. */
typedef struct face {
    point normal; /* in the world, outward from a */
    double gap;
} face;

static face widest(const ll_floor_body *a, const ll_floor_frame *fa, const ll_floor_body *b,
                   const ll_floor_frame *fb)
{
    point d = turned_back(fa, (point){b->x - a->x, b->y - a->y});
    /* b's extent along either axis of a: both are the same for a square */
    double c = magnitude(fa->cos * fb->cos + fa->sin * fb->sin),
           s = magnitude(fa->cos * fb->sin - fa->sin * fb->cos);
    double reach = a->half + b->half * (c + s);
    double gx = magnitude(d.x) - reach, gy = magnitude(d.y) - reach;
    point n = gx >= gy ? (point){d.x < 0 ? -1 : 1, 0} : (point){0, d.y < 0 ? -1 : 1};
    return (face){turned(fa, n), gx >= gy ? gx : gy};
}

/* The two corners of `b` that lie furthest against `n`: the edge that meets a face with that normal. */
static void incident_edge(const ll_floor_body *b, const ll_floor_frame *fb, point n, point edge[2])
{
    point local = turned_back(fb, n), from, to;
    double h = b->half;
    if (magnitude(local.x) >= magnitude(local.y)) {
        double x = local.x > 0 ? -h : h;
        from = (point){x, -h};
        to = (point){x, h};
    } else {
        double y = local.y > 0 ? -h : h;
        from = (point){-h, y};
        to = (point){h, y};
    }
    from = turned(fb, from);
    to = turned(fb, to);
    edge[0] = (point){b->x + from.x, b->y + from.y};
    edge[1] = (point){b->x + to.x, b->y + to.y};
}

/* Cuts the part of an edge off that lies beyond `limit` in direction `t` from `origin`; false when that is
 * all. */
static bool clip(point edge[2], point origin, point t, double limit)
{
    double a = (edge[0].x - origin.x) * t.x + (edge[0].y - origin.y) * t.y - limit;
    double b = (edge[1].x - origin.x) * t.x + (edge[1].y - origin.y) * t.y - limit;
    if (a > 0 && b > 0)
        return false;
    if (a > 0 || b > 0) {
        double share = a / (a - b);
        point cut = {edge[0].x + share * (edge[1].x - edge[0].x),
                     edge[0].y + share * (edge[1].y - edge[0].y)};
        edge[a > 0 ? 0 : 1] = cut;
    }
    return true;
}

/* Contact of a face of `a` with the edge of `b` that meets it. */
static int face_edge(const ll_floor_body *a, face f, const ll_floor_body *b, const ll_floor_frame *fb,
                     double margin, ll_floor_point points[2])
{
    point edge[2], centre = {a->x, a->y}, t = {-f.normal.y, f.normal.x}, back = {f.normal.y, -f.normal.x};
    int count = 0;
    incident_edge(b, fb, f.normal, edge);
    if (!clip(edge, centre, t, a->half) || !clip(edge, centre, back, a->half))
        return 0;
    for (int i = 0; i < 2; i++) {
        double gap = (edge[i].x - centre.x) * f.normal.x + (edge[i].y - centre.y) * f.normal.y - a->half;
        if (gap <= margin)
            points[count++] = (ll_floor_point){edge[i].x - f.normal.x * gap / 2,
                                               edge[i].y - f.normal.y * gap / 2, f.normal.x, f.normal.y, gap};
    }
    return count;
}

#define PREFERENCE 1e-4 /* m: the first box's face, unless the other's is wider by so much */

/* Separating axes: the widest gap, if any, belongs to a face of either box. */
static int box_box(const ll_floor_body *a, const ll_floor_frame *fa, const ll_floor_body *b,
                   const ll_floor_frame *fb, double margin, ll_floor_point points[2])
{
    face of_a = widest(a, fa, b, fb), of_b = widest(b, fb, a, fa);
    if (of_a.gap > margin || of_b.gap > margin)
        return 0;
    if (of_b.gap <= of_a.gap + PREFERENCE)
        return face_edge(a, of_a, b, fb, margin, points);
    int count = face_edge(b, of_b, a, fa, margin, points);
    for (int i = 0; i < count; i++) {
        points[i].nx = -points[i].nx;
        points[i].ny = -points[i].ny;
    }
    return count;
}

/* ---- any ---- */

int ll_floor_touch(const ll_floor_body *a, const ll_floor_frame *fa, const ll_floor_body *b,
                   const ll_floor_frame *fb, double margin, ll_floor_point points[2])
{
    double reach = ll_floor_bound(a) + ll_floor_bound(b) + margin, dx = b->x - a->x, dy = b->y - a->y;
    if (dx * dx + dy * dy > reach * reach)
        return 0;
    if (a->round && b->round)
        return disc_disc(a, b, margin, points);
    if (!a->round && !b->round)
        return box_box(a, fa, b, fb, margin, points);
    if (!a->round)
        return box_disc(a, fa, b, margin, points);
    int count = box_disc(b, fb, a, margin, points);
    if (count > 0) {
        points[0].nx = -points[0].nx;
        points[0].ny = -points[0].ny;
    }
    return count;
}

int ll_floor_touch_wall(const ll_floor_body *b, const ll_floor_frame *f, double nx, double ny, double wall,
                        double margin, ll_floor_point points[2])
{
    double centre = wall - (b->x * nx + b->y * ny);
    if (centre > ll_floor_bound(b) + margin)
        return 0;
    if (b->round) {
        points[0] = (ll_floor_point){b->x + nx * b->half, b->y + ny * b->half, nx, ny, centre - b->half};
        return centre - b->half <= margin;
    }
    point edge[2];
    int count = 0;
    incident_edge(b, f, (point){-nx, -ny}, edge);
    for (int i = 0; i < 2; i++) {
        double gap = wall - (edge[i].x * nx + edge[i].y * ny);
        if (gap <= margin)
            points[count++] = (ll_floor_point){edge[i].x, edge[i].y, nx, ny, gap};
    }
    return count;
}
