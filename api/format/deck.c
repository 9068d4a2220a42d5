/* SPDX-License-Identifier: MIT */
#include "deck.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COMMENT = 76, REAL_SIZE = 320 }; /* any double's, as compilers count that see no digits */

int32_t deck_element_id(const struct map_fields *fields, size_t element) {
    return fields->ids ? fields->ids[element] : (int32_t)element + 1;
}

int32_t deck_vertex_id(const struct map_fields *fields, size_t vertex) {
    return fields->vertex_ids ? fields->vertex_ids[vertex] : (int32_t)vertex + 1;
}

/* ---- what must hold ---- */

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

static size_t most_layers(const struct map_fields *fields) {
    size_t most = 0;
    for (size_t e = 0; e < fields->element_count; e++)
        most = stack_layers(fields, e) > most ? stack_layers(fields, e) : most;
    return most;
}

/* Shows layers in place of plies, if these are asked for, or constants of any are known. */
static bool take_layers(struct encoder *encoder, struct api_problem *problem) {
    struct deck_state *state = encoder->state;
    const struct map_plies *plies = encoder->fields.plies;
    enum format_plies_as as = encoder->options.plies_as;
    bool known = false;
    for (size_t k = 0; k < plies->ply_count; k++)
        known = known || yarn_plies_kind(plies, (int)k).lamina.e1 > 0;
    if (as <= PLIES_AS_WARP && !known)
        return true;
    if (!yarn_plies_make(&state->layers, &encoder->fields, as, format_within(&encoder->options),
                         encoder->format->name, problem))
        return false;
    encoder->fields.plies = &state->layers.plies;
    if (most_layers(&encoder->fields) > DECK_PLIES_MAX)
        api_problem_set(problem, API_TOO_LARGE,
                        "%s can hold at most %d layers, and with plies_as an element has %zu",
                        encoder->format->name, DECK_PLIES_MAX, most_layers(&encoder->fields));
    else if (encoder->fields.plies->ply_count > DECK_NUMBERS_MAX)
        api_problem_set(problem, API_TOO_LARGE,
                        "%s can hold at most %d kinds of layers, and with plies_as there are %zu: "
                        "choose a larger within, or plies_as=yarns",
                        encoder->format->name, DECK_NUMBERS_MAX, encoder->fields.plies->ply_count);
    return problem->id == API_OK;
}

/* Whether one sequence of plies serves all elements; sets `upward`. */
static bool check_sides(const struct encoder *encoder, bool *upward, struct api_problem *problem) {
    const struct map_fields *fields = &encoder->fields;
    size_t up = 0, down = 0, one = 0;
    for (size_t e = 0; e < fields->element_count; e++) {
        if (stack_layers(fields, e) == 0)
            continue;
        bool is_up = stack_is_upward(fields, e);
        one = is_up ? one : e;
        *(is_up ? &up : &down) += 1;
    }
    *upward = up >= down;
    if (up == 0 || down == 0 || most_layers(fields) == 1)
        return true;
    return !api_problem_set(
        problem, API_INVALID_REQUEST,
        "%s has one sequence of plies for all elements, but %zu elements face one side "
        "and %zu, such as %d, the other: reverse these, or choose nastran, lsdyna, abaqus or "
        "calculix",
        encoder->format->name, up, down, deck_element_id(fields, one));
}

bool deck_begin(struct encoder *encoder, struct api_problem *problem) {
    const struct map_fields *fields = &encoder->fields;
    const struct map_plies *plies = fields->plies;
    const struct deck *deck = encoder->format->own;
    const char *name = encoder->format->name;
    struct deck_state *state = encoder->state;
    if (!plies || plies->row_count == 0)
        api_problem_set(problem, API_INVALID_REQUEST,
                        "%s describes plies, but none of the %zu elements lies on the cloth: check "
                        "the length unit and the position of the mesh",
                        name, fields->element_count);
    else if (!plies->thickness)
        api_problem_set(
            problem, API_INVALID_REQUEST,
            "%s needs a thickness: give fabric.thickness in the drape request, or choose csv",
            name);
    else if (plies->ply_count > DECK_PLIES_MAX)
        api_problem_set(problem, API_TOO_LARGE,
                        "%s can hold at most %d plies; csv has a row for each", name,
                        DECK_PLIES_MAX);
    else if (largest_id(fields) > deck->id_max)
        api_problem_set(problem, API_TOO_LARGE,
                        "%s cannot hold the element or vertex number %d; the largest is %d", name,
                        largest_id(fields), deck->id_max);
    else if (!take_layers(encoder, problem))
        return false;
    else if (deck->one_sequence && !check_sides(encoder, &state->upward, problem))
        return false;
    else if (deck->reference && !plies->reference)
        api_problem_set(problem, API_INVALID_REQUEST,
                        "%s needs reference=x,y,z: the VX, VY, VZ of the stack, from which its "
                        "angles are measured",
                        name);
    else if (deck->grouping &&
             !stack_groups_make(&state->groups, fields, deck->grouping == DECK_BY_STACK,
                                format_within(&encoder->options)))
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory to group the elements");
    else if (deck->begin)
        (void)deck->begin(encoder, problem);
    return problem->id == API_OK;
}

