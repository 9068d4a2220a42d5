/* SPDX-License-Identifier: MIT */
#include "access.h"
#include <string.h>
#include <strings.h>

_Static_assert((int)REQUEST_CALLER_SIZE == (int)TOKENS_NAME_SIZE, "a caller is a token's name");

/* What stands behind "Bearer", or NULL. */
static const char *bearer(const struct request *request) {
    const char *text = request_header(request, "Authorization");
    if (!text || strncasecmp(text, "Bearer ", 7) != 0)
        return NULL;
    return text + 7 + strspn(text + 7, " ");
}

/* 403, always false. */
static bool refuse_role(struct reply *reply, enum tokens_role needed, bool link) {
    static const char *const names[] = {"read", "write", "admin"};
    reply_header(reply, "WWW-Authenticate",
                 "Bearer realm=\"draped\", error=\"insufficient_scope\", scope=\"%s\"",
                 names[needed]);
    reply_refuse(reply, API_FORBIDDEN, "%s: use a token of the role %s",
                 link ? "a link shows what it was made for and allows nothing else"
                      : "the token's role does not allow this",
                 names[needed]);
    return false;
}

bool access_allow(struct tokens *tokens, struct request *request, enum tokens_role needed,
                  bool links_show, struct reply *reply) {
    const char *token = bearer(request);
    struct tokens_holder holder;
    if (token && !strncmp(token, ACCESS_LINK, strlen(ACCESS_LINK))) {
        request->link = token;
        return links_show || refuse_role(reply, needed, true);
    }
    request->sees_all = !tokens;
    if (!tokens)
        return true;
    if (!token || !tokens_find(tokens, token, &holder)) {
        reply_header(reply, "WWW-Authenticate", "Bearer realm=\"draped\"%s",
                     token ? ", error=\"invalid_token\"" : "");
        reply_refuse(reply, API_UNAUTHORIZED,
                     token
                         ? "the token is unknown to this service"
                         : "the call needs a token: send the header 'Authorization: Bearer TOKEN'");
        return false;
    }
    memcpy(request->caller, holder.name, sizeof holder.name);
    memcpy(request->owner, holder.name, sizeof holder.name);
    request->sees_all = holder.role == TOKENS_ADMIN;
    return holder.role >= needed || refuse_role(reply, needed, false);
}

bool access_holds(struct tokens *tokens, const struct request *request) {
    struct tokens_holder holder;
    if (!tokens || request->link)
        return true;
    const char *token = bearer(request);
    return token && tokens_find(tokens, token, &holder) && !strcmp(holder.name, request->caller) &&
           (holder.role == TOKENS_ADMIN || !request->sees_all);
}

void access_mark(struct reply *reply) {
    if (!reply_has_header(reply, "Cache-Control"))
        reply_header(reply, "Cache-Control", "private");
    reply_header(reply, "Vary", "Authorization");
}
