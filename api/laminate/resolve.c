/* SPDX-License-Identifier: MIT */
#include "api/request/digest.h"
#include "api/request/prepared_part.h"
#include "division.h"
#include "laid_courses.h"
#include "part_foot.h"
#include "solver/laid_line.h"
#include "solver/mesh/mesh.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* How finely a loop in the parameters is followed in space, as a share of the domain. */
static const double step_share = 1.0 / 256;

void laminate_fault_of_ply(const struct laminate *laminate, size_t k, const struct api_problem *own,
                           struct api_problem *problem) {
    for (size_t n = 0; n < own->count; n++) {
        const struct api_problem_error *error = &own->error[n];
        const struct laminate_ply *ply = &laminate->plies[k];
        bool common = strncmp(error->pointer, "/surface", 8) == 0 ||
                      strncmp(error->pointer, "/rosette", 8) == 0;
        bool moved = strcmp(error->pointer, "/offset") == 0;
        bool course = ply->pieces && ply->pieces->courses;
        bool edge = course && strncmp(error->pointer, "/generators", 11) == 0;
        char pointer[API_POINTER_MAX], piece[32] = "", title[LAMINATE_TITLE_SIZE];
        laminate_title(ply, title);
        if (ply->pieces && !course)
            (void)snprintf(piece, sizeof piece, "/pieces/%zu", ply->piece);
        (void)snprintf(pointer, sizeof pointer, "/plies/%zu%s%.80s", ply->number, piece,
                       moved  ? ""
                       : edge ? "/courses"
                              : error->pointer);
        if (common)
            (void)snprintf(pointer, sizeof pointer, "%s", error->pointer);
        if (own->id == API_INVALID_REQUEST)
            api_problem_add(problem, pointer, "ply %zu (\"%s\"): %s", ply->number + 1, title,
                            error->detail);
        else
            api_problem_set_at(problem, own->id, pointer, "ply %zu (\"%s\"): %s", ply->number + 1,
                               title, error->detail);
    }
}

/* ---- the surface that boundaries are on, made when first asked for ---- */

struct boundary_surface {
    struct laminate *laminate;
    const struct api_limits *limits;
    struct arena *arena;
    struct api_problem *problem;
    bool made;
    struct prepared_part shape;
    const struct mesh *mesh; /* of it, for splits; NULL: not made */
    double mesh_size;
    size_t courses;      /* so many plies before have them, */
    struct joints below; /* the last one's joints */
};

/* Whether a net fits is another question, asked for each ply. */
enum api_problem_id laminate_part(const struct laminate *laminate, const struct api_limits *limits,
                                  struct arena *arena, struct prepared_part *shape,
                                  struct api_problem *problem) {
    struct api_request request = laminate->plies[0].drape;
    request.offset = 0;
    request.settings.has_extent[0] = request.settings.has_extent[1] = true;
    request.settings.extent[0][0] = request.settings.extent[0][1] = 0;
    request.settings.extent[1][0] = request.settings.extent[1][1] = 0;
    request.settings.start_kind = DRAPE_START_CENTROID;
    return prepared_part_make(&request, limits, arena, shape, problem);
}

static enum api_problem_id make_part(struct boundary_surface *on) {
    on->made = on->made || laminate_part(on->laminate, on->limits, on->arena, &on->shape,
                                         on->problem) == API_OK;
    return on->problem->id;
}

/* ---- loops in space ---- */

