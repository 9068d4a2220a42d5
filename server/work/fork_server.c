/* SPDX-License-Identifier: MIT */
#include "fork_server.h"
#include "child.h"
#include "sandbox.h"
#include "server/log.h"
#include "worker.h"
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

/* The argument of what a copy is to be: the body of a FORK. */
typedef char fork_order[sizeof FORK_SERVER_ARGUMENT];

/* ------------------------------------------------------------------ the daemon's side */

static struct {
    pthread_mutex_t lock; /* also of an order and its answer */
    pthread_cond_t changed;
    pthread_t thread;
    struct child child;
    bool open, stale, closing;
} fork_server = {.lock = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER};

/* A process dies with the thread that started it, so one thread starts them all. Who wants a copy
 * meanwhile waits for the lock. */
static void *keep_fork_server(void *context) {
    const struct timeval patience = {.tv_sec = ANSWER_SECONDS};
    (void)context;
    pthread_mutex_lock(&fork_server.lock);
    while (!fork_server.closing) {
        if (!fork_server.stale) {
            pthread_cond_wait(&fork_server.changed, &fork_server.lock);
            continue;
        }
        child_kill(&fork_server.child);
        fork_server.stale = false;
        if (child_start(&fork_server.child, "/proc/self/exe", FORK_SERVER_ARGUMENT))
            setsockopt(fork_server.child.socket, SOL_SOCKET, SO_RCVTIMEO, &patience,
                       sizeof patience);
        pthread_cond_broadcast(&fork_server.changed);
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
    fork_server.open = pthread_create(&fork_server.thread, NULL, keep_fork_server, NULL) == 0;
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

bool fork_server_fork(const char *argument, int socket, pid_t *pid) {
    fork_order order = {0};
    struct frame_outbox outbox;
    strncpy(order, argument, sizeof order - 1);
    frame_outbox_begin(&outbox, FRAME_FORK, order, sizeof order);
    outbox.files = &socket;
    outbox.file_count = 1;
    pthread_mutex_lock(&fork_server.lock);
    bool there = fork_server.open && child_running(&fork_server.child) && !fork_server.stale;
    int to = fork_server.child.socket;
    bool good = there && frame_push(to, &outbox) == FRAME_READY &&
                frame_expect(to, FRAME_FORKED, pid, sizeof *pid, NULL, NULL) == FRAME_READY &&
                *pid > 0;
    if (there && !good) {
        log_warning(log_event("fork_server_failed"));
        fork_server.stale = true;
        pthread_cond_broadcast(&fork_server.changed);
    }
    pthread_mutex_unlock(&fork_server.lock);
    return good;
}

/* ------------------------------------------------------------------ the process */

int fork_server_serve(char **argv, const struct fork_server_role *roles, size_t count) {
    fork_order order;
    enum frame_state state;
    int files[FRAME_FILES_MAX], file_count;
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0)
        return 1;
    while ((state = frame_expect(WORKER_FD, FRAME_FORK, order, sizeof order, files, &file_count)) ==
           FRAME_READY) {
        const struct fork_server_role *role = NULL;
        for (size_t k = 0; k < count && !role; k++)
            if (!strncmp(order, roles[k].argument, sizeof order))
                role = &roles[k];
        if (!role || file_count != 1)
            return 1;
        /* The C library's fork knows no CLONE_PARENT. What that does besides is for other threads,
         * of which there are none here, and for locks that belong to a thread by its number, of
         * which there are none either. */
        pid_t pid = (pid_t)syscall(SYS_clone, CLONE_PARENT | SIGCHLD, 0, 0, 0, 0);
        if (pid == 0) { /* the copy gets what `child_start` would have given a program */
            memset(argv[1], 0, sizeof FORK_SERVER_ARGUMENT); /* what ps shows */
            memcpy(argv[1], role->argument,
                   strnlen(role->argument, sizeof FORK_SERVER_ARGUMENT - 1));
            bool good = setpgid(0, 0) == 0 && dup2(files[0], WORKER_FD) == WORKER_FD &&
                        close(files[0]) == 0;
            exit(good ? role->main() : 1);
        }
        close(files[0]);
        if (!frame_send(WORKER_FD, FRAME_FORKED, &pid, sizeof pid))
            return 1;
    }
    return state == FRAME_CLOSED ? 0 : 1;
}
