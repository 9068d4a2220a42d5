/* SPDX-License-Identifier: MIT */
#include "columns.h"

#include "api/json/text.h"
#include "api/json/value.h"
#include "solver/wide.h"
#include <endian.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char MAGIC[8] = "DRAPECOL";

enum {
    VERSION = 2,
    PREFIX = 16,      /* magic, version, header length */
    VALUE = 8,        /* bytes of a float64; columns begin on a multiple */
    PROBE_ROWS = 16,  /* most columns that vary do so here */
    BLOCK_ROWS = 4096 /* values written at once */
};

/* Bytes of a value in each form; of REPEATED the one that there is. */
static const size_t width[API_FORM_COUNT] = {[API_FORM_FLOAT64] = VALUE,
                                             [API_FORM_INT8] = 1,
                                             [API_FORM_INT16] = 2,
                                             [API_FORM_INT32] = 4,
                                             [API_FORM_REPEATED] = VALUE};

static uint64_t padded(uint64_t bytes) {
    return (bytes + VALUE - 1) / VALUE * VALUE;
}

/* Values that are stored of so many rows. */
static size_t stored_values(enum api_form form, size_t rows) {
    return form == API_FORM_REPEATED && rows > 0 ? 1 : rows;
}

/* Gives the columns their places, one after the other from `offset`. */
static void place_columns(struct api_columns *columns, uint64_t offset) {
    for (size_t i = 0; i < columns->count; i++) {
        struct api_column *column = &columns->column[i];
        column->offset = offset;
        offset += padded((uint64_t)stored_values(column->form, column->rows) * width[column->form]);
    }
    columns->length = offset;
}

static bool same_bits(double a, double b) {
    return memcmp(&a, &b, sizeof a) == 0;
}

/* The form that takes the fewest bytes. What cannot be read is left to sending it, which says so.
 */
static enum api_form choose_form(const struct api_column_source *source, double *block) {
    bool repeated = true, whole = source->integer;
    double first_value = 0, least = 0, most = 0;
    size_t count = 0;
    for (size_t first = 0; first < source->rows; first += count) {
        size_t left = source->rows - first, probed = first > 0 ? BLOCK_ROWS : PROBE_ROWS;
        count = left < probed ? left : probed;
        if (!source->fill(source->context, first, count, block))
            return API_FORM_FLOAT64;
        if (first == 0)
            first_value = least = most = block[0];
        /* Repeated: each has the bits of the one before. */
        repeated = repeated && same_bits(block[0], first_value) &&
                   memcmp(block, block + 1, (count - 1) * sizeof *block) == 0;
        /* Whole: they come back with their bits, as a negative zero would not. */
        bool still = whole;
        for (size_t i = 0; whole && i < count; i++) {
            double value = block[i];
            bool in_range = value >= -INT32_MAX && value <= INT32_MAX;
            still &= in_range && same_bits(value, (double)(int32_t)(in_range ? value : 0));
            least = value < least ? value : least;
            most = value > most ? value : most;
        }
        whole = still;
        if (!repeated && !whole)
            break;
    }
    return source->rows <= 1                         ? API_FORM_FLOAT64
           : repeated                                ? API_FORM_REPEATED
           : !whole                                  ? API_FORM_FLOAT64
           : least >= INT8_MIN && most <= INT8_MAX   ? API_FORM_INT8
           : least >= INT16_MIN && most <= INT16_MAX ? API_FORM_INT16
                                                     : API_FORM_INT32;
}

static enum api_problem_id send(const struct api_sink *sink, const void *bytes, size_t length,
                                struct api_problem *problem) {
    if (length == 0 || sink->write(sink->context, bytes, length))
        return API_OK;
    return api_problem_set(problem, API_CANCELLED, "the result is no longer wanted");
}

/* A number that is not finite has all bits of its exponent set: one more would carry into the sign.
 */
WIDE_CLONES static bool all_finite(const double *values, size_t count) {
    typedef uint64_t bits4 __attribute__((vector_size(4 * VALUE)));
    const uint64_t one = (uint64_t)1 << 52, exponent = 0x7ff * one;
    bits4 bits, carried = {0};
    for (; count >= 4; count -= 4, values += 4) {
        memcpy(&bits, values, sizeof bits);
        carried |= (bits & exponent) + one;
    }
    bits = (bits4){0};
    memcpy(&bits, values, count * VALUE);
    carried |= (bits & exponent) + one;
    return (carried[0] | carried[1] | carried[2] | carried[3]) >> 63 == 0;
}

