/* SPDX-License-Identifier: MIT */
/* The columns of a map, and its warnings, as they are put together. */
#ifndef API_MAP_MAP_COLUMNS_H
#define API_MAP_MAP_COLUMNS_H

#include "map.h"

/* Adds a column of the points that is filled from `values`, one each; NULL, for want of memory, is
 * for the caller to see. Returns `values`. */
double *map_columns_add(struct api_map *map, const char *name, bool integer, double *values);

/* The same for a part of a column of the list, with zeros of its own. NULL without memory. */
double *map_columns_new(struct api_map *map, enum column_id id, int part, struct arena *arena);

/* Adds the numbers of the elements, and their properties and roles if there are some. */
void map_columns_ids(struct api_map *map, const struct map_target *target);

/* Adds a warning as long as there is room, printed into the map; or a text of the caller's. */
void map_warn(struct api_map *map, const char *format, ...) __attribute__((format(printf, 2, 3)));
void map_warn_text(struct api_map *map, const char *text);

#endif
