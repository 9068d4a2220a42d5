/* SPDX-License-Identifier: MIT */
/* What a client accepts and prefers: readers of the headers Accept, Prefer and If-None-Match. */
#ifndef SERVER_HTTP_NEGOTIATE_H
#define SERVER_HTTP_NEGOTIATE_H

#include <stdbool.h>
#include <stdint.h>

/* How much an Accept header (RFC 9110, 12.5.1) wants `media_type`, in thousandths: 0 not at all,
 * 1000 the most. The most specific range that matches decides. NULL or blank accepts all. */
int negotiate_quality(const char *accept, const char *media_type);

/* How much an Accept-Encoding header (RFC 9110, 12.5.3) wants a coding, in thousandths. What it
 * does not mention, by name or by `*`, it does not want; that no coding at all is acceptable even
 * so is the caller's to know. NULL wants none. */
int negotiate_coding(const char *accept_encoding, const char *coding);

/* The seconds of `wait=N` (or `wait = "N"`) in a Prefer header (RFC 7240), at most `high`; 0
 * without one that can be read, because a preference may be ignored. */
int64_t negotiate_wait(const char *prefer, int64_t high);

/* Whether an If-None-Match header names the entity tag (with its quotes), or is "*". */
bool negotiate_etag_matches(const char *if_none_match, const char *etag);

/* Whether a Content-Type is this one, with any parameters. */
bool negotiate_is_type(const char *content_type, const char *type);

/* A part of a body of `length` bytes. */
struct negotiate_range {
    uint64_t first, last; /* both within */
};

enum negotiate_part {
    NEGOTIATE_ALL,  /* no range, several, or none that can be read: all of it */
    NEGOTIATE_SOME, /* one range */
    NEGOTIATE_NONE  /* it begins beyond the end */
};

/* What a Range header (RFC 9110, 14.2) wants. NULL wants all. */
enum negotiate_part negotiate_range(const char *range, uint64_t length,
                                    struct negotiate_range *out);

/* Whether a Content-Type is JSON: application/json or anything +json, in UTF-8. */
bool negotiate_is_json(const char *content_type);

#endif
