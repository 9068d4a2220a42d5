/* SPDX-License-Identifier: MIT */
#include "postgres.h"
#include "server/store/seal.h"

/* A statement for each kind of item, whose tables have the same columns. */
#define OF_KIND(before, after)                                                                     \
    (const char *const[]){before "draped.surfaces" after, before "draped.materials" after,         \
                          before "draped.links" after}[kind]

enum store_answer postgres_item_put(struct store *store, enum store_item_kind kind,
                                    const struct store_item *item, bool *created) {
    struct query query = postgres_query_now(
        store, OF_KIND("INSERT INTO ", " (id, owner, created, seal, description, definition,"
                                       " form) VALUES ($2, $3, " POSTGRES_NOW
                                       ", $4, $5, $6, $7) ON CONFLICT (id, owner) DO NOTHING"
                                       " RETURNING 1"));
    query_bind(&query, of_text(item->id), of_text(item->owner), of_int(seal_of_item(item)),
               of_text(item->description), of_bytes(item->definition, item->definition_length),
               of_bytes(item->form, item->form_length));
    *created = query_row(&query);
    return query_end(&query);
}

enum store_answer postgres_form_put(struct store *store, const char *owner, const char *id,
                                    const void *form, size_t length) {
    struct query query =
        postgres_query(store, "UPDATE draped.surfaces SET form = $1"
                              " WHERE id = $2 AND ($3::text IS NULL OR owner = $3) RETURNING 1");
    query_bind(&query, of_bytes(form, length), of_text(id), of_text(owner));
    bool found = query_row(&query);
    return query_end_found(&query, found, STORE_EMPTY);
}

enum store_answer postgres_item_delete(struct store *store, enum store_item_kind kind,
                                       const char *owner, const char *id) {
    static const enum store_answer answers[] = {STORE_OK, STORE_EMPTY, STORE_CONFLICT};
    const bool surface = kind == STORE_SURFACES; /* which is looked for among jobs, too */
    int64_t how = 0;
    struct query query = postgres_query(
        store, surface ? "SELECT draped.delete_surface($1, $2)"
                       : OF_KIND("DELETE FROM ", " WHERE id = $1 AND ($2::text IS NULL"
                                                 " OR owner = $2) RETURNING 0"));
    query_bind(&query, of_text(id), of_text(owner));
    enum store_answer answer = query_number(&query, STORE_EMPTY, &how);
    return answer == STORE_OK ? answers[how] : answer;
}
