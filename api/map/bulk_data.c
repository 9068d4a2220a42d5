/* SPDX-License-Identifier: MIT */
#include "bulk_data.h"

#include "api/json/number.h"
#include "target.h"
#include <math.h>
#include <string.h>
#include <strings.h>

enum {
    NAME_COLUMNS = 8,
    DATA_COLUMNS = 72, /* the continuation mark stands behind them */
    ID_MAX = 99999999
};

/* ---- lines ---- */

static bool blank_column(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\0';
}

static char upper_case(char c) {
    return c >= 'a' && c <= 'z' ? (char)(c - 32) : c;
}

bool bulk_head(const char **at, const char *end, char head[BULK_HEAD]) {
    const char *c = *at;
    if (c == end)
        return false;
    const char *newline = memchr(c, '\n', (size_t)(end - c));
    newline = newline ? newline : end;
    while (c < newline && blank_column(*c))
        c++;
    for (int k = 0; k < BULK_HEAD; k++)
        head[k] = c + k < newline ? upper_case(c[k]) : ' ';
    *at = newline + (newline < end);
    return true;
}

/* Copies a line with its tabs expanded. */
static void expand_line(struct bulk_reader *reader, const char *at, const char *end) {
    size_t column = 0;
    for (; at < end; at++) {
        bool blank = blank_column(*at);
        size_t width = *at == '\t' ? 8 - column % 8 : 1;
        for (; width > 0 && column < BULK_COLUMNS - 1; width--)
            reader->line[column++] = blank ? ' ' : *at;
        reader->cut = reader->cut || (width > 0 && !blank);
    }
    reader->line[column] = '\0';
}

