/* SPDX-License-Identifier: MIT */
#include "prepared_form.h"

#include "api/checksum.h"
#include "digest.h"
#include "prepared_form_build.h"
#include "solver/drape.h"
#include "solver/mesh/mesh.h"
#include "solver/relocation.h"
#include "solver/surface/spans.h"
#include <stddef.h>
#include <string.h>

/* ---- its pointers ---- */

static void relocate_nurbs(struct relocation *relocation, struct nurbs *nurbs) {
    relocate(relocation, &nurbs->u.knots, nurbs->u.knot_count, sizeof *nurbs->u.knots);
    relocate(relocation, &nurbs->v.knots, nurbs->v.knot_count, sizeof *nurbs->v.knots);
    relocate(relocation, &nurbs->points, nurbs->point_count, sizeof *nurbs->points);
    relocate(relocation, &nurbs->weights, nurbs->weight_count, sizeof *nurbs->weights);
}

static void relocate_patch(struct relocation *relocation, struct api_surface *face) {
    relocate_nurbs(relocation, &face->nurbs);
    trim_loops_relocate(relocation, &face->trims, face->trim_count);
    relocate_text(relocation, &face->face_name);
    relocate_text(relocation, &face->face_kind);
    relocate_text(relocation, &face->face_colour);
}

static void relocate_definition(struct relocation *relocation, struct api_surface *surface) {
    struct api_mesh *mesh = &surface->mesh;
    relocate_patch(relocation, surface);
    struct api_surface *face =
        relocate_once(relocation, &surface->faces, surface->face_count, sizeof *face);
    for (size_t k = 0; face && k < surface->face_count; k++)
        relocate_patch(relocation, &face[k]);
    relocate(relocation, &mesh->vertices, mesh->vertex_count, sizeof *mesh->vertices);
    relocate(relocation, &mesh->triangles, mesh->triangle_count, sizeof *mesh->triangles);
    relocate(relocation, &surface->selection.faces, surface->selection.count,
             sizeof *surface->selection.faces);
    const char **note =
        relocate_once(relocation, &surface->notes, surface->note_count, sizeof *note);
    for (size_t k = 0; note && k < surface->note_count; k++)
        relocate_text(relocation, &note[k]);
}

static void relocate_cloth(struct relocation *relocation, struct api_request *request) {
    struct api_permeability *table = &request->permeability;
    size_t cells = table->rows * (table->fractions > 0 ? table->fractions : 1);
    relocate_text(relocation, &request->fabric.material);
    for (int k = 0; k < 2; k++) {
        struct drape_generator *generator = &request->settings.generator[k];
        relocate(relocation, &generator->curve, generator->curve_count, sizeof *generator->curve);
    }
    struct drape_settings *settings = &request->settings;
    relocate(relocation, &settings->energy.shear_curve, settings->energy.shear_count,
             sizeof *settings->energy.shear_curve);
    struct drape_cut_line *cut =
        relocate_once(relocation, &settings->cuts, settings->cut_count, sizeof *cut);
    for (size_t k = 0; cut && k < settings->cut_count; k++)
        relocate(relocation, &cut[k].path, cut[k].count, sizeof *cut[k].path);
    relocate(relocation, &request->cut_names, settings->cut_count, sizeof *request->cut_names);
    relocate(relocation, &request->cut_allowances, settings->cut_count, sizeof(double));
    struct api_limit_curve *limit = &request->fabric.limit;
    relocate(relocation, &limit->shear_deg, limit->rows, sizeof(double));
    relocate(relocation, &limit->severity, limit->rows, sizeof(double));
    relocate(relocation, &table->table_fractions, table->fractions, sizeof(double));
    relocate(relocation, &table->shear_deg, table->rows, sizeof(double));
    relocate(relocation, &table->table_k1, cells, sizeof(double));
    relocate(relocation, &table->table_k2, cells, sizeof(double));
    relocate(relocation, &table->table_k3, cells, sizeof(double));
    relocate(relocation, &table->angle_deg, cells, sizeof(double));
}

