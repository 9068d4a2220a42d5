/* SPDX-License-Identifier: MIT */
#include "number.h"

#include <charconv>

/* The buffer is large enough for every double and int64_t, so to_chars cannot fail. */

size_t api_number_shortest(char *text, double value) {
    return static_cast<size_t>(std::to_chars(text, text + API_NUMBER_SIZE, value).ptr - text);
}

size_t api_number_rounded(char *text, double value, int digits) {
    const auto format = std::chars_format::general;
    return static_cast<size_t>(
        std::to_chars(text, text + API_NUMBER_SIZE, value, format, digits).ptr - text);
}

size_t api_number_integer(char *text, int64_t value) {
    return static_cast<size_t>(std::to_chars(text, text + API_NUMBER_SIZE, value).ptr - text);
}
