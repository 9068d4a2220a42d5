/* SPDX-License-Identifier: MIT */
#include "postgres.h"
#include <stdlib.h>

/* A statement for each kind of item, whose tables have the same columns. */
#define OF_SHELF(before, after)                                                                    \
    (const char *const[]){before "draped.surfaces" after, before "draped.materials" after}[kind]

enum store_answer postgres_item_put(struct store *store, enum store_item_kind kind,
                                    const struct store_item *item, bool *created) {
    struct pg_query query = postgres_query_now(
        store, OF_SHELF("INSERT INTO ", " (id, owner, created, description, definition)"
                                        " VALUES ($2, $3, " POSTGRES_NOW
                                        ", $4, $5) ON CONFLICT (id, owner) DO NOTHING"
                                        " RETURNING 1"));
    pg_bind_text(&query, item->id);
    pg_bind_text(&query, item->owner);
    pg_bind_text(&query, item->description);
    pg_bind_bytes(&query, item->definition, item->definition_length);
    *created = pg_run(&query) > 0;
    return pg_end(&query);
}

#define ITEM_COLUMNS "sequence, id, owner, created, description"

#define LIST_OF(which)                                                                             \
    OF_SHELF("SELECT " ITEM_COLUMNS " FROM ",                                                      \
             " WHERE sequence < $1 AND " which " ORDER BY sequence DESC LIMIT $3")

static void read_item(struct pg_query *query, size_t row, struct store_item *item) {
    item->sequence = pg_int(query, row, 0);
    pg_copy(query, row, 1, item->id, sizeof item->id);
    pg_copy(query, row, 2, item->owner, sizeof item->owner);
    item->created = pg_int(query, row, 3);
    pg_duplicate(query, row, 4, &item->description, NULL);
}

enum store_answer postgres_item_get(struct store *store, enum store_item_kind kind,
                                    const char *owner, const char *id, struct store_item *item) {
    struct pg_query query = postgres_query(
        store, OF_SHELF("SELECT " ITEM_COLUMNS ", definition FROM ",
                        " WHERE id = $1 AND ($2::text IS NULL OR owner = $2) LIMIT 1"));
    pg_bind_text(&query, id);
    pg_bind_text(&query, owner);
    size_t rows = pg_run(&query);
    if (rows) {
        read_item(&query, 0, item);
        pg_duplicate(&query, 0, 5, &item->definition, &item->definition_length);
    }
    return postgres_end(&query, rows, STORE_EMPTY);
}

enum store_answer postgres_item_list(struct store *store, enum store_item_kind kind,
                                     const char *owner, int64_t cursor, int limit,
                                     struct store_items *page) {
    page->items = calloc((size_t)limit, sizeof *page->items);
    if (!page->items)
        return STORE_DOWN;
    struct pg_query query =
        postgres_query(store, owner ? LIST_OF("owner = $2") : LIST_OF("$2::text IS NULL"));
    pg_bind_int(&query, cursor > 0 ? cursor : INT64_MAX);
    pg_bind_text(&query, owner);
    pg_bind_int(&query, (int64_t)limit + 1);
    size_t rows = pg_run(&query);
    for (size_t row = 0; row < rows && row < (size_t)limit; row++)
        read_item(&query, row, &page->items[page->count++]);
    if (rows > (size_t)limit)
        page->next = page->items[limit - 1].sequence;
    return pg_end(&query);
}

/* A surface is looked for among jobs, too. */
static enum store_answer delete_surface(struct store *store, const char *owner, const char *id) {
    static const enum store_answer answers[] = {STORE_OK, STORE_EMPTY, STORE_CONFLICT};
    struct pg_query query = postgres_query(store, "SELECT draped.delete_surface($1, $2)");
    pg_bind_text(&query, id);
    pg_bind_text(&query, owner);
    int64_t how = pg_run(&query) ? pg_int(&query, 0, 0) : 0;
    enum store_answer answer = pg_end(&query);
    return answer == STORE_OK ? answers[how] : answer;
}

enum store_answer postgres_item_delete(struct store *store, enum store_item_kind kind,
                                       const char *owner, const char *id) {
    if (kind == STORE_SURFACES)
        return delete_surface(store, owner, id);
    struct pg_query query = postgres_query(
        store, "DELETE FROM draped.materials WHERE id = $1 AND ($2::text IS NULL OR owner = $2)"
               " RETURNING 1");
    pg_bind_text(&query, id);
    pg_bind_text(&query, owner);
    return postgres_end(&query, pg_run(&query), STORE_EMPTY);
}
