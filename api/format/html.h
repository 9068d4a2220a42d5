/* SPDX-License-Identifier: MIT */
/* Text of HTML and SVG. */
#ifndef API_FORMAT_HTML_H
#define API_FORMAT_HTML_H

#include "api/json/text.h"

/* Text of any kind, also within quotes. */
void html_escape(struct api_text *text, const char *string, size_t length);

/* As printf; escaped, of what is longer than 511 bytes the beginning. */
void html_say(struct api_text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
