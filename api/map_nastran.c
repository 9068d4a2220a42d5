/* SPDX-License-Identifier: MIT */
/* The Nastran bulk data of a map request, card by card. */
#include "map_mesh.h"

#include "number.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum {
    LINE_MAX_COLUMNS = 256, /* longer lines are cut; bulk data uses 80 columns */
    FIELD_SIZE = 32,        /* of a free field; fixed ones have 8 or 16 columns */
    FIELDS = 16,            /* of a card that are looked at, the name not counted */
    NAME_COLUMNS = 8,
    DATA_COLUMNS = 72, /* the continuation mark stands behind them */
    NAME_SIZE = 16,
    ID_MAX = 99999999
};

static const double coordinate_max = 1e12;

/* A card with its continuations. `given` counts the fields that its lines reach. */
struct card {
    size_t line;
    char name[NAME_SIZE];
    int given;
    char field[FIELDS][FIELD_SIZE];
};

struct reader {
    const char *at, *end; /* behind the current line */
    size_t number;        /* of the current line */
    char line[LINE_MAX_COLUMNS];
    bool held; /* the current line has not been used yet */
    bool bulk, ended;
    struct api_problem *problem;
};

/* What the file says, in the order of its cards. */
struct grids {
    size_t count;
    struct vec3 *point;
    int32_t *id;
    uint32_t *line;
};

struct elements {
    size_t count;
    int32_t (*nodes)[4]; /* ids of grids; the fourth of a triangle is -1 */
    int32_t *id;
    uint32_t *line;
};

struct file {
    struct reader reader;
    bool counting; /* the first of two passes: nothing is kept */
    struct grids grids;
    struct elements elements;
};

#define FAIL(problem, ...) (api_problem_set(problem, API_INVALID_REQUEST, __VA_ARGS__), false)

/* ---- lines ---- */

/* Copies the next line with its tabs expanded, without its comment. False at the end. */
static bool load_line(struct reader *reader) {
    size_t column = 0;
    if (reader->at == reader->end)
        return false;
    reader->number++;
    for (; reader->at < reader->end && *reader->at != '\n'; reader->at++) {
        char c = *reader->at;
        if (c == '$') {
            const char *newline = memchr(reader->at, '\n', (size_t)(reader->end - reader->at));
            reader->at = newline ? newline : reader->end;
            break;
        }
        size_t width = c == '\t' ? 8 - column % 8 : 1;
        for (; width > 0 && column < LINE_MAX_COLUMNS - 1; width--)
            reader->line[column++] = c == '\t' || c == '\r' || c == '\0' ? ' ' : c;
    }
    reader->at += reader->at < reader->end;
    reader->line[column] = '\0';
    return true;
}

static bool is_blank(const char *line) {
    return line[strspn(line, " ")] == '\0';
}

/* Whether the line begins with the word, or with the two. */
static bool begins_with(const char *line, const char *first, const char *second) {
    line += strspn(line, " ");
    size_t length = strlen(first);
    if (strncasecmp(line, first, length) != 0)
        return false;
    line += length;
    if (!*second)
        return *line == ' ' || *line == '\0' || *line == ',';
    return *line == ' ' && strncasecmp(line + strspn(line, " "), second, strlen(second)) == 0;
}

/* The next line that says something, until ENDDATA. */
static bool next_line(struct reader *reader) {
    if (reader->held) {
        reader->held = false;
        return true;
    }
    while (!reader->ended && load_line(reader)) {
        reader->ended = begins_with(reader->line, "ENDDATA", "");
        if (!reader->ended && !is_blank(reader->line))
            return true;
    }
    return false;
}

/* Passes what stands before BEGIN BULK, if there is one. */
static void skip_control(struct reader *reader) {
    struct reader ahead = *reader;
    while (load_line(&ahead)) {
        if (begins_with(ahead.line, "BEGIN", "BULK")) {
            *reader = ahead;
            reader->bulk = true;
            return;
        }
    }
}

/* ---- fields ---- */

/* Copies the text without the blanks around it; false when it does not fit. */
static bool copy_trimmed(const char *text, size_t length, char *out, size_t size) {
    while (length > 0 && *text == ' ')
        text++, length--;
    while (length > 0 && text[length - 1] == ' ')
        length--;
    bool fits = length < size;
    length = fits ? length : 0;
    memcpy(out, text, length);
    out[length] = '\0';
    return fits;
}

static bool put_field(struct reader *reader, struct card *card, int index, const char *text,
                      size_t length) {
    if (index >= FIELDS)
        return true;
    if (!copy_trimmed(text, length, card->field[index], FIELD_SIZE))
        return FAIL(reader->problem, "line %zu: a field is longer than %d characters",
                    reader->number, FIELD_SIZE - 1);
    card->given = index + 1 > card->given ? index + 1 : card->given;
    return true;
}

