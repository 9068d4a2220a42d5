/* SPDX-License-Identifier: MIT */
#include "deck.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { LINE = 400, COMMENT = 76 };

/* ---- the driver ---- */

void deck_next(struct encoder *encoder) {
    const struct deck_section *sections = encoder->format->own;
    while (sections[encoder->column].write &&
           encoder->piece.capacity - encoder->piece.length >= CARDS_ITEM) {
        const struct deck_section *section = &sections[encoder->column];
        if (encoder->row < (section->count ? section->count(encoder) : 1)) {
            section->write(encoder, encoder->row++);
        } else {
            encoder->row = 0;
            encoder->column++;
        }
    }
    encoder->ended = !sections[encoder->column].write;
}

size_t deck_vertices(const struct encoder *encoder) {
    return encoder->fields.vertex_count;
}

size_t deck_elements(const struct encoder *encoder) {
    return encoder->fields.element_count;
}

size_t deck_plies(const struct encoder *encoder) {
    return encoder->fields.plies->ply_count;
}

size_t deck_ply_elements(const struct encoder *encoder) {
    return deck_plies(encoder) * deck_elements(encoder);
}

/* ---- checks ---- */

static int32_t largest_id(const struct map_fields *fields) {
    int32_t largest = 0;
    for (size_t k = 0; k < fields->element_count; k++)
        if (deck_element_id(fields, k) > largest)
            largest = deck_element_id(fields, k);
    for (size_t k = 0; k < fields->vertex_count; k++)
        if (deck_vertex_id(fields, k) > largest)
            largest = deck_vertex_id(fields, k);
    return largest;
}

bool deck_check(const struct encoder *encoder, int32_t id_max, struct api_problem *problem) {
    const struct map_fields *fields = &encoder->fields;
    const struct map_plies *plies = fields->plies;
    const char *name = encoder->format->name;
    if (!plies || plies->row_count == 0)
        api_problem_set(
            problem, API_INVALID_REQUEST,
            "%s is of plies, but none of the %zu elements lies on the cloth; are they in "
            "the drape's length unit and position?",
            name, fields->element_count);
    else if (!plies->thickness)
        api_problem_set(problem, API_INVALID_REQUEST,
                        "%s needs a thickness: fabric.thickness in the drape request", name);
    else if (plies->ply_count > CARDS_PLIES_MAX)
        api_problem_set(problem, API_TOO_LARGE, "%s is written of at most %d plies", name,
                        CARDS_PLIES_MAX);
    else if (largest_id(fields) > id_max)
        api_problem_set(problem, API_TOO_LARGE,
                        "%s has no room for the number %d of an element or vertex: at most %d",
                        name, largest_id(fields), id_max);
    return problem->id == API_OK;
}

/* Along the element's normal when it looks where the plies follow each other to. */
static bool is_upward(const struct map_fields *fields, size_t element) {
    const struct map_plies *plies = fields->plies;
    return plies->rows[plies->first[element]].mirrored == (plies->side < 0);
}

bool deck_check_sides(const struct encoder *encoder, bool *upward, struct api_problem *problem) {
    const struct map_fields *fields = &encoder->fields;
    size_t up = 0, down = 0, one = 0;
    for (size_t e = 0; e < fields->element_count; e++) {
        if (deck_is_bare(fields, e))
            continue;
        bool is_up = is_upward(fields, e);
        one = is_up ? one : e;
        *(is_up ? &up : &down) += 1;
    }
    *upward = up >= down;
    if (up == 0 || down == 0 || fields->plies->ply_count == 1)
        return true;
    api_problem_set(
        problem, API_INVALID_REQUEST,
        "%s has one sequence of plies for all elements, but %zu of them look to one side "
        "and %zu, such as %d, to the other: turn those",
        encoder->format->name, up, down, deck_element_id(fields, one));
    return false;
}

/* ---- the stack ---- */

int32_t deck_element_id(const struct map_fields *fields, size_t element) {
    return fields->ids ? fields->ids[element] : (int32_t)element + 1;
}

int32_t deck_vertex_id(const struct map_fields *fields, size_t vertex) {
    return fields->vertex_ids ? fields->vertex_ids[vertex] : (int32_t)vertex + 1;
}

size_t deck_layers(const struct map_fields *fields, size_t element) {
    const size_t *first = fields->plies->first;
    return first[element + 1] - first[element];
}

bool deck_is_bare(const struct map_fields *fields, size_t element) {
    return deck_layers(fields, element) == 0;
}

