/* SPDX-License-Identifier: MIT */
/*
 * What a drape of a CAD part costs: of every surface that the importer wrote, the faces that hang
 * together smoothly (by 20 degrees), as many as there are, with a net of about N nodes from the
 * default start. Milliseconds, the least CPU times of a few rounds: `open` from the decoded faces
 * to a shell that is ready, `form` from the bytes of the prepared form to it, `start` to the place
 * nearest to the centroid, which `solve` has in it, `least` the search for generators of least
 * energy, with four values a side.
 *
 *     bench_parts N SURFACE.json...
 */
#include "api/limits.h"
#include "api/request/decode.h"
#include "api/request/prepared_form.h"
#include "api/run.h"
#include "tests/bench/timing.h"

#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 7, PARTS_MAX = 64 };

struct figure {
    double open, form, start, solve, least, ns;
    size_t faces, nodes;
};

static char *read_file(const char *path, size_t *length) {
    FILE *file = fopen(path, "rb");
    char *bytes = NULL;
    if (file && fseek(file, 0, SEEK_END) == 0) {
        *length = (size_t)ftell(file);
        rewind(file);
        bytes = malloc(*length);
        *length = bytes ? fread(bytes, 1, *length, file) : 0;
    }
    if (file)
        fclose(file);
    return bytes;
}

static bool open_part(const struct api_request *request, struct arena *arena,
                      struct prepared_part *part) {
    struct api_problem problem = {0};
    return prepared_part_make(request, &api_limits_default, arena, part, &problem) == API_OK;
}

/* A request for the faces of a surface that are reached from the one from which most are, with the
 * spacing of so many nodes. */
static bool read_request(const char *path, double nodes, struct arena *arena,
                         struct api_request *request) {
    size_t length = 0, most = 0;
    char *bytes = read_file(path, &length);
    struct api_problem problem = {0};
    *request = (struct api_request){
        .settings = {.method = DRAPE_GIB, .spacing = {1e9, 1e9}, .max_nodes = 20000000}};
    bool good = bytes && api_decode_surface(bytes, length, &api_limits_default, arena,
                                            &request->surface, &problem) == API_OK;
    struct api_selection choice = {.kind = API_SELECT_GROWN, .up_to_deg = API_UP_TO_DEG}, best;
    for (; good && (size_t)choice.grow_from < request->surface.face_count; choice.grow_from++) {
        struct arena_mark mark = arena_mark(arena);
        struct prepared_part part;
        request->surface.selection = choice;
        if (open_part(request, arena, &part) && part.shell.count > most) {
            const struct shell *shell = part.part.shell;
            double area = shell_area(shell, shell_largest_component(shell), NULL);
            request->settings.spacing[0] = request->settings.spacing[1] = sqrt(area / nodes);
            most = part.shell.count;
            best = choice;
        }
        arena_rewind(arena, mark);
    }
    if (most > 0)
        request->surface.selection = best;
    free(bytes);
    return most > 0;
}

static bool run_once(const struct api_request *request, struct arena *arena,
                     struct figure *figure) {
    struct prepared_part part;
    struct drape_result result;
    struct shell_point place;
    struct vec3 centroid;
    double begun = seconds(), distance;
    if (!open_part(request, arena, &part))
        return false;
    const struct shell *shell = part.part.shell;
    double opened = seconds();
    int32_t component = shell_largest_component(shell);
    (void)shell_area(shell, component, &centroid);
    shell_nearest(shell, centroid, component, &place, &distance);
    double started = seconds();
    if (drape_solve(&part.part, &request->settings, NULL, arena, &result) != STATUS_OK)
        return false;
    figure->faces = part.shell.count;
    figure->nodes = result.nodes.count;
    figure->open = fmin(figure->open, 1e3 * (opened - begun));
    figure->start = fmin(figure->start, 1e3 * (started - opened));
    figure->solve = fmin(figure->solve, 1e3 * (seconds() - started));
    struct drape_settings least = request->settings;
    for (int k = 0; k < 2; k++) {
        least.generator[k].kind = DRAPE_GENERATOR_LEAST;
        least.generator[k].curvature.points = 4;
    }
    started = seconds();
    if (drape_solve(&part.part, &least, NULL, arena, &result) != STATUS_OK)
        return false;
    figure->least = fmin(figure->least, 1e3 * (seconds() - started));
    return true;
}

