/* SPDX-License-Identifier: MIT */
/*
 * A shell: several faces, each a surface with its trimmed region, that meet along their edges and
 * are draped as one surface.
 *
 * The boundary of a face consists of edges: pieces of its trim curves and, where nothing is trimmed
 * away, of its domain's border. Edges of two faces, or of one face, that coincide within a
 * tolerance are joined there: curves are cut at each other's ends first, so that one long edge may
 * be joined to three short ones. An edge that is one point within the tolerance joins nothing. All
 * this is found from the faces alone; how they are parametrised, oriented and ordered makes no
 * difference.
 *
 * A shell is immutable once made and may be read by many threads at once.
 */
#ifndef SOLVER_SHELL_SHELL_H
#define SOLVER_SHELL_SHELL_H

#include "solver/surface/loops.h"
#include <stdint.h>

/* More faces than this are STATUS_INVALID with SHELL_TOO_MANY. */
enum { SHELL_FACES_MAX = 65535 };

/* The tolerance when none is given, as a share of the diagonal of the box round all faces. */
#define SHELL_TOLERANCE 1e-5

/* One face as its owner gives it: loops as in `trim_make`, none for the whole domain. Everything it
 * points to is used as long as the shell is. */
struct shell_patch {
    const struct surface *surface;
    const struct trim_loop *loops;
    size_t loop_count;
    const struct trim *trim; /* the loops' region, where another shell has it already; or NULL */
};

struct shell;

enum shell_fault_kind {
    SHELL_FAULTLESS,
    SHELL_TOO_MANY,      /* no face, or more than SHELL_FACES_MAX */
    SHELL_TOLERANCE_BAD, /* not positive, or as large as the shell */
    SHELL_NOTHING_LEFT,  /* the loops of a face leave nothing of it */
    SHELL_LOOP_BAD,      /* a loop of a face is open or crosses itself */
    SHELL_THREE_FACES,   /* three faces or more meet at an edge */
    SHELL_ONE_SIDED,     /* faces that cannot be oriented alike: each edge of a pair of faces wants
                            them the other way round */
    SHELL_TOO_CURVED,    /* a face whose radius of curvature is less than it is to be moved by */
    SHELL_FOLDS          /* two faces, or one, that fold where they are to be moved */
};

/* What is wrong with the faces of STATUS_INVALID and STATUS_DEGENERATE_SURFACE. */
struct shell_fault {
    enum shell_fault_kind kind;
    int face_count;         /* of those to blame */
    int32_t face[3];        /* by their place in the caller's array, in rising order */
    struct vec3 at;         /* where, of faults that have a place */
    double radius;          /* of SHELL_TOO_CURVED */
    double fold_deg;        /* of SHELL_FOLDS */
    struct loop_fault loop; /* of SHELL_LOOP_BAD */
};

/* What was found. */
struct shell_edges {
    size_t joined;      /* pairs of edges */
    size_t free;        /* edges that are the boundary of the shell */
    size_t faulty;      /* of `shell_make_lenient`: places where faces are not joined for a fault */
    double largest_gap; /* between joined edges, where they are farthest apart */
    double shortest;    /* the length of the shortest piece of the boundary; 0: there is none */
    int32_t shortest_face;
    struct vec3 shortest_at;
    size_t duplicates; /* faces left out, each being another one once more */
};

/* Joins the faces; `tolerance` 0 is the default. The loops' regions are made in `arena`, too.
 * Errors: STATUS_OUT_OF_MEMORY; STATUS_INVALID, and STATUS_DEGENERATE_SURFACE of
 * SHELL_NOTHING_LEFT, with the fault (may be NULL). */
enum status shell_make(const struct shell_patch *patches, size_t count, double tolerance,
                       struct arena *arena, struct shell **shell,
                       struct shell_fault *fault) STATUS_MUST_USE;

/* The same of faces that cannot all be one surface, to look at them and to choose some: where three
 * or more meet at an edge they are not joined there, nor are two over an edge that wants them
 * turned otherwise than others do, and loops are not asked whether they are sound. Fails as
 * `shell_make` does of faces without area and a bad tolerance. */
enum status shell_make_lenient(const struct shell_patch *patches, size_t count, double tolerance,
                               struct arena *arena, struct shell **shell) STATUS_MUST_USE;

/* A walk of `solver/relocation.h` from the pointer to a shell on, with its faces' surfaces and
 * regions; the loops that it was made of are their owner's. */
void shell_relocate(struct relocation *relocation, void *field);

/* The faces as they were given. */
size_t shell_face_count(const struct shell *shell);

/* The surface and the region of a face (NULL: all of its domain). */
const struct surface *shell_surface(const struct shell *shell, int32_t face);
const struct trim *shell_trim(const struct shell *shell, int32_t face);

/* The surface as it was given, that is of no shell. */
const struct surface *shell_plain_surface(const struct shell *shell, int32_t face);

/* The number of the component that a face belongs to, and how many components there are. Faces
 * that are joined, directly or through others, are one component. */
int32_t shell_component(const struct shell *shell, int32_t face);

/* 1 where r_u x r_v of a face is on the side on which the first face of its component has it, else
 * -1. */
int shell_side(const struct shell *shell, int32_t face);
size_t shell_component_count(const struct shell *shell);

/* Whether a face is left out as another one once more. */
bool shell_is_duplicate(const struct shell *shell, int32_t face);

struct shell_edges shell_edges(const struct shell *shell);

/* The tolerance that was used. */
double shell_tolerance(const struct shell *shell);

/* Box round all faces, and its diagonal. */
void shell_bounds(const struct shell *shell, struct vec3 *lower, struct vec3 *upper);
double shell_size(const struct shell *shell);

