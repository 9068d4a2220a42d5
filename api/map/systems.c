/* SPDX-License-Identifier: MIT */
#include "systems.h"

#include "target.h"
#include <math.h>
#include <string.h>

enum { DEPTH_MAX = 64 }; /* systems that hang on each other in a row */

/* Three points lie on a line where the sine of their angle is less. */
static const double degree = 3.14159265358979323846 / 180, least_sine = 1e-9;

/* ---- cards ---- */

/* CORD1R CIDA G1A G2A G3A CIDB G1B G2B G3B; CORD2R CID RID A1 A2 A3 B1 B2 B3, C1 C2 C3. */
int systems_read(const struct bulk_card *card, struct system found[2],
                 struct api_problem *problem) {
    static const char letters[] = "RCS";
    const char *name = card->name, *letter = strlen(name) == 6 ? strchr(letters, name[5]) : NULL;
    if (!letter || strncmp(name, "CORD", 4) != 0 || (name[4] != '1' && name[4] != '2'))
        return 0;
    bool by_grids = name[4] == '1';
    bool basic = !card->field[1][0] || strcmp(card->field[1], "0") == 0;
    int count = by_grids && card->field[4][0] ? 2 : 1;
    for (int s = 0; s < count; s++) {
        struct system *system = &found[s];
        *system = (struct system){.line = (uint32_t)card->line, .by_grids = by_grids};
        system->kind = (enum system_kind)(letter - letters);
        strcpy(system->name, name);
        bool good = bulk_id(card, 4 * s, "the id", &system->id, problem);
        if (!by_grids)
            good = good && (basic || bulk_id(card, 1, "the system", &system->reference, problem));
        for (int k = 0; good && k < 3; k++)
            good = by_grids ? bulk_id(card, 4 * s + 1 + k, "a grid", &system->grid[k], problem)
                            : bulk_point(card, 2 + 3 * k, &system->point[k], problem);
        if (!good)
            return -1;
    }
    return count;
}

/* ---- what they are in basic coordinates ---- */

struct resolution {
    struct systems *systems;
    struct grids *grids;
    struct api_problem *problem;
    int depth;
};

static bool prepare_system(struct resolution *resolution, struct system *system);

/* A point of the system with this id, in place. `line` and `what` say where it stands. */
static bool to_basic(struct resolution *resolution, int32_t id, struct vec3 *point, uint32_t line,
                     const char *what) {
    struct systems *systems = resolution->systems;
    if (id == 0)
        return true;
    int32_t index = map_ids_find(systems->by_id, systems->count, id);
    if (index < 0)
        return MAP_REFUSE(
            resolution->problem,
            "line %u: %s is in the coordinate system %d, which the file does not define", line,
            what, id);
    const struct system *system = &systems->system[index];
    if (!prepare_system(resolution, &systems->system[index]))
        return false;
    struct vec3 p = *point;
    double theta = p.y * degree, phi = p.z * degree;
    if (system->kind == SYSTEM_CYLINDRICAL)
        p = vec3_make(p.x * cos(theta), p.x * sin(theta), p.z);
    else if (system->kind == SYSTEM_SPHERICAL)
        p = vec3_make(p.x * sin(theta) * cos(phi), p.x * sin(theta) * sin(phi), p.x * cos(theta));
    struct vec3 at = vec3_axpy(p.x, system->x, system->origin);
    *point = vec3_axpy(p.z, system->z, vec3_axpy(p.y, system->y, at));
    return true;
}

static bool move_grid(struct resolution *resolution, size_t index) {
    struct grids *grids = resolution->grids;
    struct vec3 *point = &grids->point[index];
    uint32_t line = grids->line[index];
    if (!to_basic(resolution, grids->system[index], point, line, "a GRID"))
        return false;
    grids->system[index] = 0;
    bool near = fabs(point->x) <= MAP_COORDINATE_MAX && fabs(point->y) <= MAP_COORDINATE_MAX &&
                fabs(point->z) <= MAP_COORDINATE_MAX;
    return near ||
           MAP_REFUSE(resolution->problem, "line %u: a GRID has coordinates beyond 1e12", line);
}

static bool prepare_system(struct resolution *resolution, struct system *system) {
    const struct grids *grids = resolution->grids;
    struct vec3 points[3];
    if (system->state == SYSTEM_READY)
        return true;
    if (system->state == SYSTEM_BUSY)
        return MAP_REFUSE(resolution->problem, "line %u: %s %d refers to itself", system->line,
                          system->name, system->id);
    if (resolution->depth == DEPTH_MAX)
        return MAP_REFUSE(resolution->problem,
                          "line %u: %s %d: more than %d systems depend on each other", system->line,
                          system->name, system->id, DEPTH_MAX);
    system->state = SYSTEM_BUSY;
    resolution->depth++;
    for (int k = 0; k < 3; k++) { /* the points that define it, in basic coordinates */
        points[k] = system->point[k];
        if (!system->by_grids) {
            if (!to_basic(resolution, system->reference, &points[k], system->line, system->name))
                return false;
            continue;
        }
        int32_t grid = map_ids_find(grids->by_id, grids->count, system->grid[k]);
        if (grid < 0)
            return MAP_REFUSE(resolution->problem,
                              "line %u: %s %d names the grid %d, which does not exist",
                              system->line, system->name, system->id, system->grid[k]);
        if (!move_grid(resolution, (size_t)grid))
            return false;
        points[k] = grids->point[grid];
    }
    /* z = AB / |AB|, y = z x AC / |z x AC|, x = y x z. */
    struct vec3 b = vec3_sub(points[1], points[0]), c = vec3_sub(points[2], points[0]);
    struct vec3 normal = vec3_cross(b, c);
    if (!(vec3_norm(normal) > least_sine * vec3_norm(b) * vec3_norm(c)))
        return MAP_REFUSE(resolution->problem, "line %u: the three points of %s %d lie on one line",
                          system->line, system->name, system->id);
    system->origin = points[0];
    system->z = vec3_unit(b);
    system->y = vec3_unit(normal);
    system->x = vec3_cross(system->y, system->z);
    resolution->depth--;
    system->state = SYSTEM_READY;
    return true;
}

bool systems_apply(struct systems *systems, struct grids *grids, struct api_problem *problem) {
    struct resolution resolution = {systems, grids, problem, 0};
    for (size_t k = 0; k < grids->count; k++)
        if (grids->system[k] != 0 && !move_grid(&resolution, k))
            return false;
    return true;
}