/* The result header is made in a buffer that leaves room for the prefix, so that one write sends
 * the header. */
static enum api_problem_id send_header(struct api_columns *header, const struct api_sink *sink,
                                       struct api_problem *problem) {
    char buffer[API_HEADER_MAX];
    struct api_text text = api_text_over(buffer, sizeof buffer);
    api_text_bytes(&text, (const char[PREFIX]){0}, PREFIX);
    result_header_write(&text, header);
    while (text.length % VALUE != 0)
        api_text_raw(&text, " ");
    /* The numbers of a header that a solve computed. */
    const struct api_start *start = &header->start;
    const double numbers[] = {start->uv[0],   start->uv[1],  start->point.x, start->point.y,
                              start->point.z, start->warp.x, start->warp.y,  start->warp.z,
                              start->weft.x,  start->weft.y, start->weft.z};
    bool finite = header->document == API_DOCUMENT_STUDY
                      ? isfinite(header->study.solve_ms)
                      : summary_finite(&header->summary) &&
                            all_finite(numbers, sizeof numbers / sizeof *numbers);
    if (text.failed || !finite)
        return api_problem_set(problem, API_INTERNAL,
                               text.failed
                                   ? "the result's header is too long"
                                   : "the result's summary has a value that is not a number");
    uint32_t version = htole32(VERSION), length = htole32((uint32_t)(text.length - PREFIX));
    memcpy(buffer, MAGIC, sizeof MAGIC);
    memcpy(buffer + 8, &version, sizeof version);
    memcpy(buffer + 12, &length, sizeof length);
    place_columns(header, text.length);
    return send(sink, buffer, text.length, problem);
}

/* ------------------------------------------------------------------ values as bytes */

/* A double and its little-endian bytes. */
static void swap_values(double *values, size_t count) {
    for (size_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        bits = htole64(bits);
        memcpy(&values[i], &bits, sizeof bits);
    }
}

/* In place, for no value is longer than a double: of a known `size` each, for which the compiler
 * makes a loop of its own. */
static inline void pack_whole(size_t size, double *values, size_t count) {
    unsigned char *bytes = (unsigned char *)values;
    for (size_t i = 0; i < count; i++) {
        uint32_t bits = htole32((uint32_t)(int32_t)values[i]);
        memcpy(bytes + i * size, &bits, size);
    }
}

/* The other way. The bytes are at the end of the room for `count` doubles, so that none is written
 * over before it is read. */
static inline void unpack_whole(size_t size, double *values, size_t count) {
    const unsigned char *bytes = (const unsigned char *)values + count * (VALUE - size);
    for (size_t i = 0; i < count; i++) {
        uint32_t bits = 0;
        memcpy(&bits, bytes + i * size, size);
        bits = le32toh(bits);
        values[i] = size == 1 ? (int8_t)bits : size == 2 ? (int16_t)bits : (int32_t)bits;
    }
}

/* ------------------------------------------------------------------ writing */

static enum api_problem_id send_column(const struct api_column_source *source, enum api_form form,
                                       double *block, const struct api_sink *sink,
                                       struct api_problem *problem) {
    static const char zeros[VALUE] = {0};
    size_t rows = stored_values(form, source->rows), length = 0;
    for (size_t first = 0; first < rows; first += BLOCK_ROWS) {
        size_t left = rows - first, count = left < BLOCK_ROWS ? left : BLOCK_ROWS;
        if (!source->fill(source->context, first, count, block) || !all_finite(block, count))
            return api_problem_set(problem, API_INTERNAL,
                                   "the result has a value in %s.%s that is not a number",
                                   api_table_name(source->table), source->name);
        if (form == API_FORM_INT8)
            pack_whole(1, block, count);
        else if (form == API_FORM_INT16)
            pack_whole(2, block, count);
        else if (form == API_FORM_INT32)
            pack_whole(4, block, count);
        else
            swap_values(block, count);
        length = count * width[form];
        if (send(sink, block, length, problem) != API_OK)
            return problem->id;
    }
    return send(sink, zeros, (size_t)padded(length) - length, problem);
}

