/* SPDX-License-Identifier: MIT */
#include "laser_sheet.h"

#include <stdio.h>

static const char *const laser_kind_names[LASER_KINDS] = {
    [LASER_EDGE] = "edge", [LASER_HOLE] = "hole", [LASER_WARP] = "warp"};

/* ---- JSON ---- */

static void write_json_line(const struct laser_line *line, struct api_text *text) {
    api_text_raw(text, "{");
    api_text_key_string(text, "kind", laser_kind_names[line->kind]);
    api_text_key(text, "points");
    api_text_raw(text, "[");
    for (size_t k = 0; k < line->count; k++) {
        const struct laser_point *at = &line->points[k];
        const double values[] = {at->r.x,      at->r.y,      at->r.z,   at->normal.x,
                                 at->normal.y, at->normal.z, at->height};
        api_text_raw(text, k ? "," : "");
        api_text_numbers(text, values, sizeof values / sizeof *values);
    }
    api_text_raw(text, "]}");
}

void laser_sheet_write_json(const struct laser_sheet *sheet, struct api_text *text) {
    api_text_raw(text, "{");
    api_text_key_string(text, "revision", sheet->revision);
    api_text_key_string(text, "length_unit", sheet->unit->name);
    api_text_key_number(text, "tolerance", sheet->tolerance);
    api_text_key(text, "layers");
    api_text_raw(text, "[");
    for (size_t n = 0; n < sheet->layer_count; n++) {
        const struct laser_layer *layer = &sheet->layers[n];
        api_text_raw(text, n ? ",{" : "{");
        api_text_key_integer(text, "ply", layer->ply);
        if (layer->piece)
            api_text_key_integer(text, "piece", layer->piece);
        api_text_key_string(text, "name", layer->title);
        api_text_key_integer(text, "layer", layer->layer);
        api_text_key_integer(text, "of", layer->layers);
        api_text_key(text, "lines");
        api_text_raw(text, "[");
        for (size_t k = 0; k < layer->line_count; k++) {
            api_text_raw(text, k ? "," : "");
            write_json_line(&layer->lines[k], text);
        }
        api_text_raw(text, "]}");
    }
    api_text_raw(text, "]}\n");
}

/* ---- CSV ---- */

void laser_sheet_write_csv(const struct laser_sheet *sheet, struct api_text *text) {
    api_text_format(text, "ply,piece,layer,line,kind,x,y,z,nx,ny,nz,height,unit,revision\n");
    for (size_t n = 0; n < sheet->layer_count; n++) {
        const struct laser_layer *layer = &sheet->layers[n];
        for (size_t k = 0; k < layer->line_count; k++)
            for (size_t p = 0; p < layer->lines[k].count; p++) {
                const struct laser_line *line = &layer->lines[k];
                const struct laser_point *at = &line->points[p];
                const double values[] = {at->r.x,      at->r.y,      at->r.z,   at->normal.x,
                                         at->normal.y, at->normal.z, at->height};
                api_text_format(text, "%d,%d,%d,%zu,%s,", layer->ply, layer->piece, layer->layer,
                                k + 1, laser_kind_names[line->kind]);
                for (size_t v = 0; v < sizeof values / sizeof *values; v++) {
                    api_text_number(text, values[v]);
                    api_text_raw(text, ",");
                }
                api_text_format(text, "%s,%s\n", sheet->unit->name, sheet->revision);
            }
    }
}

/* ---- Virtek ---- */

void laser_sheet_write_virtek(const struct laser_sheet *sheet, struct api_text *text) {
    double mm = sheet->unit->metres * 1000;
    for (size_t n = 0; n < sheet->layer_count; n++) {
        const struct laser_layer *layer = &sheet->layers[n];
        char title[256];
        (void)snprintf(title, sizeof title, "%d %s (%d of %d) revision %s", layer->ply,
                       layer->title, layer->layer, layer->layers, sheet->revision);
        api_text_format(text, "LAYER START %s\r\n", title);
        for (size_t k = 0; k < layer->line_count; k++) {
            const struct laser_line *line = &layer->lines[k];
            const char *kind = laser_kind_names[line->kind];
            api_text_format(text, "START %s %zu\r\nP %zu\r\n", kind, k + 1, line->count);
            for (size_t p = 0; p < line->count; p++) {
                const struct laser_point *at = &line->points[p];
                api_text_format(text, "%.4f %.4f %.4f ", at->r.x * mm, at->r.y * mm, at->r.z * mm);
                api_text_format(text, "%.6f %.6f %.6f\r\n", at->normal.x, at->normal.y,
                                at->normal.z);
            }
            api_text_format(text, "END %s %zu\r\n", kind, k + 1);
        }
        api_text_format(text, "LAYER END %s\r\n", title);
    }
    api_text_raw(text, "EOD\r\n");
}
