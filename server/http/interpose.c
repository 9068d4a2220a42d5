/* SPDX-License-Identifier: MIT */
#include "interpose.h"
#include <dlfcn.h>
#include <errno.h>
#include <microhttpd.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/socket.h>

typedef enum MHD_Result queue_function(struct MHD_Connection *connection, unsigned status,
                                       struct MHD_Response *response);
typedef ssize_t recv_function(int socket, void *buffer, size_t size, int flags);

static struct interpose_hooks hooks;
static queue_function *queue_response; /* the library's */
static _Atomic(recv_function *) receive;
static _Atomic(void *) *contexts; /* by descriptor; NULL: not watched */
static size_t context_count;

bool interpose_init(const struct interpose_hooks *given, size_t descriptors) {
    hooks = *given;
    context_count = descriptors;
    contexts = calloc(descriptors, sizeof *contexts);
    *(void **)&queue_response = dlsym(RTLD_NEXT, "MHD_queue_response");
    return contexts && queue_response;
}

/* ------------------------------------------------------------------ replies */

bool interpose_queue(struct MHD_Connection *connection, unsigned status,
                     struct MHD_Response *response) {
    return queue_response(connection, status, response) == MHD_YES;
}

enum MHD_Result MHD_queue_response(struct MHD_Connection *connection, unsigned status,
                                   struct MHD_Response *response) {
    hooks.page(connection, status);
    return queue_response(connection, status, response);
}

/* ------------------------------------------------------------------ what is read */

bool interpose_watch(int socket, void *context) {
    bool fits = socket >= 0 && (size_t)socket < context_count;
    if (fits)
        atomic_store_explicit(&contexts[socket], context, memory_order_relaxed);
    return fits;
}

/* Any thread of the process, at any time, other libraries as well: looked up at the first call. */
static recv_function *find_receive(void) {
    recv_function *found = atomic_load_explicit(&receive, memory_order_relaxed);
    if (!found) {
        *(void **)&found = dlsym(RTLD_NEXT, "recv");
        if (!found)
            abort();
        atomic_store_explicit(&receive, found, memory_order_relaxed);
    }
    return found;
}

ssize_t recv(int socket, void *buffer, size_t size, int flags) {
    ssize_t got = find_receive()(socket, buffer, size, flags);
    if (got <= 0 || (size_t)socket >= context_count)
        return got;
    void *context = atomic_load_explicit(&contexts[socket], memory_order_relaxed);
    return context ? hooks.received(context, buffer, (size_t)got) : got;
}
