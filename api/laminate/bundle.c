/* SPDX-License-Identifier: MIT */
#include "bundle.h"

#include "api/format/format.h"
#include "api/format/zip_writer.h"
#include "api/json/text.h"
#include "api/request/digest.h"
#include "api/request/prepared_part.h"
#include "map.h"
#include "run.h"
#include "solver/mesh/tessellation.h"
#include "solver/shell/shell.h"
#include "solver/surface/measure.h"
#include "solver/version.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    BUNDLE_ROOM = 1 << 16,
    OWN_TRIANGLES = 4000, /* on a part that is no mesh: enough to look at, and little to send */
    OWN_TRIANGLES_MOST = 20000
};

struct bundle {
    const struct laminate *laminate;
    const struct api_reader *const *nets;
    const struct laminate_roll *ask;
    struct arena *arena; /* of the document that is written */
    struct api_problem *problem;
    struct zip_writer *archive;
    struct api_sha256 hash; /* of the open entry */
    size_t count;
    struct arena *kept; /* what the manifest says */
    struct api_text files, left_out;
};

static bool bundle_no_memory(struct bundle *b) {
    return api_problem_no_memory(b->problem, "the bundle") == API_OK;
}

/* What went wrong with the archive while a document was written. */
static bool fault_of_archive(struct bundle *b, const char *name) {
    switch (zip_writer_fault(b->archive)) {
    case ZIP_NO_MEMORY:
        return bundle_no_memory(b);
    case ZIP_TOO_LARGE:
        return !api_problem_set(b->problem, API_TOO_LARGE,
                                "%s takes more than 4 GiB: ask for it by itself", name);
    default:
        return !api_problem_set(b->problem, API_UNAVAILABLE,
                                "there is no disk space for the bundle now");
    }
}

/* ---- its documents ---- */

/* One whose entry is opened with its first bytes: what cannot be written has none. */
struct bundled {
    struct bundle *bundle;
    const char *name;
    bool open;
};

static bool write_bundled(void *context, const void *bytes, size_t length) {
    struct bundled *document = context;
    struct bundle *b = document->bundle;
    if (!document->open) {
        document->open = true;
        api_sha256_begin(&b->hash);
        if (!zip_writer_open(b->archive, document->name))
            return fault_of_archive(b, document->name);
    }
    api_sha256_add(&b->hash, bytes, length);
    return zip_writer_write(b->archive, bytes, length) || fault_of_archive(b, document->name);
}

/* Ends it, and notes what the manifest says of it. */
static bool close_bundled(const struct bundled *document, const char *media_type,
                          const char *about) {
    struct bundle *b = document->bundle;
    char digits[API_SHA256_SIZE];
    uint64_t size;
    if (!zip_writer_close(b->archive, &size))
        return fault_of_archive(b, document->name);
    api_sha256_end(&b->hash, digits);
    api_text_raw(&b->files, b->count++ ? ",{" : "{");
    api_text_key_string(&b->files, "name", document->name);
    api_text_key_string(&b->files, "media_type", media_type);
    api_text_key_string(&b->files, "about", about);
    api_text_key_integer(&b->files, "bytes", (int64_t)size);
    api_text_key_string(&b->files, "sha256", digits);
    api_text_raw(&b->files, "}");
    return true;
}

/* Notes what cannot be written, and why; what is wrong with the bundle itself stays a problem. */
static bool note_left_out(struct bundle *b, const char *name, const struct api_problem *own) {
    if (own->id == API_OUT_OF_MEMORY || own->id == API_INTERNAL || own->id == API_UNAVAILABLE) {
        *b->problem = *own;
        return false;
    }
    api_text_raw(&b->left_out, b->left_out.length ? ",{" : "{");
    api_text_key_string(&b->left_out, "name", name);
    api_text_key_string(&b->left_out, "reason", own->error[0].detail);
    api_text_raw(&b->left_out, "}");
    return true;
}

