/* SPDX-License-Identifier: MIT */
#include "html.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void html_escape(struct api_text *text, const char *string, size_t length) {
    for (size_t k = 0; k < length; k++) {
        char c = string[k];
        const char *entity = c == '<'    ? "&lt;"
                             : c == '>'  ? "&gt;"
                             : c == '&'  ? "&amp;"
                             : c == '"'  ? "&quot;"
                             : c == '\'' ? "&#39;"
                                         : NULL;
        if (entity)
            api_text_raw(text, entity);
        else
            api_text_bytes(text, &c, 1);
    }
}

void html_say(struct api_text *text, const char *format, ...) {
    char string[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(string, sizeof string, format, arguments);
    va_end(arguments);
    html_escape(text, string, strlen(string));
}
