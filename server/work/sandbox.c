/* SPDX-License-Identifier: MIT */
#include "sandbox.h"
#include <errno.h>
#include <malloc.h>
#include <sched.h>
#include <seccomp.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

/* ------------------------------------------------------------------ limits */

static void limit(int resource, rlim_t bytes) {
    const struct rlimit both = {bytes, bytes};
    setrlimit((__rlimit_resource_t)resource, &both);
}

bool sandbox_bound(pid_t pid, int resource, uint64_t value) {
    struct rlimit both;
    if (SANDBOX_SANITIZED && resource != RLIMIT_CPU)
        return true;
    if (prlimit(pid, (__rlimit_resource_t)resource, NULL, &both) != 0)
        return false;
    both.rlim_cur = value < both.rlim_max ? value : both.rlim_max;
    return prlimit(pid, (__rlimit_resource_t)resource, &both, NULL) == 0;
}

bool sandbox_bound_for_good(pid_t pid, int resource, uint64_t value) {
    const struct rlimit both = {value, value};
    return (SANDBOX_SANITIZED && resource != RLIMIT_CPU) ||
           prlimit(pid, (__rlimit_resource_t)resource, &both, NULL) == 0;
}

int64_t sandbox_processor_us(pid_t pid) {
    clockid_t clock;
    struct timespec used;
    if (clock_getcpuclockid(pid, &clock) != 0 || clock_gettime(clock, &used) != 0)
        return -1;
    return used.tv_sec * INT64_C(1000000) + used.tv_nsec / 1000;
}

bool sandbox_bound_processor(pid_t pid, uint64_t seconds) {
    int64_t used = sandbox_processor_us(pid);
    return used >= 0 && sandbox_bound(pid, RLIMIT_CPU, (uint64_t)used / 1000000 + 1 + seconds);
}

/* ------------------------------------------------------------------ system calls */

/* What needs no look at its arguments. */
static const int allowed[] = {
    /* the socket, and waiting for it */
    SCMP_SYS(read), SCMP_SYS(write), SCMP_SYS(recvfrom), SCMP_SYS(recvmsg), SCMP_SYS(sendto),
    SCMP_SYS(sendmsg), SCMP_SYS(poll), SCMP_SYS(ppoll), SCMP_SYS(close),
    /* memory that is not code */
    SCMP_SYS(brk), SCMP_SYS(munmap), SCMP_SYS(mremap), SCMP_SYS(madvise),
    /* threads and their locks */
    SCMP_SYS(futex), SCMP_SYS(set_robust_list), SCMP_SYS(rseq), SCMP_SYS(sched_yield),
    SCMP_SYS(sched_getaffinity), SCMP_SYS(gettid), SCMP_SYS(getpid), SCMP_SYS(exit),
    SCMP_SYS(exit_group), SCMP_SYS(restart_syscall),
    /* signals, of which a crash is one */
    SCMP_SYS(rt_sigaction), SCMP_SYS(rt_sigprocmask), SCMP_SYS(rt_sigreturn), SCMP_SYS(sigaltstack),
    /* clocks, random numbers, what was used */
    SCMP_SYS(clock_gettime), SCMP_SYS(clock_nanosleep), SCMP_SYS(nanosleep), SCMP_SYS(gettimeofday),
    SCMP_SYS(getrandom), SCMP_SYS(getrusage)};

/* What sanitizers need beyond it to report and to look for leaks. */
static const int allowed_sanitized[] = {
    SCMP_SYS(open),       SCMP_SYS(openat),    SCMP_SYS(stat),   SCMP_SYS(fstat),
    SCMP_SYS(newfstatat), SCMP_SYS(readlink),  SCMP_SYS(lseek),  SCMP_SYS(fcntl),
    SCMP_SYS(ioctl),      SCMP_SYS(pipe),      SCMP_SYS(pipe2),  SCMP_SYS(getdents64),
    SCMP_SYS(clone),      SCMP_SYS(ptrace),    SCMP_SYS(wait4),  SCMP_SYS(prctl),
    SCMP_SYS(getppid),    SCMP_SYS(kill),      SCMP_SYS(tgkill), SCMP_SYS(mmap),
    SCMP_SYS(mprotect),   SCMP_SYS(prlimit64), SCMP_SYS(writev), SCMP_SYS(process_vm_readv),
    SCMP_SYS(dup),        SCMP_SYS(dup2),      SCMP_SYS(uname),  SCMP_SYS(access)};

static bool allow(scmp_filter_ctx filter, const int *calls, size_t count) {
    for (size_t k = 0; k < count; k++)
        if (seccomp_rule_add(filter, SCMP_ACT_ALLOW, calls[k], 0) != 0)
            return false;
    return true;
}

static bool allow_if(scmp_filter_ctx filter, int call, struct scmp_arg_cmp condition) {
    return seccomp_rule_add_array(filter, SCMP_ACT_ALLOW, call, 1, &condition) == 0;
}

/* ------------------------------------------------------------------ entering */

/* A crash leaves no core file of gigabytes, with a customer's surface in it. Of the system's calls,
 * those for memory get data or code, and code there is enough. A clone is a thread of this process;
 * clone3 hides its flags in memory, where no filter can see them, so it is answered as not
 * implemented and the C library takes clone. Signals are this process's own. */
bool sandbox_enter(int socket, int files) {
    const int first = SANDBOX_SANITIZED ? STDERR_FILENO + 1 : 0;
    const scmp_datum_t thread = CLONE_VM | CLONE_FS | CLONE_FILES | CLONE_SIGHAND | CLONE_THREAD;
    const struct scmp_arg_cmp no_code = SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0);
    const struct scmp_arg_cmp own = SCMP_A0(SCMP_CMP_EQ, (scmp_datum_t)getpid());
    limit(RLIMIT_CORE, 0);
    if (!SANDBOX_SANITIZED) {
        if (!files)
            limit(RLIMIT_FSIZE, 0);
        limit(RLIMIT_NOFILE, (rlim_t)(socket + 1 + files));
        if (prctl(PR_SET_DUMPABLE, 0) != 0)
            return false;
    }
    if ((socket > first && close_range((unsigned)first, (unsigned)socket - 1, 0) != 0) ||
        close_range((unsigned)socket + 1, ~0U, 0) != 0 ||
        prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
        return false;
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ERRNO(EPERM));
    bool good = filter && allow(filter, allowed, sizeof allowed / sizeof *allowed) &&
                seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0) == 0;
    if (good && SANDBOX_SANITIZED)
        good =
            allow(filter, allowed_sanitized, sizeof allowed_sanitized / sizeof *allowed_sanitized);
    else if (good)
        good = allow_if(filter, SCMP_SYS(mmap), no_code) &&
               allow_if(filter, SCMP_SYS(mprotect), no_code) &&
               allow_if(filter, SCMP_SYS(clone), SCMP_A0(SCMP_CMP_MASKED_EQ, thread, thread)) &&
               allow_if(filter, SCMP_SYS(tgkill), own);
    good = good && seccomp_load(filter) == 0;
    seccomp_release(filter);
    return good;
}

bool sandbox_begin(int socket, int files, size_t kept) {
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    mallopt(M_TRIM_THRESHOLD, (int)kept);
    mallopt(M_MMAP_THRESHOLD, (int)kept);
    return prctl(PR_SET_PDEATHSIG, SIGKILL) == 0 && sandbox_enter(socket, files);
}
