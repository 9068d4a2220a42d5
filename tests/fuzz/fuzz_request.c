/* SPDX-License-Identifier: MIT */
/* The text of a request's head as http.c hands it on: target, headers (NAME:VALUE), a line each. */
#include "fuzz.h"

#include "../../server/accept.h"
#include "../../server/id.h"
#include "../../server/request.h"
#include <stdbool.h>
#include <string.h>

static void expect_printable(const char *text) {
    for (; *text; text++)
        FUZZ_PROMISE(*text > ' ' && *text < 0x7f);
}

static void read_headers(const struct request *request) {
    for (size_t k = 0; k < request->header_count; k++) {
        const char *value = request->headers[k].value;
        int64_t number;
        int quality = accept_quality(value, "application/json");
        int coding = accept_coding(value, "gzip");
        FUZZ_PROMISE(quality >= 0 && quality <= 1000 && coding >= 0 && coding <= 1000);
        int64_t wait = accept_wait(value, 60);
        FUZZ_PROMISE(wait >= 0 && wait <= 60);
        (void)accept_etag_known(value, "\"a\"");
        (void)accept_is_json(value);
        if (request_parse_int(value, 5, 99, &number))
            FUZZ_PROMISE(number >= 5 && number <= 99);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static bool prepared;
    int64_t length;
    if (!prepared)
        prepared = id_init();
    char *text = strndup((const char *)data, size);
    char *rest = text;
    char *target = strsep(&rest, "\n");
    struct request *request = request_new(target);
    FUZZ_PROMISE(request != NULL);
    request->method = "POST";
    for (char *line; (line = strsep(&rest, "\n"));) {
        char *value = strchr(line, ':');
        if (value)
            *value++ = '\0';
        request_add_header(request, line, value);
    }
    request_check_framing(request);
    request_choose_id(request);
    expect_printable(request->id);
    bool body = request_has_body(request, &length);
    FUZZ_PROMISE(length >= -1 && (body || length <= 0));
    FUZZ_PROMISE(request->fault[0] || request_header(request, "host") || request->http_1_0);
    read_headers(request);
    request_free(request);
    free(text);
    return 0;
}
