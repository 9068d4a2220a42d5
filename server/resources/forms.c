/* SPDX-License-Identifier: MIT */
#include "forms.h"

#include "api/request/prepared_form.h"
#include "server/log.h"
#include "server/spool.h"
#include "server/work/form_cache.h"
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

void forms_close(struct forms_found *form) {
    if (form->file >= 0)
        close(form->file);
    *form = (struct forms_found){.file = -1};
}

/* The stored form as a file, if it is sound: what the disk has kept is looked at here, once. */
static void find_stored_form(struct call *call, const char *id, struct forms_found *form) {
    char *bytes = NULL;
    size_t length = 0;
    if (store_form_get(call->services->store, call_owner(call), id, &bytes, &length) == STORE_OK &&
        bytes && prepared_form_sound(bytes, length, id)) {
        form->file = spool_of_bytes(bytes, length);
        form->length = form->file >= 0 ? length : 0;
        if (form->file >= 0)
            form_cache_put(call->services->forms, call->request->owner, id, form->file, length);
    }
    free(bytes);
}

enum store_answer forms_find(struct call *call, const struct api_check *check,
                             struct forms_found *form, struct store_item *surface) {
    struct form_cache *cache = call->services->forms;
    struct store *store = call->services->store;
    const char *owner = call->request->owner, *const keys[] = {check->ground, check->surface};
    enum store_answer answer = store_form_get(store, call_owner(call), check->surface, NULL, NULL);
    for (int k = 0; answer == STORE_OK && form->file < 0 && k < 2; k++)
        form->file = form_cache_get(cache, owner, keys[k], &form->length);
    if (answer == STORE_OK && form->file < 0)
        find_stored_form(call, check->surface, form);
    if (answer == STORE_OK && form->file < 0)
        answer = store_item_get(store, STORE_SURFACES, call_owner(call), check->surface, surface);
    return answer;
}

char *forms_posted(struct call *call, struct check *check, size_t *length) {
    int file = check_form(check, length);
    char *bytes = file >= 0 ? malloc(*length) : NULL;
    if (bytes && pread(file, bytes, *length, 0) != (ssize_t)*length) {
        free(bytes);
        bytes = NULL;
    }
    if (bytes)
        form_cache_put(call->services->forms, call->request->owner,
                       check_answer(check)->check.surface, file, *length);
    else
        *length = 0;
    if (file >= 0)
        close(file);
    return bytes;
}

/* A form that cannot be stored now is made again another time. */
static void store_renewed(struct call *call, const char *id, const struct forms_found *form) {
    void *bytes = mmap(NULL, form->length, PROT_READ, MAP_PRIVATE, form->file, 0);
    if (bytes == MAP_FAILED)
        return;
    enum store_answer answer =
        store_form_put(call->services->store, call_owner(call), id, bytes, form->length);
    if (answer != STORE_OK)
        log_warning(log_event("form_not_stored"), log_text("store", store_answer_name(answer)));
    munmap(bytes, form->length);
}

void forms_keep(struct call *call, struct check *check, struct forms_found *given) {
    const struct api_check *found = &check_answer(check)->check;
    struct form_cache *cache = call->services->forms;
    struct forms_found made = {.file = check_form(check, &made.length)};
    const struct forms_found *form = made.file >= 0 ? &made : given;
    const char *owner = call->request->owner;
    if (form->file >= 0)
        form_cache_put(cache, owner, found->text, form->file, form->length);
    if (made.file >= 0) {
        form_cache_put(cache, owner, found->ground, made.file, made.length);
        if (found->form_renewed)
            store_renewed(call, found->surface, &made);
    }
    forms_close(&made);
}
