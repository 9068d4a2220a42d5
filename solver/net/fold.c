/* SPDX-License-Identifier: MIT */
#include "fold.h"

#include <math.h>

enum { NEIGHBOURS = 3, FIRST_BUCKETS = 1024, NONE = -1 };

/* The nearest corner of a cell is at most this many spacings from any place in it, and a sheet of
 * the surface that is further away than half a spacing is another one. */
static const double corner_reach = 0.8;
static const double sheet_gap = 0.5;

/* Places in the cells round a node are less than this many spacings away from it: two yarns' steps,
 * which are no longer than a spacing, and the gap to another sheet. */
static const double cells_reach = 2.1;

struct entry {
    struct vec3 r;
    int32_t i, j;
    int32_t next; /* in the same bucket, or NONE */
};

struct fold {
    struct net *net;
    double spacing[2], turn[2];
    double voxel; /* side of the cubes that space is hashed by */
    struct entry *entries;
    int32_t *buckets; /* the first entry of each, or NONE */
    size_t count, room, bucket_count;
};

static int64_t voxel_of(const struct fold *fold, double x) {
    return (int64_t)floor(x / fold->voxel);
}

static size_t bucket_of(const struct fold *fold, int64_t x, int64_t y, int64_t z) {
    uint64_t key = (uint64_t)x * UINT64_C(0x9E3779B97F4A7C15);
    key = (key ^ (uint64_t)y) * UINT64_C(0xC2B2AE3D27D4EB4F);
    key = (key ^ (uint64_t)z) * UINT64_C(0x165667B19E3779F9);
    return (size_t)(key >> 32) & (fold->bucket_count - 1);
}

static size_t bucket_at(const struct fold *fold, struct vec3 r) {
    return bucket_of(fold, voxel_of(fold, r.x), voxel_of(fold, r.y), voxel_of(fold, r.z));
}

/* Room for so many entries: half as many buckets, filled anew. */
static bool grow(struct fold *fold, size_t room) {
    struct entry *entries = arena_take(fold->net->arena, room, sizeof *entries);
    int32_t *buckets = arena_take(fold->net->arena, room / 2, sizeof *buckets);
    if (!entries || !buckets || room > INT32_MAX)
        return false;
    struct entry *old = fold->entries;
    fold->entries = entries;
    fold->buckets = buckets;
    fold->room = room;
    fold->bucket_count = room / 2;
    for (size_t k = 0; k < fold->bucket_count; k++)
        buckets[k] = NONE;
    for (size_t k = 0; k < fold->count; k++) {
        size_t bucket = bucket_at(fold, old[k].r);
        entries[k] = old[k];
        entries[k].next = buckets[bucket];
        buckets[bucket] = (int32_t)k;
    }
    return true;
}

struct fold *fold_make(struct net *net, size_t count, const double spacing[2],
                       const double turn[2]) {
    struct fold *fold = arena_alloc(net->arena, 1, sizeof *fold);
    if (!fold)
        return NULL;
    *fold =
        (struct fold){.net = net, .spacing = {spacing[0], spacing[1]}, .turn = {turn[0], turn[1]}};
    fold->voxel = 2 * fmax(spacing[0], spacing[1]);
    size_t room = FIRST_BUCKETS;
    while (room < count)
        room *= 2;
    return grow(fold, room) ? fold : NULL;
}

void fold_pass_cut(struct fold *fold) {
    fold->turn[0] = fold->turn[1] = HUGE_VAL;
}

enum status fold_add(struct fold *fold, int32_t i, int32_t j, struct vec3 r) {
    if (fold->count == fold->room && !grow(fold, 2 * fold->room))
        return STATUS_OUT_OF_MEMORY;
    size_t bucket = bucket_at(fold, r);
    fold->entries[fold->count] = (struct entry){r, i, j, fold->buckets[bucket]};
    fold->buckets[bucket] = (int32_t)fold->count++;
    return STATUS_OK;
}

