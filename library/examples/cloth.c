/* SPDX-License-Identifier: MIT */
/*
 * Drapes a request, says how far the cloth shears, and writes the pattern to cut.
 *     cc cloth.c -o cloth $(pkg-config --cflags --libs drape)
 *     ./cloth hemisphere.json pattern.svg
 */
#include <drape.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

/* The drape stops after a minute. */
static int within_a_minute(void *start, double fraction) {
    (void)fraction;
    return difftime(time(NULL), *(time_t *)start) > 60;
}

/* All of a file, for the caller to free; NULL when it cannot be read. */
static char *read_file(const char *name, size_t *length) {
    FILE *file = fopen(name, "rb");
    char *bytes = NULL;
    if (file && fseek(file, 0, SEEK_END) == 0 && ftell(file) > 0) {
        *length = (size_t)ftell(file);
        rewind(file);
        bytes = malloc(*length);
        if (bytes && fread(bytes, 1, *length, file) != *length) {
            free(bytes);
            bytes = NULL;
        }
    }
    if (file)
        fclose(file);
    return bytes;
}

int main(int argc, char **argv) {
    size_t length = 0, cells = 0, pattern_length = 0;
    time_t start = time(NULL);
    char *request = argc == 3 ? read_file(argv[1], &length) : NULL;
    if (!request)
        return fprintf(stderr, "usage: cloth REQUEST.json PATTERN.svg\n"), 2;
    struct drape *drape = drape_run(request, length, "threads=2", within_a_minute, &start);
    const double *shear = drape ? drape_column(drape, "cells.shear_deg", &cells) : NULL;
    char *pattern = shear ? drape_document(drape, "svg", "allowance=0.01", &pattern_length) : NULL;
    FILE *file = pattern ? fopen(argv[2], "wb") : NULL;
    int good = file && fwrite(pattern, 1, pattern_length, file) == pattern_length;
    good = (!file || fclose(file) == 0) && good;
    if (good) {
        double largest = 0;
        for (size_t k = 0; k < cells; k++)
            largest = fmax(largest, fabs(shear[k]));
        printf("%zu cells, sheared by up to %.2f degrees\n", cells, largest);
    } else
        fprintf(stderr, "%s\n", drape && drape_problem(drape) ? drape_problem(drape) : argv[2]);
    drape_free_document(pattern);
    drape_free(drape);
    free(request);
    return !good;
}
