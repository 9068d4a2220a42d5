/* SPDX-License-Identifier: MIT */
/*
 * A request whose surface is a file: {"surface": {"file": "PART.step", "unit": "mm", ...}}. The
 * file is read as the service would, CAD files by the importer beside this program, and the request
 * gets the surface's id in its place, with whatever selects faces of it. Of a study the same with
 * the surface of its drape.
 */
#ifndef CLI_PART_H
#define CLI_PART_H

#include "api/limits.h"
#include "api/problem.h"
#include "files.h"

/* Leaves a request alone whose surface is no file; else `surface` gets its definition, which
 * belongs to the caller. `name` is the request's own path, from whose folder the file's is; NULL:
 * from the working folder. False with the problem set, or with the reason reported already. */
bool part_resolve(struct files_bytes *request, const char *name, const struct api_limits *limits,
                  struct files_bytes *surface, struct api_problem *problem);

#endif
