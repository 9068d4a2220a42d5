/* SPDX-License-Identifier: MIT */
#include "vtk_xml.h"

#include "api/json/number.h"
#include "api/json/text.h"
#include "target.h"

#include <expat.h>
#include <sodium.h>
#include <string.h>
#include <zlib.h>

/* What stands in a file, or is unpacked from it. */
struct bytes_view {
    const unsigned char *at;
    size_t length;
};

enum number_kind { REAL, SIGNED, UNSIGNED };

/* How an array is stored; `format` is NULL where there is none. */
struct data_array {
    char format; /* 'a' ascii, 'b' binary, 'p' appended; 0: there is no such array */
    enum number_kind kind;
    size_t size;     /* of a number, bytes */
    uint64_t offset; /* of what is appended */
    struct api_text text;
};

struct xml_file {
    struct arena *arena;
    struct api_problem *problem;
    XML_Parser parser;
    bool swapped, wide, packed; /* not the machine's byte order; headers of 8 bytes, not 4; zlib */
    bool in_cells, in_cell_data, in_points;
    int pieces;
    bool appended, base64; /* there is appended data, in base64 */
    size_t appended_at;    /* where the element begins, in the file */
    size_t points, cells;
    int current; /* the use of the array whose text is being read; VTK_ARRAYS: none */
    int within;  /* how many elements are open in it, whose text is not its own */
    struct data_array array[VTK_ARRAYS];
};

static const char *const use_names[VTK_ARRAYS] = {"Points", "connectivity", "offsets",
                                                  "types",  "id",           "pid"};

#define VTK_REFUSE(file, ...)                                                                      \
    ((file)->problem->id == API_OK ? MAP_REFUSE((file)->problem, __VA_ARGS__) : false)

/* ---- the description ---- */

/* The value of an attribute, or NULL. */
static const char *attribute(const char *const *attributes, const char *name) {
    for (; *attributes; attributes += 2)
        if (strcmp(attributes[0], name) == 0)
            return attributes[1];
    return NULL;
}

static bool attribute_is(const char *const *attributes, const char *name, const char *value) {
    const char *own = attribute(attributes, name);
    return own && strcmp(own, value) == 0;
}

static bool count_of(struct xml_file *file, const char *const *attributes, const char *name,
                     size_t *count) {
    const char *text = attribute(attributes, name);
    double value = -1;
    bool good = text && api_number_read(text, strlen(text), &value) == strlen(text);
    *count = good && value >= 0 && value <= INT32_MAX ? (size_t)value : 0;
    return (good && value >= 0 && value <= INT32_MAX) ||
           VTK_REFUSE(file, "%s of the piece must be a number from 0 to 2147483647", name);
}

static bool begin_file(struct xml_file *file, const char *const *attributes) {
    const char *type = attribute(attributes, "type");
    const char *compressor = attribute(attributes, "compressor");
    bool big = attribute_is(attributes, "byte_order", "BigEndian");
    file->swapped = big != (__BYTE_ORDER == __BIG_ENDIAN);
    file->wide = attribute_is(attributes, "header_type", "UInt64");
    file->packed = compressor != NULL;
    if (!type || strcmp(type, "UnstructuredGrid") != 0)
        return VTK_REFUSE(file,
                          "this VTK file is a %.40s: save the shell as an unstructured grid (.vtu)",
                          type ? type : "file without a type");
    return !compressor || strcmp(compressor, "vtkZLibDataCompressor") == 0 ||
           VTK_REFUSE(file, "the file is packed by %.40s: save it with zlib or without compression",
                      compressor);
}

