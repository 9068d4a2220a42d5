/* SPDX-License-Identifier: MIT */
#include "columns.h"

#include "api/json/place.h"
#include "api/json/text.h"
#include <endian.h>
#include <math.h>
#include <string.h>

static const char MAGIC[8] = "DRAPECOL";

enum {
    VERSION = 1,
    PREFIX = 16,      /* magic, version, directory length */
    VALUE = 8,        /* bytes of one */
    BLOCK_ROWS = 4096 /* values written at once */
};

/* Gives the columns their places, one after the other from `offset`. */
static void place_columns(struct api_columns *columns, uint64_t offset) {
    for (size_t i = 0; i < columns->count; i++) {
        columns->column[i].offset = offset;
        offset += (uint64_t)columns->column[i].rows * VALUE;
    }
    columns->length = offset;
}

static void list_columns(struct api_columns *header, const struct api_column_source *sources,
                         size_t count) {
    header->count = count;
    for (size_t i = 0; i < count; i++) {
        struct api_column *column = &header->column[i];
        *column = (struct api_column){
            .table = sources[i].table, .integer = sources[i].integer, .rows = sources[i].rows};
        strncpy(column->name, sources[i].name, API_COLUMN_NAME_SIZE - 1);
    }
}

static enum api_problem_id send(const struct api_sink *sink, const void *bytes, size_t length,
                                struct api_problem *problem) {
    if (length == 0 || sink->write(sink->context, bytes, length))
        return API_OK;
    api_problem_set(problem, API_CANCELLED, "the result was not wanted any more");
    return problem->id;
}

static bool all_finite(const double *values, size_t count) {
    bool finite = true;
    for (size_t i = 0; i < count; i++)
        finite &= isfinite(values[i]) != 0;
    return finite;
}

/* Within 2^53, where every whole number is a double. */
static bool all_whole(const double *values, size_t count) {
    bool whole = true;
    for (size_t i = 0; i < count; i++)
        whole &= fabs(values[i]) <= 0x1p53 && values[i] == floor(values[i]);
    return whole;
}

/* The numbers of a header that a solve computed. */
static bool header_finite(const struct api_columns *header) {
    const struct api_start *start = &header->start;
    if (header->document == API_DOCUMENT_STUDY)
        return isfinite(header->study.solve_ms);
    const double numbers[] = {start->uv[0],   start->uv[1],  start->point.x, start->point.y,
                              start->point.z, start->warp.x, start->warp.y,  start->warp.z,
                              start->weft.x,  start->weft.y, start->weft.z};
    return summary_finite(&header->summary) &&
           all_finite(numbers, sizeof numbers / sizeof *numbers);
}

/* The directory is made in a buffer that leaves room for the prefix, so that one write sends the
 * header. */
static enum api_problem_id send_header(struct api_columns *header, const struct api_sink *sink,
                                       struct api_problem *problem) {
    char buffer[API_HEADER_MAX];
    struct api_text text = api_text_over(buffer, sizeof buffer);
    api_text_bytes(&text, (const char[PREFIX]){0}, PREFIX);
    directory_write(&text, header);
    while (text.length % VALUE != 0)
        api_text_raw(&text, " ");
    if (text.failed || !header_finite(header)) {
        api_problem_set(problem, API_INTERNAL,
                        text.failed ? "the result's header is too long"
                                    : "the result's summary has a value that is no number");
        return problem->id;
    }
    uint32_t version = htole32(VERSION), length = htole32((uint32_t)(text.length - PREFIX));
    memcpy(buffer, MAGIC, sizeof MAGIC);
    memcpy(buffer + 8, &version, sizeof version);
    memcpy(buffer + 12, &length, sizeof length);
    place_columns(header, text.length);
    return send(sink, buffer, text.length, problem);
}

/* A double and its little-endian bytes. */
static void swap_values(double *values, size_t count) {
    for (size_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        bits = htole64(bits);
        memcpy(&values[i], &bits, sizeof bits);
    }
}