static void relocate_form(struct relocation *relocation, void *root) {
    struct prepared_form *form = root;
    struct prepared_part *part = &form->part;
    relocate_definition(relocation, &form->request.surface);
    relocate_cloth(relocation, &form->request);
    surface_relocate(relocation, &part->part.surface);
    trim_relocate(relocation, &part->part.trim);
    shell_relocate(relocation, &part->part.shell);
    mesh_relocate(relocation, &part->part.mesh);
    shell_relocate(relocation, &part->shell.shell);
    shell_relocate(relocation, &part->shell.all);
    drape_prepared_relocate(relocation, &part->prepared);
    relocate(relocation, &part->shell.numbers, part->shell.count, sizeof *part->shell.numbers);
}

/* ---- bytes ---- */

/* Before the image. The key tells forms apart, a digest made once; the checksum, made whenever a
 * form is opened, tells that nothing has changed by accident since. */
struct form_head {
    unsigned char key[PREPARED_FORM_KEY]; /* of the members below and of the image */
    int64_t checksum;                     /* of the same and of the key, this being 0 */
    char build[64]; /* the solver's version and what its structures look like */
    char source[API_ID_SIZE];
    uint64_t length; /* of the image */
};

static const char build[] = "draped form " DRAPE_VERSION " " PREPARED_FORM_BUILD;
_Static_assert((int)PREPARED_FORM_KEY == (int)API_DIGEST_BYTES, "the digest is the key");
_Static_assert(sizeof build <= sizeof((struct form_head *)0)->build, "the build's name fits");

static int64_t form_checksum(const struct form_head *head, const void *image) {
    struct form_head summed;
    memcpy(&summed, head, sizeof summed); /* the bytes between its members as well */
    summed.checksum = 0;
    return checksum_of(checksum_of(0, &summed, sizeof summed), image, head->length);
}

/* The bytes between its members are zeros. */
static void fill_head(struct form_head *head, const char source[API_ID_SIZE], const void *image,
                      size_t length) {
    const size_t described = offsetof(struct form_head, build);
    memset(head, 0, sizeof *head);
    memcpy(head->build, build, sizeof build);
    memcpy(head->source, source, API_ID_SIZE);
    head->length = length;
    api_digest_pieces((unsigned char *)head + described, sizeof *head - described, image, length,
                      head->key);
    head->checksum = form_checksum(head, image);
}

static int unit_number(const struct api_unit *unit) {
    return unit ? (int)(unit - api_units) : -1;
}

/* What drapes of the largest component of a shell share, whatever they ask for; NULL: nothing, or
 * no memory. */
static const struct drape_prepared *make_shared(const struct prepared_part *part,
                                                struct arena *arena) {
    const struct drape_settings settings = {.method = DRAPE_GIB};
    const struct shell *shell = part->part.shell;
    const struct drape_prepared *made = NULL;
    if (part->prepared || !shell)
        return part->prepared;
    enum status status =
        drape_prepare(&part->part, shell_largest_component(shell), &settings, arena, &made);
    return status == STATUS_OK ? made : NULL;
}

/* What lies outside of the arena is written by its number, or belongs to one run. */
static struct prepared_form *make_root(const struct api_request *request,
                                       const struct prepared_part *part,
                                       const char source[API_ID_SIZE], struct arena *arena) {
    struct prepared_form *form = arena_alloc(arena, 1, sizeof *form);
    if (!form)
        return NULL;
    form->request = *request;
    form->part = *part;
    (void)prepared_part_bends(&form->part);
    form->part.prepared = make_shared(part, arena);
    memcpy(form->source, source, API_ID_SIZE);
    form->unit[0] = unit_number(request->length_unit);
    form->unit[1] = unit_number(request->surface.length_unit);
    form->request.length_unit = form->request.surface.length_unit = NULL;
    form->request.surface.form = NULL;
    form->request.settings.statistics = NULL;
    form->request.settings.prepared = NULL;
    form->request.settings.team = NULL;
    return form;
}