/* A loop of the surface's parameters as points in space, its edges cut finely. */
static bool follow_on_surface(const struct surface *surface, const double (*uv)[2], size_t count,
                              struct arena *arena, struct laminate_loop *loop) {
    double lower[2], upper[2];
    struct surface_cursor cursor = {0, 0};
    size_t total = 0, *pieces = arena_alloc(arena, count, sizeof *pieces);
    if (!pieces)
        return false;
    surface_domain(surface, lower, upper);
    for (size_t k = 0; k < count; k++) {
        const double *a = uv[k], *b = uv[(k + 1) % count];
        double share = fmax(fabs(b[0] - a[0]) / (upper[0] - lower[0]),
                            fabs(b[1] - a[1]) / (upper[1] - lower[1]));
        pieces[k] = 1 + (size_t)fmin(share / step_share, 1e4);
        total += pieces[k];
    }
    struct vec3 *points = arena_alloc(arena, total, sizeof *points);
    for (size_t k = 0; points && k < count; k++)
        for (size_t n = 0; n < pieces[k]; n++) {
            const double *a = uv[k], *b = uv[(k + 1) % count];
            double share = (double)n / (double)pieces[k], at[2];
            struct surface_jet jet;
            for (int x = 0; x < 2; x++)
                at[x] = fmin(fmax(a[x] + share * (b[x] - a[x]), lower[x]), upper[x]);
            surface_evaluate(surface, &cursor, at[0], at[1], &jet);
            points[loop->count++] = jet.r;
        }
    loop->points = points;
    return points != NULL;
}

/* The loops of trims in space; where all of them cut away, with the domain's own edge about them.
 */
static enum api_problem_id loops_of_trims(struct boundary_surface *on, struct laminate_ply *ply,
                                          struct trim *trim) {
    struct laminate_boundary *boundary = &ply->boundary;
    struct laminate_loop *loops = arena_alloc(on->arena, boundary->trim_count + 1, sizeof *loops);
    double low[2], high[2];
    bool keeps = false, good = loops != NULL;
    for (size_t k = 0; k < boundary->trim_count; k++)
        keeps = keeps || boundary->trims[k].reversed;
    surface_domain(on->shape.part.surface, low, high);
    const double edge[4][2] = {
        {low[0], low[1]}, {high[0], low[1]}, {high[0], high[1]}, {low[0], high[1]}};
    boundary->count = 0;
    if (good && !keeps)
        good = follow_on_surface(on->shape.part.surface, edge, 4, on->arena,
                                 &loops[boundary->count++]);
    for (size_t k = 0; good && k < boundary->trim_count; k++) {
        const double(*points)[2];
        size_t count = trim_loop_points(trim, k, &points);
        /* Its last point is its first. */
        good = follow_on_surface(on->shape.part.surface, points, count > 1 ? count - 1 : count,
                                 on->arena, &loops[boundary->count++]);
    }
    boundary->loops = loops;
    boundary->trim_count = 0;
    return good ? API_OK : api_problem_no_memory(on->problem, "the laminate");
}

/* ---- starts ---- */

/* The centroid of what a loop spans, by its vector area. */
static struct vec3 centre_of(const struct laminate_loop *loop) {
    struct vec3 mean = {0, 0, 0}, area = {0, 0, 0}, moment = {0, 0, 0};
    double whole = 0;
    for (size_t k = 0; k < loop->count; k++)
        mean = vec3_axpy(1 / (double)loop->count, loop->points[k], mean);
    for (int pass = 0; pass < 2; pass++)
        for (size_t k = 0; k < loop->count; k++) {
            struct vec3 a = vec3_sub(loop->points[k], mean);
            struct vec3 b = vec3_sub(loop->points[(k + 1) % loop->count], mean);
            struct vec3 cross = vec3_cross(a, b);
            if (pass == 0) {
                area = vec3_add(area, cross);
                continue;
            }
            double part = vec3_dot(cross, area);
            whole += part;
            moment = vec3_axpy(part / 3, vec3_add(a, b), moment);
        }
    return whole > 0 ? vec3_axpy(1 / whole, moment, mean) : mean;
}

