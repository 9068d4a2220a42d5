/* SPDX-License-Identifier: MIT */
#include "spool.h"
#include <errno.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

int spool_new(size_t length, const char *folder) {
    int file = -1;
    if (length > SPOOL_MEMORY_MAX && *folder)
        file = open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    return file >= 0 ? file : memfd_create("draped", MFD_CLOEXEC | MFD_ALLOW_SEALING);
}

bool spool_write(int file, const void *bytes, size_t length) {
    const char *from = bytes;
    while (length > 0) {
        ssize_t written = write(file, from, length);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            return false;
        from += written;
        length -= (size_t)written;
    }
    return true;
}

bool spool_seal(int file) {
    return fcntl(file, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL) == 0;
}

int spool_of_bytes(const void *bytes, size_t length) {
    int file = spool_new(0, "");
    if (file >= 0 && spool_write(file, bytes, length) && spool_seal(file))
        return file;
    if (file >= 0)
        close(file);
    return -1;
}
