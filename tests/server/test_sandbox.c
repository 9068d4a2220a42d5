/* SPDX-License-Identifier: MIT */
/* A process that has locked itself in tries what a taken-over solver would try. */
#include "server/work/sandbox.h"
#include "tests/check.h"
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* Runs in a child, locked in, with the socket to the test. Returns 0 if all was as it should be,
 * else the line. */
typedef int attempt(int socket);

static int leave_with(attempt *act, int socket) {
    char go;
    alarm(60);
    for (int next = 1; next <= 3; next++) /* what it is not to keep is right beside the socket */
        if (dup2(socket, socket + next) < 0)
            return 254;
    return sandbox_enter(socket, 0) && write(socket, "r", 1) == 1 && read(socket, &go, 1) == 1
               ? act(socket)
               : 255;
}

/* What it may never have more of. */
static void expect_hard_limit(pid_t pid, int resource, rlim_t most) {
    struct rlimit both;
    assert_int_equal(prlimit(pid, (__rlimit_resource_t)resource, NULL, &both), 0);
    assert_int_equal(both.rlim_max, most);
}

/* What the child returned; 1000 + the signal that killed it. Before it acts it is bounded as a
 * dispatcher does it; 0: not. */
static int locked_in_with(attempt *act, uint64_t memory, uint64_t seconds) {
    int ends[2];
    int status = 0;
    char ready;
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0)
        _exit(leave_with(act, ends[1]));
    assert_int_equal(read(ends[0], &ready, 1), 1);
    expect_hard_limit(pid, RLIMIT_CORE, 0);
    if (!SANDBOX_SANITIZED) {
        expect_hard_limit(pid, RLIMIT_FSIZE, 0);
        expect_hard_limit(pid, RLIMIT_NOFILE, (rlim_t)ends[1] + 1);
    }
    close(ends[1]);
    assert_true(memory == 0 || sandbox_bound(pid, RLIMIT_AS, memory));
    assert_true(seconds == 0 || sandbox_bound_processor(pid, seconds));
    assert_int_equal(write(ends[0], "g", 1), 1);
    waitpid(pid, &status, 0);
    close(ends[0]);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

static int locked_in(attempt *act) {
    return locked_in_with(act, UINT64_C(4) << 30, 60);
}

/* Leaves the attempt with the number of the first check that fails; 1 to 254. */
#define EXPECT(number, condition)                                                                  \
    do {                                                                                           \
        if (!(condition))                                                                          \
            return number;                                                                         \
    } while (0)

static int refused(long result) {
    return result == -1 && errno == EPERM;
}

/* ------------------------------------------------------------------ what is refused */

static int reach_out(int socket_end) {
    static char *const nothing[] = {NULL};
    static char path[] = "/bin/true";
    char *const arguments[] = {path, NULL};
    (void)socket_end;
    EXPECT(1, refused(socket(AF_INET, SOCK_STREAM, 0)));
    EXPECT(2, refused(socket(AF_UNIX, SOCK_STREAM, 0)));
    EXPECT(3, refused(execve(path, arguments, nothing)));
    EXPECT(4, refused(syscall(SYS_execveat, AT_FDCWD, path, arguments, nothing, 0)));
    EXPECT(5, refused(connect(socket_end, NULL, 0)));
    EXPECT(6, refused(listen(socket_end, 1)));
    EXPECT(7, refused(accept(socket_end, NULL, NULL)));
    EXPECT(8, refused(unlink("/tmp/none")));
    EXPECT(9, refused(mkdir("/tmp/none", 0700)));
    EXPECT(10,
           refused(syscall(SYS_setuid, 0))); /* glibc's own aborts beside a sanitizer's thread */
    EXPECT(11, refused(syscall(SYS_unshare, CLONE_NEWUSER)));
    EXPECT(12, refused(syscall(SYS_mount, "", "/", "", 0, NULL)));
    EXPECT(13, refused(syscall(SYS_bpf, 0, NULL, 0)));
    EXPECT(14, refused(syscall(SYS_io_uring_setup, 1, NULL)));
    EXPECT(15, refused(syscall(SYS_perf_event_open, NULL, 0, -1, -1, 0)));
    EXPECT(16, refused(chroot("/")));
    return 0;
}

static void test_sandbox_reaches_nothing_outside(void **state) {
    (void)state;
    assert_int_equal(locked_in(reach_out), 0);
}

static int reach_files(int socket_end) {
    static const char path[] = "/etc/passwd";
    (void)socket_end;
    EXPECT(1, refused(open(path, O_RDONLY)));
    EXPECT(2, refused(syscall(SYS_openat, AT_FDCWD, path, O_RDONLY)));
    EXPECT(3, refused(syscall(SYS_openat2, AT_FDCWD, path, NULL, 0)));
    EXPECT(4, refused(syscall(SYS_memfd_create, "x", 0)));
    EXPECT(5, refused(dup(socket_end)));
    EXPECT(6, refused(fork()));
    EXPECT(7, refused(kill(getppid(), 0)));
    EXPECT(8, refused(syscall(SYS_tgkill, 1, 1, 0)));
    EXPECT(9, refused(ptrace(PTRACE_ATTACH, 1, NULL, NULL)));
    EXPECT(10, refused(prctl(PR_SET_DUMPABLE, 1)));
    EXPECT(11, refused(syscall(SYS_prlimit64, 1, RLIMIT_CORE, NULL, NULL)));
    EXPECT(16, refused(syscall(SYS_prlimit64, 0, RLIMIT_AS, NULL, NULL)));
    EXPECT(17, refused(syscall(SYS_setrlimit, RLIMIT_AS, NULL)));
    EXPECT(12, mmap(NULL, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1,
                    0) == MAP_FAILED);
    void *page = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    EXPECT(13, page != MAP_FAILED);
    EXPECT(14, refused(mprotect(page, 4096, PROT_READ | PROT_EXEC)));
    EXPECT(15, syscall(SYS_clone3, NULL, 0) == -1 && errno == ENOSYS);
    return 0;
}