/* Lets the ply start at the place nearest to the point. */
static void start_near(const struct boundary_surface *on, struct vec3 point,
                       struct api_request *drape) {
    struct drape_settings *settings = &drape->settings;
    double distance;
    if (on->shape.part.mesh) {
        struct mesh_point place;
        if (!mesh_nearest(on->shape.part.mesh, point, MESH_ANY, &place, &distance))
            return;
        settings->start_kind = DRAPE_START_POINT;
        settings->start_point = place.r;
    } else if (on->shape.part.shell) {
        struct shell_point place;
        shell_nearest(on->shape.part.shell, point, SHELL_ANY, &place, &distance);
        settings->start_kind = DRAPE_START_UV;
        settings->start_face = on->shape.shell.numbers[place.face];
        drape->start_on_face = true;
        memcpy(settings->start_uv, place.uv, sizeof settings->start_uv);
    } else {
        double uv[2];
        surface_nearest(on->shape.part.surface, point, uv, &distance);
        if (on->shape.part.trim && !trim_contains(on->shape.part.trim, uv))
            return;
        settings->start_kind = DRAPE_START_UV;
        memcpy(settings->start_uv, uv, sizeof settings->start_uv);
    }
}

static enum api_problem_id resolve_ply(struct boundary_surface *on, size_t k) {
    struct laminate_ply *ply = &on->laminate->plies[k];
    struct laminate_boundary *boundary = &ply->boundary;
    bool starts = ply->drape.settings.start_kind == DRAPE_START_CENTROID;
    bool known = on->laminate->surface.kind != API_SURFACE_NAMED;
    if (boundary->trim_count == 0 && (boundary->count == 0 || !starts || !known))
        return API_OK;
    if (make_part(on) != API_OK)
        return on->problem->id;
    if (boundary->trim_count == 0) {
        start_near(on, centre_of(&boundary->loops[0]), &ply->drape);
        return API_OK;
    }
    char pointer[API_POINTER_MAX];
    struct trim *trim = NULL;
    (void)snprintf(pointer, sizeof pointer, "/plies/%zu/boundary/trims", k);
    if (!on->shape.part.surface)
        return api_problem_add(on->problem, pointer,
                               "need a part of one NURBS surface, in whose parameters they are: "
                               "give a polygon instead");
    enum status status =
        trim_make(on->shape.part.surface, boundary->trims, boundary->trim_count, on->arena, &trim);
    if (status == STATUS_OUT_OF_MEMORY)
        return api_problem_no_memory(on->problem, "the laminate");
    if (status != STATUS_OK)
        return api_problem_add(on->problem, pointer, "leave no area of the ply");
    if (starts) {
        ply->drape.settings.start_kind = DRAPE_START_UV;
        trim_middle(trim, ply->drape.settings.start_uv);
    }
    return loops_of_trims(on, ply, trim);
}

/* ---- pieces ---- */

/* The place of a start that is stated; false where it is not known. */
static bool start_place(const struct boundary_surface *on, const struct drape_settings *settings,
                        struct vec3 *place) {
    const struct prepared_part *shape = &on->shape;
    const struct surface *surface = shape->part.surface;
    struct surface_cursor cursor = {0, 0};
    struct surface_jet jet;
    *place = settings->start_point;
    if (settings->start_kind != DRAPE_START_UV)
        return settings->start_kind == DRAPE_START_POINT;
    for (size_t f = 0; shape->part.shell && f < shell_face_count(shape->part.shell); f++)
        if (shape->shell.numbers[f] == settings->start_face)
            surface = shell_surface(shape->part.shell, (int32_t)f);
    if (!surface)
        return false;
    surface_evaluate(surface, &cursor, settings->start_uv[0], settings->start_uv[1], &jet);
    *place = jet.r;
    return true;
}

static double away_from_part(const struct boundary_surface *on, struct vec3 place) {
    struct vec3 foot, normal;
    (void)part_foot(&on->shape.part, place, &foot, &normal); /* which has a foot at poles, too */
    return vec3_distance(place, foot);
}