enum api_problem_id api_columns_write(struct api_columns *header,
                                      const struct api_column_source *sources, size_t count,
                                      const struct api_sink *sink, struct arena *arena,
                                      struct api_problem *problem) {
    if (count > API_COLUMNS_MAX)
        return api_problem_set(problem, API_INTERNAL, "the result has too many columns");
    struct arena_mark mark = arena_mark(arena);
    double *block = arena_alloc(arena, BLOCK_ROWS, sizeof *block);
    if (!block)
        return api_problem_no_memory(problem, "the result");
    header->count = count;
    for (size_t i = 0; i < count; i++) {
        struct api_column *column = &header->column[i];
        *column = (struct api_column){.table = sources[i].table,
                                      .integer = sources[i].integer,
                                      .form = choose_form(&sources[i], block),
                                      .rows = sources[i].rows};
        strncpy(column->name, sources[i].name, API_COLUMN_NAME_SIZE - 1);
    }
    enum api_problem_id id = send_header(header, sink, problem);
    if (id == API_OK && sink->summary) {
        char *summary = api_columns_summary_json(header);
        if (!summary)
            id = api_problem_no_memory(problem, "the summary");
        else if (!sink->summary(sink->context, summary))
            id = api_problem_set(problem, API_CANCELLED, "the result is no longer wanted");
        free(summary);
    }
    for (size_t i = 0; i < count && id == API_OK; i++)
        id = send_column(&sources[i], header->column[i].form, block, sink, problem);
    arena_rewind(arena, mark);
    return id;
}

/* ------------------------------------------------------------------ reading */

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

enum api_problem_id api_columns_open(const struct api_reader *reader, struct api_columns *columns,
                                     struct api_problem *problem) {
    char prefix[PREFIX], buffer[API_HEADER_MAX];
    uint32_t version = 0, length = 0;
    struct api_problem inner = {0};
    struct json_tree tree = {0};
    *columns = (struct api_columns){0};
    bool good = reader->read_at(reader->context, 0, prefix, sizeof prefix);
    if (good) {
        memcpy(&version, prefix + 8, sizeof version);
        memcpy(&length, prefix + 12, sizeof length);
        version = le32toh(version);
        length = le32toh(length);
        good = memcmp(prefix, MAGIC, sizeof MAGIC) == 0 && version >= 1 && version <= VERSION &&
               length > 0 && length <= API_HEADER_MAX - PREFIX &&
               reader->read_at(reader->context, PREFIX, buffer, length);
    }
    if (good) {
        buffer[length] = '\0';
        good = result_header_take_columns(buffer, columns);
    }
    if (good && json_tree_parse(&tree, buffer, strlen(buffer), &api_limits_default, NULL, &inner) ==
                    API_OK) {
        result_header_read(&tree, columns);
        json_tree_free(&tree);
    }
    if (inner.id == API_OUT_OF_MEMORY)
        return api_problem_no_memory(problem, "the result");
    if (!good || inner.id != API_OK)
        return api_problem_set(problem, API_INTERNAL, "the stored result is damaged");
    place_columns(columns, PREFIX + length);
    return API_OK;
}

bool api_columns_whole(const struct api_reader *reader, const struct api_columns *columns) {
    char last;
    return reader->read_at(reader->context, columns->length - 1, &last, 1);
}

bool api_columns_read(const struct api_reader *reader, const struct api_column *column,
                      size_t first, size_t count, double *values) {
    enum api_form form = column->form;
    size_t stored = stored_values(form, count), bytes = stored * width[form];
    uint64_t offset = column->offset;
    if (form != API_FORM_REPEATED)
        offset += (uint64_t)first * width[form];
    if (!reader->read_at(reader->context, offset, (char *)values + stored * VALUE - bytes, bytes))
        return false;
    if (form == API_FORM_INT8)
        unpack_whole(1, values, stored);
    else if (form == API_FORM_INT16)
        unpack_whole(2, values, stored);
    else if (form == API_FORM_INT32)
        unpack_whole(4, values, stored);
    else
        swap_values(values, stored);
    /* Whole numbers, as those of fewer bytes are, lie within 2^53, where each is a double. */
    bool good = all_finite(values, stored);
    for (size_t i = 0; column->integer && width[form] == VALUE && i < stored; i++)
        good &= fabs(values[i]) <= 0x1p53 && values[i] == floor(values[i]);
    if (!good)
        return false;
    for (size_t i = stored; i < count; i++)
        values[i] = values[0];
    return true;
}