/* What stands before the first data field: a name, or what marks a continuation. */
static size_t head_length(const char *line, bool free_field) {
    size_t length = free_field ? strcspn(line, ",") : strlen(line);
    return !free_field && length > NAME_COLUMNS ? NAME_COLUMNS : length;
}

/* Fields of 8 columns, or 16 in large cards, up to column 72. */
static bool split_fixed(struct reader *reader, struct card *card, int first, bool large) {
    size_t length = strlen(reader->line), width = large ? 16 : 8, column = NAME_COLUMNS;
    for (int k = first; column < DATA_COLUMNS && column < length; k++, column += width) {
        size_t left = length - column;
        if (!put_field(reader, card, k, reader->line + column, left < width ? left : width))
            return false;
    }
    return true;
}

static bool split_free(struct reader *reader, struct card *card, int first, bool large) {
    const char *at = strchr(reader->line, ',');
    for (int k = 0; at && k < (large ? 4 : 8); k++) {
        size_t length = strcspn(++at, ",");
        if (!put_field(reader, card, first + k, at, length))
            return false;
        at = at[length] ? at + length : NULL;
    }
    return true;
}

/* Adds the fields of the current line from `*first` on, which becomes that of the next line. */
static bool split(struct reader *reader, struct card *card, int *first, char *head) {
    bool free_field = strchr(reader->line, ',') != NULL;
    if (!copy_trimmed(reader->line, head_length(reader->line, free_field), head, NAME_SIZE))
        return FAIL(reader->problem, "line %zu: this is no card", reader->number);
    size_t length = strlen(head);
    bool large = length > 0 && (head[0] == '*' || head[length - 1] == '*');
    bool good = free_field ? split_free(reader, card, *first, large)
                           : split_fixed(reader, card, *first, large);
    *first += large ? 4 : 8;
    return good;
}

static bool is_continuation(const char *line) {
    size_t blanks = strspn(line, " ");
    return *line == '+' || *line == '*' || blanks >= NAME_COLUMNS || line[blanks] == ',';
}

static void set_name(struct card *card, const char *head) {
    size_t length = strlen(head);
    length -= length > 0 && head[length - 1] == '*';
    for (size_t k = 0; k < length; k++)
        card->name[k] = head[k] >= 'a' && head[k] <= 'z' ? (char)(head[k] - 32) : head[k];
    card->name[length] = '\0';
    card->name[strcspn(card->name, " ")] = '\0';
}

/* The next card. False at the end, or with the problem set. */
static bool next_card(struct reader *reader, struct card *card) {
    char head[NAME_SIZE];
    int first = 0;
    if (!next_line(reader))
        return false;
    memset(card, 0, sizeof *card);
    card->line = reader->number;
    if (is_continuation(reader->line))
        return FAIL(reader->problem, "line %zu: a continuation without its card", reader->number);
    if (!split(reader, card, &first, head))
        return false;
    set_name(card, head);
    while (next_line(reader)) {
        if (!is_continuation(reader->line)) {
            reader->held = true;
            break;
        }
        if (!split(reader, card, &first, head))
            return false;
    }
    return true;
}

/* ---- values ---- */

static bool read_id(const struct card *card, int index, const char *what, int32_t *id,
                    struct api_problem *problem) {
    const char *text = card->field[index];
    int64_t value = 0;
    size_t length = strlen(text), k = text[0] == '+';
    for (; k < length && text[k] >= '0' && text[k] <= '9' && value <= ID_MAX; k++)
        value = 10 * value + (text[k] - '0');
    *id = (int32_t)value;
    if (length > 0 && k == length && value > 0 && value <= ID_MAX)
        return true;
    return FAIL(problem, "line %zu: %s of %s is '%s', which is no whole number from 1 to %d",
                card->line, what, card->name, text, ID_MAX);
}

/* Nastran's reals as the number reader has them: 1.5+3 and 1.5D+3 for 1.5e+3. False when it is none
 * that could be one. */
static bool normalise_real(const char *text, char out[FIELD_SIZE + 2]) {
    size_t length = 0;
    bool exponent = false;
    text += *text == '+';
    for (const char *c = text; *c; c++) {
        bool sign = (*c == '+' || *c == '-') && c > text;
        bool letter = strchr("eEdD", *c) != NULL;
        if (letter || (sign && !exponent)) {
            if (exponent)
                return false;
            exponent = true;
            out[length++] = 'e';
            c += letter && (c[1] == '+' || c[1] == '-');
            if (*c == '-')
                out[length++] = '-';
        } else {
            out[length++] = *c;
        }
    }
    out[length] = '\0';
    return true;
}

