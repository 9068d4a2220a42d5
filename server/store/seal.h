/* SPDX-License-Identifier: MIT */
/*
 * The checksum that is stored beside each thing, in a column of its own, and looked at whenever the
 * thing is read. It is also of what the thing belongs to, so that one in the place of another is
 * seen. What differs from what was written is not handed out: STORE_ALTERED.
 */
#ifndef SERVER_STORE_SEAL_H
#define SERVER_STORE_SEAL_H

#include "store.h"

/* Of a chunk of the result that the job of that sequence wrote under that token: also of its place
 * among the chunks and of whether it is the last one, and with that of the result's length. */
struct seal_chunk {
    int64_t job, token, index;
    bool last;
};
int64_t seal_of_chunk(const struct seal_chunk *chunk, const void *bytes, size_t length);

/* Of the request of a job. */
int64_t seal_of_request(const char *id, const void *bytes, size_t length);

/* Of the numbers that a task of the study gave. */
int64_t seal_of_numbers(const char *study, const void *bytes, size_t length);

/* Of a surface or a material, without its prepared form, which has its own. */
int64_t seal_of_item(const struct store_item *item);

/* Of a summary or an error, which go from job to job. */
int64_t seal_of_text(const char *text);

#endif
