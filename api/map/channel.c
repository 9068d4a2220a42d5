/* SPDX-License-Identifier: MIT */
#include "channel.h"

#include "map_columns.h"
#include "net.h"
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

static struct vec3 rim_point(const struct rim *rim, size_t k) {
    return vec3_make(rim->x[k], rim->y[k], rim->z[k]);
}

/* ---- reading it ---- */

static double *read_rim_column(const struct api_reader *reader, const struct api_columns *columns,
                               const char *name, struct arena *arena, struct api_problem *problem) {
    const struct api_column *column = api_columns_find(columns, API_TABLE_RIM, name);
    double *values = column ? arena_take(arena, column->rows + 1, sizeof *values) : NULL;
    if (column && !values)
        map_net_no_memory(problem);
    else if (!column || !api_columns_read(reader, column, 0, column->rows, values))
        map_net_damaged(problem);
    return values;
}

/* Goes on until a line is near enough. */
static bool is_line_far(void *context, int32_t number) {
    struct search *search = context;
    const struct rim *rim = search->rim;
    struct vec3 from = rim_point(rim, (size_t)number);
    struct vec3 to = rim_point(rim, rim->next[number]);
    search->near = map_segment_distance(from, to, search->middle) <= search->width;
    return !search->near;
}

enum api_problem_id map_channel_mark(const struct map_target *target,
                                     const struct api_reader *reader,
                                     const struct api_columns *columns, struct arena *arena,
                                     size_t *marked, struct api_problem *problem) {
    struct rim rim = {.count = api_columns_rows(columns, API_TABLE_RIM)};
    size_t first = 0;
    rim.loop = read_rim_column(reader, columns, "loop", arena, problem);
    rim.x = read_rim_column(reader, columns, "x", arena, problem);
    rim.y = read_rim_column(reader, columns, "y", arena, problem);
    rim.z = read_rim_column(reader, columns, "z", arena, problem);
    if (problem->id != API_OK)
        return problem->id;
    /* Which points follow each other, and boxes round the lines between them. */
    struct box *box = arena_take(arena, rim.count + 1, sizeof *box);
    rim.next = arena_take(arena, rim.count + 1, sizeof *rim.next);
    bool good = box && rim.next;
    for (size_t k = 0; good && k < rim.count; k++) {
        bool last = k + 1 == rim.count || rim.loop[k + 1] > rim.loop[k];
        rim.next[k] = last ? first : k + 1;
        first = last ? k + 1 : first;
        box[k] = box_round(rim_point(&rim, k), rim_point(&rim, rim.next[k]), 0);
    }
    if (!good || boxes_make(box, rim.count, arena, &rim.boxes) != STATUS_OK)
        return map_net_no_memory(problem);
    *marked = 0;
    for (size_t k = 0; k < target->element_count; k++) {
        struct vec3 middle = map_target_point(target, k);
        struct search search = {&rim, middle, target->channel_width, false};
        struct box round = box_round(middle, middle, target->channel_width);
        if (target->roles[k] != MAP_FABRIC)
            continue;
        boxes_visit(rim.boxes, &round, is_line_far, &search);
        target->roles[k] = search.near ? MAP_CHANNEL : MAP_FABRIC;
        *marked += search.near;
    }
    return API_OK;
}

/* ---- what it does to the flow ---- */

void map_channel_fill(const struct map_target *target, double *const k[3], double *const tensor[6],
                      struct api_map *map) {
    const double own = target->channel_permeability;
    if (!target->has_role[MAP_CHANNEL])
        return;
    if (!k[0])
        map_warn(map, "edge_channel: the request has no permeability: in this map the column role "
                      "alone says where the channel is");
    for (size_t e = 0; k[0] && e < target->element_count; e++) {
        if (target->roles[e] != MAP_CHANNEL)
            continue;
        k[0][e] = k[1][e] = k[2][e] = own;
        for (int part = 0; part < 6; part++) /* XX YY ZZ, then what lies beside the diagonal */
            tensor[part][e] = part < 3 ? own : 0;
    }
}
