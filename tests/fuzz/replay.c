/* SPDX-License-Identifier: MIT */
/* Runs a fuzz target over files and over all files of folders, without a fuzzer; says so in TAP.
 * Usage: fuzz_NAME PATH... */
#include "fuzz.h"

#include <dirent.h>
#include <string.h>
#include <sys/stat.h>

static int count;

static void replay_file(const char *path) {
    FILE *file = fopen(path, "rb");
    struct stat status;
    if (!file || fstat(fileno(file), &status) != 0)
        abort();
    size_t size = (size_t)status.st_size;
    /* Of exactly that size, so that the sanitizer sees a byte read too many. */
    uint8_t *data = malloc(size ? size : 1);
    if (!data || fread(data, 1, size, file) != size)
        abort();
    fclose(file);
    fprintf(stderr, "# %s\n", path);
    (void)LLVMFuzzerTestOneInput(data, size);
    free(data);
    printf("ok %d - %s\n", ++count, path);
}

static void replay(const char *path) {
    struct dirent *entry;
    DIR *folder = opendir(path);
    if (!folder) {
        replay_file(path);
        return;
    }
    while ((entry = readdir(folder))) {
        char name[4096];
        if (entry->d_name[0] == '.')
            continue;
        snprintf(name, sizeof name, "%s/%s", path, entry->d_name);
        replay_file(name);
    }
    closedir(folder);
}

int main(int argc, char **argv) {
    LLVMFuzzerInitialize(&argc, &argv);
    for (int k = 1; k < argc; k++)
        replay(argv[k]);
    printf("1..%d\n", count);
    return count > 0 ? 0 : 1;
}
