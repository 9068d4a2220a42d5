/* SPDX-License-Identifier: MIT */
#include "server/store/sql.h"
#include "sqlite.h"
#include <stdlib.h>
#include <string.h>

struct put {
    const struct store_surface *surface;
    bool created;
};

static enum store_answer put_operation(struct sqlite_store *store, struct db *db, void *context) {
    struct put *put = context;
    const struct store_surface *surface = put->surface;
    struct query query =
        db_query(db, "INSERT INTO surfaces (id, owner, created, description, definition)"
                     " VALUES (?, ?, ?, ?, ?) ON CONFLICT (id, owner) DO NOTHING");
    query_bind_text(&query, surface->id);
    query_bind_text(&query, surface->owner);
    query_bind_int(&query, sqlite_now(store));
    query_bind_text(&query, surface->description);
    query_bind_bytes(&query, surface->definition, surface->definition_length);
    enum store_answer answer = query_run(&query);
    put->created = db_changes(db) > 0;
    return answer;
}

enum store_answer sqlite_surface_put(struct store *store, const struct store_surface *surface,
                                     bool *created) {
    struct put put = {.surface = surface};
    enum store_answer answer = sqlite_room_for(store, surface->definition_length);
    if (answer == STORE_OK)
        answer = sqlite_write(store, put_operation, &put);
    *created = put.created;
    return answer;
}

#define SURFACE_COLUMNS "sequence, id, owner, created, description"

static void read_surface(struct query *query, struct store_surface *surface) {
    surface->sequence = query_int(query, 0);
    query_copy(query, 1, surface->id, sizeof surface->id);
    query_copy(query, 2, surface->owner, sizeof surface->owner);
    surface->created = query_int(query, 3);
    query_duplicate(query, 4, &surface->description, NULL);
}

enum store_answer sqlite_surface_get(struct store *store, const char *owner, const char *id,
                                     struct store_surface *surface) {
    struct db *db = sqlite_take_reader(store);
    struct query query =
        db_query(db, "SELECT " SURFACE_COLUMNS ", definition FROM surfaces WHERE id = ?1"
                     " AND (?2 IS NULL OR owner = ?2) LIMIT 1");
    query_bind_text(&query, id);
    query_bind_text(&query, owner);
    bool found = query_row(&query);
    if (found) {
        read_surface(&query, surface);
        query_duplicate(&query, 5, &surface->definition, &surface->definition_length);
    }
    enum store_answer answer = sqlite_give_reader(store, db, query_end(&query));
    return answer == STORE_OK && !found ? STORE_EMPTY : answer;
}

enum store_answer sqlite_surface_list(struct store *store, const char *owner, int64_t cursor,
                                      int limit, struct store_surfaces *page) {
    page->surfaces = calloc((size_t)limit, sizeof *page->surfaces);
    if (!page->surfaces)
        return STORE_DOWN;
    struct db *db = sqlite_take_reader(store);
    struct query query =
        owner ? db_query(db, "SELECT " SURFACE_COLUMNS " FROM surfaces WHERE owner = ?"
                             " AND sequence < ? ORDER BY sequence DESC LIMIT ?")
              : db_query(db, "SELECT " SURFACE_COLUMNS " FROM surfaces WHERE ?1 IS NULL"
                             " AND sequence < ?2 ORDER BY sequence DESC LIMIT ?3");
    query_bind_text(&query, owner);
    query_bind_int(&query, cursor > 0 ? cursor : INT64_MAX);
    query_bind_int(&query, (int64_t)limit + 1);
    while (query_row(&query)) {
        if (page->count == (size_t)limit) {
            page->next = page->surfaces[limit - 1].sequence;
            break;
        }
        read_surface(&query, &page->surfaces[page->count++]);
    }
    return sqlite_give_reader(store, db, query_end(&query));
}

struct named {
    const char *owner, *id; /* owner NULL: all */
};

/* An owner keeps what its jobs need. What an administrator's job needs may be of any owner: the
 * last one stays. */
static enum store_answer in_use(struct db *db, const struct named *named) {
    struct query query = db_query(
        db, "SELECT 1 FROM jobs WHERE surface = ?1 AND status < " SQL_FIRST_ENDED " AND (?2 IS NULL"
            " OR owner = ?2 OR NOT EXISTS"
            " (SELECT 1 FROM surfaces WHERE id = ?1 AND owner <> ?2)) LIMIT 1");
    query_bind_text(&query, named->id);
    query_bind_text(&query, named->owner);
    bool used = query_row(&query);
    enum store_answer answer = query_end(&query);
    return answer == STORE_OK && used ? STORE_CONFLICT : answer;
}

static enum store_answer delete_operation(struct sqlite_store *store, struct db *db,
                                          void *context) {
    (void)store;
    const struct named *named = context;
    enum store_answer answer = in_use(db, named);
    if (answer != STORE_OK)
        return answer;
    struct query query =
        db_query(db, "DELETE FROM surfaces WHERE id = ?1 AND (?2 IS NULL OR owner = ?2)");
    query_bind_text(&query, named->id);
    query_bind_text(&query, named->owner);
    answer = query_run(&query);
    return answer == STORE_OK && db_changes(db) == 0 ? STORE_EMPTY : answer;
}

enum store_answer sqlite_surface_delete(struct store *store, const char *owner, const char *id) {
    struct named named = {.owner = owner, .id = id};
    return sqlite_write(store, delete_operation, &named);
}
