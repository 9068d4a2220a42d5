/* SPDX-License-Identifier: MIT */
#include "server/store/survey.h"
#include "server/clock.h"
#include "sqlite.h"
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { BUSY_MS = 5000 };

bool sqlite_survey(const char *path, survey_look *look, void *context, char why[STORE_WHY_SIZE]) {
    if (access(path, R_OK) != 0) { /* opening it would make it */
        snprintf(why, STORE_WHY_SIZE, "the database %s: %s", path, strerror(errno));
        return false;
    }
    struct db *db = db_open(path, BUSY_MS, why);
    const struct reader reader = sqlite_reader(db);
    bool good = db && db_set_up(db, "PRAGMA query_only=ON", why) &&
                look(&reader, clock_utc_us(), context, why);
    if (!good && db && !why[0])
        db_explain(db, why);
    db_close(db);
    return good;
}
