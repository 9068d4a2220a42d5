/* SPDX-License-Identifier: MIT */
#include "postgres.h"
#include <stdlib.h>

enum store_answer postgres_surface_put(struct store *store, const struct store_surface *surface,
                                       bool *created) {
    struct pg_query query = postgres_query_now(
        store, "INSERT INTO draped.surfaces (id, owner, created, description, definition)"
               " VALUES ($2, $3, " POSTGRES_NOW ", $4, $5) ON CONFLICT (id, owner) DO NOTHING"
               " RETURNING 1");
    pg_bind_text(&query, surface->id);
    pg_bind_text(&query, surface->owner);
    pg_bind_text(&query, surface->description);
    pg_bind_bytes(&query, surface->definition, surface->definition_length);
    *created = pg_run(&query) > 0;
    return pg_end(&query);
}

#define SURFACE_COLUMNS "sequence, id, owner, created, description"

#define LIST_OF(which)                                                                             \
    "SELECT " SURFACE_COLUMNS " FROM draped.surfaces WHERE sequence < $1 AND " which               \
    " ORDER BY sequence DESC LIMIT $3"

static void read_surface(struct pg_query *query, size_t row, struct store_surface *surface) {
    surface->sequence = pg_int(query, row, 0);
    pg_copy(query, row, 1, surface->id, sizeof surface->id);
    pg_copy(query, row, 2, surface->owner, sizeof surface->owner);
    surface->created = pg_int(query, row, 3);
    pg_duplicate(query, row, 4, &surface->description, NULL);
}

enum store_answer postgres_surface_get(struct store *store, const char *owner, const char *id,
                                       struct store_surface *surface) {
    struct pg_query query = postgres_query(store, "SELECT " SURFACE_COLUMNS
                                                  ", definition FROM draped.surfaces WHERE id = $1"
                                                  " AND ($2::text IS NULL OR owner = $2) LIMIT 1");
    pg_bind_text(&query, id);
    pg_bind_text(&query, owner);
    size_t rows = pg_run(&query);
    if (rows) {
        read_surface(&query, 0, surface);
        pg_duplicate(&query, 0, 5, &surface->definition, &surface->definition_length);
    }
    return postgres_end(&query, rows, STORE_EMPTY);
}

enum store_answer postgres_surface_list(struct store *store, const char *owner, int64_t cursor,
                                        int limit, struct store_surfaces *page) {
    page->surfaces = calloc((size_t)limit, sizeof *page->surfaces);
    if (!page->surfaces)
        return STORE_DOWN;
    struct pg_query query =
        postgres_query(store, owner ? LIST_OF("owner = $2") : LIST_OF("$2::text IS NULL"));
    pg_bind_int(&query, cursor > 0 ? cursor : INT64_MAX);
    pg_bind_text(&query, owner);
    pg_bind_int(&query, (int64_t)limit + 1);
    size_t rows = pg_run(&query);
    for (size_t row = 0; row < rows && row < (size_t)limit; row++)
        read_surface(&query, row, &page->surfaces[page->count++]);
    if (rows > (size_t)limit)
        page->next = page->surfaces[limit - 1].sequence;
    return pg_end(&query);
}

enum store_answer postgres_surface_delete(struct store *store, const char *owner, const char *id) {
    static const enum store_answer answers[] = {STORE_OK, STORE_EMPTY, STORE_CONFLICT};
    struct pg_query query = postgres_query(store, "SELECT draped.delete_surface($1, $2)");
    pg_bind_text(&query, id);
    pg_bind_text(&query, owner);
    int64_t how = pg_run(&query) ? pg_int(&query, 0, 0) : 0;
    enum store_answer answer = pg_end(&query);
    return answer == STORE_OK ? answers[how] : answer;
}