/* Gives every region its piece: the request's, then others that are as the ply says. */
static enum api_problem_id assign_regions(struct boundary_surface *on, size_t k,
                                          const struct division *division,
                                          struct laminate_pieces *pieces) {
    struct laminate_piece *all = arena_alloc(on->arena, division->count, sizeof *all);
    bool taken[LAMINATE_PIECES_MAX] = {false};
    char pointer[API_POINTER_MAX];
    struct vec3 place;
    double reach =
        pieces->seam.over ? pieces->seam.overlap : fmax(pieces->seam.overlap, pieces->seam.gap) / 2;
    const double *spacing = pieces->ply.settings.spacing, widest = fmax(spacing[0], spacing[1]);
    size_t count = 0, stated = pieces->count;
    if (!all)
        return api_problem_no_memory(on->problem, "the laminate");
    for (; count < stated; count++) {
        struct laminate_piece *own = &all[count];
        const struct laminate_piece *from = &pieces->pieces[count];
        int32_t region = division_region_at(division, from->at);
        (void)snprintf(pointer, sizeof pointer, "/plies/%zu/pieces/%zu/at", k, count);
        if (!(away_from_part(on, from->at) <= widest))
            return api_problem_add(on->problem, pointer,
                                   "is further from the part than the spacing, %.6g: move it onto "
                                   "the part, into the region that the piece is to have",
                                   widest);
        if (region < 0 || taken[region] || count == division->count)
            return api_problem_add(on->problem, pointer,
                                   region < 0
                                       ? "is in no region of the part: move it away from its edge"
                                       : "is in the region of a piece before it: move it to the "
                                         "other side of a split, or leave one of them out");
        *own = *from;
        taken[region] = true;
        (void)snprintf(pointer, sizeof pointer, "/plies/%zu/pieces/%zu/start", k, count);
        if (start_place(on, &own->drape.settings, &place) &&
            division_region_at(division, place) != region)
            return api_problem_add(on->problem, pointer,
                                   "is not in the region of the piece's \"at\"");
        if (own->drape.settings.start_kind == DRAPE_START_CENTROID)
            start_near(on, division->regions[region].middle, &own->drape);
        (void)snprintf(pointer, sizeof pointer, "/plies/%zu/pieces/%zu", k, count);
        if (division->regions[region].depth <= reach)
            return api_problem_add(on->problem, pointer,
                                   "is narrower than its seam, no place of it being further than "
                                   "%.6g from a split: make the seam narrower, or move the split",
                                   reach);
    }
    (void)snprintf(pointer, sizeof pointer, "/plies/%zu/seam", k);
    for (size_t region = 0; region < division->count; region++) {
        const struct division_region *own = &division->regions[region];
        if (taken[region])
            continue;
        if (own->depth <= reach)
            return api_problem_add(on->problem, pointer,
                                   "is wider than the piece about (%.6g, %.6g, %.6g), of which no "
                                   "place is further than %.6g from a split: make the seam "
                                   "narrower, or move the split",
                                   own->middle.x, own->middle.y, own->middle.z, reach);
        char *name = arena_alloc(on->arena, LAMINATE_NAME_MAX + 1, 1);
        if (!name)
            return api_problem_no_memory(on->problem, "the laminate");
        size_t number = count + 1;
        for (bool again = true; again; number++) {
            again = false;
            (void)snprintf(name, LAMINATE_NAME_MAX + 1, "piece_%zu", number);
            for (size_t n = 0; n < count; n++)
                again = again || strcmp(all[n].name, name) == 0;
        }
        all[count] = (struct laminate_piece){.name = name, .at = own->middle, .drape = pieces->ply};
        start_near(on, own->middle, &all[count++].drape);
    }
    pieces->pieces = all;
    pieces->count = count;
    return API_OK;
}

static bool foot_of_part(const void *context, struct vec3 r, struct vec3 *place,
                         struct vec3 *normal) {
    return part_foot(context, r, place, normal);
}

/* Splits are within this share of a spacing of the part. */
static const double laid_within = 0.02;

