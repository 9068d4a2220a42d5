/* SPDX-License-Identifier: MIT */
/*
 * An HDF5 file made in memory, by libhdf5's core driver: nothing is read or written elsewhere, so a
 * process without files can make one. The same contents give the same bytes; no times are kept.
 *
 * A failed call (out of memory, as a rule) fails all that follow: one question at the end is
 * enough.
 */
#ifndef API_FORMAT_HDF5_H
#define API_FORMAT_HDF5_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct hdf5_file;

/* An empty file; NULL without memory. */
struct hdf5_file *hdf5_new(void);
void hdf5_free(struct hdf5_file *file); /* NULL is allowed */

/* A group below the root, "/" being there from the start. */
void hdf5_group(struct hdf5_file *file, const char *name);

/* A dataset of little-endian numbers: `rows` of them, or `rows` times `columns`, the last running
 * fastest; `columns` 0: one dimension. `name` is its path. */
void hdf5_reals(struct hdf5_file *file, const char *name, size_t rows, size_t columns,
                const double *values);
void hdf5_integers(struct hdf5_file *file, const char *name, size_t rows, size_t columns,
                   const int64_t *values);

/* A string as an attribute of a group: of fixed length, UTF-8. */
void hdf5_string(struct hdf5_file *file, const char *group, const char *name, const char *value);

/* The file as it would be on a disk, which lives as long as `file`; NULL when a call has failed. */
const char *hdf5_image(struct hdf5_file *file, size_t *length);

#endif
