/* SPDX-License-Identifier: MIT */
#include "overlap_tiles.h"

#include "separation.h"

enum { NEIGHBOURS = 3, FRAMES = 256 };

/* The places on a side of a patch, and the patches on one of a tile. */
enum { PATCH_BITS = OVERLAP_PATCH_BITS, PATCH = 1 << PATCH_BITS, PATCHES = NET_TILE / PATCH };
_Static_assert((int)PATCH == (int)SEPARATION_SIDE, "patches are asked whether they lie apart");

/* A place is well inside a cell this share of its sides away from them; cells that are narrower, by
 * the sine of their angle, are not asked. */
static const double well_inside = 0.1, narrow = 0.2;

/* Places in the cells round a node are less than this many spacings away from it: two yarns' steps,
 * which are no longer than a spacing, and the gap to another sheet. */
static const double cells_reach = 2.1;

/* The side of the cubes that space is hashed by, in spacings: about what a patch, or a tile,
 * reaches over. */
static const double cube_side = 6, tile_cube_side = 20;

/* The frame of a patch, as long as the net does not change there; then of OVERLAP_NONE. */
struct framed {
    int32_t patch;
    struct separation_frame frame;
};

struct overlap {
    struct net *net;
    struct overlap_normals normals;
    double spacing[2], turn[2];
    const struct shell_slit *slit[2];
    const struct curtain *curtain;
    double reach;
    struct overlap_patches patches;
    struct framed *frames; /* FRAMES of the patches asked for theirs last; NULL: of none yet */
    int32_t next_frame;
};

struct overlap *overlap_make(struct net *net, size_t count, const double spacing[2],
                             const double turn[2], const struct shell_slit *const slit[2],
                             const struct curtain *curtain, struct overlap_normals normals) {
    struct overlap *overlap = arena_alloc(net->arena, 1, sizeof *overlap);
    if (!overlap)
        return NULL;
    double longest = fmax(spacing[0], spacing[1]);
    *overlap = (struct overlap){.net = net,
                                .normals = normals,
                                .spacing = {spacing[0], spacing[1]},
                                .turn = {turn[0], turn[1]},
                                .slit = {slit[0], slit[1]},
                                .curtain = curtain,
                                .reach = cells_reach * longest};
    return overlap_patches_make(&overlap->patches, net->arena, count, cube_side * longest) ? overlap
                                                                                           : NULL;
}

void overlap_pass_slits(struct overlap *overlap) {
    overlap->turn[0] = overlap->turn[1] = HUGE_VAL;
    overlap->slit[0] = overlap->slit[1] = NULL;
}

static const struct overlap_shape unknown_shape = {HUGE_VAL, 0};
/* Whether the frame of a patch is known. */
static bool has_frame(const struct overlap *overlap, int32_t number) {
    int32_t at = overlap->patches.patch[number].frame;
    return at != OVERLAP_NONE && overlap->frames[at].patch == number;
}

/* Frames are as the nodes of their patch and those beside them were: forgets those of the nodes
 * from (i, j) to (i_last, j_last). */
static void forget_frames(struct overlap *overlap, int32_t i, int32_t j, int32_t i_last,
                          int32_t j_last) {
    for (int32_t q = (j - 1) >> PATCH_BITS; overlap->frames && q <= (j_last + 1) >> PATCH_BITS; q++)
        for (int32_t p = (i - 1) >> PATCH_BITS; p <= (i_last + 1) >> PATCH_BITS; p++) {
            int32_t number = *overlap_patches_slot(&overlap->patches, p, q);
            if (number != OVERLAP_NONE && has_frame(overlap, number))
                overlap->frames[overlap->patches.patch[number].frame].patch = OVERLAP_NONE;
        }
}

void overlap_forget(struct overlap *overlap, int32_t i, int32_t j) {
    forget_frames(overlap, i, j, i, j);
}

