/* SPDX-License-Identifier: MIT */
#include "interpose.h"
#include <dlfcn.h>
#include <errno.h>
#include <microhttpd.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/socket.h>

typedef enum MHD_Result queue_function(struct MHD_Connection *connection, unsigned status,
                                       struct MHD_Response *response);
typedef ssize_t recv_function(int socket, void *buffer, size_t size, int flags);
typedef int control_function(int epoll, int operation, int file, struct epoll_event *event);

static struct interpose_hooks hooks;
static queue_function *queue_response; /* the library's */

/* Contexts by descriptor; NULL: not watched. */
struct watched {
    size_t count;
    _Atomic(void *) contexts[];
};

/* Published when it is whole: threads that are none of the front's call recv from the start. */
static _Atomic(struct watched *) watched;

bool interpose_init(const struct interpose_hooks *given, size_t descriptors) {
    struct watched *made = calloc(1, sizeof *made + descriptors * sizeof *made->contexts);
    *(void **)&queue_response = dlsym(RTLD_NEXT, "MHD_queue_response");
    if (!made || !queue_response) {
        free(made);
        return false;
    }
    hooks = *given;
    made->count = descriptors;
    atomic_store_explicit(&watched, made, memory_order_release);
    return true;
}

/* The function of that name that this program's stands before. Any thread of the process calls, at
 * any time, other libraries as well: it is looked up at the first call. */
static void *find_next(_Atomic(void *) *found, const char *name) {
    void *next = atomic_load_explicit(found, memory_order_relaxed);
    if (!next) {
        next = dlsym(RTLD_NEXT, name);
        if (!next)
            abort();
        atomic_store_explicit(found, next, memory_order_relaxed);
    }
    return next;
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

/* Where the context of a socket is; NULL for a descriptor that is too large. */
static _Atomic(void *) *context_of(int socket) {
    struct watched *all = atomic_load_explicit(&watched, memory_order_acquire);
    return all && socket >= 0 && (size_t)socket < all->count ? &all->contexts[socket] : NULL;
}

bool interpose_watch(int socket, void *context) {
    _Atomic(void *) *slot = context_of(socket);
    if (slot)
        atomic_store_explicit(slot, context, memory_order_relaxed);
    return slot != NULL;
}

ssize_t recv(int socket, void *buffer, size_t size, int flags) {
    static _Atomic(void *) library;
    recv_function *receive;
    *(void **)&receive = find_next(&library, "recv");
    ssize_t got = receive(socket, buffer, size, flags);
    _Atomic(void *) *slot = got > 0 ? context_of(socket) : NULL;
    void *context = slot ? atomic_load_explicit(slot, memory_order_relaxed) : NULL;
    return context ? hooks.received(context, buffer, (size_t)got) : got;
}

/* ------------------------------------------------------------------ what is waited for */

int epoll_ctl(int epoll, int operation, int file, struct epoll_event *event) {
    static _Atomic(void *) library;
    control_function *control;
    *(void **)&control = find_next(&library, "epoll_ctl");
    int before = errno, code = control(epoll, operation, file, event);
    if (code == 0 || operation != EPOLL_CTL_DEL || errno != ENOENT)
        return code;
    errno = before;
    return 0;
}
