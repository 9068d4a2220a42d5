/* SPDX-License-Identifier: MIT */
/* Content codings (RFC 9110, 8.4): compresses a reply's stream while it is sent. */
#ifndef SERVER_HTTP_COMPRESS_H
#define SERVER_HTTP_COMPRESS_H

#include "reply.h"
#include <stdbool.h>

enum pack_coding { PACK_IDENTITY, PACK_ZSTD, PACK_GZIP };

/* The coding that an Accept-Encoding header (NULL: none was sent) wants the most; among equals zstd
 * before gzip before none. */
enum pack_coding pack_choose(const char *accept_encoding);

/* As in Content-Encoding; "identity" for none. */
const char *pack_name(enum pack_coding coding);

/* Replaces the stream, which it takes over, by one of its compressed bytes: the same bytes for the
 * same content. Not for PACK_IDENTITY. False without memory, the stream left as it was. */
bool pack_stream(enum pack_coding coding, struct reply_stream *stream);

#endif
