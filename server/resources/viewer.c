/* SPDX-License-Identifier: MIT */
/* The page at `/` and its files, which the binary holds as they are and compressed with gzip. */
#include "handlers.h"
#include "server/http/compress.h"
#include "server/http/negotiate.h"
#include <stdio.h>
#include <string.h>

struct viewer_file {
    const char *name, *type;
    size_t offset, length;               /* as it is */
    size_t packed_offset, packed_length; /* with gzip */
};

#include "viewer_files.h"

/* The bytes of all files, from the assembler: a C array of a megabyte takes the compiler long. */
__asm__(".section .rodata\n"
        "viewer_bytes: .incbin \"" VIEWER_BINARY "\"\n"
        ".previous\n");
extern const char viewer_bytes[] __attribute__((visibility("hidden")));

enum { FILE_COUNT = sizeof viewer_files / sizeof *viewer_files };

/* Nothing but the page's own files, and calls to where it came from. */
static const char policy[] = "default-src 'none'; script-src 'self'; style-src 'self'; "
                             "img-src 'self'; connect-src 'self'; worker-src 'self'; "
                             "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

_Static_assert(sizeof policy <= REPLY_VALUE_SIZE, "a longer header would be left out");

static const struct viewer_file *find_file(const char *name) {
    for (size_t k = 0; k < FILE_COUNT; k++)
        if (!strcmp(viewer_files[k].name, name))
            return &viewer_files[k];
    return NULL;
}

/* The file in the coding that the caller takes, or 304 when it has it. */
static void reply_file(const struct request *request, const struct viewer_file *file,
                       const char *cache, struct reply *reply) {
    char etag[96];
    bool gzip = negotiate_coding(request_header(request, "Accept-Encoding"), "gzip") > 0;
    snprintf(etag, sizeof etag, "\"%s-%s%s\"", VIEWER_DIGEST, file->name, gzip ? "-gzip" : "");
    if (negotiate_etag_matches(request_header(request, "If-None-Match"), etag))
        reply_empty(reply, 304);
    else
        reply_literal(reply, 200, file->type,
                      viewer_bytes + (gzip ? file->packed_offset : file->offset),
                      gzip ? file->packed_length : file->length);
    if (gzip && reply->status == 200)
        reply_header(reply, "Content-Encoding", "%s", compress_name(COMPRESS_GZIP));
    reply_header(reply, "ETag", "%s", etag);
    reply_header(reply, "Vary", "Accept-Encoding");
    reply_header(reply, "Cache-Control", "%s", cache);
    reply_header(reply, "Content-Security-Policy", "%s", policy);
}

enum http_next viewer_page(struct call *call) {
    reply_file(call->request, find_file("index.html"), "no-cache", call->reply);
    reply_header(call->reply, "Cross-Origin-Opener-Policy", "same-origin");
    reply_header(call->reply, "Referrer-Policy", "no-referrer");
    return HTTP_DONE;
}

/* The address has the digest of all files in it: what is there never changes. */
enum http_next viewer_file(struct call *call) {
    const struct viewer_file *file = find_file(call->request->segments[2]);

    if (file && !strcmp(call->request->segments[1], VIEWER_DIGEST))
        reply_file(call->request, file, "public, max-age=31536000, immutable", call->reply);
    else
        reply_refuse(call->reply, API_NOT_FOUND,
                     "the page has no such file, or has another version: load / again");
    return HTTP_DONE;
}
