/* SPDX-License-Identifier: MIT */
#include "triangulation.h"

#include <math.h>
#include <string.h>

enum { OWN = 3, NONE = -1 };

/* Points nearer to each other than this are one; a point this near to an edge is on it. */
static const double together = 1e-12;

/* Diagonals whose opposite angles are this near to half a turn may stay: rounding. */
static const double even_sine = 1e-12;

/* Exchanges, for each edge that is looked at, before giving up. */
enum { EXCHANGES = 64 };

struct builder {
    struct triangulation *t;
    int32_t *at;    /* of each point: a triangle that has it */
    int32_t *stack; /* of triangles whose edges are to be looked at */
    size_t depth, room;
    int32_t last; /* where the last point was found */
};

static int next_corner(int k) {
    return k == 2 ? 0 : k + 1;
}

static int last_corner(int k) {
    return k == 0 ? 2 : k - 1;
}

/* Twice the area of the triangle p, q, r, positive counter-clockwise. */
static double twice_area_of(const struct triangulation *t, int32_t p, int32_t q, int32_t r) {
    struct vec3 a = t->points[p], b = t->points[q], c = t->points[r];
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/* Which of a triangle's three corners, or neighbours, `wanted` is. */
static int place_among(const int32_t three[3], int32_t wanted) {
    for (int k = 0; k < 3; k++)
        if (three[k] == wanted)
            return k;
    return NONE;
}

static void set_triangle(struct builder *b, int32_t triangle, const int32_t corner[3]) {
    memcpy(b->t->corners[triangle], corner, sizeof *b->t->corners);
    for (int k = 0; k < 3; k++)
        b->at[corner[k]] = triangle;
}

/* Makes `triangle` and what lies beyond its edge k each other's neighbours. */
static void link_beyond(struct triangulation *t, int32_t triangle, int k, int32_t other,
                        int32_t was, bool fixed) {
    t->beyond[triangle][k] = other;
    t->fixed[triangle][k] = fixed;
    if (other == NONE)
        return;
    int back = place_among(t->beyond[other], was);
    if (back != NONE)
        t->beyond[other][back] = triangle;
}

/* The triangles (p, q, r) and (q, p, o) on both sides of an edge. */
struct diamond {
    int32_t other; /* the second triangle */
    int32_t p, q, r, o;
    int back; /* its edge to the first */
};

static struct diamond diamond_at(const struct triangulation *t, int32_t s, int k) {
    const int32_t *own = t->corners[s];
    int32_t other = t->beyond[s][k];
    int back = place_among(t->beyond[other], s);
    return (struct diamond){other,
                            own[k],
                            own[next_corner(k)],
                            own[last_corner(k)],
                            t->corners[other][last_corner(back)],
                            back};
}

/* ---- exchanging diagonals ---- */

/* At edge k of triangle s, from p to q: (p, o, r), (o, q, r) for (p, q, r), (q, p, o). */
static void exchange_diagonal(struct builder *b, int32_t s, int k) {
    struct triangulation *t = b->t;
    const struct diamond d = diamond_at(t, s, k);
    const int next = next_corner(k), last = last_corner(k);
    const int po = next_corner(d.back), oq = last_corner(d.back);
    int32_t beyond[4] = {t->beyond[s][next], t->beyond[s][last], t->beyond[d.other][po],
                         t->beyond[d.other][oq]};
    bool fixed[4] = {t->fixed[s][next], t->fixed[s][last], t->fixed[d.other][po],
                     t->fixed[d.other][oq]};
    set_triangle(b, s, (const int32_t[]){d.p, d.o, d.r});
    set_triangle(b, d.other, (const int32_t[]){d.o, d.q, d.r});
    t->beyond[s][1] = d.other;
    t->beyond[d.other][2] = s;
    t->fixed[s][1] = t->fixed[d.other][2] = false;
    t->beyond[s][2] = beyond[1];
    t->fixed[s][2] = fixed[1];
    t->beyond[d.other][0] = beyond[3];
    t->fixed[d.other][0] = fixed[3];
    link_beyond(t, s, 0, beyond[2], d.other, fixed[2]);
    link_beyond(t, d.other, 1, beyond[0], s, fixed[0]);
}

/* Whether the two triangles make a convex quadrilateral in the plane. */
static bool is_convex_pair(const struct triangulation *t, const struct diamond *d) {
    struct vec3 diagonal = vec3_sub(t->points[d->o], t->points[d->r]);
    double least = together * vec3_norm(diagonal);
    return twice_area_of(t, d->p, d->o, d->r) > least && twice_area_of(t, d->o, d->q, d->r) > least;
}

static void push_triangle(struct builder *b, int32_t triangle) {
    if (b->depth < b->room)
        b->stack[b->depth++] = triangle;
}

/* Exchanges those diagonals round the triangles of the stack that may go and ought to: the angles
 * opposite to them, where the points are `at`, add up to more than half a turn. */
static void exchange_all(struct builder *b, const struct vec3 *at, const bool *chosen,
                         size_t most) {
    struct triangulation *t = b->t;
    while (b->depth > 0 && most > 0) {
        int32_t s = b->stack[--b->depth];
        for (int k = 0; k < 3; k++) {
            int32_t o = t->beyond[s][k];
            if ((chosen && !chosen[t->region[s]]) || o == NONE || t->fixed[s][k])
                continue;
            const struct diamond d = diamond_at(t, s, k);
            struct vec3 pr = vec3_sub(at[d.p], at[d.r]), qr = vec3_sub(at[d.q], at[d.r]);
            struct vec3 po = vec3_sub(at[d.p], at[d.o]), qo = vec3_sub(at[d.q], at[d.o]);
            double cosine[2] = {vec3_dot(pr, qr), vec3_dot(po, qo)};
            double sine[2] = {vec3_norm(vec3_cross(pr, qr)), vec3_norm(vec3_cross(po, qo))};
            double scale = sqrt(vec3_norm2(pr) * vec3_norm2(qr) * vec3_norm2(po) * vec3_norm2(qo));
            double sum = sine[0] * cosine[1] + cosine[0] * sine[1];
            if (!(sum < -even_sine * scale) || !is_convex_pair(t, &d))
                continue;
            exchange_diagonal(b, s, k);
            push_triangle(b, o);
            push_triangle(b, s);
            most--;
            break;
        }
    }
    b->depth = 0;
}

/* ---- points ---- */

/* Three triangles for one. */
static void split_triangle(struct builder *b, int32_t s, int32_t point) {
    struct triangulation *t = b->t;
    int32_t corner[3], beyond[3], part[3] = {s, (int32_t)t->count, (int32_t)t->count + 1};
    memcpy(corner, t->corners[s], sizeof corner);
    memcpy(beyond, t->beyond[s], sizeof beyond);
    t->count += 2;
    for (int k = 0; k < 3; k++) {
        set_triangle(b, part[k], (const int32_t[]){corner[k], corner[next_corner(k)], point});
        t->beyond[part[k]][1] = part[next_corner(k)];
        t->beyond[part[k]][2] = part[last_corner(k)];
        link_beyond(t, part[k], 0, beyond[k], s, false);
        push_triangle(b, part[k]);
    }
}

/* Four triangles for the two at the edge k: (p, q, r), (q, p, o) become (p, x, r), (x, q, r),
 * (q, x, o), (x, p, o). */
static void split_edge(struct builder *b, int32_t s, int k, int32_t x) {
    struct triangulation *t = b->t;
    const struct diamond d = diamond_at(t, s, k);
    int32_t o = d.other, s2 = (int32_t)t->count, o2 = s2 + 1;
    int32_t qr = t->beyond[s][next_corner(k)], rp = t->beyond[s][last_corner(k)];
    int32_t po = t->beyond[o][next_corner(d.back)], oq = t->beyond[o][last_corner(d.back)];
    t->count += 2;
    set_triangle(b, s, (const int32_t[]){d.p, x, d.r});
    set_triangle(b, s2, (const int32_t[]){x, d.q, d.r});
    set_triangle(b, o, (const int32_t[]){d.q, x, d.o});
    set_triangle(b, o2, (const int32_t[]){x, d.p, d.o});
    const int32_t beyond[4][3] = {{o2, s2, rp}, {o, qr, s}, {s2, o2, oq}, {s, po, o}};
    const int32_t own[4] = {s, s2, o, o2};
    for (int n = 0; n < 4; n++)
        memcpy(t->beyond[own[n]], beyond[n], sizeof beyond[n]);
    link_beyond(t, s2, 1, qr, s, false);
    link_beyond(t, o2, 1, po, o, false);
    for (int n = 0; n < 4; n++)
        push_triangle(b, own[n]);
}

static void insert_point(struct builder *b, int32_t point) {
    struct triangulation *t = b->t;
    struct vec3 r = t->points[point];
    int32_t s = b->last, last = NONE;
    /* walks to the triangle that the point is in, or on whose edge it is */
    for (size_t step = 0; step < t->count && s != last; step++) {
        last = s;
        for (int n = 0; n < 3 && s == last; n++) {
            int k = (n + (int)step) % 3; /* not always the same first: no walk in circles */
            const int32_t *corner = t->corners[last];
            if (t->beyond[last][k] != NONE &&
                twice_area_of(t, corner[k], corner[next_corner(k)], point) < 0)
                s = t->beyond[last][k];
        }
    }
    t->same[point] = point;
    for (int k = 0; k < 3; k++) {
        int32_t corner = t->corners[s][k];
        if (vec3_distance(t->points[corner], r) <= together) {
            t->same[point] = corner;
            return;
        }
    }
    int on = NONE;
    for (int k = 0; k < 3; k++) {
        int32_t p = t->corners[s][k], q = t->corners[s][next_corner(k)];
        double length = vec3_distance(t->points[p], t->points[q]);
        if (twice_area_of(t, p, q, point) <= together * length && t->beyond[s][k] != NONE)
            on = k;
    }
    if (on == NONE)
        split_triangle(b, s, point);
    else
        split_edge(b, s, on, point);
    b->last = b->at[point];
    exchange_all(b, t->points, NULL, EXCHANGES * t->count);
}

/* ---- given edges ---- */

/* The triangle left of the edge from p to q, and which of its edges that is; NONE without one. */
static int32_t find_edge(const struct builder *b, int32_t p, int32_t q, int *k) {
    const struct triangulation *t = b->t;
    int32_t first = b->at[p], s = first;
    do {
        *k = place_among(t->corners[s], p);
        if (t->corners[s][next_corner(*k)] == q)
            return s;
        s = t->beyond[s][last_corner(*k)];
    } while (s != NONE && s != first);
    return NONE;
}

/* Where the way from p to q goes: `through` is a point on it, or the first edge crossed is that
 * opposite to p in the triangle returned, or NONE where it can not be told. */
static int32_t find_way(const struct builder *b, int32_t p, int32_t q, int32_t *through) {
    const struct triangulation *t = b->t;
    int32_t first = b->at[p], s = first;
    *through = NONE;
    do {
        int k = place_among(t->corners[s], p);
        int32_t right = t->corners[s][next_corner(k)], left = t->corners[s][last_corner(k)];
        struct vec3 way = vec3_sub(t->points[q], t->points[p]);
        struct vec3 to = vec3_sub(t->points[right], t->points[p]);
        double by = twice_area_of(t, p, q, right), other = twice_area_of(t, p, q, left);
        if (fabs(by) <= together * vec3_norm(way) && vec3_dot(way, to) > 0) {
            *through = right;
            return s;
        }
        if (by < 0 && other > 0 && twice_area_of(t, p, right, left) > 0 &&
            fabs(other) > together * vec3_norm(way))
            return s;
        s = t->beyond[s][last_corner(k)];
    } while (s != NONE && s != first);
    return NONE;
}

struct pair {
    int32_t p, q;
};

/* Exchanges the diagonals that cross the way from p to q. False where it crosses a given edge. */
static bool clear_way(struct builder *b, int32_t p, int32_t q, struct pair *crossed, size_t count,
                      size_t room) {
    struct triangulation *t = b->t;
    size_t head = 0;
    for (size_t left = EXCHANGES * (count + 4); count > 0 && left > 0; left--) {
        struct pair pair = crossed[head];
        int k;
        int32_t s = find_edge(b, pair.p, pair.q, &k);
        head = (head + 1) % room;
        count--;
        if (s == NONE)
            continue;
        const struct diamond d = diamond_at(t, s, k);
        if (!is_convex_pair(t, &d)) {
            crossed[(head + count++) % room] = pair;
            continue;
        }
        exchange_diagonal(b, s, k);
        bool ends = d.r == p || d.r == q || d.o == p || d.o == q;
        double by = twice_area_of(t, p, q, d.r), other = twice_area_of(t, p, q, d.o);
        if (!ends && (by > 0) != (other > 0))
            crossed[(head + count++) % room] = (struct pair){d.r, d.o};
    }
    return count == 0;
}

/* Makes the edge from p to q. False where another given edge is in its way. */
static bool make_edge(struct builder *b, int32_t p, int32_t q, struct pair *crossed, size_t room) {
    struct triangulation *t = b->t;
    for (size_t part = 0; p != q && part < t->point_count; part++) {
        int k;
        int32_t to = q, through, s = find_edge(b, p, q, &k);
        if (s == NONE) {
            size_t count = 0;
            s = find_way(b, p, q, &through);
            if (s == NONE)
                return false;
            for (k = next_corner(place_among(t->corners[s], p)); through == NONE;) {
                int32_t right = t->corners[s][k], left = t->corners[s][next_corner(k)];
                int32_t o = t->beyond[s][k];
                if (t->fixed[s][k] || count == room || o == NONE)
                    return false;
                crossed[count++] = (struct pair){right, left};
                int back = place_among(t->beyond[o], s);
                int32_t far = t->corners[o][last_corner(back)];
                double by = twice_area_of(t, p, q, far);
                if (far == q || fabs(by) <= together * vec3_distance(t->points[p], t->points[q]))
                    through = far;
                /* o has left -> right as edge `back`: beyond it right -> far, far -> left */
                s = o;
                k = by > 0 ? next_corner(back) : last_corner(back);
            }
            to = through;
            if (count > 0 && !clear_way(b, p, to, crossed, count, room))
                return false;
            s = find_edge(b, p, to, &k);
            if (s == NONE)
                return false;
        }
        int32_t o = t->beyond[s][k];
        t->fixed[s][k] = true;
        if (o != NONE)
            t->fixed[o][place_among(t->beyond[o], s)] = true;
        p = to;
    }
    return true;
}

/* ---- the whole ---- */

/* Room for `count` points, and one triangle far round the unit square. */
static bool begin_triangulation(struct builder *b, size_t count, struct arena *arena) {
    static const double far[OWN][2] = {{-20, -20}, {40, -20}, {0, 40}};
    struct triangulation *t = b->t;
    size_t all = count + OWN, room = 2 * all + 1;
    int32_t first = (int32_t)count;
    t->point_count = count;
    t->points = arena_take(arena, all, sizeof *t->points);
    t->same = arena_take(arena, all, sizeof *t->same);
    t->corners = arena_take(arena, room, sizeof *t->corners);
    t->beyond = arena_take(arena, room, sizeof *t->beyond);
    t->fixed = arena_alloc(arena, room, sizeof *t->fixed);
    t->region = arena_take(arena, room, sizeof *t->region);
    b->at = arena_take(arena, all, sizeof *b->at);
    b->room = 4 * room;
    b->stack = arena_take(arena, b->room, sizeof *b->stack);
    if (!t->points || !t->same || !t->corners || !t->beyond || !t->fixed || !t->region || !b->at ||
        !b->stack)
        return false;
    for (int k = 0; k < OWN; k++) {
        t->points[first + k] = vec3_make(far[k][0], far[k][1], 0);
        t->same[first + k] = first + k;
        t->beyond[0][k] = NONE;
    }
    t->count = 1;
    set_triangle(b, 0, (const int32_t[]){first, first + 1, first + 2});
    return true;
}

enum status triangulate(const double (*points)[2], size_t count, const int32_t (*edges)[2],
                        size_t edge_count, struct arena *arena,
                        struct triangulation **triangulation) {
    struct builder b = {.t = arena_alloc(arena, 1, sizeof *b.t)};
    struct triangulation *t = b.t;
    *triangulation = t;
    if (!t || !begin_triangulation(&b, count, arena))
        return STATUS_OUT_OF_MEMORY;
    struct pair *crossed = arena_take(arena, 2 * count + 8, sizeof *crossed);
    if (!crossed)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++) {
        if (!(points[k][0] >= 0 && points[k][0] <= 1 && points[k][1] >= 0 && points[k][1] <= 1))
            return STATUS_INVALID;
        t->points[k] = vec3_make(points[k][0], points[k][1], 0);
    }
    for (size_t k = 0; k < count; k++)
        insert_point(&b, (int32_t)k);
    for (size_t k = 0; k < edge_count; k++)
        t->missed +=
            !make_edge(&b, t->same[edges[k][0]], t->same[edges[k][1]], crossed, 2 * count + 8);
    /* regions: what hangs together without a given edge between */
    for (size_t k = 0; k < t->count; k++)
        t->region[k] = NONE;
    for (size_t k = 0; k < t->count; k++) {
        if (t->region[k] != NONE)
            continue;
        t->region[k] = (int32_t)t->region_count;
        for (push_triangle(&b, (int32_t)k); b.depth > 0;) {
            int32_t s = b.stack[--b.depth];
            for (int e = 0; e < 3; e++) {
                int32_t o = t->beyond[s][e];
                if (o == NONE || t->fixed[s][e] || t->region[o] != NONE)
                    continue;
                t->region[o] = (int32_t)t->region_count;
                push_triangle(&b, o);
            }
        }
        t->region_count++;
    }
    return STATUS_OK;
}

enum status triangulation_improve(struct triangulation *t, const struct vec3 *at,
                                  const bool *chosen, struct arena *arena) {
    struct builder b = {.t = t, .room = 4 * t->count};
    b.at = arena_take(arena, t->point_count + OWN, sizeof *b.at);
    b.stack = arena_take(arena, b.room, sizeof *b.stack);
    if (!b.at || !b.stack)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = t->count; k > 0; k--)
        push_triangle(&b, (int32_t)(k - 1));
    exchange_all(&b, at, chosen, EXCHANGES * t->count);
    return STATUS_OK;
}
