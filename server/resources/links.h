/* SPDX-License-Identifier: MIT */
/*
 * Links: what an owner shows to whom has no token of theirs, and for how long. Who has the token of
 * a link reads the jobs that it was made for, the drapes of laminates among them and the surfaces
 * they name, may map these drapes on a mesh, and does nothing else. Of the token the store has the
 * hash alone, which is the link's id: deleting the link takes back what it shows.
 */
#ifndef SERVER_RESOURCES_LINKS_H
#define SERVER_RESOURCES_LINKS_H

#include "call.h"

/* Whether the request's link shows what its path names by {id}: then the caller sees that. False:
 * the reply is 401 for a link that is not or no longer there, 404 for what it does not show. */
bool links_admit(struct call *call);

/* Whether the link of the token still holds, or cannot be looked at now. */
bool links_hold(struct store *store, const char *token);

#endif
