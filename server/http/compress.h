/* SPDX-License-Identifier: MIT */
/* Content codings (RFC 9110, 8.4): compresses a reply's stream while it is sent. */
#ifndef SERVER_HTTP_COMPRESS_H
#define SERVER_HTTP_COMPRESS_H

#include "reply.h"
#include <stdbool.h>

enum compress_coding { COMPRESS_IDENTITY, COMPRESS_ZSTD, COMPRESS_GZIP };

/* The coding that an Accept-Encoding header (NULL: none was sent) wants the most; among equals zstd
 * before gzip before none. */
enum compress_coding compress_choose(const char *accept_encoding);

/* As in Content-Encoding; "identity" for none. */
const char *compress_name(enum compress_coding coding);

/* Replaces the stream, which it takes over, by one of its compressed bytes: the same bytes for the
 * same content. Not for COMPRESS_IDENTITY. False without memory, the stream left as it was. */
bool compress_stream(enum compress_coding coding, struct reply_stream *stream);

#endif