static bool read_coordinate(const struct card *card, int index, double *value,
                            struct api_problem *problem) {
    char text[FIELD_SIZE + 2];
    if (index >= card->given)
        return FAIL(problem, "line %zu: %s ends before its coordinate %c", card->line, card->name,
                    "xyz"[index - 2]);
    *value = 0;
    if (!card->field[index][0])
        return true;
    bool good = normalise_real(card->field[index], text);
    size_t length = good ? strlen(text) : 0;
    if (good && api_number_read(text, length, value) == length && fabs(*value) <= coordinate_max)
        return true;
    return FAIL(problem, "line %zu: coordinate %c of %s is '%s', which is no number within +-1e12",
                card->line, "xyz"[index - 2], card->name, card->field[index]);
}

/* ---- cards ---- */

/* GRID ID CP X1 X2 X3 CD ..: CD, the system of displacements, means nothing here. */
static bool take_grid(struct file *file, const struct card *card) {
    struct api_problem *problem = file->reader.problem;
    struct grids *grids = &file->grids;
    double x[3] = {0};
    int32_t id;
    if (!read_id(card, 0, "the id", &id, problem))
        return false;
    if (card->field[1][0] && strcmp(card->field[1], "0") != 0)
        return FAIL(problem,
                    "line %zu: GRID %d is in the coordinate system '%s'; only the basic one is read",
                    card->line, id, card->field[1]);
    for (int k = 0; k < 3; k++)
        if (!read_coordinate(card, 2 + k, &x[k], problem))
            return false;
    if (!file->counting) {
        grids->point[grids->count] = vec3_make(x[0], x[1], x[2]);
        grids->id[grids->count] = id;
        grids->line[grids->count] = (uint32_t)card->line;
    }
    grids->count++;
    return true;
}

/* CTRIA3 EID PID G1 G2 G3, CQUAD4 EID PID G1 G2 G3 G4: the property and what follows the corners
 * mean nothing here. */
static bool take_element(struct file *file, const struct card *card, int corners) {
    struct api_problem *problem = file->reader.problem;
    struct elements *elements = &file->elements;
    int32_t id, nodes[4] = {-1, -1, -1, -1};
    if (!read_id(card, 0, "the id", &id, problem))
        return false;
    for (int k = 0; k < corners; k++)
        if (!read_id(card, 2 + k, "a corner", &nodes[k], problem))
            return false;
    if (!file->counting) {
        memcpy(elements->nodes[elements->count], nodes, sizeof nodes);
        elements->id[elements->count] = id;
        elements->line[elements->count] = (uint32_t)card->line;
    }
    elements->count++;
    return true;
}

/* Cards that say nothing about where the elements are. */
static bool means_nothing(const char *name) {
    return strcmp(name, "PARAM") == 0 || strcmp(name, "PSHELL") == 0 ||
           strncmp(name, "PCOMP", 5) == 0 || strncmp(name, "MAT", 3) == 0;
}

static bool take_card(struct file *file, const struct card *card) {
    if (strcmp(card->name, "GRID") == 0)
        return take_grid(file, card);
    if (strcmp(card->name, "CTRIA3") == 0)
        return take_element(file, card, 3);
    if (strcmp(card->name, "CQUAD4") == 0)
        return take_element(file, card, 4);
    if (means_nothing(card->name))
        return true;
    for (const char *c = card->name; *c; c++)
        if (*c < ' ' || *c > '~')
            return FAIL(file->reader.problem, "line %zu: this is no card", card->line);
    return FAIL(file->reader.problem,
                "line %zu: %s is not supported; GRID, CTRIA3 and CQUAD4 are read", card->line,
                card->name);
}

/* One pass. */
static bool read_cards(struct file *file, const char *bytes, size_t length) {
    struct api_problem *problem = file->reader.problem;
    struct card card;
    file->reader = (struct reader){.at = bytes, .end = bytes + length, .problem = problem};
    file->grids.count = file->elements.count = 0;
    skip_control(&file->reader);
    while (next_card(&file->reader, &card))
        if (!take_card(file, &card))
            return false;
    if (problem->id != API_OK)
        return false;
    if (file->reader.bulk && !file->reader.ended)
        return FAIL(problem, "line %zu: the file ends without ENDDATA: it is not whole",
                    file->reader.number);
    return true;
}

/* ---- ids ---- */

struct key {
    int32_t id;
    int32_t index;
};

static int compare_keys(const void *a, const void *b) {
    const struct key *x = a, *y = b;
    return x->id != y->id ? (x->id > y->id) - (x->id < y->id)
                          : (x->index > y->index) - (x->index < y->index);
}

/* The ids with their places, sorted, in `arena`; most files have them so already. NULL without
 * memory. */
