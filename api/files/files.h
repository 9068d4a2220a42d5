/* SPDX-License-Identifier: MIT */
/*
 * Files of CAD and mesh that surfaces come from. Meshes are read here: STL, OBJ and the shells
 * of decks and of meshers become the JSON of a triangle mesh, with equal corners made one. STEP and
 * IGES take Open CASCADE, which the importer alone has (import); here is only what they are called.
 */
#ifndef API_FILES_FILES_H
#define API_FILES_FILES_H

#include "api/map/target.h"
#include "api/problem.h"
#include "solver/arena.h"
#include "solver/status.h"
#include <stdbool.h>
#include <stddef.h>

struct file_format {
    const char *name; /* in `?format=` */
    const char *media_type;
    const char *suffixes[4]; /* of names, in lower case, up to a NULL */
    bool cad;                /* read by the importer */
    map_target_reader *read; /* its shells with their own numbers; NULL: it has triangles alone */
};

enum { FILE_FORMATS = 10 };
extern const struct file_format file_formats[FILE_FORMATS];

/* NULL: there is none of this name, or with this end of a file's name. */
const struct file_format *file_format_named(const char *name);
const struct file_format *file_format_of(const char *path);

/* Why a file is no part, by its name: what it is and what to do with it, or, and then false, which
 * names there are. */
enum { FILE_REFUSAL_SIZE = 192 };
bool file_refuse(const char *path, char text[FILE_REFUSAL_SIZE]);

/* The unit of a file that states none, and of which nobody said one. */
#define FILE_UNIT "mm"

/* Whether `unit` is one that lengths may be in. */
bool file_unit_known(const char *unit);

/*
 * Reads a mesh. `unit` is that of its lengths, "" when nobody said: FILE_UNIT, which is noted; no
 * mesh file says one. The text is a JSON surface {"vertices", "triangles", "length_unit", "notes"},
 * zero-terminated, in `arena`. Corners within 1e-7 of the box's diagonal are one vertex; triangles
 * without area and second ones on the same corners are left out and noted. Returns API_OK,
 * API_UNREADABLE_FILE with the line or the byte, or API_OUT_OF_MEMORY.
 */
enum api_problem_id file_read_mesh(const struct file_format *format, const char *bytes,
                                   size_t length, const char *unit, struct arena *arena,
                                   const char **text, size_t *text_length,
                                   struct api_problem *problem) STATUS_MUST_USE;

/* Reads a mesh that somebody's drape is mapped onto: its triangles as elements from 0, of decks and
 * meshers the shells with their own numbers. Problems as above, and as `map_target_nastran`. */
enum api_problem_id file_read_target(const struct file_format *format, const char *bytes,
                                     size_t length, struct arena *arena, struct map_target *target,
                                     struct api_problem *problem) STATUS_MUST_USE;

#endif
