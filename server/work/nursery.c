/* SPDX-License-Identifier: MIT */
#include "nursery.h"
#include "child.h"
#include "sandbox.h"
#include "server/log.h"
#include "worker.h"
#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { ANSWER_SECONDS = 5 }; /* a nursery that takes longer is stopped, or gone */

/* An order; the socket comes with it. The answer is the process's id, or -1. */
struct order {
    char argument[sizeof NURSERY_ARGUMENT];
};

union control {
    struct cmsghdr head;
    char bytes[CMSG_SPACE(sizeof(int))];
};

/* ------------------------------------------------------------------ the daemon's side */

static struct {
    pthread_mutex_t lock; /* also of an order and its answer */
    pthread_cond_t changed;
    pthread_t thread;
    struct child child;
    bool open, stale, closing;
} nursery = {.lock = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER};

/* With the lock: who wants a copy waits for it. */
static void start(void) {
    const struct timeval patience = {.tv_sec = ANSWER_SECONDS};
    child_kill(&nursery.child);
    nursery.stale = false;
    if (child_start(&nursery.child, "/proc/self/exe", NURSERY_ARGUMENT, SOCK_SEQPACKET))
        setsockopt(nursery.child.socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    pthread_cond_broadcast(&nursery.changed);
}

/* A process dies with the thread that started it, so one thread starts them all. */
static void *keep(void *context) {
    (void)context;
    pthread_mutex_lock(&nursery.lock);
    while (!nursery.closing) {
        if (nursery.stale)
            start();
        else
            pthread_cond_wait(&nursery.changed, &nursery.lock);
    }
    child_kill(&nursery.child);
    pthread_mutex_unlock(&nursery.lock);
    return NULL;
}

bool nursery_open(void) {
    if (SANDBOX_SANITIZED)
        return true;
    pthread_mutex_lock(&nursery.lock);
    nursery.stale = true;
    nursery.open = pthread_create(&nursery.thread, NULL, keep, NULL) == 0;
    while (nursery.open && nursery.stale)
        pthread_cond_wait(&nursery.changed, &nursery.lock);
    bool good = nursery.open;
    pthread_mutex_unlock(&nursery.lock);
    if (!good)
        log_error(log_event("nursery_start_failed"));
    return good;
}

void nursery_close(void) {
    if (!nursery.open)
        return;
    pthread_mutex_lock(&nursery.lock);
    nursery.closing = true;
    pthread_cond_broadcast(&nursery.changed);
    pthread_mutex_unlock(&nursery.lock);
    pthread_join(nursery.thread, NULL);
    nursery.open = nursery.closing = false;
}

void nursery_renew(void) {
    pthread_mutex_lock(&nursery.lock);
    nursery.stale = nursery.open;
    pthread_cond_broadcast(&nursery.changed);
    pthread_mutex_unlock(&nursery.lock);
}

static bool send_order(int nursery_socket, const char *argument, int socket) {
    struct order order = {0};
    union control control = {0};
    struct iovec part = {&order, sizeof order};
    const struct msghdr message = {.msg_iov = &part,
                                   .msg_iovlen = 1,
                                   .msg_control = control.bytes,
                                   .msg_controllen = sizeof control.bytes};
    strncpy(order.argument, argument, sizeof order.argument - 1);
    control.head.cmsg_level = SOL_SOCKET;
    control.head.cmsg_type = SCM_RIGHTS;
    control.head.cmsg_len = CMSG_LEN(sizeof socket);
    memcpy(CMSG_DATA(&control.head), &socket, sizeof socket);
    return sendmsg(nursery_socket, &message, MSG_NOSIGNAL) == (ssize_t)sizeof order;
}

bool nursery_fork(const char *argument, int socket, pid_t *pid) {
    pthread_mutex_lock(&nursery.lock);
    bool there = nursery.open && child_running(&nursery.child) && !nursery.stale;
    int to = nursery.child.socket;
    bool good = there && send_order(to, argument, socket) &&
                recv(to, pid, sizeof *pid, 0) == (ssize_t)sizeof *pid && *pid > 0;
    if (there && !good) {
        log_warning(log_event("nursery_failed"));
        nursery.stale = true;
        pthread_cond_broadcast(&nursery.changed);
    }
    pthread_mutex_unlock(&nursery.lock);
    return good;
}

/* ------------------------------------------------------------------ the process */

/* The argument of the next order, "" at the end, and its socket. */
static struct order receive(int *socket) {
    struct order order = {0};
    union control control;
    struct iovec part = {&order, sizeof order};
    struct msghdr message = {.msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = control.bytes,
                             .msg_controllen = sizeof control.bytes};
    ssize_t got;
    do
        got = recvmsg(WORKER_FD, &message, MSG_CMSG_CLOEXEC);
    while (got < 0 && errno == EINTR);
    const struct cmsghdr *files = CMSG_FIRSTHDR(&message);
    if (got != (ssize_t)sizeof order || !files || files->cmsg_len != CMSG_LEN(sizeof *socket))
        return (struct order){0};
    memcpy(socket, CMSG_DATA(files), sizeof *socket);
    return order;
}

/* In the copy: what `child_start` would have given a program. What ps shows is where the arguments
 * were. */
static int be(const struct nursery_role *role, int socket, char *argument) {
    memset(argument, 0, sizeof NURSERY_ARGUMENT);
    memcpy(argument, role->argument, strnlen(role->argument, sizeof NURSERY_ARGUMENT - 1));
    if (setpgid(0, 0) != 0 || dup2(socket, WORKER_FD) != WORKER_FD || close(socket) != 0)
        return 1;
    return role->main();
}

/* The C library's fork knows no CLONE_PARENT. What that does besides is for other threads, of which
 * there are none here, and for locks that belong to a thread by its number, of which there are none
 * either. */
static pid_t copy(void) {
    return (pid_t)syscall(SYS_clone, CLONE_PARENT | SIGCHLD, 0, 0, 0, 0);
}

int nursery_serve(char **argv, const struct nursery_role *roles, size_t count) {
    int socket = -1;
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0)
        return 1;
    for (;;) {
        const struct order order = receive(&socket);
        const struct nursery_role *role = NULL;
        for (size_t k = 0; k < count && !role; k++)
            role = strncmp(order.argument, roles[k].argument, sizeof order.argument) ? NULL
                                                                                     : &roles[k];
        if (!role)
            return order.argument[0] != 0;
        pid_t pid = copy();
        if (pid == 0)
            exit(be(role, socket, argv[1]));
        close(socket);
        if (send(WORKER_FD, &pid, sizeof pid, MSG_NOSIGNAL) != (ssize_t)sizeof pid)
            return 1;
    }
}