enum status overlap_add(struct overlap *overlap, int32_t i, int32_t j, struct vec3 r) {
    overlap_forget(overlap, i, j);
    struct net_tile *tile = net_touch(overlap->net, i, j);
    struct overlap_box box = overlap_nothing;
    overlap_stretch_box(&box, r, overlap->reach);
    return tile ? overlap_patches_stretch(&overlap->patches, i >> PATCH_BITS, j >> PATCH_BITS, tile,
                                          &box, unknown_shape)
                : STATUS_OUT_OF_MEMORY;
}

/* The nodes inside of row y of a patch that begins at column x, as bits. */
static unsigned inside_row(const struct net_tile *tile, int x, int y) {
    return (unsigned)tile->bits[NET_BIT_INSIDE][y] >> x & ((1u << PATCH) - 1);
}

static void keep_most(double *most, double value) {
    *most = value > *most ? value : *most;
}

/* The shape of the patch whose first place is at (x, y) of a window. Edges go on to the places
 * round it: a and b along warp and weft. */
static struct overlap_shape find_shape(const struct net_window *w, int x, int y) {
    enum { ROUND = PATCH + 2 };
    struct overlap_shape shape = {0, 1};
    struct vec3 r[ROUND][ROUND]; /* [j][i]: the places of the patch and those round it */
    unsigned has[ROUND];         /* bits of which are there */
    for (int j = 0; j < ROUND; j++) {
        int row = y + j - 1;
        has[j] = (unsigned)(net_window_row(w, NET_BIT_PLACE, row) >> (NET_TILE + x - 1)) &
                 ((1u << ROUND) - 1);
        for (unsigned bits = has[j]; bits; bits &= bits - 1) {
            int i = __builtin_ctz(bits);
            r[j][i] = net_window_find(w, x + i - 1, row)->r;
        }
    }
    for (int j = 1; j <= PATCH; j++) {
        const unsigned below = has[j - 1], own = has[j], above = has[j + 1];
        const unsigned has_a = own & own >> 1, has_b = own & above;
        const struct vec3 *row = r[j];
        for (int i = 1; i <= PATCH; i++) {
            struct vec3 a = vec3_sub(row[i + 1], row[i]), b = vec3_sub(r[j + 1][i], row[i]);
            if ((has_a & has_a << 1) >> i & 1)
                keep_most(&shape.bend2, vec3_norm2(vec3_sub(a, vec3_sub(row[i], row[i - 1]))));
            if ((has_b & below) >> i & 1)
                keep_most(&shape.bend2, vec3_norm2(vec3_sub(b, vec3_sub(row[i], r[j - 1][i]))));
            if (!((has_a & has_b) >> i & 1))
                continue;
            struct vec3 across = vec3_sub(r[j + 1][i + 1], r[j + 1][i]);
            if ((above & above >> 1) >> i & 1)
                keep_most(&shape.bend2, vec3_norm2(vec3_sub(across, a)));
            double sine2 = vec3_norm2(vec3_cross(a, b)) / (vec3_norm2(a) * vec3_norm2(b));
            shape.sine2 = sine2 < shape.sine2 ? sine2 : shape.sine2;
        }
    }
    return shape;
}

enum status overlap_add_tile(struct overlap *overlap, const struct net_tile *tile, bool shaped) {
    enum status status = STATUS_OK;
    struct net_window window = net_window(overlap->net, tile->ti, tile->tj);
    int32_t i = tile->ti * NET_TILE, j = tile->tj * NET_TILE;
    forget_frames(overlap, i, j, i + NET_TILE - 1, j + NET_TILE - 1);
    for (int at = 0; at < PATCHES * PATCHES && status == STATUS_OK; at++) {
        int x = at % PATCHES * PATCH, y = at / PATCHES * PATCH;
        struct overlap_shape shape = shaped ? find_shape(&window, x, y) : unknown_shape;
        struct overlap_box box = overlap_nothing; /* of what its nodes reach */
        for (int row = y; row < y + PATCH; row++)
            for (unsigned bits = inside_row(tile, x, row); bits; bits &= bits - 1)
                overlap_stretch_box(&box, tile->node[row][x + __builtin_ctz(bits)].r,
                                    overlap->reach);
        if (box.low[0] <= box.high[0])
            status = overlap_patches_stretch(&overlap->patches, tile->ti * PATCHES + x / PATCH,
                                             tile->tj * PATCHES + y / PATCH, tile, &box, shape);
    }
    return status;
}

