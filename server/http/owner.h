/* SPDX-License-Identifier: MIT */
/*
 * Whose a request is: the owner that its work, its connections and what it stores are counted for.
 * A caller with a token is the owner of the token's name. Callers without are told apart by their
 * address: one owner for each address of IPv4, one for each network of 64 bits of IPv6, which is
 * what a single customer gets at the least. Such a name begins with "@", which no token's may.
 *
 * Behind a proxy all connections come from the proxy, which says for whom in Forwarded (RFC 7239)
 * or X-Forwarded-For. Anybody can send these, so they count only from the addresses that the
 * configuration names, and of the list in them only what such proxies have added themselves: the
 * last address that is not a trusted proxy.
 */
#ifndef SERVER_HTTP_OWNER_H
#define SERVER_HTTP_OWNER_H

#include "request.h"
#include <stdbool.h>
#include <sys/socket.h>

/* The owner by address. Of a socket that has none "@". */
void owner_of_address(const struct sockaddr *address, char name[REQUEST_CALLER_SIZE]);

/* The owner of a request without a token that came from that peer, by its headers if the peer is
 * in `trusted`, a list of addresses split by commas. What no address can be read from is the
 * peer's. */
void owner_of_request(const char *trusted, const struct sockaddr *peer,
                      const struct request *request, char name[REQUEST_CALLER_SIZE]);

/* Whether the peer is in that list. */
bool owner_trusts(const char *trusted, const struct sockaddr *peer);

/* Whether the peer is on this machine and the request is its own: no proxy says otherwise. */
bool owner_is_local(const struct sockaddr *peer, const struct request *request);

/* Whether the text is a list of addresses split by commas; "" is an empty one. */
bool owner_are_addresses(const char *list);

#endif
