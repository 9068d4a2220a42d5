/* SPDX-License-Identifier: MIT */
/*
 * Every column there is, in the order in which results and maps have them. From this one list come
 * the columns of a result (`fields.c` says how each is computed), how a map carries them over, the
 * vectors and tensors of formats that know such, how JSON writes them, and the table in
 * docs/fields.md. A new column is one line here and its computation.
 *
 * X(TABLE, name, stem, KIND, unit, NEED, meaning): a vector or tensor is stored as one column for
 * each component, whose names are made of the stem; the stem of all others is the name.
 */
#ifndef API_RESULT_COLUMN_LIST_H
#define API_RESULT_COLUMN_LIST_H

#include <stdbool.h>
#include <stddef.h>

/* clang-format off */
#define COLUMN_LIST(X)                                                                             \
    X(NODES, i, i, INTEGER, "", ALWAYS, "place along the warp, in steps from the start")           \
    X(NODES, j, j, INTEGER, "", ALWAYS, "place along the weft, in steps from the start")           \
    X(NODES, u, u, SCALAR, "", ALWAYS, "parameter u of the surface; on a mesh the triangle")       \
    X(NODES, v, v, SCALAR, "", ALWAYS, "parameter v of the surface; on a mesh 0")                  \
    X(NODES, face, face, INTEGER, "", FACES, "number of the face that u and v are parameters of")  \
    X(NODES, x, x, SCALAR, "length", ALWAYS, "position")                                           \
    X(NODES, y, y, SCALAR, "length", ALWAYS, "position")                                           \
    X(NODES, z, z, SCALAR, "length", ALWAYS, "position")                                           \
    X(NODES, shear_deg, shear_deg, SCALAR, "deg", ALWAYS,                                          \
      "90 minus the angle between warp and weft at the node")                                       \
    X(NODES, error_estimate, error_estimate, SCALAR, "length", ESTIMATE,                           \
      "distance to the net of the continuous cloth")                                               \
    X(NODES, shear_error_deg, shear_error_deg, SCALAR, "deg", ESTIMATE,                            \
      "how far shear_deg may be from that of this net")                                            \
    X(NODES, grown, grown, FLAG, "", ALWAYS,                                                       \
      "1 where the node rests on a yarn that goes straight on from a free edge")                   \
    X(CELLS, id, id, INTEGER, "", MAP, "number of the element in the mesh, or of the point")       \
    X(CELLS, pid, pid, INTEGER, "", MAP_PROPERTY, "property of the element in the mesh")           \
    X(CELLS, role, role, INTEGER, "", MAP_ROLE,                                                    \
      "0: fabric, 1: inlet, 2: outlet, 3: channel along the rim")                                  \
    X(CELLS, ply_count, ply_count, INTEGER, "", LAMINATE, "number of plies")              \
    X(CELLS, i, i, INTEGER, "", ALWAYS, "the cell's first corner, in steps from the start")        \
    X(CELLS, j, j, INTEGER, "", ALWAYS, "the cell's first corner, in steps from the start")        \
    X(CELLS, shear_deg, shear_deg, SCALAR, "deg", ALWAYS, "shear angle γ")                         \
    X(CELLS, thickness, thickness, SCALAR, "length", THICKNESS,                                    \
      "n t₀ / cos γ; in a rigid cavity its height h")                                              \
    X(CELLS, fiber_volume_fraction, fiber_volume_fraction, SCALAR, "", FRACTION,                   \
      "Vf₀; in a rigid cavity Vf₀ (n t₀ / h) / cos γ")                                             \
    X(CELLS, porosity, porosity, SCALAR, "", FRACTION, "1 - Vf")                                   \
    X(CELLS, pressure, pressure, SCALAR, "Pa", COMPACTION,                                         \
      "on the plies with a compaction law")                                            \
    X(CELLS, warp, warp, VECTOR, "", ALWAYS, "unit direction of the warp at the middle")           \
    X(CELLS, weft, weft, VECTOR, "", ALWAYS, "unit direction of the weft at the middle")           \
    X(CELLS, k1, k1, SCALAR, "m²", PERMEABILITY, "larger principal permeability in the surface")   \
    X(CELLS, k2, k2, SCALAR, "m²", PERMEABILITY, "smaller principal permeability in the surface")  \
    X(CELLS, k3, k3, SCALAR, "m²", PERMEABILITY, "permeability through the surface")               \
    X(CELLS, k1_direction, k1, VECTOR, "", PERMEABILITY, "unit direction of k1")                   \
    X(CELLS, locked, locked, FLAG, "", LOCKING, "1 where \\|γ\\| exceeds the locking angle")       \
    X(CELLS, severity, severity, SCALAR, "", LIMIT, "how severe γ is, 0 to 1, by `limit_curve`")   \
    X(CELLS, packing_exceeded, packing_exceeded, FLAG, "", FRACTION,                               \
      "1 where Vf exceeds what fibres can be packed to")                                           \
    X(CELLS, out_of_table, out_of_table, FLAG, "", TABLE,                                             \
      "1 where \\|γ\\| or Vf lies outside the table")                                               \
    X(CELLS, permeability, k, TENSOR, "m²", MAP_PERMEABILITY, "the permeability in global axes")   \
    X(CELLS, distance, distance, SCALAR, "length", MAP, "from the point to the cloth")             \
    X(CELLS, extrapolated, extrapolated, TRUTH, "", MAP, "whether the point lies beyond the cloth")\
    X(FRONT, i, i, INTEGER, "", ALWAYS, "missing node next to the net, in steps from the start")                    \
    X(FRONT, j, j, INTEGER, "", ALWAYS, "missing node next to the net, in steps from the start")                    \
    X(FRONT, reason, reason, REASON, "", ALWAYS, "why the net ends there")                         \
    X(RIM, loop, loop, INTEGER, "", ALWAYS, "closed loop of the part's edge that the point is of") \
    X(RIM, x, x, SCALAR, "length", ALWAYS, "position")                                             \
    X(RIM, y, y, SCALAR, "length", ALWAYS, "position")                                             \
    X(RIM, z, z, SCALAR, "length", ALWAYS, "position")                                             \
    X(RIM, u, u, SCALAR, "", ALWAYS, "parameter u of the surface; on a mesh the triangle")         \
    X(RIM, v, v, SCALAR, "", ALWAYS, "parameter v of the surface; on a mesh 0")                    \
    X(RIM, face, face, INTEGER, "", FACES, "number of the face that u and v are parameters of")    \
    X(RIM, p, p, SCALAR, "", ALWAYS, "place along the warp: i as a real number")                   \
    X(RIM, q, q, SCALAR, "", ALWAYS, "place along the weft: j as a real number")                   \
    X(RIM, covered, covered, FLAG, "", ALWAYS, "0 where no cloth reaches the edge")                \
    X(RIM, cut, cut, INTEGER, "", CUTS, "cut whose lip goes on from the point: 1, 2, .. to its tip, -1, -2, .. back; 0 of none") \
    X(CUTS, name, name, NAME, "", CUTS, "of the request, else cut_1, cut_2, ..")                   \
    X(CUTS, length, length, SCALAR, "length", CUTS, "on the part")                                 \
    X(CUTS, tip_angle_deg, tip_angle_deg, SCALAR, "deg", CUTS, "between the lips at the tip, in the flat cloth: above 0 a dart, 0 a slit, below 0 the cloth would lie on itself") \
    X(CUTS, mouth_width, mouth_width, SCALAR, "length", CUTS, "between the lips' ends at the edge, in the flat cloth; below 0 where they pass each other") \
    X(CUTS, area, area, SCALAR, "length²", CUTS, "between the lips, in the flat cloth: cut out; below 0 lacking") \
    X(CUTS, covered, covered, FLAG, "", CUTS, "0 where no cloth reaches the tip or an end of a lip: angle, width and area are 0 then") \
    X(CUTS, allowance, allowance, SCALAR, "length", CUTS, "of the request, along both lips in patterns") \
    X(PLIES, element, element, INTEGER, "", MAP, "number of the element, as `id` of the cells")    \
    X(PLIES, ply, ply, INTEGER, "", MAP, "number of the ply from 1, the first on the tool")        \
    X(PLIES, piece, piece, INTEGER, "", MAP, "number of its piece from 1, 0 of a ply of one; where any has several") \
    X(PLIES, angle_deg, angle_deg, SCALAR, "deg", MAP,                                             \
      "from the element's reference direction to the warp")                                        \
    X(PLIES, shear_deg, shear_deg, SCALAR, "deg", MAP, "shear angle γ")                            \
    X(PLIES, thickness, thickness, SCALAR, "length", THICKNESS, "of the ply")                      \
    X(PLIES, fiber_volume_fraction, fiber_volume_fraction, SCALAR, "", FRACTION, "of the ply") \
    X(VARIANTS, start_u, start_u, SCALAR, "", ALWAYS, "parameter u of the start; on a mesh the triangle") \
    X(VARIANTS, start_v, start_v, SCALAR, "", ALWAYS, "parameter v of the start; on a mesh 0")     \
    X(VARIANTS, face, face, INTEGER, "", FACES, "number of the face that these are parameters of") \
    X(VARIANTS, x, x, SCALAR, "length", ALWAYS, "position of the start")                           \
    X(VARIANTS, y, y, SCALAR, "length", ALWAYS, "position of the start")                           \
    X(VARIANTS, z, z, SCALAR, "length", ALWAYS, "position of the start")                           \
    X(VARIANTS, angle_deg, angle_deg, SCALAR, "deg", ALWAYS, "direction of the warp at the start") \
    X(VARIANTS, pre_shear_deg, pre_shear_deg, SCALAR, "deg", ALWAYS, "shear at the start")         \
    X(VARIANTS, coarseness, coarseness, SCALAR, "", ALWAYS, "spacing of its net over that of the drape") \
    X(VARIANTS, max_shear_deg, max_shear_deg, POSITIVE, "deg", JUDGED, "greatest \\|γ\\|")         \
    X(VARIANTS, p95_shear_deg, p95_shear_deg, POSITIVE, "deg", JUDGED, "\\|γ\\| that 95 % of the area has less than") \
    X(VARIANTS, locked_area, locked_area, POSITIVE, "length²", JUDGED, "area beyond the locking angle") \
    X(VARIANTS, severity_area, severity_area, POSITIVE, "length²", JUDGED, "area times its severity") \
    X(VARIANTS, uncovered_area, uncovered_area, POSITIVE, "length²", JUDGED, "area of the part without cloth") \
    X(VARIANTS, waste_area, waste_area, POSITIVE, "length²", JUDGED, "area of the rectangle round the flat pattern, minus the pattern") \
    X(VARIANTS, angle_deviation_deg, angle_deviation_deg, POSITIVE, "deg", JUDGED, "mean angle between warp and `wanted_direction`") \
    X(VARIANTS, fiber_volume_fraction_range, fiber_volume_fraction_range, POSITIVE, "", JUDGED, "greatest minus least Vf") \
    X(VARIANTS, k1_ratio_p95, k1_ratio_p95, POSITIVE, "", JUDGED, "factor between k1 and that of the unsheared fabric: 95 % of the area has less") \
    X(VARIANTS, cut_length, cut_length, POSITIVE, "length", JUDGED, "of all cuts on the part together") \
    X(VARIANTS, angle_deviation_max_deg, angle_deviation_max_deg, POSITIVE, "deg", JUDGED, "greatest such angle of a cell") \
    X(VARIANTS, gap_width, gap_width, POSITIVE, "length", JUDGED, "greatest distance between neighbouring courses") \
    X(VARIANTS, cloth_coverage, cloth_coverage, POSITIVE, "", ALWAYS, "share of the part under cloth") \
    X(VARIANTS, mean_shear_deg, mean_shear_deg, POSITIVE, "deg", JUDGED, "mean \\|γ\\| by area")   \
    X(VARIANTS, laid_coverage, laid_coverage, POSITIVE, "", JUDGED, "share of the part under courses or in gaps between them") \
    X(VARIANTS, feasible, feasible, FLAG, "", ALWAYS, "1 where the variant keeps all limits")               \
    X(VARIANTS, pareto, pareto, FLAG, "", ALWAYS, "1 where no other variant is better in one objective and as good in all") \
    X(VARIANTS, failure, failure, FAILURE, "", ALWAYS, "why the variant failed, or `none`")        \
    X(BANDS, i, i, INTEGER, "", ALWAYS, "the nominal cell, in steps from its start")               \
    X(BANDS, j, j, INTEGER, "", ALWAYS, "the nominal cell, in steps from its start")               \
    X(BANDS, x, x, SCALAR, "length", ALWAYS, "middle of the cell")                                 \
    X(BANDS, y, y, SCALAR, "length", ALWAYS, "middle of the cell")                                 \
    X(BANDS, z, z, SCALAR, "length", ALWAYS, "middle of the cell")                                 \
    X(PROPOSED, variant, variant, INTEGER, "", ALWAYS, "whose cut it is, counted from 0")          \
    X(PROPOSED, cut, cut, INTEGER, "", ALWAYS, "number of the cut, counted from 1")                \
    X(PROPOSED, mouth_x, mouth_x, SCALAR, "length", ALWAYS, "where it begins, at the edge")        \
    X(PROPOSED, mouth_y, mouth_y, SCALAR, "length", ALWAYS, "where it begins, at the edge")        \
    X(PROPOSED, mouth_z, mouth_z, SCALAR, "length", ALWAYS, "where it begins, at the edge")        \
    X(PROPOSED, tip_x, tip_x, SCALAR, "length", ALWAYS, "where it ends")                           \
    X(PROPOSED, tip_y, tip_y, SCALAR, "length", ALWAYS, "where it ends")                           \
    X(PROPOSED, tip_z, tip_z, SCALAR, "length", ALWAYS, "where it ends")                           \
    X(COURSES, variant, variant, INTEGER, "", ALWAYS, "whose course it is, counted from 0")        \
    X(COURSES, course, course, INTEGER, "", ALWAYS, "number of the course, counted from 1")        \
    X(COURSES, point, point, INTEGER, "", ALWAYS, "number of the distance, counted from 1: of a course there are one or more") \
    X(COURSES, distance, distance, SCALAR, "length", ALWAYS, "of its near edge from the line, or from the course before") \
    X(COURSES, width, width, SCALAR, "length", ALWAYS, "its width")                                \
    X(COURSES, origin, origin, SCALAR, "", ALWAYS, "where its weft generator is, as a share of its near edge")