struct buffer {
    char *bytes;
    size_t length;
};

static bool add_bytes(void *context, const void *bytes, size_t length) {
    struct buffer *buffer = context;
    char *all = realloc(buffer->bytes, buffer->length + length);
    if (!all)
        return false;
    memcpy(all + buffer->length, bytes, length);
    buffer->bytes = all;
    buffer->length += length;
    return true;
}

/* Writes the form of the part, and opens it as often as the part is made. */
static bool open_form(const struct api_request *request, struct arena *arena,
                      struct figure *figure) {
    static const char source[API_ID_SIZE] = "0123456789abcdef0123456789abcdef";
    struct buffer form = {NULL, 0};
    const struct api_sink sink = {.write = add_bytes, .context = &form};
    struct prepared_part part;
    bool good = open_part(request, arena, &part) &&
                prepared_form_write(request, &part, source, arena, &sink) > 0;
    for (int round = 0; good && round < ROUNDS; round++) {
        struct arena *own = arena_new((size_t)1 << 30);
        double begun = seconds();
        good = own && prepared_form_open(form.bytes, form.length, source, own);
        figure->form = fmin(figure->form, 1e3 * (seconds() - begun));
        arena_free(own);
    }
    free(form.bytes);
    return good;
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void print_summary(const struct figure *figures, int count) {
    for (int which = 0; which < 2; which++) {
        double column[6][PARTS_MAX];
        for (int k = 0; k < count; k++) {
            const struct figure *f = &figures[k];
            column[0][k] = f->open;
            column[1][k] = f->form;
            column[2][k] = f->start;
            column[3][k] = f->solve;
            column[4][k] = 1e6 * f->solve / (double)f->nodes;
            column[5][k] = f->least;
        }
        printf("%-16s %5s %7s", which ? "worst" : "median", "", "");
        for (int c = 0; c < 6; c++) {
            qsort(column[c], (size_t)count, sizeof **column, compare);
            printf(c < 4   ? " %8.2f"
                   : c < 5 ? " %8.0f"
                           : " %8.1f",
                   column[c][which ? count - 1 : count / 2]);
        }
        printf("\n");
    }
}

static bool bench_part(const char *path, double nodes, struct figure *figure) {
    struct arena *arena = arena_new((size_t)8 << 30);
    struct api_request request;
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    *figure = (struct figure){.open = HUGE_VAL,
                              .form = HUGE_VAL,
                              .start = HUGE_VAL,
                              .solve = HUGE_VAL,
                              .least = HUGE_VAL};
    if (arena)
        arena_clear(arena);
    bool good = arena && read_request(path, nodes, arena, &request);
    for (int round = 0; good && round < ROUNDS; round++) {
        struct arena_mark mark = arena_mark(arena);
        good = run_once(&request, arena, figure);
        arena_rewind(arena, mark);
    }
    good = good && open_form(&request, arena, figure);
    arena_free(arena);
    if (good)
        printf("%-16.*s %5zu %7zu %8.2f %8.2f %8.2f %8.2f %8.0f %8.1f\n", (int)strcspn(name, "."),
               name, figure->faces, figure->nodes, figure->open, figure->form, figure->start,
               figure->solve, 1e6 * figure->solve / (double)figure->nodes, figure->least);
    else
        printf("%s: failed\n", name);
    return good;
}

int main(int argc, char **argv) {
    struct figure figures[PARTS_MAX];
    int count = argc - 2;
    double nodes = argc > 1 ? atof(argv[1]) : 0;
    if (count < 1 || count > PARTS_MAX || !(nodes > 0) || !api_prepare()) {
        fprintf(stderr, "usage: bench_parts N SURFACE.json...\n");
        return 2;
    }
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
    printf("CAD parts, nets of about %.0f nodes\n%-16s %5s %7s %8s %8s %8s %8s %8s %8s\n", nodes,
           "part", "faces", "nodes", "open ms", "form ms", "start ms", "solve ms", "ns/node",
           "least ms");
    for (int k = 0; k < count; k++)
        if (!bench_part(argv[k + 2], nodes, &figures[k]))
            return 1;
    print_summary(figures, count);
    return 0;
}
