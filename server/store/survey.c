/* SPDX-License-Identifier: MIT */
#include "survey.h"
#include <stdio.h>
#include <string.h>

bool survey_refuse(int64_t schema, int64_t current, char why[STORE_WHY_SIZE]) {
    snprintf(why, STORE_WHY_SIZE, "the store has schema %lld, and this version of draped %lld: %s",
             (long long)schema, (long long)current,
             schema < current ? "no daemon of this version has opened it yet" : "use a newer one");
    return false;
}

bool survey_store(const char *url, struct survey *survey, char why[STORE_WHY_SIZE]) {
    memset(survey, 0, sizeof *survey);
    return store_url_remote(url)
               ? postgres_survey(url, survey, why)
               : sqlite_survey(strncmp(url, "sqlite:", 7) ? url : url + 7, survey, why);
}
