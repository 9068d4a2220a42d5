/* SPDX-License-Identifier: MIT */
/* The checks that handlers begin and wait for: what a caller sent is never read on a thread of the
 * front. */
#ifndef SERVER_RESOURCES_CHECKING_H
#define SERVER_RESOURCES_CHECKING_H

#include "call.h"
#include "server/work/document_pool.h"

/* The order to check the call's body; the caller may add to it. */
struct document_pool_order checking_order(const struct call *call, enum checker_kind kind);

/* Has the order take the result of the call's job along, which then belongs to the check; without a
 * check its `columns.context` has to be freed. With `request` also the job's own, as the second
 * document, to be freed when the check has begun. False: the reply says why there is none. (maps.c)
 */
bool maps_take_columns(struct call *call, struct document_pool_order *order, char **request);

/* Begins the check of an order that has its columns, with the call's query for options, and frees
 * `record` and, without a check, the columns' context. False: the reply says why there is none.
 * (maps.c) */
bool maps_begin(struct call *call, struct document_pool_order *order, char *record);

/* Likewise of an order about a variant of the call's study, which is taken along. (studies.c) */
bool studies_begin(struct call *call, struct document_pool_order *order, size_t variant);

/* The number of the variant of `?sample=`. False: the reply says what is wrong with it.
 * (studies.c) */
bool studies_read_sample(struct call *call, size_t *sample);

/* The answer of such a call, whose check writes a document of that format: 200, or with an entity
 * tag 206 for a part; its headers about caches are then the caller's. (maps.c) */
enum http_next maps_answer(struct call *call, const struct format *format, const char *etag);

/* Begins the check and watches for its end. NULL: the reply says why not. */
struct check *checking_begin(struct call *call, const struct document_pool_order *order);

/* The same, and keeps it as the `state` of the request, which ends it. */
bool checking_keep(struct call *call, const struct document_pool_order *order);

/* How far a check is. */
enum checking_state {
    CHECKING_WAIT,    /* return HTTP_WAIT; the call is resumed at its end */
    CHECKING_REFUSED, /* it ended with a problem, or the service stops: the reply says so */
    CHECKING_PASSED
};

enum checking_state checking_look(struct call *call, struct check *check);

/* `length` bytes of its output from `offset` on, malloc'ed and zero-terminated; NULL without
 * memory.
 */
char *checking_text(struct check *check, uint64_t offset, uint64_t length);

/* The answer of a call whose check is its request's `state`: HTTP_WAIT until that is done; when it
 * has passed, `passed` makes the reply. */
enum http_next checking_answer(struct call *call,
                               void (*passed)(struct call *call, struct check *check));

/* As `passed`: all that the check has written, as JSON. */
void checking_reply_json(struct call *call, struct check *check);

#endif