void deck_end(struct encoder *encoder) {
    struct deck_state *state = encoder->state;
    yarn_plies_free(&state->layers);
    stack_groups_free(&state->groups);
    free(state->middle);
    free(state->edge);
}

/* ---- the head ---- */

/* Words behind the mark, in lines of at most COMMENT characters; a line feed ends a paragraph. */
static void write_comment(struct encoder *encoder, const char *words) {
    const struct deck *deck = encoder->format->own;
    while (*words) {
        size_t length = strcspn(words, "\n"), room = COMMENT - strlen(deck->mark);
        if (length > room)
            for (length = room; length > 1 && words[length] != ' ';)
                length--;
        api_text_format(&encoder->piece, "%s %.*s\n", deck->mark, (int)length, words);
        words += length;
        words += strspn(words, " \n");
    }
}

void deck_write_vector(struct encoder *encoder, struct vec3 vector, const char *between,
                       int width) {
    const double values[3] = {vector.x, vector.y, vector.z};
    for (int k = 0; k < 3; k++) {
        api_text_raw(&encoder->piece, k ? between : "");
        deck_real(encoder, values[k], width);
    }
}

void deck_write_cord2r(struct encoder *encoder, const struct deck_axes *axes) {
    enum { WIDTH = 16, FIELDS = 9, FIRST = 2, ROW = 4 };
    struct vec3 on_z = vec3_add(axes->origin, axes->z), in_xz = vec3_add(axes->origin, axes->x);
    const double values[FIELDS] = {axes->origin.x, axes->origin.y, axes->origin.z, on_z.x, on_z.y,
                                   on_z.z,         in_xz.x,        in_xz.y,        in_xz.z};
    api_text_format(&encoder->piece, "CORD2R* %16d%16d", axes->id, 0);
    for (int k = 0; k < FIELDS; k++) {
        api_text_raw(&encoder->piece, (k + FIRST) % ROW ? "" : "\n*       ");
        deck_real(encoder, values[k], WIDTH);
    }
    api_text_raw(&encoder->piece, "\n");
}

static void write_rosette(struct encoder *encoder) {
    const struct api_rosette *rosette = encoder->fields.rosette;
    const struct deck *deck = encoder->format->own;
    int32_t largest = largest_id(&encoder->fields);
    struct deck_axes axes = {.id = largest < deck->id_max ? largest + 1 : largest,
                             .origin = rosette->origin,
                             .x = vec3_unit(rosette->x)};
    axes.z = vec3_unit(vec3_axpy(-vec3_dot(rosette->z, axes.x), axes.x, rosette->z));
    axes.y = vec3_cross(axes.z, axes.x);
    write_comment(encoder,
                  "The next coordinate system is the rosette: 0 degrees of a ply's direction is "
                  "its x-axis, projected on the part where the ply starts. Nothing else here "
                  "refers to it.");
    deck->rosette(encoder, &axes);
}

/* Each ply, with its constants where they are known. */
static void write_plies(struct encoder *encoder) {
    char words[400];
    struct lamina own;
    for (size_t k = 0; k < encoder->fields.plies->ply_count; k++) {
        int length =
            snprintf(words, sizeof words, "Ply %zu: %s", k + 1, encoder->fields.plies->names[k]);
        if (deck_lamina(encoder, (int)k, &own))
            (void)snprintf(words + length, sizeof words - (size_t)length,
                           "; E1 %.6g, E2 %.6g, nu12 %.6g, G12 %.6g", own.e1, own.e2, own.nu12,
                           own.g12);
        write_comment(encoder, words);
    }
}

