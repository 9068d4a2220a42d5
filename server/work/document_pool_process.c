/* SPDX-License-Identifier: MIT */
#include "document_pool_parts.h"

#include "sandbox.h"
#include "server/log.h"
#include <errno.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

enum { SLOW_NICENESS = 10 }; /* of a process in the slow lane, above ours */

static void bound(const struct check_place *place, int resource, uint64_t value) {
    if (!sandbox_bound(place->child.pid, resource, value))
        log_warning(log_event("checker_not_bounded"), log_text("detail", strerror(errno)));
}

bool document_pool_can_import(void) {
    char importer[CHILD_PATH_SIZE];
    child_beside(DOCUMENT_POOL_IMPORTER, importer);
    return access(importer, X_OK) == 0;
}

bool place_start(struct document_pool *pool, struct check_place *place, bool imports) {
    struct checker_hello hello;
    char importer[CHILD_PATH_SIZE];
    if (child_running(&place->child) && place->imports == imports)
        return true;
    child_kill(&place->child);
    child_beside(DOCUMENT_POOL_IMPORTER, importer);
    if (!child_start(&place->child, imports ? importer : NULL, CHECKER_ARGUMENT, SOCK_SEQPACKET))
        return false;
    place->imports = imports;
    place->limit = 0;
    place->slow = false;
    if (recv(place->child.socket, &hello, sizeof hello, 0) != (ssize_t)sizeof hello) {
        child_kill(&place->child);
        return false;
    }
    place->base = hello.address_space;
    bound(place, RLIMIT_FSIZE, (uint64_t)pool->settings.max_output);
    return true;
}

void place_bound(struct check *check) {
    struct check_place *place = check->place;
    uint64_t mapped = 0;
    for (int k = 0; k < CHECKER_DOCUMENTS; k++)
        mapped += check->files[k] >= 0 ? check->packet.length[k] : 0;
    uint64_t limit = place->base + (uint64_t)check->reserve + mapped;
    if (place->limit == limit)
        return;
    place->limit = limit;
    bound(place, RLIMIT_AS, limit);
}

void place_end(struct check_place *place, bool crashed) {
    char why[CHILD_WHY_SIZE];
    if (crashed) {
        child_reap(&place->child, why);
        log_warning(log_event("checker_crashed"), log_text("why", why),
                    log_text("program", place->imports ? DOCUMENT_POOL_IMPORTER : "draped"));
    } else {
        child_kill(&place->child);
    }
}

void place_lower(struct check_place *place) {
    if (!place->slow)
        child_lower(&place->child, SLOW_NICENESS);
    place->slow = true;
}
