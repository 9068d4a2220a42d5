/* SPDX-License-Identifier: MIT */
#include "negotiate.h"
#include "request.h"
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { ITEM_SIZE = 256 };

/* Copies the next piece of a list up to one of `separators`, without blanks around it; moves
 * `*rest` on. Too long a piece is cut, which at worst makes it match nothing. False at the end. */
static bool next_list_item(const char **rest, const char *separators, char piece[ITEM_SIZE]) {
    if (!**rest)
        return false;
    const char *from = *rest, *end = from + strcspn(from, separators);
    *rest = end + (*end != '\0');
    while (end > from && strchr(" \t", end[-1]))
        end--;
    from += strspn(from, " \t");
    size_t length = end > from ? (size_t)(end - from) : 0;
    snprintf(piece, ITEM_SIZE, "%.*s", (int)(length < ITEM_SIZE ? length : ITEM_SIZE - 1), from);
    return true;
}

/* The q of a range's parameters, in thousandths. */
static int quality(const char *parameters) {
    char parameter[ITEM_SIZE];
    while (next_list_item(&parameters, ";", parameter)) {
        if (strncasecmp(parameter, "q=", 2) != 0)
            continue;
        double q = strtod(parameter + 2, NULL);
        return q >= 1 ? 1000 : q > 0 ? (int)(q * 1000) : 0;
    }
    return 1000;
}

int negotiate_quality(const char *accept, const char *media_type) {
    if (!accept || !accept[strspn(accept, " \t")])
        return 1000;
    const size_t kind = strcspn(media_type, "/") + 1;
    int best = 0, wanted = 0;
    char item[ITEM_SIZE], range[ITEM_SIZE];
    while (next_list_item(&accept, ",", item)) {
        const char *rest = item;
        if (!next_list_item(&rest, ";", range))
            continue;
        /* the type itself, "type / *", "* / *", no match */
        int specific = !strcasecmp(range, media_type)                                        ? 3
                       : !strcmp(range, "*/*")                                               ? 1
                       : !strncasecmp(range, media_type, kind) && !strcmp(range + kind, "*") ? 2
                                                                                             : 0;
        if (specific > best) {
            best = specific;
            wanted = quality(rest);
        }
    }
    return wanted;
}

int negotiate_coding(const char *accept_encoding, const char *coding) {
    int others = 0;
    char item[ITEM_SIZE], name[ITEM_SIZE];
    while (accept_encoding && next_list_item(&accept_encoding, ",", item)) {
        const char *rest = item;
        if (!next_list_item(&rest, ";", name))
            continue;
        if (!strcasecmp(name, coding))
            return quality(rest);
        if (!strcmp(name, "*"))
            others = quality(rest);
    }
    return others;
}

/* A preference is NAME [ "=" VALUE ] (RFC 7240, 2), with blanks and quotes. */
int64_t negotiate_wait(const char *prefer, int64_t high) {
    char item[ITEM_SIZE];
    while (prefer && next_list_item(&prefer, ",;", item)) {
        int64_t seconds;
        if (strncasecmp(item, "wait", 4) != 0)
            continue;
        char *value = item + 4 + strspn(item + 4, " \t");
        if (*value++ != '=')
            continue;
        value += strspn(value, " \t");
        size_t length = strlen(value);
        if (length >= 2 && *value == '"' && value[length - 1] == '"') {
            value[length - 1] = '\0';
            value++;
        }
        if (request_parse_int(value, 0, INT64_MAX, &seconds))
            return seconds < high ? seconds : high;
    }
    return 0;
}

bool negotiate_etag_matches(const char *if_none_match, const char *etag) {
    char item[ITEM_SIZE];
    while (if_none_match && next_list_item(&if_none_match, ",", item)) {
        const char *tag = strncmp(item, "W/", 2) ? item : item + 2;
        if (!strcmp(tag, "*") || !strcmp(tag, etag))
            return true;
    }
    return false;
}

bool negotiate_is_type(const char *content_type, const char *type) {
    char own[ITEM_SIZE];
    return next_list_item(&content_type, ";", own) && strcasecmp(own, type) == 0;
}

bool negotiate_is_json(const char *content_type) {
    char type[ITEM_SIZE], parameter[ITEM_SIZE];
    if (!next_list_item(&content_type, ";", type))
        return false;
    size_t length = strlen(type);
    if (strcasecmp(type, "application/json") != 0 &&
        (length < 5 || strcasecmp(type + length - 5, "+json") != 0))
        return false;
    while (next_list_item(&content_type, ";", parameter))
        if (!strncasecmp(parameter, "charset=", 8) && strcasecmp(parameter + 8, "utf-8") != 0 &&
            strcasecmp(parameter + 8, "\"utf-8\"") != 0)
            return false;
    return true;
}

/* Digits alone; too large a number is the largest. False without any. */
static bool read_position(const char **text, uint64_t *value) {
    const char *begin = *text;
    *value = 0;
    for (; **text >= '0' && **text <= '9'; (*text)++) {
        uint64_t digit = (uint64_t)(**text - '0');
        *value = *value > (UINT64_MAX - digit) / 10 ? UINT64_MAX : *value * 10 + digit;
    }
    return *text > begin;
}

enum negotiate_part negotiate_range(const char *range, uint64_t length,
                                    struct negotiate_range *out) {
    uint64_t first, last;
    if (!range || strncasecmp(range, "bytes=", 6) != 0)
        return NEGOTIATE_ALL;
    const char *text = range + 6;
    bool begins = read_position(&text, &first);
    if (*text++ != '-')
        return NEGOTIATE_ALL;
    bool ends = read_position(&text, &last);
    if (*text || (!begins && !ends) || (begins && ends && last < first))
        return NEGOTIATE_ALL;
    if (begins ? first >= length : last == 0 || length == 0)
        return NEGOTIATE_NONE;
    if (!begins) { /* so many at the end */
        first = last < length ? length - last : 0;
        ends = false;
    }
    *out = (struct negotiate_range){first, ends && last < length ? last : length - 1};
    return NEGOTIATE_SOME;
}
