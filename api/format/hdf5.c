/* SPDX-License-Identifier: MIT */
#include "hdf5.h"

#include <hdf5.h>
#include <stdlib.h>
#include <string.h>

enum { INCREMENT = 1 << 16 }; /* bytes by which a file grows */

struct hdf5_file {
    hid_t file;
    bool failed;
};

struct hdf5_file *hdf5_new(void) {
    struct hdf5_file *file = calloc(1, sizeof *file);
    if (!file)
        return NULL;
    H5dont_atexit();
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL); /* a library prints nothing */
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    file->file = H5I_INVALID_HID;
    /* The name is for the driver alone; it looks for no such file, having no path to resolve. */
    if (access >= 0 && H5Pset_fapl_core(access, INCREMENT, false) >= 0)
        file->file = H5Fcreate("/draped.h5", H5F_ACC_TRUNC, H5P_DEFAULT, access);
    H5Pclose(access);
    if (file->file >= 0)
        return file;
    H5close();
    free(file);
    return NULL;
}

/* After a failure the library begins anew: an allocation that failed within it may have left it
 * unable to go on. */
void hdf5_free(struct hdf5_file *file) {
    if (!file)
        return;
    if (H5Fclose(file->file) < 0 || file->failed)
        H5close();
    free(file);
}

/* Keeps whether a call went well. */
static bool note_success(struct hdf5_file *file, bool well) {
    file->failed = file->failed || !well;
    return well;
}

/* Properties of an object that keeps no times. */
static hid_t without_times(hid_t kind) {
    hid_t properties = H5Pcreate(kind);
    if (properties >= 0)
        H5Pset_obj_track_times(properties, false);
    return properties;
}

void hdf5_group(struct hdf5_file *file, const char *name) {
    if (file->failed)
        return;
    hid_t properties = without_times(H5P_GROUP_CREATE);
    hid_t group = H5Gcreate2(file->file, name, H5P_DEFAULT, properties, H5P_DEFAULT);
    if (note_success(file, group >= 0))
        H5Gclose(group);
    H5Pclose(properties);
}

static void write_dataset(struct hdf5_file *file, const char *name, const hsize_t *sizes, int rank,
                          hid_t stored, hid_t given, const void *values) {
    if (file->failed)
        return;
    hid_t properties = without_times(H5P_DATASET_CREATE);
    hid_t space = H5Screate_simple(rank, sizes, NULL);
    hid_t set = H5Dcreate2(file->file, name, stored, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    if (note_success(file, set >= 0)) {
        note_success(file, H5Dwrite(set, given, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
        note_success(file, H5Dclose(set) >= 0);
    }
    H5Sclose(space);
    H5Pclose(properties);
}

void hdf5_reals(struct hdf5_file *file, const char *name, size_t rows, size_t columns,
                const double *values) {
    write_dataset(file, name, (const hsize_t[]){rows, columns}, columns ? 2 : 1, H5T_IEEE_F64LE,
                  H5T_NATIVE_DOUBLE, values);
}

void hdf5_integers(struct hdf5_file *file, const char *name, size_t rows, size_t columns,
                   const int64_t *values) {
    write_dataset(file, name, (const hsize_t[]){rows, columns}, columns ? 2 : 1, H5T_STD_I64LE,
                  H5T_NATIVE_INT64, values);
}

void hdf5_string(struct hdf5_file *file, const char *group, const char *name, const char *value) {
    if (file->failed)
        return;
    hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
    H5Tset_size(type, strlen(value) + 1);
    H5Tset_cset(type, H5T_CSET_UTF8);
    hid_t attribute = H5Acreate_by_name(file->file, group, name, type, space, H5P_DEFAULT,
                                        H5P_DEFAULT, H5P_DEFAULT);
    if (note_success(file, attribute >= 0)) {
        note_success(file, H5Awrite(attribute, type, value) >= 0);
        H5Aclose(attribute);
    }
    H5Sclose(space);
    H5Tclose(type);
}

/* The core driver's handle is where its memory begins. */
const char *hdf5_image(struct hdf5_file *file, size_t *length) {
    void *handle = NULL;
    if (file->failed || H5Fflush(file->file, H5F_SCOPE_GLOBAL) < 0 ||
        H5Fget_vfd_handle(file->file, H5P_DEFAULT, &handle) < 0)
        return NULL;
    ssize_t size = H5Fget_file_image(file->file, NULL, 0); /* without what it may still grow by */
    if (size <= 0)
        return NULL;
    *length = (size_t)size;
    return *(char *const *)handle;
}
