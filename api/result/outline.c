/* SPDX-License-Identifier: MIT */
#include "outline.h"

#include <stdlib.h>
#include <string.h>

enum { BLOCK = 1024 };

/* Cells first .. last - 1 of a row. */
struct run {
    int32_t first, last;
};

struct row {
    int32_t j;
    struct run *runs;
    size_t count, capacity;
};

static const struct row none = {0};

/* A side of the outline, from one lattice point to another. */
struct side {
    int32_t i, j, to_i, to_j;
    bool used;
};

struct builder {
    struct row below, row; /* the row before, the one that grows */
    struct side *sides;
    size_t count, capacity;
    bool failed; /* no memory */
};

/* The elements with room for one more of `size` bytes; `failed` is set without memory. */
static void *room_for(void *elements, size_t count, size_t *capacity, size_t size, bool *failed) {
    if (count < *capacity)
        return elements;
    size_t wanted = *capacity ? 2 * *capacity : 64;
    void *larger = realloc(elements, wanted * size);
    *capacity = larger ? wanted : *capacity;
    *failed = *failed || !larger;
    return larger ? larger : elements;
}

static void add_side(struct builder *builder, int32_t i, int32_t j, int32_t to_i, int32_t to_j) {
    builder->sides = room_for(builder->sides, builder->count, &builder->capacity,
                              sizeof *builder->sides, &builder->failed);
    if (!builder->failed)
        builder->sides[builder->count++] = (struct side){i, j, to_i, to_j, false};
}

/* ---- sides ---- */

/* The place of the k-th end of a row's runs, INT32_MAX behind the last. */
static int32_t run_end_at(const struct row *row, size_t k) {
    if (k / 2 >= row->count)
        return INT32_MAX;
    return k % 2 ? row->runs[k / 2].last : row->runs[k / 2].first;
}

/* The sides on the line j between two rows: where only one of them has cells. */
static void close_line(struct builder *builder, int32_t j, const struct row *below,
                       const struct row *above) {
    size_t ends[2] = {0, 0};
    int32_t from = 0;
    for (;;) {
        int32_t next[2] = {run_end_at(below, ends[0]), run_end_at(above, ends[1])};
        int32_t to = next[0] < next[1] ? next[0] : next[1];
        bool in_below = ends[0] % 2, in_above = ends[1] % 2;
        if (in_above && !in_below)
            add_side(builder, from, j, to, j);
        if (in_below && !in_above)
            add_side(builder, to, j, from, j);
        if (to == INT32_MAX)
            return;
        for (int k = 0; k < 2; k++)
            ends[k] += next[k] == to;
        from = to;
    }
}

/* The row is complete: its sides, and those on the line under it. */
static void finish_row(struct builder *builder) {
    struct row *row = &builder->row, *below = &builder->below;
    if (row->count == 0)
        return;
    bool adjacent = below->count > 0 && below->j == row->j - 1;
    if (below->count > 0 && !adjacent)
        close_line(builder, below->j + 1, below, &none);
    close_line(builder, row->j, adjacent ? below : &none, row);
    for (size_t k = 0; k < row->count; k++) {
        add_side(builder, row->runs[k].last, row->j, row->runs[k].last, row->j + 1);
        add_side(builder, row->runs[k].first, row->j + 1, row->runs[k].first, row->j);
    }
    struct row swap = *below;
    *below = *row;
    *row = swap;
    row->count = 0;
}

