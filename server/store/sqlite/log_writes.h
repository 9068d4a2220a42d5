/* SPDX-License-Identifier: MIT */
/*
 * The write-ahead log written in long pieces. SQLite writes every page of a transaction by two
 * calls, 24 bytes that describe it and then the page, which makes the file system touch each of its
 * own pages twice: for a result of some hundred kilobytes that costs as much as all that SQLite
 * itself does. This layer between SQLite and the system holds back what is written at the end of
 * the log and writes it at once when the transaction does.
 *
 * Nothing of a transaction counts before its last frame, and SQLite tells nobody of a frame before
 * that: so what is held back is in the file before anybody may look for it, before it is
 * synchronised (which SQLite asks for afterwards, or not, as before), and before the commit is
 * answered; a failure is the commit's. https://www.sqlite.org/walformat.html, "The WAL File Format"
 *
 * What is held when a transaction is rolled back is forgotten before another connection's can be
 * in its place.
 */
#ifndef SERVER_STORE_SQLITE_LOG_WRITES_H
#define SERVER_STORE_SQLITE_LOG_WRITES_H

struct sqlite3;

/* As `sqlite3_open_v2`, through the layer over what is SQLite's default at the first call; through
 * that default alone when the layer cannot be had. The connection's rollback hook is taken. Any
 * thread. */
int log_writes_open(const char *path, struct sqlite3 **db, int flags);

#endif