/* A place this near to a joint is on it: 1e-9 of the size, and twice the largest gap. */
double shell_joint_width(const struct shell *shell);

/* Area of the faces of a component, and its centroid (may be NULL). */
double shell_area(const struct shell *shell, int32_t component, struct vec3 *centroid);

/* The square of its radius of gyration, as `surface_gyration2`. */
double shell_gyration2(const struct shell *shell, int32_t component);

/* The component of the largest area, of equal ones the first. */
int32_t shell_largest_component(const struct shell *shell);

/* A place of a shell: parameters of a face, inside its region or on its edge. */
struct shell_point {
    int32_t face;
    double uv[2];    /* the caller's */
    double inner[2]; /* the same as the solver takes them (`spans.h`) */
};

/* Whether the faces reached from `face` may lead back to where they came from otherwise than over
 * a hole: they have no boundary, or more than one. */
bool shell_may_close(const struct shell *shell, int32_t face);

/* Whether they may be a tube: they have two boundaries or more, of which none, or both of two, are
 * like the edge of a plate as far as their normals tell. */
bool shell_may_be_tube(const struct shell *shell, int32_t face);

/* The length of their mean normal: 1 for a plate, 0.5 for a hemisphere, 0 for what is closed. */
double shell_flatness(const struct shell *shell, int32_t face);

/* Whether they have no boundary. */
bool shell_is_closed(const struct shell *shell, int32_t face);

/* An edge that is part of the boundary: a polyline in the inner parameters of a face, which lies on
 * its left, seen against the normal that the face has. */
struct shell_edge {
    int32_t face;
    double (*uv)[2];
    size_t count; /* of points; 0 where an edge is no boundary of the component */
};

/* Edge number 0 .. shell_edge_count - 1, its points in `arena`. Errors: STATUS_OUT_OF_MEMORY. */
size_t shell_edge_count(const struct shell *shell);
enum status shell_edge(const struct shell *shell, size_t number, int32_t component,
                       struct arena *arena, struct shell_edge *edge) STATUS_MUST_USE;

/* An edge as points, about a length apart and closer where it bends: inner parameters of its face,
 * and places in space. Both sides of a joint have the same places, and edges that meet end in one.
 */
struct shell_line {
    int32_t face;
    double (*uv)[2];
    struct vec3 *r;
    size_t count; /* 0: the edge is no boundary of a face of the component */
};

/* The lines of a component, one for each edge of the shell: those of its faces' boundaries, and
 * those that are one point in space. Errors: STATUS_OUT_OF_MEMORY. */
enum status shell_lines(const struct shell *shell, int32_t component, double size,
                        struct arena *arena, struct shell_line **lines) STATUS_MUST_USE;

/* The place nearest to `point` on the faces of a component, or of all with SHELL_ANY, and its
 * distance. */
enum { SHELL_ANY = -1 };
void shell_nearest(const struct shell *shell, struct vec3 point, int32_t component,
                   struct shell_point *place, double *distance);

/* Where another component comes nearest to that of `face`, by points of its edges. Errors:
 * STATUS_OUT_OF_MEMORY. */
struct shell_apart {
    int32_t face; /* of the other */
    struct vec3 at;
    double distance; /* HUGE_VAL: there is no other */
};
enum status shell_nearest_apart(const struct shell *shell, int32_t face, struct arena *arena,
                                struct shell_apart *apart) STATUS_MUST_USE;

/* `shell_nearest` on the component of `place`, which is near it: of its own face the place to which
 * the way from there leads down. */
void shell_nearest_from(const struct shell *shell, struct vec3 point, struct shell_point *place,
                        double *distance);

/* The place of another face of the component of `face` that is nearest to `point`, if it is within
 * `reach` and inside that face's region. False where there is none. */
bool shell_over(const struct shell *shell, struct vec3 point, int32_t face, double reach,
                struct shell_point *place);

/* A shell of the same faces of which `face` has its normal along r_u x r_v, and the others of its
 * component like it: a shallow copy in `arena`. Errors: STATUS_OUT_OF_MEMORY. */
enum status shell_orient(const struct shell *shell, int32_t face, struct arena *arena,
                         struct shell **oriented) STATUS_MUST_USE;

/*
 * The shell of the same faces, each moved along its normal by `height` (`offset.h`), to the side to
 * which the first face of its component has r_u x r_v. `patches` are those that the shell was made
 * of. Faces that fold by up to a degree or what the tolerance hides are joined all the same, over
 * the gap. Errors: as `shell_make`; STATUS_INVALID with SHELL_TOO_CURVED or SHELL_FOLDS.
 */
enum status shell_offset(const struct shell *shell, const struct shell_patch *patches,
                         double height, struct arena *arena, struct shell **moved,
                         struct shell_fault *fault) STATUS_MUST_USE;

/* A corner of a face: its number, and inner parameters. */
struct shell_corner {
    int32_t face;
    double uv[2];
};

/* The other faces with a corner at a pole of a face, and how many they are: the pole at the end
 * `end` % 2 of the axis `end` / 2. */
size_t shell_round_pole(const struct surface *surface, int end,
                        const struct shell_corner **corners);

/* The joint that edge `number` is the first side of: its faces, and the largest angle in degrees
 * by which they fold there. False for other edges. */
bool shell_joint(const struct shell *shell, size_t number, int32_t face[2], double *fold);

/* The faces reached from `face` across joints that fold by no more than `up_to_deg` degrees:
 * `reached`, as long as there are faces, gets 1 for each of them and 0 for the others. Errors:
 * STATUS_OUT_OF_MEMORY. */
enum status shell_grow(const struct shell *shell, int32_t face, double up_to_deg,
                       struct arena *arena, uint8_t *reached) STATUS_MUST_USE;

#endif