/* Patches this far from each other in the net are asked whether the net between them is even. */
enum { EVEN_MOST = 3 };

/* The middle of a cell is one and a half places away from that of the next but one, and may lie
 * near its edge. */
static const double least_of_all = 1.6;

/* What looks at the patches that come near the nodes of one in space, until there is nothing more
 * to be known. */
struct look {
    struct overlap *overlap;
    const struct overlap_patch *patch;
    bool all;                        /* of a net that may lack nodes, and of all neighbours in it */
    int32_t away;                    /* how far they are in the net, at the most; one more than
                                        EVEN_MOST stands for all that are further */
    struct separation_points points; /* of the patch */
};

/* Notes how far the other patch is in the net, in patches. */
static bool note_away(void *context, int32_t other) {
    struct look *look = context;
    const struct overlap_patch *p = look->patch, *q = &look->overlap->patches.patch[other];
    int32_t i = p->pi < q->pi ? q->pi - p->pi : p->pi - q->pi;
    int32_t j = p->pj < q->pj ? q->pj - p->pj : p->pj - q->pj;
    int32_t away = i > j ? i : j;
    look->away = away > look->away ? away : look->away;
    return away > EVEN_MOST;
}

/* The column and the row of a patch's first node in its tile. */
static int patch_column(const struct overlap_patch *patch) {
    return (patch->pi & (PATCHES - 1)) * PATCH;
}

static int patch_row(const struct overlap_patch *patch) {
    return (patch->pj & (PATCHES - 1)) * PATCH;
}

/* The frame of a patch, in the place of the one made longest ago; NULL without memory. */
static const struct separation_frame *separation_frame_of(struct overlap *overlap, int32_t number) {
    struct overlap_patch *patch = &overlap->patches.patch[number];
    if (has_frame(overlap, number))
        return &overlap->frames[patch->frame].frame;
    if (!overlap->frames) {
        overlap->frames = arena_take(overlap->net->arena, FRAMES, sizeof *overlap->frames);
        if (!overlap->frames)
            return NULL;
    }
    struct framed *framed = &overlap->frames[overlap->next_frame];
    struct net_window window = net_window(overlap->net, patch->tile->ti, patch->tile->tj);
    separation_frame(&window, patch_column(patch), patch_row(patch), &framed->frame);
    framed->patch = number;
    patch->frame = overlap->next_frame;
    overlap->next_frame = (overlap->next_frame + 1) % FRAMES;
    return &framed->frame;
}

static bool may_meet(void *context, int32_t other) {
    struct look *look = context;
    const struct separation_frame *frame = separation_frame_of(look->overlap, other);
    return !frame || !separation_holds(frame, &look->points, look->overlap->reach,
                                       look->all ? least_of_all : NEIGHBOURS + 1);
}

/* Whether nodes of a patch and of those at most so many away from it are in each other's cells only
 * if they are neighbours; with `all`, if all places there have nodes. Nodes that are m places apart
 * along both yarns are so on the tangent plane half way between them, too, in steps of the yarns
 * there, but for 2 (m^2 / 2) second differences by the sine between them, and cells of one of them
 * reach over a place but for 2 m: both together are to be less than m - 1. */
