/* SPDX-License-Identifier: MIT */
/*
 * Segments of the plane and the faces between them: where segments meet or cross they are divided,
 * what ends without dividing anything is dropped. Ends nearer to each other than 1e-9 of all that
 * they span are one.
 */
#ifndef API_LAMINATE_ARRANGEMENT_H
#define API_LAMINATE_ARRANGEMENT_H

#include "api/result/polygons.h"
#include "solver/arena.h"
#include <stdint.h>

/* A segment with a number of the caller's. */
struct segment {
    double from[2], to[2];
    int32_t number;
};

/* A list that grows in an arena. */
struct segments {
    struct segment *list;
    size_t count, room;
    struct arena *arena;
};

/* False without memory. */
bool segments_add(struct segments *segments, const double from[2], const double to[2],
                  int32_t number);
bool segments_add_polygons(struct segments *segments, const struct polygons *polygons,
                           int32_t number);

struct arrangement;

/* Of segments on each other the number of the first stays. NULL without memory. */
struct arrangement *arrangement_make(const struct segments *segments, struct arena *arena);

/*
 * The face in which a point lies, as polygons with the face on their left (zero-initialised; the
 * caller frees them in any case), none where it lies outside all; and of each of their points the
 * number of the segment that begins there, in the arena. False without memory.
 */
bool arrangement_face(const struct arrangement *arrangement, const double at[2],
                      struct polygons *face, int32_t **numbers);

/* The boundary of all faces in which `holds` is true, alike. It is asked beside every segment. */
bool arrangement_select(const struct arrangement *arrangement,
                        bool (*holds)(const void *context, const double at[2]), const void *context,
                        struct polygons *selected);

#endif