static bool begin_array(struct xml_file *file, const char *const *attributes) {
    static const struct {
        const char *name;
        enum number_kind kind;
        size_t size;
    } types[] = {{"Float64", REAL, 8},    {"Float32", REAL, 4},    {"Int64", SIGNED, 8},
                 {"Int32", SIGNED, 4},    {"Int16", SIGNED, 2},    {"Int8", SIGNED, 1},
                 {"UInt64", UNSIGNED, 8}, {"UInt32", UNSIGNED, 4}, {"UInt16", UNSIGNED, 2},
                 {"UInt8", UNSIGNED, 1}};
    const char *name = attribute(attributes, "Name"), *format = attribute(attributes, "format");
    const char *offset = attribute(attributes, "offset");
    double place = 0;
    size_t type = 0;
    int use = file->in_points ? VTK_POINTS_ARRAY : file->in_cells ? VTK_CONNECTIVITY : VTK_IDS;
    int end = file->in_points ? VTK_CONNECTIVITY : file->in_cells ? VTK_IDS : VTK_ARRAYS;
    while (!file->in_points && use < end && !(name && strcmp(name, use_names[use]) == 0))
        use++;
    if (use == end)
        return true; /* some other field */
    while (type < sizeof types / sizeof *types &&
           !attribute_is(attributes, "type", types[type].name))
        type++;
    if (type == sizeof types / sizeof *types)
        return use >= VTK_IDS ||
               VTK_REFUSE(file, "the array %s is of a type that is not read", use_names[use]);
    if (use >= VTK_IDS && types[type].kind == REAL)
        return true; /* a field of that name, no numbers */
    if (file->array[use].format)
        return VTK_REFUSE(file, "the array %s is defined twice", use_names[use]);
    if (offset && (api_number_read(offset, strlen(offset), &place) != strlen(offset) || place < 0 ||
                   place > 1e15))
        return VTK_REFUSE(file, "the offset of the array %s is none", use_names[use]);
    file->array[use] = (struct data_array){.format = !format || strcmp(format, "ascii") == 0 ? 'a'
                                                     : strcmp(format, "appended") == 0       ? 'p'
                                                                                             : 'b',
                                           .kind = types[type].kind,
                                           .size = types[type].size,
                                           .offset = (uint64_t)place,
                                           .text = api_text_growing(file->arena)};
    file->current = use;
    return true;
}

static void XMLCALL begin_element(void *context, const char *name, const char **attributes) {
    struct xml_file *file = context;
    const char *const *given = (const char *const *)attributes;
    bool good = true;
    if (file->current < VTK_ARRAYS)
        file->within++;
    else if (strcmp(name, "VTKFile") == 0)
        good = begin_file(file, given);
    else if (strcmp(name, "Piece") == 0)
        good = (file->pieces++ == 0 ||
                VTK_REFUSE(file, "the file has several pieces: merge them into one")) &&
               count_of(file, given, "NumberOfPoints", &file->points) &&
               count_of(file, given, "NumberOfCells", &file->cells);
    else if (strcmp(name, "Points") == 0)
        file->in_points = true;
    else if (strcmp(name, "Cells") == 0)
        file->in_cells = true;
    else if (strcmp(name, "CellData") == 0)
        file->in_cell_data = true;
    else if (strcmp(name, "DataArray") == 0 &&
             (file->in_points || file->in_cells || file->in_cell_data))
        good = begin_array(file, given);
    else if (strcmp(name, "AppendedData") == 0) {
        file->appended = true;
        file->base64 = attribute_is(given, "encoding", "base64");
        file->appended_at = (size_t)XML_GetCurrentByteIndex(file->parser);
        good = false;
    }
    if (!good)
        XML_StopParser(file->parser, XML_FALSE);
}

static void XMLCALL end_element(void *context, const char *name) {
    struct xml_file *file = context;
    file->in_points = file->in_points && strcmp(name, "Points") != 0;
    file->in_cells = file->in_cells && strcmp(name, "Cells") != 0;
    file->in_cell_data = file->in_cell_data && strcmp(name, "CellData") != 0;
    if (file->within > 0)
        file->within--;
    else
        file->current = VTK_ARRAYS;
}

static void XMLCALL take_text(void *context, const char *text, int length) {
    struct xml_file *file = context;
    if (file->current < VTK_ARRAYS && file->within == 0 && file->array[file->current].format != 'p')
        api_text_bytes(&file->array[file->current].text, text, (size_t)length);
}

/* No entity is expanded: a file of meshes has none. */
static void XMLCALL refuse_entity(void *context, const char *name, int parameter, const char *value,
                                  int length, const char *base, const char *system,
                                  const char *public, const char *notation) {
    struct xml_file *file = context;
    (void)name, (void)parameter, (void)value, (void)length, (void)base, (void)system, (void)public,
        (void)notation;
    (void)VTK_REFUSE(file, "the file defines entities, which no VTK file has");
    XML_StopParser(file->parser, XML_FALSE);
}