static bool end_bundled(const struct bundled *document, const char *media_type, const char *about,
                        const struct api_problem *own) {
    struct bundle *b = document->bundle;
    if (b->problem->id == API_OK && document->open && own->id == API_OK)
        return close_bundled(document, media_type, about);
    if (document->open && b->problem->id == API_OK)
        *b->problem = *own;
    return b->problem->id == API_OK && note_left_out(b, document->name, own);
}

static bool add_json(struct bundle *b, const char *name, const char *about, const char *text) {
    struct bundled document = {.bundle = b, .name = name};
    const struct api_problem none = {.id = API_OK};
    if (!text)
        return bundle_no_memory(b);
    return write_bundled(&document, text, strlen(text)) &&
           end_bundled(&document, "application/json", about, &none);
}

static bool add_drawing(struct bundle *b, const char *name, const struct format *format, int roll) {
    struct bundled document = {.bundle = b, .name = name};
    const struct api_sink sink = {.write = write_bundled, .context = &document};
    struct api_problem own = {.id = API_OK};
    struct arena_mark mark = arena_mark(b->arena);
    struct laminate_roll ask = *b->ask;
    ask.number = roll;
    (void)!laminate_patterns(b->laminate, b->nets, LAMINATE_ALL, format->name, &ask, &sink,
                             b->arena, &own);
    arena_rewind(b->arena, mark);
    return end_bundled(&document, format->media_type, format->about, &own);
}

static bool add_encoded(struct bundle *b, const char *name, const struct format *format,
                        const struct format_source *source) {
    struct bundled document = {.bundle = b, .name = name};
    const struct format_options options = {.plies_as = PLIES_AS_DEFAULT};
    struct api_problem own = {.id = API_OK};
    struct encoder *encoder = encoder_new(format, source, &options, &own);
    char *bytes = encoder ? malloc(BUNDLE_ROOM) : NULL;
    ssize_t got = 0;
    while (bytes && (got = encoder_read(encoder, bytes, BUNDLE_ROOM)) > 0)
        if (!write_bundled(&document, bytes, (size_t)got))
            break;
    if (encoder && (!bytes || got < 0))
        api_problem_set(&own, bytes ? API_INTERNAL : API_OUT_OF_MEMORY, "%s cannot be written",
                        name);
    free(bytes);
    encoder_free(encoder);
    return end_bundled(&document, format->media_type, format->about, &own);
}

/* ---- what they are ---- */

static bool add_request(struct bundle *b) {
    struct arena_mark mark = arena_mark(b->arena);
    bool good = add_json(b, "request.json", "the laminate as it was understood",
                         laminate_normalise(b->laminate, b->arena));
    arena_rewind(b->arena, mark);
    return good;
}

/* What is cut and laid. */
static bool add_drawings(struct bundle *b) {
    static const struct {
        const char *name, *format;
        enum format_use use;
    } drawings[] = {{"ply_book.html", "html", FORMAT_BOOK},
                    {"patterns/rolls.svg", "svg", FORMAT_PATTERN},
                    {"patterns/rolls.dxf", "dxf", FORMAT_PATTERN},
                    {"patterns/pieces_astm.dxf", "astm", FORMAT_PATTERN},
                    {"laser/lines.json", "laser", FORMAT_LASER},
                    {"laser/lines.csv", "laser-csv", FORMAT_LASER},
                    {"laser/virtek.ply", "virtek", FORMAT_LASER}};
    size_t rolls = laminate_cloths(b->laminate);
    for (size_t k = 0; k < sizeof drawings / sizeof *drawings; k++)
        if (!add_drawing(b, drawings[k].name, format_named(drawings[k].use, drawings[k].format), 0))
            return false;
    for (size_t roll = 1; roll <= rolls; roll++) {
        char name[ZIP_NAME_SIZE];
        (void)snprintf(name, sizeof name, "patterns/roll_%zu.plt", roll);
        if (!add_drawing(b, name, format_named(FORMAT_PATTERN, "hpgl"), (int)roll))
            return false;
    }
    return true;
}