static void test_sandbox_has_no_files_and_no_code(void **state) {
    (void)state;
    if (SANDBOX_SANITIZED)
        skip(); /* they open files to report, and trace the process to find leaks */
    assert_int_equal(locked_in(reach_files), 0);
}

/* ------------------------------------------------------------------ what is left */

static void *add_one(void *context) {
    int *number = context;
    void *memory = malloc(1 << 20);
    memset(memory, 1, 1 << 20);
    free(memory);
    ++*number;
    return NULL;
}

static int work(int socket_end) {
    enum { THREADS = 8, LARGE = 256 << 20 };
    pthread_t threads[THREADS];
    int numbers[THREADS] = {0};
    struct timespec pause = {0, 1000000};
    for (int k = 0; k < THREADS; k++)
        EXPECT(1, pthread_create(&threads[k], NULL, add_one, &numbers[k]) == 0);
    for (int k = 0; k < THREADS; k++)
        EXPECT(2, pthread_join(threads[k], NULL) == 0 && numbers[k] == 1);
    char *large = malloc(LARGE);
    EXPECT(3, large != NULL);
    large = realloc(large, LARGE / 2);
    EXPECT(4, large != NULL);
    free(large);
    EXPECT(5, nanosleep(&pause, NULL) == 0);
    EXPECT(6, send(socket_end, "x", 1, MSG_NOSIGNAL) == 1);
    return 0;
}

static void test_sandbox_lets_a_solver_work(void **state) {
    (void)state;
    assert_int_equal(locked_in(work), 0);
}

/* abort() and its like end the process as anywhere. */
static int crash(int socket_end) {
    (void)socket_end;
    signal(SIGABRT, SIG_DFL);
    abort();
}

static void test_sandbox_lets_it_crash(void **state) {
    (void)state;
    assert_int_equal(locked_in(crash), 1000 + SIGABRT);
}

/* ------------------------------------------------------------------ bounds */

static int spin(int socket_end) {
    (void)socket_end;
    for (volatile unsigned long k = 0; k < ~0UL;)
        k++;
    return 1;
}

static void test_sandbox_bounds_the_processor(void **state) {
    (void)state;
    assert_int_equal(locked_in_with(spin, 0, 1), 1000 + SIGXCPU);
}

/* Until the process has had so much time of a processor. */
static void spin_until(double seconds) {
    while ((double)clock() / CLOCKS_PER_SEC < seconds)
        continue;
}

/* A worker that has had two seconds and more before has one of its own for the next drape. */
static void test_sandbox_bounds_the_processor_from_then_on(void **state) {
    (void)state;
    int ends[2];
    int status = 0;
    char go = 'g';
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        alarm(60);
        spin_until(2.2);
        bool good = write(ends[1], &go, 1) == 1 && read(ends[1], &go, 1) == 1;
        spin_until(2.5);
        _exit(!good);
    }
    assert_int_equal(read(ends[0], &go, 1), 1);
    assert_true(sandbox_bound_processor(pid, 1));
    assert_int_equal(write(ends[0], &go, 1), 1);
    waitpid(pid, &status, 0);
    assert_int_equal(status, 0);
    close(ends[0]);
    close(ends[1]);
}

static int hoard(int socket_end) {
    (void)socket_end;
    const struct rlimit more = {RLIM_INFINITY, RLIM_INFINITY};
    EXPECT(2, refused(syscall(SYS_prlimit64, 0, RLIMIT_AS, &more, NULL)));
    EXPECT(3, refused(syscall(SYS_setrlimit, RLIMIT_AS, &more)));
    for (int k = 0; k < 64; k++)
        if (!malloc(64 << 20))
            return 0;
    return 1;
}

static void test_sandbox_bounds_memory(void **state) {
    (void)state;
    if (SANDBOX_SANITIZED)
        skip(); /* they reserve terabytes of addresses */
    assert_int_equal(locked_in_with(hoard, UINT64_C(1) << 30, 0), 0);
}

static int look_around(int socket_end) {
    for (int fd = 0; fd < 64; fd++)
        EXPECT(4, fd == socket_end || (write(fd, "", 0) == -1 && errno == EBADF));
    return 0;
}

static void test_sandbox_keeps_one_descriptor(void **state) {
    (void)state;
    if (SANDBOX_SANITIZED)
        skip(); /* they keep standard error and open files to report */
    assert_int_equal(locked_in(look_around), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sandbox_reaches_nothing_outside),
        cmocka_unit_test(test_sandbox_has_no_files_and_no_code),
        cmocka_unit_test(test_sandbox_lets_a_solver_work),
        cmocka_unit_test(test_sandbox_lets_it_crash),
        cmocka_unit_test(test_sandbox_bounds_the_processor),
        cmocka_unit_test(test_sandbox_bounds_the_processor_from_then_on),
        cmocka_unit_test(test_sandbox_bounds_memory),
        cmocka_unit_test(test_sandbox_keeps_one_descriptor),
    };
    return cmocka_run_group_tests_name("sandbox", tests, NULL, NULL);
}