/* The splits, along the part. */
static bool lay_splits(const struct boundary_surface *on, double reach,
                       struct laminate_pieces *pieces) {
    const struct laid_line_part part = {foot_of_part, &on->shape.part};
    struct drape_cut_line *laid = arena_alloc(on->arena, pieces->split_count, sizeof *laid);
    enum status status = laid ? STATUS_OK : STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < pieces->split_count && status == STATUS_OK; k++)
        status = laid_line_make(&part, &pieces->splits[k], reach, on->arena, &laid[k]);
    pieces->splits = laid;
    return status == STATUS_OK;
}

/* Divides the part into the regions of ply k, whose pieces then are those of all regions. */
static enum api_problem_id divide_ply(struct boundary_surface *on, size_t k,
                                      struct laminate_pieces *pieces) {
    const double *spacing = pieces->ply.settings.spacing;
    const struct drape_part *part = &on->shape.part;
    struct division division;
    enum division_fault fault;
    char pointer[API_POINTER_MAX];
    if (make_part(on) != API_OK)
        return on->problem->id;
    int32_t face = 0;
    while (part->shell &&
           shell_component(part->shell, face) != shell_largest_component(part->shell))
        face++;
    if (!on->mesh &&
        division_mesh(part, face, on->arena, &on->mesh, &on->mesh_size, on->problem) != API_OK)
        return on->problem->id;
    double reach = fmax(spacing[0], spacing[1]);
    if (!lay_splits(on, laid_within * reach, pieces) ||
        !division_make(part, on->mesh, on->mesh_size, reach, pieces, on->arena, &division, &fault))
        return api_problem_no_memory(on->problem, "the laminate");
    (void)snprintf(pointer, sizeof pointer, "/plies/%zu/splits/%zu", k, division.fault);
    if (fault == DIVISION_OFF_PART)
        return api_problem_add(on->problem, pointer,
                               "is further from the part than the spacing at (%.6g, %.6g, %.6g): "
                               "give its path more points, or move it onto the part",
                               division.at.x, division.at.y, division.at.z);
    if (fault == DIVISION_DIVIDES_NOTHING)
        return api_problem_add(on->problem, pointer,
                               "divides nothing, for the same piece is on both sides of it: let it "
                               "go from edge to edge of the part, or to another split, or end "
                               "where it begins; a line with an end inside belongs into \"cuts\"");
    if (fault == DIVISION_REPEATED)
        return api_problem_add(on->problem, pointer,
                               "lies on splits before it: no place of it is further from them than "
                               "%.4g, and narrower pieces are not found. Leave it out, or move it",
                               on->mesh_size);
    (void)snprintf(pointer, sizeof pointer, "/plies/%zu/splits", k);
    if (division.count > LAMINATE_PIECES_MAX)
        return api_problem_add(on->problem, pointer,
                               "divide the part into more than %d pieces, which are allowed",
                               LAMINATE_PIECES_MAX);
    return assign_regions(on, k, &division, pieces);
}