static struct key *sort_ids(const int32_t *ids, size_t count, struct arena *arena) {
    struct key *keys = arena_take(arena, count, sizeof *keys);
    bool sorted = true;
    for (size_t k = 0; keys && k < count; k++) {
        keys[k] = (struct key){ids[k], (int32_t)k};
        sorted = sorted && (k == 0 || ids[k - 1] < ids[k]);
    }
    if (keys && !sorted)
        qsort(keys, count, sizeof *keys, compare_keys);
    return keys;
}

/* The place of the second of two equal ids, or -1. */
static int32_t find_repeated(const struct key *keys, size_t count) {
    for (size_t k = 1; k < count; k++)
        if (keys[k].id == keys[k - 1].id)
            return keys[k].index;
    return -1;
}

/* Ids without gaps are found at once. */
static int32_t find_id(const struct key *keys, size_t count, int32_t id) {
    int64_t guess = count > 0 ? (int64_t)id - keys[0].id : -1;
    if (guess >= 0 && guess < (int64_t)count && keys[guess].id == id)
        return keys[guess].index;
    size_t low = 0, high = count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (keys[middle].id < id)
            low = middle + 1;
        else
            high = middle;
    }
    return low < count && keys[low].id == id ? keys[low].index : -1;
}

static bool connect(struct file *file, const struct key *grids) {
    struct elements *elements = &file->elements;
    for (size_t row = 0; row < elements->count; row++) {
        for (int k = 0; k < 4 && elements->nodes[row][k] >= 0; k++) {
            int32_t id = elements->nodes[row][k];
            int32_t index = find_id(grids, file->grids.count, id);
            if (index < 0)
                return FAIL(file->reader.problem,
                            "line %u: element %d has the corner %d, but there is no GRID %d",
                            elements->line[row], elements->id[row], id, id);
            elements->nodes[row][k] = index;
        }
    }
    return true;
}

/* Looks for repeated ids and turns the elements' ids of corners into places. */
static bool resolve(struct file *file, struct arena *arena) {
    struct arena_mark mark = arena_mark(arena);
    struct api_problem *problem = file->reader.problem;
    struct key *grids = sort_ids(file->grids.id, file->grids.count, arena);
    struct key *elements = sort_ids(file->elements.id, file->elements.count, arena);
    if (!grids || !elements) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "the mesh needs more memory than allowed");
        return false;
    }
    int32_t grid = find_repeated(grids, file->grids.count);
    int32_t element = find_repeated(elements, file->elements.count);
    if (grid >= 0)
        return FAIL(problem, "line %u: there is another GRID %d before it", file->grids.line[grid],
                    file->grids.id[grid]);
    if (element >= 0)
        return FAIL(problem, "line %u: there is another element %d before it",
                    file->elements.line[element], file->elements.id[element]);
    bool good = connect(file, grids);
    arena_rewind(arena, mark);
    return good;
}

/* ---- the file ---- */

static bool allocate(struct file *file, struct arena *arena) {
    struct grids *grids = &file->grids;
    struct elements *elements = &file->elements;
    grids->point = arena_take(arena, grids->count, sizeof *grids->point);
    grids->id = arena_take(arena, grids->count, sizeof *grids->id);
    grids->line = arena_take(arena, grids->count, sizeof *grids->line);
    elements->nodes = arena_take(arena, elements->count, sizeof *elements->nodes);
    elements->id = arena_take(arena, elements->count, sizeof *elements->id);
    elements->line = arena_take(arena, elements->count, sizeof *elements->line);
    if (grids->point && grids->id && grids->line && elements->nodes && elements->id && elements->line)
        return true;
    api_problem_set(file->reader.problem, API_OUT_OF_MEMORY,
                    "the mesh needs more memory than allowed");
    return false;
}

enum api_problem_id api_map_mesh_nastran(const char *bytes, size_t length, struct arena *arena,
                                         struct api_map_mesh *mesh, struct api_problem *problem) {
    struct file file = {.reader = {.problem = problem}, .counting = true};
    *mesh = (struct api_map_mesh){0};
    if (!read_cards(&file, bytes, length))
        return problem->id;
    if (file.elements.count == 0) {
        api_problem_set(problem, API_INVALID_REQUEST, "the file has no CTRIA3 and no CQUAD4");
        return problem->id;
    }
    file.counting = false;
    if (!allocate(&file, arena) || !read_cards(&file, bytes, length) || !resolve(&file, arena))
        return problem->id;
    *mesh = (struct api_map_mesh){.vertices = file.grids.point,
                                  .vertex_count = file.grids.count,
                                  .elements = (const int32_t(*)[4])file.elements.nodes,
                                  .element_count = file.elements.count,
                                  .ids = file.elements.id};
    return API_OK;
}