/* The yarn's step at (i, j) along (di, dj); zero where none is known. */
static struct vec3 yarn_step(struct net *net, int32_t i, int32_t j, int di, int dj) {
    const struct net_node *here = net_place(net, i, j), *ahead = net_place(net, i + di, j + dj);
    const struct net_node *back = net_place(net, i - di, j - dj);
    if (ahead && back)
        return vec3_scale(0.5, vec3_sub(ahead->r, back->r));
    return ahead  ? vec3_sub(ahead->r, here->r)
           : back ? vec3_sub(here->r, back->r)
                  : vec3_make(0, 0, 0);
}

/* Whether `point` lies in the cells round the node of the entry: |x|, |y| < 1 in its yarns' own
 * oblique coordinates, and on the same sheet. A yarn alone is taken as crossed at right angles. */
static bool within_cells(struct fold *fold, const struct entry *entry,
                         const struct station *station) {
    const struct net_node *node = net_find(fold->net, entry->i, entry->j);
    if (fabs(node->uv[0] - station->uv[0]) > fold->turn[0] ||
        fabs(node->uv[1] - station->uv[1]) > fold->turn[1])
        return false;
    struct vec3 normal = station->normal, offset = vec3_sub(station->jet.r, node->r);
    struct vec3 a = yarn_step(fold->net, entry->i, entry->j, 1, 0);
    struct vec3 b = yarn_step(fold->net, entry->i, entry->j, 0, 1);
    if (vec3_norm2(a) == 0)
        a = vec3_scale(fold->spacing[0], vec3_unit(vec3_cross(b, normal)));
    if (vec3_norm2(b) == 0)
        b = vec3_scale(fold->spacing[1], vec3_unit(vec3_cross(normal, a)));
    struct vec3 across = vec3_cross(a, b);
    double area2 = vec3_norm2(across), height = vec3_dot(offset, across);
    if (!(area2 > 0) || height * height > sheet_gap * sheet_gap * area2 * vec3_norm2(a))
        return false;
    if (!(vec3_dot(across, normal) > 0))
        return false;
    double x = vec3_dot(vec3_cross(offset, b), across) / area2;
    double y = vec3_dot(vec3_cross(a, offset), across) / area2;
    return fabs(x) < 1 && fabs(y) < 1;
}

/* A node (i, j) at `point`; without its station, whether there is a part of the net near it. */
struct visitor {
    struct fold *fold;
    int32_t i, j;
    struct vec3 point;
    const struct station *station;
};

static bool meets_in_bucket(const struct visitor *v, int32_t bucket) {
    struct fold *fold = v->fold;
    double reach = cells_reach * fmax(fold->spacing[0], fold->spacing[1]), reach2 = reach * reach;
    for (int32_t at = bucket; at != NONE; at = fold->entries[at].next) {
        const struct entry *e = &fold->entries[at];
        bool neighbour = e->i - v->i <= NEIGHBOURS && v->i - e->i <= NEIGHBOURS &&
                         e->j - v->j <= NEIGHBOURS && v->j - e->j <= NEIGHBOURS;
        if (!neighbour && vec3_norm2(vec3_sub(e->r, v->point)) < reach2 &&
            (!v->station || within_cells(fold, e, v->station)))
            return true;
    }
    return false;
}

static bool meets(const struct visitor *v) {
    struct fold *fold = v->fold;
    struct vec3 point = v->point;
    double reach = corner_reach * fmax(fold->spacing[0], fold->spacing[1]);
    int64_t x1 = voxel_of(fold, point.x + reach), y1 = voxel_of(fold, point.y + reach);
    int64_t z1 = voxel_of(fold, point.z + reach);
    for (int64_t x = voxel_of(fold, point.x - reach); x <= x1; x++)
        for (int64_t y = voxel_of(fold, point.y - reach); y <= y1; y++)
            for (int64_t z = voxel_of(fold, point.z - reach); z <= z1; z++)
                if (meets_in_bucket(v, fold->buckets[bucket_of(fold, x, y, z)]))
                    return true;
    return false;
}

bool fold_is_near(struct fold *fold, int32_t i, int32_t j, struct vec3 r) {
    return meets(&(struct visitor){fold, i, j, r, NULL});
}

bool fold_meets(struct fold *fold, int32_t i, int32_t j, const struct station *station) {
    return meets(&(struct visitor){fold, i, j, station->jet.r, station});
}
