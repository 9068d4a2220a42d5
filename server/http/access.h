/* SPDX-License-Identifier: MIT */
/* Authorisation: the check of a request's token (RFC 6750). */
#ifndef SERVER_HTTP_ACCESS_H
#define SERVER_HTTP_ACCESS_H

#include "reply.h"
#include "request.h"
#include "tokens.h"

/* The token of a link begins so; what it shows is looked at in the store (resources/links.h). */
#define ACCESS_LINK "draped-link-"

/* Sets the caller of the request, which needs the role, and its owner if that has a token; or, if
 * links may show what it is for, the `link` of one that has a link's. False: the reply is 401 or
 * 403. Without tokens (NULL) every request is allowed, and its caller is "", but one with a link's
 * gets no more than elsewhere. */
bool access_allow(struct tokens *tokens, struct request *request, enum tokens_role needed,
                  bool links_show, struct reply *reply);

/* Whether the token of a request that was allowed still allows what it did then: not once it has
 * been revoked, or has lost the role by which it sees what others own. For answers that last. A
 * link's is not looked at. */
bool access_holds(struct tokens *tokens, const struct request *request);

/* Tells caches on the way that the answer is for this caller alone. */
void access_mark(struct reply *reply);

#endif