const struct map_ply_row *deck_layer(const struct map_fields *fields, size_t element, size_t k) {
    const struct map_plies *plies = fields->plies;
    size_t count = deck_layers(fields, element);
    return &plies->rows[plies->first[element] + (is_upward(fields, element) ? k : count - 1 - k)];
}

const struct map_ply_row *deck_row(const struct map_fields *fields, size_t element, int ply) {
    const struct map_plies *plies = fields->plies;
    for (size_t k = plies->first[element]; k < plies->first[element + 1]; k++)
        if (plies->rows[k].ply == ply)
            return &plies->rows[k];
    return NULL;
}

struct element_frame deck_frame(const struct map_fields *fields, size_t element) {
    struct element_frame frame;
    (void)element_frame_make(fields->vertices, fields->elements[element], fields->plies->reference,
                             &frame);
    return frame;
}

double deck_thickness(const struct map_fields *fields, int ply) {
    const struct map_plies *plies = fields->plies;
    double least = 0;
    for (size_t k = 0; k < plies->row_count; k++)
        if (plies->rows[k].ply == ply && (least == 0 || plies->rows[k].thickness < least))
            least = plies->rows[k].thickness;
    return least;
}

double deck_fold_deg(double angle_deg) {
    while (angle_deg > 90)
        angle_deg -= 180;
    while (angle_deg <= -90)
        angle_deg += 180;
    return angle_deg;
}

/* ---- text ---- */

void deck_line(struct encoder *encoder, const char *format, ...) {
    char line[LINE];
    va_list values;
    va_start(values, format);
    vsnprintf(line, sizeof line, format, values);
    va_end(values);
    api_text_raw(&encoder->piece, line);
}

/* Words behind the mark, in lines of at most COMMENT characters. */
static void write_comment(struct encoder *encoder, const char *mark, const char *words) {
    while (*words) {
        size_t length = strlen(words), room = COMMENT - strlen(mark);
        if (length > room) {
            for (length = room; length > 1 && words[length] != ' ';)
                length--;
        }
        deck_line(encoder, "%s %.*s\n", mark, (int)length, words);
        words += length;
        words += strspn(words, " ");
    }
}

void deck_head(struct encoder *encoder, const char *mark, const char *const *about) {
    const struct map_fields *fields = &encoder->fields;
    char words[LINE];
    size_t bare = 0;
    for (size_t e = 0; e < fields->element_count; e++)
        bare += deck_is_bare(fields, e);
    snprintf(words, sizeof words,
             "Drape %s on %zu elements, %zu %s. Lengths in %s, angles in degrees; ply k is of "
             "material k, material k yours to define.",
             encoder->id, fields->element_count, fields->plies->ply_count,
             fields->plies->ply_count == 1 ? "ply" : "plies", fields->unit->name);
    write_comment(encoder, mark, words);
    for (; *about; about++)
        write_comment(encoder, mark, *about);
    for (size_t k = 0; k < fields->plies->ply_count; k++) {
        snprintf(words, sizeof words, "Ply %zu: %s", k + 1, fields->plies->names[k]);
        write_comment(encoder, mark, words);
    }
    if (bare > 0) {
        snprintf(words, sizeof words, "%zu elements have no ply and are left out.", bare);
        write_comment(encoder, mark, words);
    }
    for (size_t k = 0; k < fields->warning_count; k++) {
        snprintf(words, sizeof words, "Warning: %s", fields->warnings[k]);
        write_comment(encoder, mark, words);
    }
}

void deck_integer(struct encoder *encoder, int64_t value, int width) {
    deck_line(encoder, "%*lld", width, (long long)value);
}

void deck_blank(struct encoder *encoder, int width) {
    deck_line(encoder, "%*s", width, "");
}

void deck_word(struct encoder *encoder, const char *word, int width) {
    deck_line(encoder, "%-*s", width, word);
}

/* "1" and "1E-05" become "1." and "1.E-05": without a point a field is no real number. */
static void put_point(char *text) {
    if (strchr(text, '.'))
        return;
    char *exponent = strpbrk(text, "eE");
    size_t at = exponent ? (size_t)(exponent - text) : strlen(text);
    memmove(text + at + 1, text + at, strlen(text + at) + 1);
    text[at] = '.';
}

void deck_real(struct encoder *encoder, double value, int width) {
    char text[LINE];
    int digits = width < 16 ? width - 1 : 15; /* more would add nothing but rounding */
    do {
        snprintf(text, sizeof text, "%.*G", digits, value == 0 ? 0 : value);
        put_point(text);
    } while ((int)strlen(text) > width && --digits > 0);
    deck_line(encoder, "%*s", width, text);
}