/* Of every drape the request, which can be posted again, and the result. */
static bool add_drapes(struct bundle *b) {
    const struct format *npz = format_named(FORMAT_RESULT, "npz");
    for (size_t n = 0; n < b->laminate->net_count; n++) {
        char name[ZIP_NAME_SIZE];
        struct arena_mark mark = arena_mark(b->arena);
        (void)snprintf(name, sizeof name, "drapes/%zu_request.json", n + 1);
        bool good =
            add_json(b, name, "the request of a drape", laminate_request(b->laminate, n, b->arena));
        arena_rewind(b->arena, mark);
        if (!good)
            return false;
        (void)snprintf(name, sizeof name, "drapes/%zu_result.npz", n + 1);
        struct api_problem failed = {.id = API_OK};
        const struct format_source source = {.id = b->laminate->net_digest[n],
                                             .reader = b->nets[n]};
        if (!b->nets[n])
            api_problem_set(&failed, API_INVALID_REQUEST, "the drape failed");
        if (!(b->nets[n] ? add_encoded(b, name, npz, &source) : note_left_out(b, name, &failed)))
            return false;
    }
    return true;
}

/* Triangles on the part, as elements. */
static bool mesh_of_part(struct bundle *b, struct map_target *target) {
    static const double unit_triangle = 0.4330127018922193; /* the area of one of side 1 */
    struct prepared_part shape;
    struct mesh *made = NULL;
    enum status status = STATUS_OK;
    struct vec3 middle;
    double area = 0;
    int32_t face = 0;
    if (laminate_part(b->laminate, &api_limits_default, b->arena, &shape, b->problem) != API_OK)
        return false;
    const struct drape_part *part = &shape.part;
    while (part->shell &&
           shell_component(part->shell, face) != shell_largest_component(part->shell))
        face++;
    if (part->surface)
        area = surface_area(part->surface, &middle);
    else if (part->shell)
        area = shell_area(part->shell, shell_component(part->shell, face), &middle);
    double size = sqrt(area / (OWN_TRIANGLES * unit_triangle));
    if (part->surface)
        status = mesh_from_surface(part->surface, size, OWN_TRIANGLES_MOST, b->arena, &made);
    else if (part->shell)
        status = mesh_from_shell(part->shell, face, size, OWN_TRIANGLES_MOST, b->arena, &made);
    const struct mesh *mesh = part->mesh ? part->mesh : made;
    if (status != STATUS_OK && status != STATUS_OUT_OF_MEMORY)
        return api_problem_set(b->problem, API_DEGENERATE_SURFACE,
                               "the part is too uneven to be covered with triangles, on which "
                               "decks would be: send a mesh") == API_OK;
    int32_t(*elements)[4] =
        status == STATUS_OK ? arena_alloc(b->arena, mesh->triangle_count, sizeof *elements) : NULL;
    if (!elements)
        return bundle_no_memory(b);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        memcpy(elements[t], mesh->corners[t], sizeof mesh->corners[t]);
        elements[t][3] = -1;
    }
    *target = (struct map_target){.vertices = mesh->vertices,
                                  .vertex_count = mesh->vertex_count,
                                  .elements = (const int32_t(*)[4])elements,
                                  .element_count = mesh->triangle_count,
                                  .wants_outlines = true,
                                  .wants_yarns = true};
    return true;
}

/* What the file of a map is called. */
static void name_deck(const struct format *format, char name[ZIP_NAME_SIZE]) {
    static const struct {
        const char *format, *name;
    } names[] = {{"json", "map.json"},        {"csv", "elements.csv"},
                 {"vtu", "map.vtu"},          {"lcmsim", "lcmsim.zip"},
                 {"lcmsim-h5", "lcmsim.h5"},  {"lims", "lims.dmp"},
                 {"nastran", "nastran.bdf"},  {"optistruct", "optistruct.fem"},
                 {"radioss", "radioss.inc"},  {"lsdyna", "lsdyna.k"},
                 {"abaqus", "abaqus.inp"},    {"calculix", "calculix.inp"},
                 {"abd", "abd.csv"},          {"acp", "acp.csv"},
                 {"compost", "compost.json"}, {"gmsh", "gmsh.msh"},
                 {"unv", "universal.unv"}};
    const char *file = format->name;
    for (size_t n = 0; n < sizeof names / sizeof *names; n++)
        file = strcmp(names[n].format, format->name) == 0 ? names[n].name : file;
    (void)snprintf(name, ZIP_NAME_SIZE, "decks/%s", file);
}

