/* SPDX-License-Identifier: MIT */
/*
 * The prepared form of a surface: what it was decoded to, and what follows from its faces for every
 * drape (spans, regions, areas, joints, the mesh by which a tube is cut open), made once and kept
 * as bytes. Who has the form need not read the definition, nor make anything of it.
 *
 * A form is of one source, a document that it is known by: the definition of a stored surface,
 * whose id is its digest, or a request with a surface of its own, which is then decoded as a whole.
 * It has what one choice of faces and one offset make, and of a stored surface all faces, so that
 * another choice has only to be joined.
 *
 * Bytes are never trusted to be a form: of another source, by another version or build of the
 * program, or with a bit that has changed they are none, and what they would have had is made anew.
 * (Whoever can write the checksum, too, is only kept from this: pointers out of the form. What
 * opens forms is as much shut in as what reads definitions.)
 */
#ifndef API_REQUEST_PREPARED_FORM_H
#define API_REQUEST_PREPARED_FORM_H

#include "api/input.h"
#include "api/sink.h"
#include "prepared_part.h"

/* The first bytes of a form, a digest made with it, which tell it from any other. */
enum { PREPARED_FORM_KEY = 32 };

/* Longer forms are not made: what they save is little against what they take of memory. */
#define PREPARED_FORM_MOST ((size_t)64 << 20)

struct prepared_form {
    struct api_request request; /* of a stored surface only `surface` and `offset` mean something */
    struct prepared_part part;  /* of the faces that are chosen there, moved by the offset */
    int unit[2];                /* of the request and of its surface, in `api_units`; -1: none */
    char source[API_ID_SIZE];
};

/* A form in `arena` of a surface that was decoded there, with all that its faces give. NULL without
 * memory. Its `source` is "", and what keeps the faces from being one surface no fault here. */
const struct prepared_form *prepared_form_make(const struct api_surface *surface,
                                               struct arena *arena);

/* Writes the form of a request whose part has been made in `arena`, an arena that `arena_clear` was
 * called for before it held anything. `source` is the digest of the document (`api_digest_bytes`).
 * Returns how many bytes; 0 where there is none, without memory or because it would be too long. */
size_t prepared_form_write(const struct api_request *request, const struct prepared_part *part,
                           const char source[API_ID_SIZE], struct arena *arena,
                           const struct api_sink *sink);

/* Whether the bytes are a form of that source, or with NULL of any, by this very program. */
bool prepared_form_sound(const void *bytes, size_t length, const char source[API_ID_SIZE]);

/* The form, in `arena`; the bytes are copied. NULL where they are not sound, or without memory.
 * `source` as above. */
const struct prepared_form *prepared_form_open(const void *bytes, size_t length,
                                               const char source[API_ID_SIZE], struct arena *arena);

/* The form that came with the input, if it is of that source. */
const struct prepared_form *prepared_form_find(const struct api_input *input,
                                               const char source[API_ID_SIZE], struct arena *arena);

/* The part of the request's form, if it is of the faces that the request chooses and of its offset;
 * else NULL. */
const struct prepared_part *prepared_form_part(const struct api_request *request);

#endif
