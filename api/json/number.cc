/* SPDX-License-Identifier: MIT */
#include "number.h"

#include "shortest.h"
#include <charconv>

/* The buffer is large enough for every double and int64_t, so to_chars cannot fail. */

size_t api_number_by_library(char *text, double value) {
    return static_cast<size_t>(std::to_chars(text, text + API_NUMBER_SIZE, value).ptr - text);
}

size_t api_number_shortest(char *text, double value) {
    const size_t length = shortest_write(text, value);
    return length > 0 ? length : api_number_by_library(text, value);
}

size_t api_number_rounded(char *text, double value, int digits) {
    const auto format = std::chars_format::general;
    return static_cast<size_t>(
        std::to_chars(text, text + API_NUMBER_SIZE, value, format, digits).ptr - text);
}

size_t api_number_integer(char *text, int64_t value) {
    return static_cast<size_t>(std::to_chars(text, text + API_NUMBER_SIZE, value).ptr - text);
}

static inline const char *digits_end(const char *at, const char *end) {
    while (at < end && *at >= '0' && *at <= '9')
        at++;
    return at;
}

const char *api_number_end(const char *text, const char *end) {
    const char *const whole = text + (text < end && *text == '-');
    const char *at = digits_end(whole, end);
    if (at == whole || (*whole == '0' && at > whole + 1))
        return nullptr;
    if (at < end && *at == '.') {
        const char *const fraction = at + 1;
        at = digits_end(fraction, end);
        if (at == fraction)
            return nullptr;
    }
    if (at < end && (*at == 'e' || *at == 'E')) {
        const char *const sign = at + 1;
        const char *const exponent = sign + (sign < end && (*sign == '+' || *sign == '-'));
        const char *const last = digits_end(exponent, end);
        return last > exponent ? last : at;
    }
    return at;
}

/* Whether a decimal that no double can hold is too small rather than too large: by the sign of its
 * exponent, or else by the digits before its point. */
static bool underflows(const char *text, const char *end) {
    for (const char *at = text; at < end; at++)
        if (*at == 'e' || *at == 'E')
            return at + 1 < end && at[1] == '-';
    while (text < end && (*text == '-' || *text == '0'))
        text++;
    return text < end && *text == '.';
}

size_t api_number_read(const char *text, size_t length, double *value) {
    const size_t sign = length > 0 && text[0] == '-' ? 1 : 0;
    const char *const end = text + length;
    if (sign == length || ((text[sign] < '0' || text[sign] > '9') && text[sign] != '.'))
        return 0; /* from_chars would take "inf" and "nan" */
    const auto read = std::from_chars(text, end, *value);
    if (read.ec == std::errc::result_out_of_range) {
        if (!underflows(text, read.ptr))
            return 0;
        *value = 0;
    } else if (read.ec != std::errc()) {
        return 0;
    }
    return static_cast<size_t>(read.ptr - text);
}
