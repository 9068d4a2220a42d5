/* SPDX-License-Identifier: MIT */
#include "server/store/seal.h"
#include "server/store/sql.h"
#include "sqlite.h"

/* A statement for each kind of item, whose tables have the same columns. */
#define OF_KIND(before, after)                                                                     \
    (const char *const[]){before "surfaces" after, before "materials" after,                       \
                          before "links" after}[kind]

enum store_answer sqlite_item_put(struct store *store, enum store_item_kind kind,
                                  const struct store_item *item, bool *created) {
    struct query query = {.sql = OF_KIND("INSERT INTO ",
                                         " (id, owner, created, seal, description, definition,"
                                         " form) VALUES (?, ?, ?, ?, ?, ?, ?)"
                                         " ON CONFLICT (id, owner) DO NOTHING")};
    query_bind(&query, of_text(item->id), of_text(item->owner),
               of_int(sqlite_now(sqlite_of(store))), of_int(seal_of_item(item)),
               of_text(item->description), of_bytes(item->definition, item->definition_length),
               of_bytes(item->form, item->form_length));
    enum store_answer answer = sqlite_room_for(store, item->definition_length + item->form_length);
    if (answer == STORE_OK)
        answer = sqlite_change(store, DB_DURABLE, &query, STORE_EMPTY);
    *created = answer == STORE_OK;
    return answer == STORE_EMPTY ? STORE_OK : answer;
}

enum store_answer sqlite_form_put(struct store *store, const char *owner, const char *id,
                                  const void *form, size_t length) {
    struct query query = {
        .sql = "UPDATE surfaces SET form = ?1 WHERE id = ?2 AND (?3 IS NULL OR owner = ?3)"};
    query_bind(&query, of_bytes(form, length), of_text(id), of_text(owner));
    enum store_answer answer = sqlite_room_for(store, length);
    return answer == STORE_OK ? sqlite_change(store, DB_DURABLE, &query, STORE_EMPTY) : answer;
}

struct named {
    enum store_item_kind kind;
    const char *owner, *id; /* owner NULL: all */
};

/* An owner keeps the surfaces that its jobs need. What an administrator's job needs may be of any
 * owner: the last one stays. */
static enum store_answer delete_operation(struct sqlite_store *store, struct db *db,
                                          void *context) {
    (void)store;
    const struct named *named = context;
    const enum store_item_kind kind = named->kind;
    struct query query;
    if (kind == STORE_SURFACES) {
        query = db_query(db, "SELECT 1 FROM jobs WHERE surface = ?1 AND status < " SQL_FIRST_ENDED
                             " AND (?2 IS NULL OR owner = ?2 OR NOT EXISTS"
                             " (SELECT 1 FROM surfaces WHERE id = ?1 AND owner <> ?2)) LIMIT 1");
        query_bind(&query, of_text(named->id), of_text(named->owner));
        enum store_answer used = query_find(&query, STORE_EMPTY);
        if (used != STORE_EMPTY)
            return used == STORE_OK ? STORE_CONFLICT : used;
    }
    query = db_query(db, OF_KIND("DELETE FROM ", " WHERE id = ?1 AND (?2 IS NULL OR owner = ?2)"));
    query_bind(&query, of_text(named->id), of_text(named->owner));
    return db_change(&query, STORE_EMPTY);
}

enum store_answer sqlite_item_delete(struct store *store, enum store_item_kind kind,
                                     const char *owner, const char *id) {
    struct named named = {.kind = kind, .owner = owner, .id = id};
    return sqlite_write(store, DB_DURABLE, delete_operation, &named);
}
