/* SPDX-License-Identifier: MIT */
#include "forms.h"

#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* Of a process, the one that was used last first. */
static struct kept {
    char key[PREPARED_FORM_KEY]; /* the first bytes of the form */
    const struct prepared_form *form;
    struct arena *arena;
} kept[FORMS_KEPT];

bool forms_map(int file, size_t length, struct forms_mapped *form) {
    *form = (struct forms_mapped){NULL, length};
    void *bytes = NULL;
    if (length > 0)
        bytes = mmap(NULL, length, PROT_READ, MAP_PRIVATE, file, 0);
    if (file >= 0)
        close(file);
    form->bytes = bytes == MAP_FAILED ? NULL : bytes;
    return bytes != MAP_FAILED;
}

void forms_unmap(struct forms_mapped *form) {
    union {
        const void *mapped;
        void *memory;
    } bytes = {form->bytes};
    if (form->bytes)
        munmap(bytes.memory, form->length);
}

/* Frees the last places until what is left holds no more than that. */
static void make_room(size_t bytes) {
    size_t held = 0;
    for (int k = 0; k < FORMS_KEPT; k++) {
        held += kept[k].arena ? arena_held(kept[k].arena) : 0;
        if (k < FORMS_KEPT - 1 && held <= FORMS_KEPT_BYTES - bytes)
            continue;
        arena_free(kept[k].arena);
        kept[k] = (struct kept){.form = NULL};
    }
}

const struct prepared_form *forms_open(const struct forms_mapped *form) {
    struct kept found = {.form = NULL};
    int at = 0;
    if (form->length < sizeof found.key || form->length > FORMS_KEPT_BYTES / 2)
        return NULL;
    while (at < FORMS_KEPT &&
           !(kept[at].form && !memcmp(kept[at].key, form->bytes, sizeof found.key)))
        at++;
    if (at < FORMS_KEPT) {
        found = kept[at];
    } else {
        make_room(2 * form->length); /* the last place is free then */
        at = FORMS_KEPT - 1;
        memcpy(found.key, form->bytes, sizeof found.key);
        found.arena = arena_new(2 * form->length + FORMS_KEPT_BYTES / 64);
        if (found.arena)
            found.form = prepared_form_open(form->bytes, form->length, NULL, found.arena);
        if (!found.form) {
            arena_free(found.arena);
            return NULL;
        }
    }
    memmove(&kept[1], &kept[0], (size_t)at * sizeof *kept);
    kept[0] = found;
    return found.form;
}
