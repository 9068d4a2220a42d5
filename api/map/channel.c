/* SPDX-License-Identifier: MIT */
#include "channel.h"

#include "solver/surface/boxes.h"

/* The rim as it was stored: loops of points, each closed by the line to its first point. */
struct rim {
    size_t count;
    double *loop, *x, *y, *z;
    size_t *next;        /* the point after each */
    struct boxes *boxes; /* round the lines from each point to the next */
};

/* What is asked of an element. */
struct search {
    const struct rim *rim;
    struct vec3 middle;
    double width;
    bool near;
};

/* |p - a - t (b - a)| with t = (p - a).(b - a) / |b - a|^2, within 0..1. */
double map_segment_distance(struct vec3 a, struct vec3 b, struct vec3 point) {
    struct vec3 line = vec3_sub(b, a), to = vec3_sub(point, a);
    double length2 = vec3_norm2(line), along = vec3_dot(to, line);
    double t = length2 <= 0 || along <= 0 ? 0 : along >= length2 ? 1 : along / length2;
    return vec3_distance(to, vec3_scale(t, line));
}

static struct vec3 point_at(const struct rim *rim, size_t k) {
    return vec3_make(rim->x[k], rim->y[k], rim->z[k]);
}

/* ---- reading it ---- */

static double *read_column(const struct api_reader *reader, const struct api_columns *columns,
                           const char *name, struct arena *arena, struct api_problem *problem) {
    const struct api_column *column = api_columns_find(columns, API_TABLE_RIM, name);
    double *values = column ? arena_take(arena, column->rows + 1, sizeof *values) : NULL;
    if (column && !values)
        api_problem_set(problem, API_OUT_OF_MEMORY, "the map needs more memory than allowed");
    else if (!column || !api_columns_read(reader, column, 0, column->rows, values))
        api_problem_set(problem, API_INTERNAL, "the stored result is damaged or cannot be read");
    return values;
}

static bool read_rim(const struct api_reader *reader, const struct api_columns *columns,
                     struct arena *arena, struct rim *rim, struct api_problem *problem) {
    rim->count = api_columns_rows(columns, API_TABLE_RIM);
    rim->loop = read_column(reader, columns, "loop", arena, problem);
    rim->x = read_column(reader, columns, "x", arena, problem);
    rim->y = read_column(reader, columns, "y", arena, problem);
    rim->z = read_column(reader, columns, "z", arena, problem);
    return problem->id == API_OK;
}

/* ---- searching it ---- */

static void close_loops(struct rim *rim) {
    size_t first = 0;
    for (size_t k = 0; k < rim->count; k++) {
        bool last = k + 1 == rim->count || rim->loop[k + 1] > rim->loop[k];
        rim->next[k] = last ? first : k + 1;
        first = last ? k + 1 : first;
    }
}

static bool make_tree(struct rim *rim, struct arena *arena, struct api_problem *problem) {
    struct box *box = arena_take(arena, rim->count + 1, sizeof *box);
    rim->next = arena_take(arena, rim->count + 1, sizeof *rim->next);
    bool good = box && rim->next;
    if (good)
        close_loops(rim);
    for (size_t k = 0; good && k < rim->count; k++)
        box[k] = box_round(point_at(rim, k), point_at(rim, rim->next[k]), 0);
    if (!good || boxes_make(box, rim->count, arena, &rim->boxes) != STATUS_OK)
        api_problem_set(problem, API_OUT_OF_MEMORY, "the map needs more memory than allowed");
    return problem->id == API_OK;
}

/* Goes on until a line is near enough. */
static bool look(void *context, int32_t number) {
    struct search *search = context;
    const struct rim *rim = search->rim;
    struct vec3 from = point_at(rim, (size_t)number);
    struct vec3 to = point_at(rim, rim->next[number]);
    search->near = map_segment_distance(from, to, search->middle) <= search->width;
    return !search->near;
}

static size_t mark_near(const struct map_target *target, const struct rim *rim) {
    size_t marked = 0;
    for (size_t k = 0; k < target->element_count; k++) {
        struct vec3 middle = map_target_point(target, k);
        struct search search = {rim, middle, target->channel_width, false};
        struct box round = box_round(middle, middle, target->channel_width);
        if (target->roles[k] != MAP_FABRIC)
            continue;
        boxes_visit(rim->boxes, &round, look, &search);
        target->roles[k] = search.near ? MAP_CHANNEL : MAP_FABRIC;
        marked += search.near;
    }
    return marked;
}

enum api_problem_id map_channel_mark(const struct map_target *target,
                                     const struct api_reader *reader,
                                     const struct api_columns *columns, struct arena *arena,
                                     size_t *marked, struct api_problem *problem) {
    struct rim rim = {0};
    if (read_rim(reader, columns, arena, &rim, problem) && make_tree(&rim, arena, problem))
        *marked = mark_near(target, &rim);
    return problem->id;
}