/* What became of the yarns of woven plies. */
static void write_plies_as(struct encoder *encoder) {
    char words[400];
    enum format_plies_as as = encoder->options.plies_as;
    double off = fmax(format_within(&encoder->options) / 4, YARN_PLIES_FINEST / 2);
    if (as == PLIES_AS_BISECTOR)
        (void)snprintf(words, sizeof words,
                       "Woven plies are a layer along the bisector of warp and weft, whose "
                       "constants are those of both yarns at a shear that is off by at most %g "
                       "degrees.",
                       off);
    else
        (void)snprintf(words, sizeof words, "%s",
                       as == PLIES_AS_YARNS
                           ? "Woven plies are two unidirectional layers, along warp and weft."
                           : "The shear between warp and weft is not here; plies_as=yarns and "
                             "plies_as=bisector have it.");
    write_comment(encoder, words);
}

/* The drape, the unit, what `about` says, the plies, bare elements, warnings and the groups. */
static void write_deck_head(struct encoder *encoder) {
    const struct map_fields *fields = &encoder->fields;
    const struct deck *deck = encoder->format->own;
    const struct deck_state *state = encoder->state;
    char words[400 + ENCODER_NOTE_SIZE], origin[ENCODER_NOTE_SIZE];
    size_t bare = 0;
    encoder_origin(encoder, origin);
    origin[0] = (char)toupper(origin[0]);
    for (size_t e = 0; e < fields->element_count; e++)
        bare += stack_layers(fields, e) == 0;
    snprintf(words, sizeof words,
             "%s on %zu elements, %zu %s. Lengths in %s, angles in degrees%s; ply k has "
             "material k%s.",
             origin, fields->element_count, fields->plies->ply_count,
             fields->plies->ply_count == 1 ? "ply" : "plies", fields->unit->name,
             state->layers.lamina ? ", forces in N" : "",
             state->layers.lamina ? "" : ", which you must define");
    write_comment(encoder, words);
    write_comment(encoder, deck->about);
    write_plies_as(encoder);
    write_plies(encoder);
    if (bare > 0) {
        snprintf(words, sizeof words, "%zu elements have no ply and are left out.", bare);
        write_comment(encoder, words);
    }
    for (size_t k = 0; k < fields->warning_count; k++) {
        snprintf(words, sizeof words, "Warning: %s", fields->warnings[k]);
        write_comment(encoder, words);
    }
    if (deck->grouping) {
        snprintf(
            words, sizeof words,
            "Rounded: %zu elements share %zu stacks (within=%g; 0 rounds nothing). Thicknesses "
            "are off by at most %.2g percent.",
            fields->element_count - bare, state->groups.count, format_within(&encoder->options),
            state->groups.thickness_percent);
        write_comment(encoder, words);
    }
    if (deck->grouping == DECK_BY_STACK) {
        snprintf(words, sizeof words,
                 "Angles from the bottom ply are off by at most %.2g degrees; the bottom ply's own "
                 "are not rounded.",
                 state->groups.angle_deg);
        write_comment(encoder, words);
    }
    if (fields->rosette)
        write_rosette(encoder);
    api_text_raw(&encoder->piece, deck->text ? deck->text : "");
}

/* ---- the sections ---- */

void deck_next(struct encoder *encoder) {
    const struct deck *deck = encoder->format->own;
    const struct map_fields *fields = &encoder->fields;
    const struct deck_state *state = encoder->state;
    const struct stack_groups *groups = &state->groups;
    const size_t counts[] = {
        [DECK_ONCE] = 1,
        [DECK_VERTICES] = fields->vertex_count,
        [DECK_ELEMENTS] = fields->element_count,
        [DECK_STACKS] = fields->element_count,
        [DECK_PLIES] = fields->plies->ply_count,
        [DECK_PLY_ELEMENTS] = fields->plies->ply_count * fields->element_count,
        [DECK_GROUPS] = groups->count,
        [DECK_MEMBERS] = groups->start ? groups->start[groups->count] : 0,
        [DECK_MIDDLES] = state->middles,
    };
    if (!encoder->begun)
        write_deck_head(encoder);
    encoder->begun = true;
    while (deck->sections[encoder->column].items &&
           encoder->piece.capacity - encoder->piece.length >= DECK_ITEM) {
        const struct deck_section *section = &deck->sections[encoder->column];
        if (encoder->row == counts[section->items]) {
            encoder->row = 0;
            encoder->column++;
            continue;
        }
        size_t number = encoder->row++;
        struct deck_item item = {.number = number, .element = number, .ply = (int)number};
        if (section->items == DECK_PLY_ELEMENTS) {
            item.element = number % fields->element_count;
            item.ply = (int)(number / fields->element_count);
            item.first = item.element == 0;
            item.last = item.element + 1 == fields->element_count;
        } else if (section->items == DECK_GROUPS) {
            item.element = (size_t)groups->member[groups->start[number]];
        } else if (section->items == DECK_MEMBERS) {
            item.element = (size_t)groups->member[number];
            size_t group = (size_t)groups->group[item.element];
            item.first = number == groups->start[group];
            item.last = number + 1 == groups->start[group + 1];
        }
        if (section->items != DECK_ONCE && section->items != DECK_VERTICES &&
            section->items != DECK_PLIES && section->items != DECK_MIDDLES) {
            item.id = deck_element_id(fields, item.element);
            item.corners = fields->elements[item.element];
            item.layers = stack_layers(fields, item.element);
        }
        if (section->text)
            api_text_raw(&encoder->piece, section->text);
        else if (section->items != DECK_STACKS || item.layers > 0)
            section->write(encoder, &item);
    }
    encoder->ended = !deck->sections[encoder->column].items;
}

