/* SPDX-License-Identifier: MIT */
#include "survey.h"
#include <string.h>

bool survey_store(const char *url, struct survey *survey, char why[STORE_WHY_SIZE]) {
    memset(survey, 0, sizeof *survey);
    return store_url_remote(url)
               ? postgres_survey(url, survey, why)
               : sqlite_survey(strncmp(url, "sqlite:", 7) ? url : url + 7, survey, why);
}
