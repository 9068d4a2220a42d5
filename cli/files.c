/* SPDX-License-Identifier: MIT */
#include "files.h"

#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { COPY_SIZE = 1 << 16 };

void files_complain(const char *what, const char *why) {
    fprintf(stderr, "%s: %s: %s\n", program_invocation_short_name, what, why);
}

/* ---- input ---- */

bool files_drain(FILE *stream, struct files_bytes *bytes) {
    while (!feof(stream)) {
        if (bytes->length == bytes->capacity) {
            size_t capacity = bytes->capacity ? 2 * bytes->capacity : COPY_SIZE;
            char *data = realloc(bytes->data, capacity);
            if (!data)
                return false;
            bytes->data = data;
            bytes->capacity = capacity;
        }
        bytes->length +=
            fread(bytes->data + bytes->length, 1, bytes->capacity - bytes->length, stream);
        if (ferror(stream))
            return false;
    }
    return true;
}

bool files_read(const char *path, struct files_bytes *bytes) {
    FILE *stream = path ? fopen(path, "rb") : stdin;
    bool ok = stream && files_drain(stream, bytes);
    if (!ok)
        files_complain(path ? path : "standard input", strerror(errno));
    if (stream && path)
        fclose(stream);
    return ok;
}

bool files_read_at(void *stream, uint64_t offset, void *buffer, size_t length) {
    return fseeko(stream, (off_t)offset, SEEK_SET) == 0 &&
           fread(buffer, 1, length, stream) == length;
}

/* ---- output ---- */

bool files_append(void *stream, const void *bytes, size_t length) {
    return fwrite(bytes, 1, length, stream) == length;
}

/* The temporary file of this process, for a signal that ends it. */
static char *volatile unfinished;

static void end_by_signal(int number) {
    if (unfinished)
        unlink(unfinished);
    raise(number); /* its default action is back */
}

void files_watch_signals(void) {
    const int numbers[] = {SIGINT, SIGTERM, SIGHUP, SIGPIPE};
    struct sigaction action = {.sa_handler = end_by_signal, .sa_flags = (int)SA_RESETHAND};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        sigaction(numbers[i], &action, NULL);
}

bool files_open(struct files_output *output, const char *path) {
    struct stat old;
    mode_t mask = umask(0);
    umask(mask);
    bool exists = path && stat(path, &old) == 0;
    *output = (struct files_output){.name = path ? path : "standard output"};
    if (!path) {
        output->stream = stdout;
    } else if (exists && !S_ISREG(old.st_mode)) {
        output->stream = fopen(path, "wb");
    } else {
        /* A temporary file beside the target, with the mode that the target will have. */
        output->target = exists ? realpath(path, NULL) : strdup(path);
        if ((exists && access(path, W_OK) != 0) || !output->target ||
            asprintf(&output->temporary, "%s.XXXXXX", output->target) < 0)
            output->temporary = NULL;
        int file = output->temporary ? mkstemp(output->temporary) : -1;
        if (file < 0) {
            free(output->temporary);
            output->temporary = NULL;
        } else {
            unfinished = output->temporary;
            output->stream = fchmod(file, exists ? old.st_mode & 0777 : 0666 & ~mask) == 0
                                 ? fdopen(file, "wb")
                                 : NULL;
            if (!output->stream)
                close(file);
        }
    }
    if (!output->stream)
        files_complain(output->name, strerror(errno));
    return output->stream != NULL;
}

bool files_close(struct files_output *output, bool ok) {
    bool wanted = ok;
    if (output->stream)
        ok = (output->stream == stdout ? fflush(stdout) : fclose(output->stream)) == 0 && ok;
    if (output->temporary)
        ok = ok && rename(output->temporary, output->target) == 0;
    if (wanted && !ok)
        files_complain(output->name, strerror(errno));
    if (output->temporary && !ok)
        unlink(output->temporary);
    unfinished = NULL;
    free(output->temporary);
    free(output->target);
    return ok;
}