static bool is_evenly_bent(const struct overlap *overlap, const struct overlap_patch *patch,
                           int32_t away, bool all) {
    const unsigned row = (1u << PATCH) - 1;
    struct overlap_shape worst = {0, 1};
    for (int32_t q = patch->pj - away; q <= patch->pj + away; q++)
        for (int32_t p = patch->pi - away; p <= patch->pi + away; p++) {
            const struct overlap_patch *other = overlap_patches_find(&overlap->patches, p, q);
            if (!other && all)
                return false;
            if (!other)
                continue;
            worst.bend2 = fmax(worst.bend2, other->shape.bend2);
            worst.sine2 = fmin(worst.sine2, other->shape.sine2);
            const uint16_t *places = &other->tile->bits[NET_BIT_PLACE][patch_row(other)];
            for (int y = 0; y < PATCH && all; y++)
                if ((places[y] >> patch_column(other) & row) != row)
                    return false;
        }
    double d = fmin(overlap->spacing[0], overlap->spacing[1]), m = PATCH * (away + 1) - 1;
    double most = (m - 1) / (m * m + 2 * m) * d;
    return worst.bend2 < most * most * worst.sine2;
}

/* Those patches of a tile whose nodes may lie on another part of the net, as bits: not those whose
 * neighbours in space are near in the net, too, which is even there, or lie apart from them. `all`:
 * a net that lacks nodes is not taken to be even. */
static unsigned find_suspects(struct overlap *overlap, const struct net_tile *tile, bool all) {
    unsigned suspects = 0;
    for (int at = 0; at < PATCHES * PATCHES; at++) {
        const struct overlap_patch *patch =
            overlap_patches_find(&overlap->patches, tile->ti * PATCHES + at % PATCHES,
                                 tile->tj * PATCHES + at / PATCHES);
        if (!patch)
            continue;
        struct look look = {.overlap = overlap, .patch = patch, .all = all, .away = 1};
        (void)overlap_patches_meet(&overlap->patches, patch, overlap->reach, note_away, &look);
        if (look.away <= EVEN_MOST && is_evenly_bent(overlap, patch, look.away, all))
            continue;
        struct net_window window = net_window(overlap->net, tile->ti, tile->tj);
        separation_points(&window, patch_column(patch), patch_row(patch), &look.points);
        if (overlap_patches_meet(&overlap->patches, patch, overlap->reach, may_meet, &look))
            suspects |= 1u << at;
    }
    return suspects;
}

unsigned overlap_suspects(struct overlap *overlap, const struct net_tile *tile) {
    return find_suspects(overlap, tile, false);
}

unsigned overlap_layers(struct overlap *overlap, const struct net_tile *tile) {
    return find_suspects(overlap, tile, true);
}

enum overlap_tile *overlap_look(struct net *net, struct net_tile *const *tiles,
                                const double spacing[2]) {
    double longest = fmax(spacing[0], spacing[1]);
    return overlap_tiles(net, tiles, tile_cube_side * longest, cells_reach * longest, NEIGHBOURS);
}

/* A node of the net that another one may lie on: at column x and row y of a tile. */
struct target {
    const struct net_tile *tile;
    int x, y;
};

static const struct net_node *place_beside(struct net *net, const struct target *at, int dx,
                                           int dy) {
    int x = at->x + dx, y = at->y + dy;
    if (x < 0 || y < 0 || x >= NET_TILE || y >= NET_TILE)
        return net_place(net, at->tile->ti * NET_TILE + x, at->tile->tj * NET_TILE + y);
    return at->tile->bits[NET_BIT_PLACE][y] >> x & 1 ? &at->tile->node[y][x] : NULL;
}

static struct vec3 yarn_step(struct net *net, const struct target *at, int dx, int dy) {
    return net_step(place_beside(net, at, -dx, -dy), &at->tile->node[at->y][at->x],
                    place_beside(net, at, dx, dy));
}

/* Whether a cut parts a place from a node. */
static bool is_beyond_cut(const struct overlap *overlap, const struct net_node *node,
                          struct vec3 r) {
    return overlap->curtain && curtain_parts(overlap->curtain, node->r, r, NULL);
}

/* Whether `point` lies in the cells round a node: |x|, |y| < 1 in its yarns' own
 * oblique coordinates, and on the same sheet. A yarn alone is taken as crossed at right angles, and
 * has its side of a thin part from the surface. */
