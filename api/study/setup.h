/* SPDX-License-Identifier: MIT */
/* A study made ready: what all of its variants share. It is not changed once it is opened. */
#ifndef API_STUDY_SETUP_H
#define API_STUDY_SETUP_H

#include "part.h"
#include "proposal.h"
#include "request.h"
#include "study.h"

/* A start of a grid, or of a list. */
struct study_start {
    struct part_point point;
    enum failure failure; /* why it cannot be draped from; FAILURE_NONE: it can */
};

/* Between k1 of a shear and unsheared. */
struct study_k1_ratio {
    double ratio; /* at least 1 */
    int bin;      /* of the shear */
};

struct api_study {
    struct arena *arena; /* that holds all of it */
    struct study_request request;
    struct study_part part;
    struct study_k1_ratio *k1; /* of all bins, by rising ratio; NULL: not judged */
    const struct vec3 *middle; /* of the divisions of the part (`struct drape_statistics`) */
    size_t divisions;          /* 0: the rows say nothing of them */
    struct study_start *starts;
    size_t start_count;            /* 1 where the drape's own is kept, which is not in `starts` */
    struct study_variant *obvious; /* that a search begins with */
    size_t obvious_count;
    struct sample_nominal *nominal; /* of a study that draws samples, else NULL */
    struct proposal_edge edge;      /* of the part, where cuts are proposed */
    size_t field_numbers; /* that each of its rows has behind it: cells times fields; else 0 */
};

#endif