/* The stack on a mesh, in every format of maps; angles run from the rosette, if there is one. */
static bool add_decks(struct bundle *b) {
    const struct drape_zero *zero = &b->laminate->plies[0].drape.settings.zero;
    struct arena_mark mark = arena_mark(b->arena);
    struct map_target target;
    struct api_map *map = arena_alloc(b->arena, 1, sizeof *map);
    const struct format *format;
    if (!map)
        return bundle_no_memory(b);
    if (!mesh_of_part(b, &target))
        return false;
    target.has_reference = zero->kind == DRAPE_ZERO_ROSETTE;
    target.reference = zero->x;
    if (laminate_map(b->laminate, b->nets, &target, NULL, b->arena, map, b->problem) != API_OK)
        return false;
    const struct format_source source = {.fields = &map->fields};
    for (size_t k = 0; (format = format_at(FORMAT_MAP, k)); k++) {
        char name[ZIP_NAME_SIZE];
        name_deck(format, name);
        if (!add_encoded(b, name, format, &source))
            return false;
    }
    arena_rewind(b->arena, mark);
    return true;
}

static bool add_manifest(struct bundle *b) {
    const struct laminate *laminate = b->laminate;
    const char *left_out = b->left_out.length ? api_text_finish(&b->left_out) : "";
    const char *files = api_text_finish(&b->files);
    struct api_text text = api_text_growing(b->kept);
    api_text_raw(&text, "{");
    api_text_key_string(&text, "revision", laminate->revision);
    api_text_key_string(&text, "version", DRAPE_VERSION);
    api_text_key_string(&text, "length_unit", laminate->length_unit->name);
    api_text_key(&text, "plies");
    for (size_t k = 0; k < laminate->count; k++) {
        const struct laminate_ply *ply = &laminate->plies[k];
        char title[LAMINATE_TITLE_SIZE];
        laminate_title(ply, title);
        api_text_raw(&text, k ? ",{" : "[{");
        api_text_key_integer(&text, "ply", (int64_t)ply->number + 1);
        api_text_key_string(&text, "name", title);
        api_text_key_integer(&text, "layers", laminate_layers(ply));
        api_text_key_integer(&text, "drape", (int64_t)ply->net + 1);
        api_text_raw(&text, "}");
    }
    api_text_raw(&text, "],\"files\":[");
    api_text_raw(&text, files ? files : "");
    api_text_raw(&text, "],\"left_out\":[");
    api_text_raw(&text, left_out ? left_out : "");
    api_text_raw(&text, "]}\n");
    const char *manifest = left_out && files ? api_text_finish(&text) : NULL;
    return add_json(b, "manifest.json", "what is in the bundle", manifest);
}

/* ---- the whole ---- */

enum api_problem_id laminate_bundle(const struct laminate *laminate,
                                    const struct api_reader *const *nets,
                                    const struct laminate_roll *ask, const struct api_sink *sink,
                                    struct arena *arena, struct api_problem *problem) {
    struct bundle bundle = {.laminate = laminate,
                            .nets = nets,
                            .ask = ask,
                            .arena = arena,
                            .problem = problem,
                            .archive = zip_writer_new(sink),
                            .kept = arena_new(SIZE_MAX)},
                  *b = &bundle;
    b->files = b->left_out = api_text_growing(b->kept);
    if (!b->archive || !b->kept)
        (void)bundle_no_memory(b);
    else if (add_request(b) && add_drawings(b) && add_drapes(b) && add_decks(b) && add_manifest(b))
        (void)(zip_writer_end(b->archive) || fault_of_archive(b, "the bundle"));
    zip_writer_free(b->archive);
    arena_free(b->kept);
    return problem->id;
}