void deck_write_point(struct encoder *encoder, int32_t id, struct vec3 point) {
    const struct deck_point *form = &((const struct deck *)encoder->format->own)->point;
    const double x[3] = {point.x, point.y, point.z};
    api_text_format(&encoder->piece, "%s%*d", form->name, form->number_width, id);
    for (int k = 0; k < 3; k++) {
        api_text_raw(&encoder->piece, form->before[k]);
        deck_real(encoder, x[k], form->width);
    }
    api_text_raw(&encoder->piece, "\n");
}

bool deck_lamina(const struct encoder *encoder, int ply, struct lamina *lamina) {
    const struct yarn_plies *layers = &((const struct deck_state *)encoder->state)->layers;
    double area = encoder->fields.unit->metres * encoder->fields.unit->metres;
    if (!layers->lamina || layers->lamina[ply].e1 == 0)
        return false;
    *lamina = layers->lamina[ply];
    lamina->e1 *= area;
    lamina->e2 *= area;
    lamina->g12 *= area;
    return true;
}

/* MID E1 E2 NU12, G12; shear across the layer is rigid where G1Z and G2Z are left out. */
void deck_write_mat8(struct encoder *encoder, const struct deck_item *item) {
    enum { WIDTH = 16 };
    struct lamina own;
    if (!deck_lamina(encoder, item->ply, &own))
        return;
    api_text_format(&encoder->piece, "MAT8*   %16d", item->ply + 1);
    deck_real(encoder, own.e1, WIDTH);
    deck_real(encoder, own.e2, WIDTH);
    deck_real(encoder, own.nu12, WIDTH);
    api_text_raw(&encoder->piece, "\n*       ");
    deck_real(encoder, own.g12, WIDTH);
    api_text_raw(&encoder->piece, "\n");
}

void deck_write_vertex(struct encoder *encoder, const struct deck_item *item) {
    const struct map_fields *fields = &encoder->fields;
    deck_write_point(encoder, deck_vertex_id(fields, item->number), fields->vertices[item->number]);
}

void deck_write_axes(struct encoder *encoder, size_t element, double angle_deg, const char *between,
                     int width) {
    struct element_frame frame = stack_frame(&encoder->fields, element);
    struct vec3 a = element_direction(&frame, angle_deg), b = vec3_cross(frame.normal, a);
    const double values[6] = {a.x, a.y, a.z, b.x, b.y, b.z};
    for (int k = 0; k < 6; k++) {
        api_text_raw(&encoder->piece, k ? between : "");
        deck_real(encoder, values[k], width);
    }
    api_text_raw(&encoder->piece, "\n");
}

/* Without a point a field is no real number: "1" and "1E-05" become "1." and "1.E-05". More digits
 * than 15 would add nothing but rounding. */
void deck_real(struct encoder *encoder, double value, int width) {
    char text[REAL_SIZE];
    int digits = width < 16 ? width - 1 : 15;
    do {
        snprintf(text, sizeof text, "%.*G", digits, value == 0 ? 0 : value);
        if (!strchr(text, '.')) {
            size_t at = strcspn(text, "eE");
            memmove(text + at + 1, text + at, strlen(text + at) + 1);
            text[at] = '.';
        }
    } while ((int)strlen(text) > width && --digits > 0);
    api_text_format(&encoder->piece, "%*s", width, text);
}
