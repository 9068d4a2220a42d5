/* SPDX-License-Identifier: MIT */
#include "fork_server.h"
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

enum { ANSWER_SECONDS = 5 }; /* a fork server that takes longer is stopped, or gone */

/* An order; the socket comes with it. The answer is the process's id, or -1. */
struct order {
    char argument[sizeof FORK_SERVER_ARGUMENT];
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
} fork_server = {.lock = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER};

/* With the lock: who wants a copy waits for it. */
static void start(void) {
    const struct timeval patience = {.tv_sec = ANSWER_SECONDS};
    child_kill(&fork_server.child);
    fork_server.stale = false;
    if (child_start(&fork_server.child, "/proc/self/exe", FORK_SERVER_ARGUMENT, SOCK_SEQPACKET))
        setsockopt(fork_server.child.socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    pthread_cond_broadcast(&fork_server.changed);
}

/* A process dies with the thread that started it, so one thread starts them all. */
static void *keep(void *context) {
    (void)context;
    pthread_mutex_lock(&fork_server.lock);
    while (!fork_server.closing) {
        if (fork_server.stale)
            start();
        else
            pthread_cond_wait(&fork_server.changed, &fork_server.lock);
    }
    child_kill(&fork_server.child);
    pthread_mutex_unlock(&fork_server.lock);
    return NULL;
}

bool fork_server_open(void) {
    if (SANDBOX_SANITIZED)
        return true;
    pthread_mutex_lock(&fork_server.lock);
    fork_server.stale = true;
    fork_server.open = pthread_create(&fork_server.thread, NULL, keep, NULL) == 0;
    while (fork_server.open && fork_server.stale)
        pthread_cond_wait(&fork_server.changed, &fork_server.lock);
    bool good = fork_server.open;
    pthread_mutex_unlock(&fork_server.lock);
    if (!good)
        log_error(log_event("fork_server_start_failed"));
    return good;
}

void fork_server_close(void) {
    if (!fork_server.open)
        return;
    pthread_mutex_lock(&fork_server.lock);
    fork_server.closing = true;
    pthread_cond_broadcast(&fork_server.changed);
    pthread_mutex_unlock(&fork_server.lock);
    pthread_join(fork_server.thread, NULL);
    fork_server.open = fork_server.closing = false;
}

void fork_server_renew(void) {
    pthread_mutex_lock(&fork_server.lock);
    fork_server.stale = fork_server.open;
    pthread_cond_broadcast(&fork_server.changed);
    pthread_mutex_unlock(&fork_server.lock);
}

static bool send_order(int fork_server_socket, const char *argument, int socket) {
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
    return sendmsg(fork_server_socket, &message, MSG_NOSIGNAL) == (ssize_t)sizeof order;
}

bool fork_server_fork(const char *argument, int socket, pid_t *pid) {
    pthread_mutex_lock(&fork_server.lock);
    bool there = fork_server.open && child_running(&fork_server.child) && !fork_server.stale;
    int to = fork_server.child.socket;
    bool good = there && send_order(to, argument, socket) &&
                recv(to, pid, sizeof *pid, 0) == (ssize_t)sizeof *pid && *pid > 0;
    if (there && !good) {
        log_warning(log_event("fork_server_failed"));
        fork_server.stale = true;
        pthread_cond_broadcast(&fork_server.changed);
    }
    pthread_mutex_unlock(&fork_server.lock);
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
static int be(const struct fork_server_role *role, int socket, char *argument) {
    memset(argument, 0, sizeof FORK_SERVER_ARGUMENT);
    memcpy(argument, role->argument, strnlen(role->argument, sizeof FORK_SERVER_ARGUMENT - 1));
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

int fork_server_serve(char **argv, const struct fork_server_role *roles, size_t count) {
    int socket = -1;
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0)
        return 1;
    for (;;) {
        const struct order order = receive(&socket);
        const struct fork_server_role *role = NULL;
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