/* clang-format on */

enum api_table {
    API_TABLE_NODES,
    API_TABLE_CELLS,
    API_TABLE_FRONT,
    API_TABLE_RIM,
    API_TABLE_CUTS,     /* of drapes with cuts alone */
    API_TABLE_CUT,      /* of stored results, for maps: the cells that the rim cuts */
    API_TABLE_PLIES,    /* of maps onto meshes alone */
    API_TABLE_VARIANTS, /* of studies alone */
    API_TABLE_BANDS,    /* of studies that draw samples alone */
    API_TABLE_PROPOSED, /* of studies that propose cuts alone */
    API_TABLE_COURSES,  /* of studies that vary courses alone */
    API_TABLE_COUNT
};

/* "nodes", "cells", "front", "rim", "cuts", "cut", "plies", "variants", "bands",
 * "proposed", "courses". */
extern const char *const column_tables[API_TABLE_COUNT];
static inline const char *api_table_name(enum api_table table) {
    return column_tables[table];
}

enum column_kind {
    COLUMN_SCALAR,
    COLUMN_VECTOR,   /* STEM_x, STEM_y, STEM_z */
    COLUMN_TENSOR,   /* symmetric: STEMxx, STEMyy, STEMzz, STEMxy, STEMyz, STEMxz, VTK's order */
    COLUMN_INTEGER,  /* whole numbers within 2^53 */
    COLUMN_FLAG,     /* 0 or 1 */
    COLUMN_TRUTH,    /* 0 or 1; false or true in JSON */
    COLUMN_REASON,   /* enum drape_reason; its name in JSON */
    COLUMN_POSITIVE, /* a number from 0 on, or -1 for none: null in JSON */
    COLUMN_FAILURE,  /* enum failure; its name in JSON */
    COLUMN_NAME,     /* number of the cut from 0; its name in JSON and CSV */
    COLUMN_KINDS
};