static bool within_cells(struct overlap *overlap, const struct target *at,
                         const struct surface_point *surface_point) {
    const struct net_node *node = &at->tile->node[at->y][at->x];
    if (fabs(node->uv[0] - surface_point->uv[0]) > overlap->turn[0] ||
        fabs(node->uv[1] - surface_point->uv[1]) > overlap->turn[1])
        return false;
    struct vec3 normal = surface_point->normal, offset = vec3_sub(surface_point->jet.r, node->r);
    struct vec3 a = yarn_step(overlap->net, at, 1, 0);
    struct vec3 b = yarn_step(overlap->net, at, 0, 1);
    bool alone = vec3_norm2(a) == 0 || vec3_norm2(b) == 0;
    struct vec3 own = alone ? overlap->normals.at(overlap->normals.context, node) : normal;
    if (!(vec3_dot(own, normal) > 0))
        return false;
    if (vec3_norm2(a) == 0)
        a = vec3_scale(overlap->spacing[0], vec3_unit(vec3_cross(b, own)));
    if (vec3_norm2(b) == 0)
        b = vec3_scale(overlap->spacing[1], vec3_unit(vec3_cross(own, a)));
    struct vec3 across = vec3_cross(a, b);
    double area2 = vec3_norm2(across), height = vec3_dot(offset, across);
    if (!(area2 > 0) ||
        height * height > overlap_sheet_gap * overlap_sheet_gap * area2 * vec3_norm2(a))
        return false;
    if (!(vec3_dot(across, normal) > 0))
        return false;
    double x = vec3_dot(vec3_cross(offset, b), across) / area2;
    double y = vec3_dot(vec3_cross(a, offset), across) / area2;
    bool within = fabs(x) < 1 && fabs(y) < 1 && !is_beyond_cut(overlap, node, surface_point->jet.r);
    if (!within || !overlap->slit[0])
        return within;
    const struct shell_slit_point to = {surface_point->jet.r, normal};
    const struct shell_slit_point from = {node->r,
                                          overlap->normals.at(overlap->normals.context, node)};
    return !shell_slits_part(overlap->slit, &from, &to);
}

/* A node (i, j) at `point`; without its point, whether there is a part of the net near it; with
 * `cell`, whether one of the cells there, which it gets, has the point inside. */
struct visitor {
    struct overlap *overlap;
    int32_t i, j;
    struct vec3 point;
    const struct surface_point *surface_point;
    bool before; /* on what comes before it alone */
    bool framed; /* the net hardly changes between one node that is asked for and the next */
    int32_t *cell;
    struct vec3 normal; /* of the surface, for a cell */
    int32_t own;        /* cells (i, j) to so many places below it are not asked */
    bool turned;        /* its own cell is turned over, or not whole: neighbours are asked, too */
};

/* Whether the point lies well inside the cell (i, j), unless that is one of the visitor's own: in
 * the coordinates of its mean yarns about its middle, on the same sheet. */
static bool lies_on_cell(const struct visitor *v, const struct target *at, int32_t i, int32_t j) {
    if (v->i - i >= 0 && v->i - i <= v->own && v->j - j >= 0 && v->j - j <= v->own)
        return false;
    const struct net_node *node[4];
    for (int k = 0; k < 4; k++) {
        node[k] = place_beside(v->overlap->net, at, k & 1, k / 2);
        if (!node[k] || node[k]->state != NET_INSIDE ||
            is_beyond_cut(v->overlap, node[k], v->point))
            return false;
    }
    struct vec3 up = vec3_sub(node[3]->r, node[0]->r), down = vec3_sub(node[1]->r, node[2]->r);
    struct vec3 a = vec3_scale(0.5, vec3_add(up, down)), b = vec3_scale(0.5, vec3_sub(up, down));
    struct vec3 sum = vec3_add(vec3_add(node[0]->r, node[3]->r), vec3_add(node[1]->r, node[2]->r));
    struct vec3 offset = vec3_axpy(-0.25, sum, v->point), across = vec3_cross(a, b);
    double area2 = vec3_norm2(across), height = vec3_dot(offset, across);
    if (!(area2 > narrow * narrow * vec3_norm2(a) * vec3_norm2(b)) ||
        height * height > overlap_sheet_gap * overlap_sheet_gap * area2 * vec3_norm2(a) / 4 ||
        !(vec3_dot(across, v->normal) > sqrt(area2) / 2))
        return false;
    double x = vec3_dot(vec3_cross(offset, b), across) / area2;
    double y = vec3_dot(vec3_cross(a, offset), across) / area2;
    if (!(fabs(x) < 0.5 - well_inside && fabs(y) < 0.5 - well_inside))
        return false;
    v->cell[0] = i;
    v->cell[1] = j;
    return true;
}

