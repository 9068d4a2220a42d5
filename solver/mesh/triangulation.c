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

/* Twice the area of the triangle a, b, c, positive counter-clockwise. */
static double twice_area(struct vec3 a, struct vec3 b, struct vec3 c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static double twice_area_of(const struct triangulation *t, int32_t a, int32_t b, int32_t c) {
    return twice_area(t->points[a], t->points[b], t->points[c]);
}

static int corner_of(const struct triangulation *t, int32_t triangle, int32_t point) {
    for (int k = 0; k < 3; k++)
        if (t->corners[triangle][k] == point)
            return k;
    return NONE;
}

/* The edge of `triangle` beyond which `other` lies. */
static int edge_to(const struct triangulation *t, int32_t triangle, int32_t other) {
    for (int k = 0; k < 3; k++)
        if (t->beyond[triangle][k] == other)
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
    int back = edge_to(t, other, was);
    if (back != NONE)
        t->beyond[other][back] = triangle;
}

/* ---- exchanging diagonals ---- */

/* At edge k of triangle s, from p to q: (p, far, r), (far, q, r) for (p, q, r), (q, p, far). */
static void exchange_diagonal(struct builder *b, int32_t s, int k) {
    struct triangulation *t = b->t;
    int32_t o = t->beyond[s][k];
    int back = edge_to(t, o, s);
    int32_t p = t->corners[s][k], q = t->corners[s][next_corner(k)],
            r = t->corners[s][last_corner(k)];
    int32_t far = t->corners[o][last_corner(back)];
    int32_t qr = t->beyond[s][next_corner(k)], rp = t->beyond[s][last_corner(k)];
    int32_t po = t->beyond[o][next_corner(back)], oq = t->beyond[o][last_corner(back)];
    bool f_qr = t->fixed[s][next_corner(k)], f_rp = t->fixed[s][last_corner(k)];
    bool f_po = t->fixed[o][next_corner(back)], f_oq = t->fixed[o][last_corner(back)];
    set_triangle(b, s, (const int32_t[]){p, far, r});
    set_triangle(b, o, (const int32_t[]){far, q, r});
    t->beyond[s][1] = o;
    t->beyond[o][2] = s;
    t->fixed[s][1] = t->fixed[o][2] = false;
    t->beyond[s][2] = rp;
    t->fixed[s][2] = f_rp;
    t->beyond[o][0] = oq;
    t->fixed[o][0] = f_oq;
    link_beyond(t, s, 0, po, o, f_po);
    link_beyond(t, o, 1, qr, s, f_qr);
}

/* Whether the two triangles at an edge make a convex quadrilateral in the plane. */
static bool is_convex_pair(const struct triangulation *t, int32_t s, int k) {
    int32_t o = t->beyond[s][k];
    int back = edge_to(t, o, s);
    int32_t p = t->corners[s][k], q = t->corners[s][next_corner(k)],
            r = t->corners[s][last_corner(k)];
    int32_t far = t->corners[o][last_corner(back)];
    struct vec3 diagonal = vec3_sub(t->points[far], t->points[r]);
    double least = together * vec3_norm(diagonal);
    return twice_area_of(t, p, far, r) > least && twice_area_of(t, far, q, r) > least;
}

/* Whether the angles at r and o opposite to the edge p q add up to more than half a turn. */
static bool is_wide(struct vec3 p, struct vec3 q, struct vec3 r, struct vec3 o) {
    struct vec3 a = vec3_sub(p, r), b = vec3_sub(q, r), c = vec3_sub(p, o), d = vec3_sub(q, o);
    double cosine[2] = {vec3_dot(a, b), vec3_dot(c, d)};
    double sine[2] = {vec3_norm(vec3_cross(a, b)), vec3_norm(vec3_cross(c, d))};
    double scale = sqrt(vec3_norm2(a) * vec3_norm2(b) * vec3_norm2(c) * vec3_norm2(d));
    return sine[0] * cosine[1] + cosine[0] * sine[1] < -even_sine * scale;
}

static bool ought_to_go(const struct triangulation *t, const struct vec3 *at, int32_t s, int k) {
    int32_t o = t->beyond[s][k];
    if (o == NONE || t->fixed[s][k])
        return false;
    int32_t far = t->corners[o][last_corner(edge_to(t, o, s))];
    const int32_t *corner = t->corners[s];
    return is_wide(at[corner[k]], at[corner[next_corner(k)]], at[corner[last_corner(k)]],
                   at[far]) &&
           is_convex_pair(t, s, k);
}

static void push_triangle(struct builder *b, int32_t triangle) {
    if (b->depth < b->room)
        b->stack[b->depth++] = triangle;
}

/* Exchanges diagonals round the triangles of the stack. */
static void exchange_all(struct builder *b, const struct vec3 *at, const bool *chosen,
                         size_t most) {
    struct triangulation *t = b->t;
    while (b->depth > 0 && most > 0) {
        int32_t s = b->stack[--b->depth];
        for (int k = 0; k < 3; k++) {
            int32_t o = t->beyond[s][k];
            if ((chosen && !chosen[t->region[s]]) || !ought_to_go(t, at, s, k))
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

/* The triangle that a point is in, or on whose edge it is. */
static int32_t find_triangle(const struct builder *b, struct vec3 r) {
    const struct triangulation *t = b->t;
    int32_t s = b->last;
    for (size_t step = 0; step < t->count; step++) {
        int32_t to = NONE;
        for (int n = 0; n < 3 && to == NONE; n++) {
            int k = (n + (int)step) % 3; /* not always the same first: no walk in circles */
            const int32_t *corner = t->corners[s];
            if (twice_area(t->points[corner[k]], t->points[corner[next_corner(k)]], r) < 0)
                to = t->beyond[s][k];
        }
        if (to == NONE)
            return s;
        s = to;
    }
    return s;
}

/* Three triangles for one. */
static void split_triangle(struct builder *b, int32_t s, int32_t point) {
    struct triangulation *t = b->t;
    int32_t corner[3], beyond[3], part[3] = {s, (int32_t)t->count, (int32_t)t->count + 1};
    memcpy(corner, t->corners[s], sizeof corner);
    memcpy(beyond, t->beyond[s], sizeof beyond);
    t->count += 2;
    for (int k = 0; k < 3; k++)
        set_triangle(b, part[k], (const int32_t[]){corner[k], corner[next_corner(k)], point});
    for (int k = 0; k < 3; k++) {
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
    int32_t o = t->beyond[s][k], s2 = (int32_t)t->count, o2 = s2 + 1;
    int back = edge_to(t, o, s);
    int32_t p = t->corners[s][k], q = t->corners[s][next_corner(k)],
            r = t->corners[s][last_corner(k)];
    int32_t far = t->corners[o][last_corner(back)];
    int32_t qr = t->beyond[s][next_corner(k)], rp = t->beyond[s][last_corner(k)];
    int32_t po = t->beyond[o][next_corner(back)], oq = t->beyond[o][last_corner(back)];
    t->count += 2;
    set_triangle(b, s, (const int32_t[]){p, x, r});
    set_triangle(b, s2, (const int32_t[]){x, q, r});
    set_triangle(b, o, (const int32_t[]){q, x, far});
    set_triangle(b, o2, (const int32_t[]){x, p, far});
    const int32_t beyond[4][3] = {{o2, s2, rp}, {o, qr, s}, {s2, o2, oq}, {s, po, o}};
    const int32_t own[4] = {s, s2, o, o2}, was[4] = {s, s, o, o};
    for (int n = 0; n < 4; n++)
        for (int e = 0; e < 3; e++)
            t->beyond[own[n]][e] = beyond[n][e];
    link_beyond(t, s2, 1, qr, was[1], false);
    link_beyond(t, o2, 1, po, was[3], false);
    for (int n = 0; n < 4; n++)
        push_triangle(b, own[n]);
}

static void insert_point(struct builder *b, int32_t point) {
    struct triangulation *t = b->t;
    struct vec3 r = t->points[point];
    int32_t s = find_triangle(b, r);
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
        struct vec3 p = t->points[t->corners[s][k]], q = t->points[t->corners[s][next_corner(k)]];
        if (twice_area(p, q, r) <= together * vec3_distance(p, q) && t->beyond[s][k] != NONE)
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
        *k = corner_of(t, s, p);
        if (t->corners[s][next_corner(*k)] == q)
            return s;
        s = t->beyond[s][last_corner(*k)];
    } while (s != NONE && s != first);
    return NONE;
}

static void fix_edge(struct builder *b, int32_t s, int k) {
    struct triangulation *t = b->t;
    int32_t o = t->beyond[s][k];
    t->fixed[s][k] = true;
    if (o != NONE)
        t->fixed[o][edge_to(t, o, s)] = true;
}

/* Where the way from p to q goes: `through` is a point on it, or the first edge crossed is that
 * opposite to p in the triangle returned, or NONE where it can not be told. */
static int32_t find_way(const struct builder *b, int32_t p, int32_t q, int32_t *through) {
    const struct triangulation *t = b->t;
    int32_t first = b->at[p], s = first;
    *through = NONE;
    do {
        int k = corner_of(t, s, p);
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
        if (!is_convex_pair(t, s, k)) {
            crossed[(head + count++) % room] = pair;
            continue;
        }
        int32_t r = t->corners[s][last_corner(k)], o = t->beyond[s][k];
        int32_t far = t->corners[o][last_corner(edge_to(t, o, s))];
        exchange_diagonal(b, s, k);
        bool ends = r == p || r == q || far == p || far == q;
        double by = twice_area_of(t, p, q, r), other = twice_area_of(t, p, q, far);
        if (!ends && (by > 0) != (other > 0))
            crossed[(head + count++) % room] = (struct pair){r, far};
    }
    return count == 0;
}

/* Makes the edge from p to q. False where another given edge is in its way. */
static bool make_edge(struct builder *b, int32_t p, int32_t q, struct pair *crossed, size_t room) {
    struct triangulation *t = b->t;
    for (size_t part = 0; p != q && part < t->point_count; part++) {
        int k;
        int32_t s = find_edge(b, p, q, &k), through;
        if (s != NONE) {
            fix_edge(b, s, k);
            return true;
        }
        size_t count = 0;
        int32_t to = q;
        s = find_way(b, p, q, &through);
        if (s == NONE)
            return false;
        for (k = next_corner(corner_of(t, s, p)); through == NONE;) {
            if (t->fixed[s][k] || count == room)
                return false;
            int32_t right = t->corners[s][k], left = t->corners[s][next_corner(k)];
            crossed[count++] = (struct pair){right, left};
            int32_t o = t->beyond[s][k];
            if (o == NONE)
                return false;
            int back = edge_to(t, o, s);
            int32_t far = t->corners[o][last_corner(back)];
            double by = twice_area_of(t, p, q, far);
            double width = vec3_distance(t->points[p], t->points[q]);
            if (far == q || fabs(by) <= together * width) {
                to = far;
                break;
            }
            /* o has left -> right as edge `back`: beyond it right -> far, far -> left */
            s = o;
            k = by > 0 ? next_corner(back) : last_corner(back);
        }
        if (through != NONE)
            to = through;
        if (count > 0 && !clear_way(b, p, to, crossed, count, room))
            return false;
        s = find_edge(b, p, to, &k);
        if (s == NONE)
            return false;
        fix_edge(b, s, k);
        p = to;
    }
    return true;
}

/* ---- the whole ---- */

static void find_regions(struct builder *b) {
    struct triangulation *t = b->t;
    for (size_t k = 0; k < t->count; k++)
        t->region[k] = NONE;
    for (size_t k = 0; k < t->count; k++) {
        if (t->region[k] != NONE)
            continue;
        b->depth = 0;
        t->region[k] = (int32_t)t->region_count;
        for (push_triangle(b, (int32_t)k); b->depth > 0;) {
            int32_t s = b->stack[--b->depth];
            for (int e = 0; e < 3; e++) {
                int32_t o = t->beyond[s][e];
                if (o == NONE || t->fixed[s][e] || t->region[o] != NONE)
                    continue;
                t->region[o] = (int32_t)t->region_count;
                push_triangle(b, o);
            }
        }
        t->region_count++;
    }
}

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
    find_regions(&b);
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