size_t prepared_form_write(const struct api_request *request, const struct prepared_part *part,
                           const char source[API_ID_SIZE], struct arena *arena,
                           const struct api_sink *sink) {
    struct relocation relocation = {.walk = relocate_form};
    struct arena *own = arena_child(arena);
    struct prepared_form *root = make_root(request, part, source, arena);
    size_t length = 0;
    const void *image = own && root && arena_held(arena) <= 2 * PREPARED_FORM_MOST
                            ? relocation_take(&relocation, arena, root, sizeof *root, own, &length)
                            : NULL;
    if (!image || length > PREPARED_FORM_MOST)
        return 0;
    struct form_head head;
    fill_head(&head, source, image, length);
    bool good =
        sink->write(sink->context, &head, sizeof head) && sink->write(sink->context, image, length);
    return good ? sizeof head + length : 0;
}

bool prepared_form_sound(const void *bytes, size_t length, const char source[API_ID_SIZE]) {
    struct form_head head;
    if (length < sizeof head)
        return false;
    memcpy(&head, bytes, sizeof head);
    source = source ? source : head.source;
    return !memcmp(head.build, build, sizeof build) && !memcmp(head.source, source, API_ID_SIZE) &&
           head.length == length - sizeof head &&
           head.checksum == form_checksum(&head, (const char *)bytes + sizeof head);
}

const struct prepared_form *prepared_form_open(const void *bytes, size_t length,
                                               const char source[API_ID_SIZE],
                                               struct arena *arena) {
    struct relocation relocation = {.walk = relocate_form};
    if (!prepared_form_sound(bytes, length, source))
        return NULL;
    struct prepared_form *form =
        relocation_open(&relocation, (const char *)bytes + sizeof(struct form_head),
                        length - sizeof(struct form_head), sizeof *form, arena);
    const struct api_unit *unit[2] = {NULL, NULL};
    for (int k = 0; form && k < 2; k++) {
        if (form->unit[k] >= API_UNIT_COUNT)
            return NULL;
        unit[k] = form->unit[k] >= 0 ? &api_units[form->unit[k]] : NULL;
    }
    if (form) {
        form->request.length_unit = unit[0];
        form->request.surface.length_unit = unit[1];
        form->request.surface.form = form;
    }
    return form;
}

const struct prepared_form *prepared_form_find(const struct api_input *input,
                                               const char source[API_ID_SIZE],
                                               struct arena *arena) {
    if (input->opened && !memcmp(input->opened->source, source, API_ID_SIZE))
        return input->opened;
    return input->form_length > 0
               ? prepared_form_open(input->form, input->form_length, source, arena)
               : NULL;
}

/* ---- what it has ---- */

const struct prepared_form *prepared_form_make(const struct api_surface *surface,
                                               struct arena *arena) {
    struct api_problem fault = {0};
    struct prepared_form *form = arena_alloc(arena, 1, sizeof *form);
    if (!form || prepared_part_make_whole(surface, arena, &form->part, &fault) == API_OUT_OF_MEMORY)
        return NULL;
    form->request.surface = *surface;
    form->request.surface.selection = (struct api_selection){.kind = API_SELECT_ALL};
    return form;
}

static bool same_selection(const struct api_selection *a, const struct api_selection *b) {
    if (a->kind != b->kind)
        return false;
    if (a->kind == API_SELECT_LIST)
        return a->count == b->count && !memcmp(a->faces, b->faces, a->count * sizeof *a->faces);
    return a->kind == API_SELECT_ALL ||
           (a->seed == b->seed && a->grow_from == b->grow_from && a->up_to_deg == b->up_to_deg &&
            a->point.x == b->point.x && a->point.y == b->point.y && a->point.z == b->point.z);
}

const struct prepared_part *prepared_form_part(const struct api_request *request) {
    const struct prepared_form *form = request->surface.form;
    const struct drape_part *part = form ? &form->part.part : NULL;
    return part && (part->surface || part->shell || part->mesh) &&
                   form->request.offset == request->offset &&
                   same_selection(&form->request.surface.selection, &request->surface.selection)
               ? &form->part
               : NULL;
}
