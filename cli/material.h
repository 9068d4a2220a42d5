/* SPDX-License-Identifier: MIT */
/* Materials in files, `--material FILE`, which a request names as it does those of the library. */
#ifndef CLI_MATERIAL_H
#define CLI_MATERIAL_H

#include "api/limits.h"
#include "api/problem.h"
#include "files.h"

enum { MATERIAL_FILES_MAX = 64 };

struct material_files {
    const char *path[MATERIAL_FILES_MAX];
    int count;
};

/* Puts the materials into the request that it names; of two files with one name the first. False
 * with the problem set, or with the reason reported already. */
bool material_resolve(struct files_bytes *request, const struct material_files *files,
                      const struct api_limits *limits, struct api_problem *problem);

#endif
