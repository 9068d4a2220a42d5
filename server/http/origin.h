/* SPDX-License-Identifier: MIT */
/*
 * What web pages may do through their readers' browsers. A page of another origin can make a
 * browser send requests to a daemon on loopback or in an inner network; and one whose own name is
 * made to resolve to the daemon's address (DNS rebinding) is of the same origin to the browser. So
 * a request must name a host that the daemon has (`Host`), and one that changes something must not
 * come from a page of another origin (`Origin`, `Sec-Fetch-Site`), unless --cors-origin names it.
 * Programs other than browsers send neither and are not concerned.
 */
#ifndef SERVER_HTTP_ORIGIN_H
#define SERVER_HTTP_ORIGIN_H

#include "reply.h"
#include "request.h"
#include "server/config.h"

/* Whether the text is "*" or a list, split by commas, of names as --public-name takes them, or of
 * origins as --cors-origin does: scheme://HOST or scheme://HOST:PORT as browsers send them, without
 * a path; none of them with a "*", which would match nothing. */
bool origin_are_hosts(const char *list, bool origins);

/* Whether the request names this daemon: `localhost`, an address of loopback, the one of --listen
 * (any address where that is 0.0.0.0 or [::]), or a name of --public-name; any port. A request of
 * HTTP/1.0 may name none. False: the reply is 403. */
bool origin_allows_host(const struct config *config, const struct request *request,
                        struct reply *reply);

/* Whether the request may change something: it does not come from a web page, or from one of this
 * daemon's own or of --cors-origin. False: the reply is 403. */
bool origin_allows_change(const struct config *config, const struct request *request,
                          struct reply *reply);

/* Lets a browser show the answer to the page that asked, if --cors-origin names its origin; and,
 * when it asks beforehand, lists what it may send. */
void origin_share(const struct config *config, const struct request *request, struct reply *reply);

#endif