/* Whether a node of the visitor's own quadrant comes after it. */
static bool comes_after(const struct visitor *v, int32_t i, int32_t j) {
    int32_t si = v->i < 0 ? -1 : 1, sj = v->j < 0 ? -1 : 1;
    return i * si > 0 && j * sj > 0 && (j * sj > v->j * sj || (j == v->j && i * si > v->i * si));
}

/* Whether the visitor meets one of the nodes or cells near its point. */
static bool meets_any_patch(const struct visitor *v) {
    const unsigned all = (2u << 2 * NEIGHBOURS) - 1;
    const struct overlap_patches *patches = &v->overlap->patches;
    double reach2 = v->overlap->reach * v->overlap->reach;
    struct vec3 r = v->point;
    int64_t cube[3] = {(int64_t)floor(r.x / patches->cube), (int64_t)floor(r.y / patches->cube),
                       (int64_t)floor(r.z / patches->cube)};
    int32_t site = overlap_patches_first(patches, cube);
    for (; site != OVERLAP_NONE; site = patches->sites[site].next) {
        int32_t number = patches->sites[site].patch;
        const struct overlap_patch *patch = &patches->patch[number];
        const double *low = patch->box.low, *high = patch->box.high;
        if (!(r.x >= low[0] && r.x <= high[0] && r.y >= low[1] && r.y <= high[1] && r.z >= low[2] &&
              r.z <= high[2]))
            continue;
        const struct separation_frame *frame =
            v->framed ? separation_frame_of(v->overlap, number) : NULL;
        if (frame && separation_holds_at(frame, r))
            continue;
        /* the columns, as bits, that are no further than NEIGHBOURS from the visitor's */
        int32_t i = patch->pi * PATCH, j = patch->pj * PATCH, di = v->i - i;
        bool far = v->turned || di < -NEIGHBOURS || di >= PATCH + NEIGHBOURS;
        unsigned near = far               ? 0
                        : di > NEIGHBOURS ? all << (di - NEIGHBOURS)
                                          : all >> (NEIGHBOURS - di);
        struct target at = {patch->tile, i & (NET_TILE - 1), j & (NET_TILE - 1)};
        for (const struct target first = at; at.y < first.y + PATCH; at.y++, j++) {
            bool beside = j - v->j <= NEIGHBOURS && v->j - j <= NEIGHBOURS;
            unsigned bits = inside_row(patch->tile, first.x, at.y) & ~(beside ? near : 0);
            for (; bits; bits &= bits - 1) {
                at.x = first.x + __builtin_ctz(bits);
                if (vec3_norm2(vec3_sub(patch->tile->node[at.y][at.x].r, r)) >= reach2)
                    continue;
                if (v->cell ? lies_on_cell(v, &at, i + at.x - first.x, j)
                            : !(v->before && comes_after(v, i + at.x - first.x, j)) &&
                                  (!v->surface_point ||
                                   within_cells(v->overlap, &at, v->surface_point)))
                    return true;
            }
        }
    }
    return false;
}

bool overlap_is_near(struct overlap *overlap, int32_t i, int32_t j, struct vec3 r) {
    return meets_any_patch(&(struct visitor){.overlap = overlap, .i = i, .j = j, .point = r});
}