static bool read_cells(struct builder *builder, struct outline *outline,
                       const struct api_reader *reader, const struct api_columns *columns) {
    const struct api_column *column[2] = {api_columns_find(columns, API_TABLE_CELLS, "i"),
                                          api_columns_find(columns, API_TABLE_CELLS, "j")};
    struct row *row = &builder->row;
    double block[2][BLOCK];
    int32_t before[2] = {0, 0};
    size_t rows = column[0] && column[1] ? column[0]->rows : 0;
    for (size_t first = 0, count; first < rows; first += count) {
        count = rows - first < BLOCK ? rows - first : BLOCK;
        if (!api_columns_read(reader, column[0], first, count, block[0]) ||
            !api_columns_read(reader, column[1], first, count, block[1]))
            return false;
        for (size_t k = 0; k < count && !builder->failed; k++) {
            int32_t i = (int32_t)block[0][k], j = (int32_t)block[1][k];
            const int32_t low[2] = {i, j};
            bool start = first + k == 0;
            for (int axis = 0; axis < 2; axis++) {
                if (start || low[axis] < outline->low[axis])
                    outline->low[axis] = low[axis];
                if (start || low[axis] + 1 > outline->high[axis])
                    outline->high[axis] = low[axis] + 1;
            }
            if (!start && (j < before[1] || (j == before[1] && i <= before[0])))
                return false;
            /* The cell goes on the last run of its row, or begins one. */
            if (row->count > 0 && row->j != j)
                finish_row(builder);
            row->j = j;
            if (row->count > 0 && row->runs[row->count - 1].last == i) {
                row->runs[row->count - 1].last = i + 1;
            } else {
                row->runs = room_for(row->runs, row->count, &row->capacity, sizeof *row->runs,
                                     &builder->failed);
                if (!builder->failed)
                    row->runs[row->count++] = (struct run){i, i + 1};
            }
            before[0] = i;
            before[1] = j;
        }
    }
    finish_row(builder);
    if (builder->below.count > 0 && !builder->failed)
        close_line(builder, builder->below.j + 1, &builder->below, &none);
    return column[0] && column[1];
}

/* ---- polygons ---- */

static int compare_starts(const void *a, const void *b) {
    const struct side *x = a, *y = b;
    return x->j != y->j ? (x->j > y->j) - (x->j < y->j) : (x->i > y->i) - (x->i < y->i);
}

static int sign(int32_t value) {
    return (value > 0) - (value < 0);
}

/* > 0 where the outline turns left from one side to the next, 0 where it goes straight on. */
static int side_turn(const struct side *side, const struct side *next) {
    int a[2] = {sign(side->to_i - side->i), sign(side->to_j - side->j)};
    int b[2] = {sign(next->to_i - next->i), sign(next->to_j - next->j)};
    return a[0] * b[1] - a[1] * b[0];
}

enum api_problem_id outline_make(struct outline *outline, const struct api_reader *reader,
                                 const struct api_columns *columns, struct api_problem *problem) {
    struct builder builder = {0};
    if (!read_cells(&builder, outline, reader, columns))
        api_problem_set(problem, API_INTERNAL, "the stored result is damaged");
    else if (builder.count > 0)
        qsort(builder.sides, builder.count, sizeof *builder.sides, compare_starts);
    for (size_t k = 0; problem->id == API_OK && !builder.failed && k < builder.count; k++) {
        struct side *const sides = builder.sides, *const end = sides + builder.count;
        struct side *side = sides[k].used || sides[k].j != sides[k].to_j ? NULL : &sides[k];
        bool begun = side != NULL;
        /* The polygon of a side that lies along i: it begins at a corner. */
        for (bool corner = true; side && !builder.failed;) {
            if (corner)
                outline->points = room_for(outline->points, outline->count, &outline->capacity,
                                           sizeof *outline->points, &builder.failed);
            if (corner && !builder.failed)
                outline->points[outline->count++] = (struct outline_point){side->i, side->j, false};
            side->used = true;
            /* The side that begins where this one ends; where two do, the one to the left, which
             * keeps cells that touch at a corner apart. */
            const struct side key = {.i = side->to_i, .j = side->to_j};
            struct side *next = NULL;
            struct side *found = bsearch(&key, sides, builder.count, sizeof *sides, compare_starts);
            while (found && found > sides && compare_starts(found - 1, &key) == 0)
                found--;
            for (; found && found < end && compare_starts(found, &key) == 0; found++)
                if (!found->used && (!next || side_turn(side, found) > side_turn(side, next)))
                    next = found;
            corner = next && side_turn(side, next) != 0;
            side = next;
        }
        if (begun && !builder.failed)
            outline->points[outline->count - 1].last = true;
    }
    if (builder.failed)
        api_problem_no_memory(problem, "the outline");
    free(builder.below.runs);
    free(builder.row.runs);
    free(builder.sides);
    return problem->id;
}

void outline_free(struct outline *outline) {
    free(outline->points);
    *outline = (struct outline){0};
}
