/* SPDX-License-Identifier: MIT */
/*
 * Checks the bytes of an HTTP/1 connection, one after the other, before the library that interprets
 * them sees them: request lines, header fields, chunks and trailers as RFC 9112 has them, and how
 * long each message is. Whatever two implementations could read in two ways is malformed; so the
 * library never has to decide, and a proxy in front that reads what this accepts reads the same
 * messages.
 *
 * Stricter than the RFC asks of a recipient, which may but need not be lenient: lines end with CR
 * LF; no folded lines; no blanks before a colon, behind a length or coding, or in a chunk's line;
 * one Content-Length; no transfer coding but `chunked`, not with Content-Length and not in
 * HTTP/1.0; no fragment, no user and no query without a path in a target; no framing fields in
 * trailers.
 *
 * A pure function of the bytes: no memory but the struct, no I/O. The result does not depend on how
 * the bytes are split into calls.
 */
#ifndef SERVER_HTTP_WIRE_H
#define SERVER_HTTP_WIRE_H

#include "api/problem.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The most of what a message may have besides its body. */
enum {
    WIRE_HEAD_BYTES = 32 * 1024,      /* request line and headers: beyond it 414 or 431 */
    WIRE_FIELDS_MAX = 100,            /* headers; beyond it 431 */
    WIRE_EMPTY_LINES_MAX = 64,        /* before a request line */
    WIRE_CHUNK_LINE_BYTES = 4096,     /* size and extensions of one chunk */
    WIRE_EXTENSION_BYTES = 16 * 1024, /* extensions of all chunks of a message */
    WIRE_TRAILER_BYTES = 8 * 1024,    /* beyond it 431 */
    WIRE_TEXT_SIZE = 320              /* the longest Host or authority, with some room */
};

/* A connection. Plain memory; only `messages`, `closing`, `problem` and `detail` are for callers.
 */
struct wire {
    unsigned char state, field; /* what is being read */
    unsigned char seen;         /* which of the known fields the head has, a bit each */
    bool options, asterisk, http_1_0, chunked, close_token, keep_token;
    bool text_cut;               /* `text` is longer than its memory */
    unsigned short text_length;  /* of what is being read, as far as it matters */
    unsigned short fields;       /* of the head or the trailers; empty lines before the head */
    uint32_t head, line;         /* bytes of the head or the trailers; of a chunk's line */
    uint32_t extensions;         /* bytes of those of all chunks */
    uint64_t left;               /* bytes of the body or of the chunk */
    bool closing;                /* the last head asks for the end of the connection */
    uint64_t messages;           /* that were complete */
    enum api_problem_id problem; /* API_OK, or what is wrong with message number `messages` */
    const char *detail;          /* a sentence about it, constant */
    char text[WIRE_TEXT_SIZE];
};

void wire_init(struct wire *wire);

/* Checks the next bytes. Returns how many of them are good: all, or those before the first that is
 * not; then `problem` is set, and every later call returns 0. `*begun`, unless NULL, is where the
 * message that comes last begins: the position in `bytes`, 0 when it began before them. */
size_t wire_check(struct wire *wire, const char *bytes, size_t length, size_t *begun);

/* Whether the bytes so far end between two messages. */
bool wire_between(const struct wire *wire);

/* Whether a text is `uri-host [ ":" port ]` (RFC 9110, 7.2): a name, an IPv4 address or an address
 * in brackets. The empty text is none. */
bool wire_is_authority(const char *text, size_t length);

/* Of a hexadecimal digit; -1 for another character. */
int wire_hex_value(unsigned char c);

#endif