static bool parse_description(struct xml_file *file, const char *bytes, size_t length) {
    enum { CHUNK = 1 << 20 };
    enum XML_Status status = XML_STATUS_OK;
    file->parser = XML_ParserCreate(NULL);
    if (!file->parser)
        return map_target_no_memory(file->problem);
    XML_SetUserData(file->parser, file);
    XML_SetElementHandler(file->parser, begin_element, end_element);
    XML_SetCharacterDataHandler(file->parser, take_text);
    XML_SetEntityDeclHandler(file->parser, refuse_entity);
    for (size_t at = 0; at <= length && status == XML_STATUS_OK; at += CHUNK) {
        size_t part = length - at < CHUNK ? length - at : CHUNK;
        status = XML_Parse(file->parser, bytes + at, (int)part, at + part == length);
        if (at + part == length)
            break;
    }
    if (status != XML_STATUS_OK && !file->appended)
        (void)VTK_REFUSE(file, "line %lu: this is not a VTK XML file: %s",
                         (unsigned long)XML_GetCurrentLineNumber(file->parser),
                         XML_ErrorString(XML_GetErrorCode(file->parser)));
    XML_ParserFree(file->parser);
    return file->problem->id == API_OK;
}

/* ---- numbers ---- */

/* Reads base64 up to where it ends: pieces of it, each with its padding. NULL without memory. */
static unsigned char *read_base64(struct bytes_view text, struct arena *arena, size_t *length) {
    size_t most = text.length / 4 * 3 + 3, part = 1;
    unsigned char *bytes = arena_take(arena, most, 1);
    const char *at = (const char *)text.at, *end = at + text.length;
    *length = 0;
    while (bytes && at < end && part > 0) {
        if (sodium_base642bin(bytes + *length, most - *length, at, (size_t)(end - at), " \t\r\n",
                              &part, &at, sodium_base64_VARIANT_ORIGINAL) != 0)
            break;
        *length += part;
    }
    return bytes;
}

/* The whole number of `size` bytes there. */
static uint64_t whole_at(const struct xml_file *file, const unsigned char *at, size_t size) {
    uint64_t value = 0;
    bool little = file->swapped == (__BYTE_ORDER == __BIG_ENDIAN);
    for (size_t k = 0; k < size; k++)
        value = value << 8 | at[little ? size - 1 - k : k];
    return value;
}

static double array_number(const struct xml_file *file, const struct data_array *array,
                           const unsigned char *at) {
    uint64_t bits = whole_at(file, at, array->size);
    uint32_t half = (uint32_t)bits;
    double wide;
    float narrow;
    int shift = (int)(8 * (8 - array->size));
    if (array->kind == UNSIGNED)
        return (double)bits;
    if (array->kind == SIGNED)
        return (double)((int64_t)(bits << shift) >> shift);
    memcpy(&wide, &bits, sizeof wide);
    memcpy(&narrow, &half, sizeof narrow);
    return array->size == sizeof wide ? wide : (double)narrow;
}

static bool cut_short(struct xml_file *file, int use) {
    return VTK_REFUSE(file, "the array %s is damaged or cut short", use_names[use]);
}

/* Unpacks the blocks of an array: their number, the length of each and of the last, if that is
 * another, and how long each is packed; then the blocks. */
static bool unpack(struct xml_file *file, int use, struct bytes_view packed,
                   struct bytes_view *out) {
    enum { RATIO = 1032 }; /* more than zlib can pack */
    size_t word = file->wide ? 8 : 4;
    if (packed.length < word)
        return cut_short(file, use);
    uint64_t blocks = whole_at(file, packed.at, word);
    if (blocks == 0) {
        *out = (struct bytes_view){packed.at, 0};
        return true;
    }
    if (blocks > packed.length / word || packed.length < (3 + blocks) * word)
        return cut_short(file, use);
    uint64_t block = whole_at(file, packed.at + word, word);
    uint64_t last = whole_at(file, packed.at + 2 * word, word);
    uint64_t at = (3 + blocks) * word, most = RATIO * (uint64_t)packed.length;
    if (block == 0 || block > most / blocks || last > block)
        return cut_short(file, use);
    uint64_t total = (blocks - (last > 0)) * block + last;
    unsigned char *bytes = arena_take(file->arena, (size_t)total, 1);
    if (!bytes)
        return map_target_no_memory(file->problem);
    for (uint64_t k = 0; k < blocks; k++) {
        uint64_t length = whole_at(file, packed.at + (3 + k) * word, word);
        uLongf room = (uLongf)(k + 1 == blocks && last > 0 ? last : block), wanted = room;
        if (length > packed.length - at ||
            uncompress(bytes + k * block, &room, packed.at + at, (uLong)length) != Z_OK ||
            room != wanted)
            return cut_short(file, use);
        at += length;
    }
    *out = (struct bytes_view){bytes, (size_t)total};
    return true;
}