bool overlap_meets(struct overlap *overlap, int32_t i, int32_t j,
                   const struct surface_point *surface_point) {
    return meets_any_patch(&(struct visitor){.overlap = overlap,
                                             .i = i,
                                             .j = j,
                                             .point = surface_point->jet.r,
                                             .surface_point = surface_point});
}

bool overlap_meets_before(struct overlap *overlap, int32_t i, int32_t j,
                          const struct surface_point *surface_point) {
    return meets_any_patch(&(struct visitor){.overlap = overlap,
                                             .i = i,
                                             .j = j,
                                             .point = surface_point->jet.r,
                                             .surface_point = surface_point,
                                             .before = true,
                                             .framed = true});
}

/* Whether the cell from (i, j) on is whole, with the middle of its nodes, and faces the way
 * `normal` does: next to such a cell another one only lies on it if one between them is turned
 * over. */
static bool cell_faces(struct net *net, int32_t i, int32_t j, struct vec3 normal, bool *whole,
                       struct vec3 *middle) {
    const struct net_node *node[4];
    struct vec3 r[4];
    for (int k = 0; k < 4; k++) {
        node[k] = net_find(net, i + (k & 1), j + k / 2);
        *whole = node[k] && node[k]->state == NET_INSIDE;
        if (!*whole)
            return false;
        r[k] = node[k]->r;
    }
    *whole = !net_is_parted(node[0], node[1], 0) && !net_is_parted(node[2], node[3], 0) &&
             !net_is_parted(node[0], node[2], 1) && !net_is_parted(node[1], node[3], 1);
    if (!*whole)
        return false;
    struct vec3 up = vec3_sub(r[3], r[0]), across = vec3_sub(r[2], r[1]);
    *middle = vec3_scale(0.25, vec3_add(vec3_add(r[0], r[3]), vec3_add(r[1], r[2])));
    return vec3_dot(vec3_cross(up, across), normal) > 0;
}

bool overlap_turns_over(struct net *net, const struct net_tile *tile, const double spacing[2],
                        struct overlap_normals normals) {
    const unsigned all = (2u << PATCH) - 1;
    double most = fmin(spacing[0], spacing[1]) / (2 * PATCH);
    struct net_window window = net_window(net, tile->ti, tile->tj);
    for (int at = 0; at < PATCHES * PATCHES; at++) {
        int x = at % PATCHES * PATCH, y = at / PATCHES * PATCH;
        /* Cells that are whole, and turn so little from one to the next, all face one way. */
        bool alike = true;
        for (int row = y; row <= y + PATCH; row++)
            alike =
                alike && !(~net_window_row(&window, NET_BIT_INSIDE, row) >> (NET_TILE + x) & all);
        struct overlap_shape shape = alike ? find_shape(&window, x, y) : unknown_shape;
        alike = shape.bend2 < most * most * shape.sine2;
        for (int k = 0; k < (alike ? 1 : PATCH * PATCH); k++) {
            int column = x + k % PATCH, row = y + k / PATCH;
            const struct net_node *node = &tile->node[row][column];
            if (node->state != NET_INSIDE)
                continue;
            struct vec3 middle, normal = normals.at(normals.context, node);
            bool whole;
            if (vec3_norm2(normal) > 0 &&
                !cell_faces(net, tile->ti * NET_TILE + column, tile->tj * NET_TILE + row, normal,
                            &whole, &middle) &&
                whole)
                return true;
        }
    }
    return false;
}

bool overlap_lies_on(struct overlap *overlap, int32_t i, int32_t j, struct vec3 normal,
                     int32_t cell[2]) {
    struct visitor v = {.overlap = overlap,
                        .i = i,
                        .j = j,
                        .normal = normal,
                        .cell = cell,
                        .own = 1,
                        .framed = true};
    struct vec3 middle;
    bool whole;
    v.turned = !cell_faces(overlap->net, i, j, normal, &whole, &middle);
    v.point = net_find(overlap->net, i, j)->r;
    if (meets_any_patch(&v))
        return true;
    v.point = middle;
    v.own = 0;
    return whole && meets_any_patch(&v);
}
