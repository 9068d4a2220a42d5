/* SPDX-License-Identifier: MIT */
/*
 * The checker process: reads what callers sent (requests, surfaces, meshes), so that no thread of
 * the daemon does. It is the same binary (`child.h`), with CHECKER_ARGUMENT, locked in
 * (`sandbox.h`), and talks to its pool (`document_pool.h`) over a socket of packets: one order, one
 * answer. Short documents lie in the packet, long ones in sealed memory files that come with it;
 * what it writes goes to a file that came with the order, too. Both ends are the same binary on the
 * same machine, so a packet is the struct itself; but the checker is where hostile input is read,
 * so the pool believes an answer no further than `checker_answer_sound` goes.
 */
#ifndef SERVER_WORK_CHECKER_H
#define SERVER_WORK_CHECKER_H

#include "api/check.h"
#include "api/limits.h"
#include "api/problem.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define CHECKER_ARGUMENT "checker"

enum {
    CHECKER_INLINE_MAX = 32 * 1024, /* bytes of all documents in one packet */
    CHECKER_OPTION_SIZE = 16,
    CHECKER_NOTE_SIZE = 320
};

/* What is to be done with the documents. */
enum checker_kind {
    CHECKER_DRAPE,      /* `api_check_drape` of the body, with the surface and the materials */
    CHECKER_STUDY,      /* `api_check_study` likewise */
    CHECKER_LAMINATE,   /* `laminate_check` likewise */
    CHECKER_STACK,      /* `laminate_map_record` on the mesh of the body: the record as the second
                           document, the results as columns */
    CHECKER_PATTERNS,   /* `laminate_pattern_record` likewise, without a mesh */
    CHECKER_VARIANT,    /* the request of a variant of a study, with its surface and its result as
                           columns */
    CHECKER_SAMPLE,     /* the result of that request in the format */
    CHECKER_SAMPLE_MAP, /* and the fields of that result on the mesh of the body */
    CHECKER_SURFACE,    /* `api_check_surface` of the body */
    CHECKER_MATERIAL,   /* `api_check_material` of the body */
    CHECKER_NORMALISE,  /* `api_check_normalise` of the body */
    CHECKER_UNDERSTOOD, /* `api_study_normalise` of the body */
    CHECKER_PREVIEW,    /* `api_check_preview` of the body */
    CHECKER_REPORT, /* the result in the columns as a report, with the request of the body as it was
                       understood; the second document: its digest and when it was finished,
                       zero-terminated */
    CHECKER_MAP,    /* the fields of the columns on the mesh of the body: `api/map/map.h` */
    CHECKER_KINDS
};

/* The documents of an order, in this order in the packet or as files beside it. */
enum checker_document {
    CHECKER_BODY,
    CHECKER_SECOND,    /* the stored surface; of CHECKER_MAP the request of the drape */
    CHECKER_COLUMNS,   /* the container of the job's result, always a file */
    CHECKER_OPTIONS,   /* of a map, sample or report: of each option its name and its value,
                        * zero-terminated
                        */
    CHECKER_REQUEST,   /* of a variant: the study */
    CHECKER_MATERIALS, /* the owner's that a request names, a line each; empty: the store was not
                          asked for any yet */
    CHECKER_FORM,      /* the prepared form of the stored surface, always a file; empty: none */
    CHECKER_DOCUMENTS
};

/* The files of an order: its documents, and those that it writes to. */
enum checker_file {
    CHECKER_OUTPUT = CHECKER_DOCUMENTS,
    CHECKER_FORM_OUTPUT, /* the prepared form that the check makes */
    CHECKER_FILES
};

/* The head of an order's packet; the inline documents follow it. The files come in the order of
 * `enum checker_file`. */
struct checker_order {
    uint32_t kind;
    uint32_t files; /* bit k: there is file k */
    uint64_t length[CHECKER_DOCUMENTS];
    struct api_limits limits;
    int64_t deadline_ms; /* by `clock_ms`: when the pool gives up */
    bool has_start;      /* of CHECKER_NORMALISE */
    struct api_start start;
    /* of CHECKER_SURFACE: what file the body is, "" for JSON, and the unit of one that says none */
    char source[CHECKER_OPTION_SIZE], unit[CHECKER_OPTION_SIZE];
    uint64_t variant;               /* of a study; of CHECKER_STACK the number of plies, of
                                       CHECKER_PATTERNS 0 for all of them or else that of one from 1 */
    char mesh[CHECKER_OPTION_SIZE]; /* of maps: the format of the body, "" for JSON */
    /* of maps, samples and reports */
    char id[API_ID_SIZE];
    char format[CHECKER_OPTION_SIZE];
};

/* The first packet of a process, once it is locked in. */
struct checker_hello {
    uint64_t address_space; /* bytes it has without any order */
};

struct checker_answer {
    struct api_check check;
    uint64_t output_length;       /* bytes written */
    int64_t processor_us;         /* time of a processor that it took */
    char note[CHECKER_NOTE_SIZE]; /* of a map: the header `Draped-Binning`; "": none */
    struct api_problem problem;
};

/* Whether an answer of `length` bytes is one: terminated strings, a known problem. Clears what was
 * not sent. */
bool checker_answer_sound(struct checker_answer *answer, size_t length);

/* What a process has that not every one has; NULL where it has not. */
struct checker_abilities {
    /* For tests, called with the body of each order before it is carried out. */
    void (*before)(const char *body, size_t length);
    /* The importer's: a CAD file as the JSON of a surface, malloc'ed; else NULL with a sentence in
     * `why`. */
    char *(*import)(const char *body, size_t length, const char *format, const char *unit,
                    size_t *text_length, char why[API_DETAIL_MAX]);
};

/* The process: serves orders on WORKER_FD until its other end closes. Returns the exit status. */
int checker_serve(const struct checker_abilities *abilities);

/* The same without tests: what `draped checker` does. */
int checker_main(void);

#endif
