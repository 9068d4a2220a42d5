/* SPDX-License-Identifier: MIT */
#include "checker.h"

#include "api/request/material.h"
#include "api/run.h"
#include "checker_task.h"
#include "sandbox.h"
#include "worker.h"
#include <errno.h>
#include <malloc.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

/* Kept between orders: most need no new memory from the system. */
enum { KEPT_BYTES = 4 * 1024 * 1024 };

/* Finds the documents in the packet and in the files. */
static bool find_documents(struct checker_task *task, size_t packet_length) {
    static char empty[1];
    size_t at = 0;
    int file = 0;
    for (int k = 0; k < CHECKER_DOCUMENTS; k++) {
        size_t length = task->order.length[k];
        if (!(task->order.files & 1u << k)) {
            task->document[k] = task->packet + at;
            at += length;
            if (length > packet_length || at > packet_length)
                return false;
            continue;
        }
        task->document[k] = empty;
        if (file == task->files)
            return false;
        if (!length) {
            file++;
            continue;
        }
        void *bytes = mmap(NULL, length, PROT_READ, MAP_PRIVATE, task->file[file++], 0);
        if (bytes == MAP_FAILED)
            return false;
        task->document[k] = task->mapped[k] = bytes;
    }
    task->output = task->order.files & 1u << CHECKER_DOCUMENTS ? task->file[file++] : -1;
    return file == task->files;
}

static void clear(struct checker_task *task) {
    uint64_t used = 0;
    for (int k = 0; k < CHECKER_DOCUMENTS; k++) {
        if (task->mapped[k])
            munmap(task->mapped[k], task->order.length[k]);
        task->mapped[k] = NULL;
        used += task->order.length[k];
    }
    for (int k = 0; k < task->files; k++)
        close(task->file[k]);
    task->files = 0;
    if (used > CHECKER_INLINE_MAX)
        malloc_trim(0);
}

/* The length of the documents in the packet; negative at the end. */
static ssize_t receive(struct checker_task *task) {
    struct iovec parts[] = {{&task->order, sizeof task->order},
                            {task->packet, sizeof task->packet}};
    union {
        struct cmsghdr head;
        char bytes[CMSG_SPACE(CHECKER_FILES_MAX * sizeof(int))];
    } control;
    struct msghdr message = {.msg_iov = parts,
                             .msg_iovlen = 2,
                             .msg_control = control.bytes,
                             .msg_controllen = sizeof control.bytes};
    ssize_t got;
    do
        got = recvmsg(WORKER_FD, &message, MSG_CMSG_CLOEXEC);
    while (got < 0 && errno == EINTR);
    if (got < (ssize_t)sizeof task->order || message.msg_flags & (MSG_TRUNC | MSG_CTRUNC))
        return -1;
    struct cmsghdr *files = CMSG_FIRSTHDR(&message);
    task->files = files ? (int)((files->cmsg_len - CMSG_LEN(0)) / sizeof(int)) : 0;
    if (files)
        memcpy(task->file, CMSG_DATA(files), (size_t)task->files * sizeof(int));
    return got - (ssize_t)sizeof task->order;
}

/* Of a problem as many places as there are. */
static bool send_answer(const struct checker_answer *answer) {
    size_t places = answer->problem.count < API_ERRORS_MAX ? answer->problem.count : API_ERRORS_MAX;
    size_t length =
        offsetof(struct checker_answer, problem.place) + places * sizeof answer->problem.place[0];
    return send(WORKER_FD, answer, length, MSG_NOSIGNAL) == (ssize_t)length;
}

/* ------------------------------------------------------------------ the process */

/* No life without the daemon. What an order frees stays with the process, up to KEPT_BYTES. */
static bool set_up(void) {
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    mallopt(M_TRIM_THRESHOLD, KEPT_BYTES);
    mallopt(M_MMAP_THRESHOLD, KEPT_BYTES);
    return api_prepare() && prctl(PR_SET_PDEATHSIG, SIGKILL) == 0 &&
           sandbox_enter(WORKER_FD, CHECKER_FILES_MAX);
}

/* Bytes of address space, 0 when that cannot be read. */
static uint64_t address_space(void) {
    unsigned long long pages = 0;
    FILE *file = fopen("/proc/self/statm", "re");
    if (!file)
        return 0;
    if (fscanf(file, "%llu", &pages) != 1)
        pages = 0;
    fclose(file);
    return pages * (uint64_t)sysconf(_SC_PAGESIZE);
}

int checker_serve(const struct checker_abilities *abilities) {
    static struct checker_task task;
    const struct checker_hello hello = {address_space()};
    ssize_t length;
    if (!hello.address_space || !set_up() ||
        send(WORKER_FD, &hello, sizeof hello, MSG_NOSIGNAL) != (ssize_t)sizeof hello)
        return 1;
    while ((length = receive(&task)) >= 0) {
        memset(&task.answer, 0, offsetof(struct checker_answer, problem.place));
        task.buffered = 0;
        bool good = find_documents(&task, (size_t)length);
        if (good && abilities->before)
            abilities->before(task.document[CHECKER_BODY], task.order.length[CHECKER_BODY]);
        if (good)
            checker_task_carry_out(&task, abilities);
        clear(&task);
        if (!good || !send_answer(&task.answer))
            return 1;
    }
    return 0;
}

int checker_main(void) {
    static const struct checker_abilities none;
    return checker_serve(&none);
}

/* ------------------------------------------------------------------ the other end */

static bool terminated(const char *text, size_t size) {
    return memchr(text, '\0', size) != NULL;
}

bool checker_answer_sound(struct checker_answer *answer, size_t length) {
    const struct api_problem *problem = &answer->problem;
    size_t head = offsetof(struct checker_answer, problem.place);
    if (length < head || problem->id >= API_PROBLEM_COUNT || problem->count > API_ERRORS_MAX ||
        length != head + problem->count * sizeof problem->place[0] ||
        (problem->id != API_OK) != (problem->count > 0))
        return false;
    memset((char *)answer + length, 0, sizeof *answer - length);
    for (size_t k = 0; k < problem->count; k++)
        if (!terminated(problem->place[k].pointer, API_POINTER_MAX) ||
            !terminated(problem->place[k].detail, API_DETAIL_MAX))
            return false;
    return terminated(answer->check.digest, API_ID_SIZE) &&
           terminated(answer->check.surface, API_ID_SIZE) &&
           terminated(answer->check.material, API_MATERIAL_NAME_SIZE) &&
           terminated(answer->note, CHECKER_NOTE_SIZE) &&
           answer->check.filled_length <= answer->output_length &&
           answer->check.definition_length <= answer->output_length;
}
