/* SPDX-License-Identifier: MIT */
#include "mesh_encode.h"

#include "mesh_format.h"
#include <stdlib.h>
#include <string.h>

static const struct api_mesh_format *const formats[] = {&mesh_format_json, &mesh_format_csv,
                                                        &mesh_format_vtu, &mesh_format_lcmsim};

const struct api_mesh_format *api_mesh_format_at(size_t index) {
    return index < sizeof formats / sizeof *formats ? formats[index] : NULL;
}

const struct api_mesh_format *api_mesh_format_named(const char *name) {
    for (size_t k = 0; k < sizeof formats / sizeof *formats; k++)
        if (strcmp(name, formats[k]->name) == 0)
            return formats[k];
    return NULL;
}

const char *api_mesh_format_media_type(const struct api_mesh_format *format) {
    return format->media_type;
}

const char *api_mesh_format_name(const struct api_mesh_format *format) {
    return format->name;
}

bool api_mesh_format_needs_elements(const struct api_mesh_format *format) {
    return !format->no_elements;
}

const struct api_column_source *mesh_column(const struct api_mesh_fields *fields,
                                            const char *name) {
    for (size_t k = 0; k < fields->column_count; k++)
        if (strcmp(fields->columns[k].name, name) == 0)
            return &fields->columns[k];
    return NULL;
}

struct api_mesh_encoder *api_mesh_encoder_new(const struct api_mesh_format *format,
                                              const struct api_mesh_fields *fields,
                                              struct api_problem *problem) {
    struct api_mesh_encoder *encoder = malloc(sizeof *encoder);
    void *state = calloc(1, format->state_size);
    if (!encoder || !state) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory to encode the mesh");
        free(state);
        free(encoder);
        return NULL;
    }
    memset(encoder, 0, offsetof(struct api_mesh_encoder, buffer));
    encoder->format = format;
    encoder->fields = *fields;
    encoder->state = state;
    if (format->begin(encoder, problem))
        return encoder;
    api_mesh_encoder_free(encoder);
    return NULL;
}

static bool refill(struct api_mesh_encoder *encoder) {
    while (encoder->sent == encoder->piece.length) {
        if (encoder->ended || encoder->failed)
            return false;
        encoder->piece = api_text_over(encoder->buffer, sizeof encoder->buffer);
        encoder->sent = 0;
        encoder->format->next(encoder);
        encoder->failed = encoder->failed || encoder->piece.failed;
        if (encoder->failed)
            encoder->piece.length = 0;
    }
    return true;
}

ssize_t api_mesh_encoder_read(struct api_mesh_encoder *encoder, char *buffer, size_t size) {
    size_t length = 0;
    while (length < size && refill(encoder)) {
        size_t left = encoder->piece.length - encoder->sent;
        size_t part = left < size - length ? left : size - length;
        memcpy(buffer + length, encoder->buffer + encoder->sent, part);
        encoder->sent += part;
        length += part;
    }
    return length == 0 && encoder->failed ? -1 : (ssize_t)length;
}

uint64_t api_mesh_encoder_length(const struct api_mesh_encoder *encoder) {
    return encoder->length;
}

const char *api_mesh_encoder_binning(const struct api_mesh_encoder *encoder) {
    return encoder->binning;
}

void api_mesh_encoder_free(struct api_mesh_encoder *encoder) {
    if (encoder && encoder->format->end)
        encoder->format->end(encoder);
    if (encoder)
        free(encoder->state);
    free(encoder);
}