/* What has to be given for a column to be there. */
enum column_need {
    COLUMN_ALWAYS,
    COLUMN_ESTIMATE,
    COLUMN_FACES,
    COLUMN_THICKNESS,
    COLUMN_FRACTION,
    COLUMN_LOCKING,
    COLUMN_LIMIT,
    COLUMN_PERMEABILITY,
    COLUMN_TABLE,
    COLUMN_CUTS,
    COLUMN_JUDGED, /* an objective of the study, or a limit */
    COLUMN_MAP,    /* a map has it, a result has not */
    COLUMN_MAP_PERMEABILITY,
    COLUMN_MAP_PROPERTY, /* a map onto a mesh whose file has properties */
    COLUMN_MAP_ROLE,     /* a map with inlet, outlet or edge_channel */
    COLUMN_LAMINATE,     /* a map of a laminate */
    COLUMN_COMPACTION,   /* one whose plies are pressed by their laws */
    COLUMN_NEEDS
};

enum column_id {
#define COLUMN_ID(TABLE, name, stem, KIND, unit, NEED, meaning) COLUMN_##TABLE##_##name,
    COLUMN_LIST(COLUMN_ID)
#undef COLUMN_ID
        COLUMN_COUNT
};

enum { COLUMN_PARTS_MAX = 6 };

struct column_spec {
    enum api_table table;
    enum column_kind kind;
    enum column_need need;
    const char *name, *unit, *meaning;  /* "length": the drape's length unit */
    int parts;                          /* columns it is stored as */
    const char *part[COLUMN_PARTS_MAX]; /* their names */
};

extern const struct column_spec column_specs[COLUMN_COUNT]; /* by column_id */

/* The column that a stored one of this name is, or is a part of; NULL for an unknown name. */
const struct column_spec *column_spec_find(enum api_table table, const char *name);

/* The names of the stored columns of some, one after the other; returns how many. */
size_t column_part_names(const enum column_id *ids, size_t count, const char **names);

bool column_kind_is_integer(enum column_kind kind);

/* For documentation: what a kind is called, and what a need asks for ("" for always). */
extern const char *const column_kind_names[COLUMN_KINDS], *const column_need_names[COLUMN_NEEDS];

#endif