/* Copies the next line without its comment; most as they are. False at the end. */
static bool load_line(struct bulk_reader *reader) {
    const char *at = reader->at, *newline, *dollar;
    if (at == reader->end)
        return false;
    newline = memchr(at, '\n', (size_t)(reader->end - at));
    newline = newline ? newline : reader->end;
    dollar = memchr(at, '$', (size_t)(newline - at));
    size_t length = (size_t)((dollar ? dollar : newline) - at);
    reader->number++;
    reader->cut = false;
    if (length < BULK_COLUMNS && !memchr(at, '\t', length) && !memchr(at, '\0', length) &&
        !memchr(at, '\r', length)) {
        memcpy(reader->line, at, length);
        reader->line[length] = '\0';
    } else {
        expand_line(reader, at, at + length);
    }
    reader->at = newline + (newline < reader->end);
    return true;
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

/* The next line that is not blank, until ENDDATA. */
static bool next_card_line(struct bulk_reader *reader) {
    if (reader->held) {
        reader->held = false;
        return true;
    }
    while (!reader->ended && load_line(reader)) {
        reader->ended = begins_with(reader->line, "ENDDATA", "");
        if (!reader->ended && reader->line[strspn(reader->line, " ")] != '\0')
            return true;
    }
    return false;
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

static bool put_card_field(struct bulk_reader *reader, struct bulk_card *card, int index,
                           const char *text, size_t length) {
    if (index >= BULK_FIELDS)
        return true;
    if (!copy_trimmed(text, length, card->field[index], BULK_FIELD_SIZE))
        return MAP_REFUSE(reader->problem, "line %zu: a field is longer than %d characters",
                          reader->number, BULK_FIELD_SIZE - 1);
    card->given = index + 1 > card->given ? index + 1 : card->given;
    return true;
}

/* Adds the fields of the current line from `*first` on, which becomes that of the next line: free
 * ones between commas, or fixed ones of 8 columns, 16 in large cards, up to column 72. `head` is
 * what stands before the first: a name, or what marks a continuation. */
static bool split_line(struct bulk_reader *reader, struct bulk_card *card, int *first, char *head) {
    const char *line = reader->line, *comma = strchr(line, ',');
    size_t whole = strlen(line), named = comma ? (size_t)(comma - line) : NAME_COLUMNS;
    if (reader->cut)
        return MAP_REFUSE(reader->problem, "line %zu is longer than %d columns", reader->number,
                          BULK_COLUMNS - 1);
    if (!copy_trimmed(line, named < whole ? named : whole, head, BULK_NAME_SIZE))
        return MAP_REFUSE(reader->problem, "line %zu: this is not a card", reader->number);
    size_t length = strlen(head);
    bool large = length > 0 && (head[0] == '*' || head[length - 1] == '*'), good = true;
    int field = *first;
    *first += large ? 4 : 8;
    for (const char *at = comma; good && at && field < *first; field++) {
        const char *next = strchr(++at, ',');
        good = put_card_field(reader, card, field, at, (size_t)((next ? next : line + whole) - at));
        at = next;
    }
    size_t width = large ? 16 : 8, end = whole < DATA_COLUMNS ? whole : DATA_COLUMNS;
    for (size_t at = NAME_COLUMNS; good && !comma && at < end; at += width, field++)
        good =
            put_card_field(reader, card, field, line + at, whole - at < width ? whole - at : width);
    return good;
}

static bool is_continuation(const char *line) {
    size_t blanks = strspn(line, " ");
    return *line == '+' || *line == '*' || blanks >= NAME_COLUMNS || line[blanks] == ',';
}

struct bulk_reader bulk_begin(const char *bytes, size_t length, struct api_problem *problem) {
    struct bulk_reader reader = {.at = bytes, .end = bytes + length, .problem = problem};
    struct bulk_reader ahead = reader;
    while (!reader.bulk && load_line(&ahead)) {
        ahead.bulk = begins_with(ahead.line, "BEGIN", "BULK");
        if (ahead.bulk)
            reader = ahead; /* what stands before it is not for us */
    }
    return reader;
}

bool bulk_next(struct bulk_reader *reader, struct bulk_card *card) {
    char head[BULK_NAME_SIZE];
    int first = 0;
    if (!next_card_line(reader)) {
        if (reader->bulk && !reader->ended)
            api_problem_set(reader->problem, API_INVALID_REQUEST,
                            "line %zu: the file ends without ENDDATA, so a part of it is missing",
                            reader->number);
        return false;
    }
    memset(card, 0, sizeof *card);
    card->line = reader->number;
    if (is_continuation(reader->line))
        return MAP_REFUSE(
            reader->problem, "line %zu: this continuation follows no card%s", reader->number,
            reader->line[0] == '*'
                ? "; decks of Abaqus and CalculiX are not read: export Nastran bulk data"
                : "");
    if (!split_line(reader, card, &first, head))
        return false;
    size_t length = strcspn(head, " ");
    length -= length > 0 && head[length - 1] == '*' && head[length] == '\0'; /* of large fields */
    for (size_t k = 0; k < length; k++)
        card->name[k] = upper_case(head[k]);
    while (next_card_line(reader)) {
        if (!is_continuation(reader->line)) {
            reader->held = true;
            break;
        }
        if (!split_line(reader, card, &first, head))
            return false;
    }
    return true;
}

/* ---- values ---- */

bool bulk_id(const struct bulk_card *card, int index, const char *what, int32_t *id,
             struct api_problem *problem) {
    const char *text = card->field[index];
    int64_t value = 0;
    size_t length = strlen(text), k = text[0] == '+';
    for (; k < length && text[k] >= '0' && text[k] <= '9' && value <= ID_MAX; k++)
        value = 10 * value + (text[k] - '0');
    *id = (int32_t)value;
    if (length > 0 && k == length && value > 0 && value <= ID_MAX)
        return true;
    return MAP_REFUSE(problem, "line %zu: %s of %s is '%s', not a whole number from 1 to %d",
                      card->line, what, card->name, text, ID_MAX);
}

/* As the number reader has them: 1.5+3 and 1.5D+3 for 1.5e+3. */
static bool read_short_real(const char *begin, double *value) {
    char text[BULK_FIELD_SIZE + 2];
    size_t length = 0;
    bool exponent = false;
    for (const char *c = begin; *c; c++) {
        bool sign = (*c == '+' || *c == '-') && c > begin;
        bool letter = strchr("eEdD", *c) != NULL;
        if (letter && exponent)
            return false;
        if (letter || (sign && !exponent)) {
            exponent = true;
            text[length++] = 'e';
            c += letter && (c[1] == '+' || c[1] == '-');
            if (*c == '-')
                text[length++] = '-';
        } else {
            text[length++] = *c;
        }
    }
    return api_number_read(text, length, value) == length;
}

static bool bulk_real(const struct bulk_card *card, int index, const char *what, double *value,
                      struct api_problem *problem) {
    const char *field = card->field[index];
    if (index >= card->given)
        return MAP_REFUSE(problem, "line %zu: %s ends before its %s", card->line, card->name, what);
    *value = 0;
    if (!*field)
        return true;
    const char *begin = field + (*field == '+');
    size_t length = strlen(begin);
    if ((api_number_read(begin, length, value) == length || read_short_real(begin, value)) &&
        fabs(*value) <= MAP_COORDINATE_MAX)
        return true;
    return MAP_REFUSE(problem, "line %zu: %s of %s is '%s', not a number within +-1e12", card->line,
                      what, card->name, field);
}

bool bulk_point(const struct bulk_card *card, int first, struct vec3 *point,
                struct api_problem *problem) {
    return bulk_real(card, first, "coordinate x", &point->x, problem) &&
           bulk_real(card, first + 1, "coordinate y", &point->y, problem) &&
           bulk_real(card, first + 2, "coordinate z", &point->z, problem);
}