/* The bytes of an array that is not text, without its header. */
static bool find_bytes(struct xml_file *file, int use, struct bytes_view appended,
                       struct bytes_view *found) {
    struct data_array *array = &file->array[use];
    size_t word = file->wide ? 8 : 4;
    struct bytes_view raw;
    if (array->format == 'p') {
        if (array->offset > appended.length)
            return cut_short(file, use);
        raw = (struct bytes_view){appended.at + array->offset, appended.length - array->offset};
    } else {
        raw.length = array->text.length;
        raw.at = (const unsigned char *)api_text_finish(&array->text);
        if (!raw.at)
            return map_target_no_memory(file->problem);
    }
    if (array->format == 'b' || file->base64) {
        size_t length;
        raw.at = read_base64(raw, file->arena, &length);
        if (!raw.at)
            return map_target_no_memory(file->problem);
        raw.length = length;
    }
    if (file->packed)
        return unpack(file, use, raw, found);
    if (raw.length < word || whole_at(file, raw.at, word) > raw.length - word)
        return cut_short(file, use);
    *found = (struct bytes_view){raw.at + word, (size_t)whole_at(file, raw.at, word)};
    return true;
}

/* The numbers of an array that is text. */
static bool read_ascii(struct xml_file *file, int use, double **values, size_t *count) {
    struct data_array *array = &file->array[use];
    size_t length = array->text.length, at = 0, most = length / 2 + 1;
    const char *text = api_text_finish(&array->text);
    *values = arena_take(file->arena, most, sizeof **values);
    *count = 0;
    if (!text || !*values)
        return map_target_no_memory(file->problem);
    while ((at += strspn(text + at, " \t\r\n")) < length) {
        size_t taken = api_number_read(text + at, length - at, &(*values)[*count]);
        at += taken;
        if (taken == 0 || (text[at] && !strchr(" \t\r\n", text[at])))
            return VTK_REFUSE(file, "the array %s must be numbers, not '%.*s'", use_names[use],
                              (int)strcspn(text + at - taken, " \t\r\n") < 24
                                  ? (int)strcspn(text + at - taken, " \t\r\n")
                                  : 24,
                              text + at - taken);
        ++*count;
    }
    return true;
}

/* All numbers of an array. */
static bool read_array(struct xml_file *file, int use, struct bytes_view appended, double **values,
                       size_t *count) {
    const struct data_array *array = &file->array[use];
    struct bytes_view bytes = {.length = 0};
    if (array->format == 'a')
        return read_ascii(file, use, values, count);
    if (!find_bytes(file, use, appended, &bytes))
        return false;
    *count = bytes.length / array->size;
    *values = arena_take(file->arena, *count, sizeof **values);
    if (!*values)
        return map_target_no_memory(file->problem);
    for (size_t k = 0; k < *count; k++)
        (*values)[k] = array_number(file, array, bytes.at + k * array->size);
    return true;
}

/* Where what is appended begins: behind the element's own sign. */
static struct bytes_view find_appended(const struct xml_file *file, const char *bytes,
                                       size_t length) {
    const char *end = bytes + length, *at = bytes + file->appended_at;
    at = file->appended ? memchr(at, '>', (size_t)(end - at)) : NULL;
    at = at ? memchr(at, '_', (size_t)(end - at)) : NULL;
    return at ? (struct bytes_view){(const unsigned char *)at + 1, (size_t)(end - at) - 1}
              : (struct bytes_view){(const unsigned char *)end, 0};
}

bool vtk_xml_read(const char *bytes, size_t length, struct arena *arena, struct vtk_grid *grid,
                  struct api_problem *problem) {
    struct xml_file file = {.arena = arena, .problem = problem, .current = VTK_ARRAYS};
    if (!parse_description(&file, bytes, length))
        return false;
    *grid = (struct vtk_grid){.points = file.points, .cells = file.cells};
    struct bytes_view appended = find_appended(&file, bytes, length);
    for (int use = 0; use < VTK_ARRAYS; use++)
        if (file.array[use].format &&
            !read_array(&file, use, appended, &grid->values[use], &grid->count[use]))
            return false;
    return file.pieces > 0 || VTK_REFUSE(&file, "the file has no piece of an unstructured grid");
}