/* Gives every piece an entry of its own. */
static enum api_problem_id expand_plies(struct boundary_surface *on) {
    struct laminate *laminate = on->laminate;
    size_t count = 0;
    for (size_t k = 0; k < laminate->count; k++) {
        const struct laminate_pieces *stated = laminate->plies[k].pieces;
        struct laminate_pieces *own = arena_alloc(on->arena, 1, sizeof *own);
        if (!own)
            return api_problem_no_memory(on->problem, "the laminate");
        if (stated) {
            *own = *stated;
            laminate->plies[k].pieces = own;
            bool known = laminate->surface.kind != API_SURFACE_NAMED;
            if (known && !own->courses && divide_ply(on, k, own) != API_OK)
                return on->problem->id;
            if (known && own->courses &&
                laid_courses_make(laminate, k, on->courses++, on->limits, on->arena, &on->below,
                                  own, on->problem) != API_OK)
                return on->problem->id;
        }
        count += stated ? own->count : 1;
    }
    if (count == laminate->count)
        return API_OK;
    if (count > LAMINATE_PLIES_MAX)
        return api_problem_add(on->problem, "/plies", "have %zu pieces, and %d are allowed", count,
                               LAMINATE_PLIES_MAX);
    struct laminate_ply *all = arena_alloc(on->arena, count, sizeof *all), *next = all;
    if (!all)
        return api_problem_no_memory(on->problem, "the laminate");
    for (size_t k = 0; k < laminate->count; k++) {
        const struct laminate_ply *ply = &laminate->plies[k];
        const struct laminate_pieces *pieces = ply->pieces;
        for (size_t n = 0; n < (pieces ? pieces->count : 1); n++, next++) {
            *next = *ply;
            next->piece = n;
            if (!pieces)
                continue;
            double weight = pieces->pieces[n].drape.fabric.areal_weight;
            next->drape = pieces->pieces[n].drape;
            next->drape.offset = ply->drape.offset;
            if (weight > 0 && fabs(weight - pieces->ply.fabric.areal_weight) > 0)
                next->areal_weight = weight;
            double price = pieces->pieces[n].drape.fabric.price;
            if (price > 0 && fabs(price - pieces->ply.fabric.price) > 0)
                next->price = price;
        }
    }
    laminate->plies = all;
    laminate->count = count;
    return API_OK;
}

/* Of what was understood, its surface by id, and the solver's version. */
static bool find_revision(struct laminate *laminate, const char surface[API_ID_SIZE],
                          struct arena *arena) {
    struct laminate named = *laminate;
    struct arena_mark mark = arena_mark(arena);
    memcpy(named.surface.id, surface, sizeof named.surface.id);
    const char *document = laminate_normalise(&named, arena);
    struct api_text text = api_text_growing(arena);
    api_text_raw(&text, document ? document : "");
    api_text_raw(&text, DRAPE_VERSION);
    const char *all = api_text_finish(&text);
    if (document && all)
        api_digest_bytes(all, strlen(all), laminate->revision);
    arena_rewind(arena, mark);
    return document && all;
}

enum api_problem_id laminate_resolve(struct laminate *laminate, const struct api_limits *limits,
                                     struct arena *arena, struct api_problem *problem) {
    struct boundary_surface on = {
        .laminate = laminate, .limits = limits, .arena = arena, .problem = problem};
    char id[API_ID_SIZE];
    if (expand_plies(&on) != API_OK)
        return problem->id;
    for (size_t k = 0; k < laminate->count; k++)
        if (resolve_ply(&on, k) != API_OK)
            return problem->id;
    /* Which plies share a drape. */
    size_t *net_ply = arena_alloc(arena, laminate->count, sizeof *net_ply);
    laminate->net_digest = arena_alloc(arena, laminate->count, sizeof *laminate->net_digest);
    laminate->net_ply = net_ply;
    if (!net_ply || !laminate->net_digest || !api_digest_surface(&laminate->surface, arena, id))
        return api_problem_no_memory(problem, "the laminate");
    for (size_t k = 0; k < laminate->count; k++) {
        struct laminate_ply *ply = &laminate->plies[k];
        struct api_request named = laminate_drape(laminate, k);
        char digest[API_ID_SIZE];
        memcpy(named.surface.id, id, sizeof id);
        if (!api_digest_request(&named, arena, digest))
            return api_problem_no_memory(problem, "the laminate");
        for (ply->net = 0; ply->net < laminate->net_count; ply->net++)
            if (memcmp(laminate->net_digest[ply->net], digest, sizeof digest) == 0)
                break;
        if (ply->net < laminate->net_count)
            continue;
        memcpy(laminate->net_digest[laminate->net_count], digest, sizeof digest);
        net_ply[laminate->net_count++] = k;
    }
    return find_revision(laminate, id, arena) ? API_OK
                                              : api_problem_no_memory(problem, "the laminate");
}