static enum api_problem_id send_column(const struct api_column_source *source, double *block,
                                       const struct api_sink *sink, struct api_problem *problem) {
    for (size_t first = 0; first < source->rows; first += BLOCK_ROWS) {
        size_t left = source->rows - first, count = left < BLOCK_ROWS ? left : BLOCK_ROWS;
        if (!source->fill(source->context, first, count, block) || !all_finite(block, count)) {
            api_problem_set(problem, API_INTERNAL,
                            "the result has a value in %s.%s that is no number",
                            api_table_name(source->table), source->name);
            return problem->id;
        }
        swap_values(block, count);
        if (send(sink, block, count * VALUE, problem) != API_OK)
            return problem->id;
    }
    return API_OK;
}

enum api_problem_id api_columns_write(struct api_columns *header,
                                      const struct api_column_source *sources, size_t count,
                                      const struct api_sink *sink, struct arena *arena,
                                      struct api_problem *problem) {
    if (count > API_COLUMNS_MAX) {
        api_problem_set(problem, API_INTERNAL, "the result has too many columns");
        return problem->id;
    }
    struct arena_mark mark = arena_mark(arena);
    double *block = arena_alloc(arena, BLOCK_ROWS, sizeof *block);
    if (!block) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory to write the result");
        return problem->id;
    }
    list_columns(header, sources, count);
    enum api_problem_id id = send_header(header, sink, problem);
    for (size_t i = 0; i < count && id == API_OK; i++)
        id = send_column(&sources[i], block, sink, problem);
    arena_rewind(arena, mark);
    return id;
}

static bool read_memory(void *context, uint64_t offset, void *buffer, size_t length) {
    const struct api_memory *memory = context;
    if (offset > memory->length || length > memory->length - offset)
        return false;
    if (length > 0)
        memcpy(buffer, memory->bytes + offset, length);
    return true;
}

struct api_reader api_reader_of(struct api_memory *memory) {
    return (struct api_reader){read_memory, memory};
}

/* The directory's bytes in `buffer` of API_HEADER_MAX; 0 when this is no container. */
static size_t read_header(const struct api_reader *reader, char *buffer) {
    char prefix[PREFIX];
    uint32_t version, length;
    if (!reader->read_at(reader->context, 0, prefix, sizeof prefix))
        return 0;
    memcpy(&version, prefix + 8, sizeof version);
    memcpy(&length, prefix + 12, sizeof length);
    version = le32toh(version);
    length = le32toh(length);
    bool known = memcmp(prefix, MAGIC, sizeof MAGIC) == 0 && version == VERSION;
    if (!known || length > API_HEADER_MAX - PREFIX)
        return 0;
    return reader->read_at(reader->context, PREFIX, buffer, length) ? length : 0;
}

enum api_problem_id api_columns_open(const struct api_reader *reader, struct api_columns *columns,
                                     struct api_problem *problem) {
    char buffer[API_HEADER_MAX];
    struct api_problem inner = {0};
    struct json_tree tree = {0};
    size_t length = read_header(reader, buffer);
    *columns = (struct api_columns){0};
    if (length > 0 &&
        json_tree_parse(&tree, buffer, length, &api_limits_default, NULL, &inner) == API_OK) {
        directory_read(&tree, columns);
        json_tree_free(&tree);
    }
    if (inner.id == API_OUT_OF_MEMORY) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory to read the result");
        return API_OUT_OF_MEMORY;
    }
    if (length == 0 || inner.id != API_OK) {
        api_problem_set(problem, API_INTERNAL, "the stored result is damaged");
        return API_INTERNAL;
    }
    place_columns(columns, PREFIX + length);
    return API_OK;
}

bool api_columns_read(const struct api_reader *reader, const struct api_column *column,
                      size_t first, size_t count, double *values) {
    uint64_t offset = column->offset + (uint64_t)first * VALUE;
    if (!reader->read_at(reader->context, offset, values, count * VALUE))
        return false;
    swap_values(values, count);
    return all_finite(values, count) && (!column->integer || all_whole(values, count));
}
