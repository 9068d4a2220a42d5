/* SPDX-License-Identifier: MIT */
#include "wire.h"
#include <string.h>
#include <strings.h>

/* ------------------------------------------------------------------ sets of bytes */

/* A bit for each of the 256 bytes, as RFC 9110 and RFC 3986 define the classes. */
typedef const uint32_t set[8];

/* tchar */
static set token_set = {0, 0x03ff6cfa, 0xc7fffffe, 0x57ffffff, 0, 0, 0, 0};
/* visible ASCII but '#': what a URI may have, and what browsers send unescaped */
static set target_set = {0, 0xfffffff6, 0xffffffff, 0x7fffffff, 0, 0, 0, 0};
/* field-vchar, blank and tab */
static set value_set = {0x00000200, 0xffffffff, 0xffffffff, 0x7fffffff,
                        0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff};
/* reg-name without '%': unreserved and sub-delims */
static set host_set = {0, 0x2bff7fd2, 0x87fffffe, 0x47fffffe, 0, 0, 0, 0};
/* an address in brackets: hexadecimal digits, ':' and '.' */
static set address_set = {0, 0x07ff4000, 0x0000007e, 0x0000007e, 0, 0, 0, 0};
/* qdtext */
static set quoted_set = {0x00000200, 0xfffffffb, 0xefffffff, 0x7fffffff,
                         0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff};

static inline bool in_set(const uint32_t *bits, unsigned char c) {
    return bits[c >> 5] >> (c & 31) & 1;
}

int wire_hex_value(unsigned char c) {
    unsigned char lower = c | 0x20;
    return c >= '0' && c <= '9' ? c - '0' : lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

/* ------------------------------------------------------------------ the machine */

/* What the next byte belongs to. In order: the request line, fields, the body. */
enum state {
    START,
    EMPTY_LF, /* of an empty line before the request line */
    METHOD,
    TARGET_FIRST,
    TARGET,       /* that begins with '/' */
    TARGET_OTHER, /* kept in `text` */
    VERSION,      /* `text_length` bytes of it have come */
    LINE_LF,

    FIELD_FIRST, /* of a name, or of the empty line */
    FIELD_NAME,
    FIELD_BLANK, /* before the value */
    FIELD_VALUE,
    FIELD_LF,
    HEAD_LF,

    TRAILER_FIRST, /* as FIELD_FIRST to HEAD_LF */
    TRAILER_NAME,
    TRAILER_BLANK,
    TRAILER_VALUE,
    TRAILER_LF,
    TRAILERS_LF,

    BODY,
    CHUNK_FIRST, /* of the size */
    CHUNK_SIZE,
    EXTENSION_FIRST, /* of the name */
    EXTENSION_NAME,
    EXTENSION_VALUE, /* its first byte */
    EXTENSION_TOKEN,
    EXTENSION_QUOTED,
    EXTENSION_ESCAPED,
    EXTENSION_END, /* after the closing quote */
    CHUNK_LF,
    CHUNK_DATA,
    DATA_CR,
    DATA_LF
};

enum { TRAILERS = TRAILER_FIRST - FIELD_FIRST }; /* from a state of fields to that of trailers */

/* Fields that say how a message is framed or where it goes; each only once. */
enum field { OTHER, HOST, CONTENT_LENGTH, TRANSFER_ENCODING, AUTHORIZATION, CONNECTION };

/* Always false: the byte is not good. */
static bool refuse_bytes(struct wire *wire, enum api_problem_id problem, const char *detail) {
    wire->problem = problem;
    wire->detail = detail;
    return false;
}

static bool malformed(struct wire *wire, const char *detail) {
    return refuse_bytes(wire, API_BAD_REQUEST, detail);
}

/* Always true. */
static bool go(struct wire *wire, enum state state) {
    wire->state = (unsigned char)state;
    return true;
}

static void keep_byte(struct wire *wire, unsigned char c) {
    if (wire->text_length < sizeof wire->text)
        wire->text[wire->text_length++] = (char)c;
    else
        wire->text_cut = true;
}

static void forget_text(struct wire *wire) {
    wire->text_length = 0;
    wire->text_cut = false;
}

static bool complete_message(struct wire *wire) {
    wire->messages++;
    wire->fields = 0;
    return go(wire, START);
}

/* ------------------------------------------------------------------ the request line */

bool wire_is_authority(const char *text, size_t length) {
    size_t at = 0, port = 0;
    if (length && text[0] == '[') {
        while (++at < length && in_set(address_set, (unsigned char)text[at]))
            continue;
        if (at < 3 || at == length || text[at++] != ']')
            return false;
    } else {
        for (; at < length && text[at] != ':'; at++) {
            bool escape = text[at] == '%' && length - at > 2 &&
                          wire_hex_value((unsigned char)text[at + 1]) >= 0 &&
                          wire_hex_value((unsigned char)text[at + 2]) >= 0;
            if (!escape && !in_set(host_set, (unsigned char)text[at]))
                return false;
            at += escape ? 2 : 0;
        }
        if (at == 0)
            return false;
    }
    if (at < length && text[at++] != ':')
        return false;
    for (; at < length && text[at] >= '0' && text[at] <= '9'; at++)
        port++;
    return at == length && port <= 5;
}

/* A target that is no path: `*` of OPTIONS, or an absolute URI. */
static bool end_target(struct wire *wire) {
    static const char *const schemes[] = {"http://", "https://"};
    const char *text = wire->text;
    size_t length = wire->text_length, begin = 0;
    wire->asterisk = length == 1 && text[0] == '*';
    if (wire->asterisk)
        return true;
    for (size_t k = 0; k < 2; k++)
        if (length > strlen(schemes[k]) && !strncasecmp(text, schemes[k], strlen(schemes[k])))
            begin = strlen(schemes[k]);
    const char *slash = begin ? memchr(text + begin, '/', length - begin) : NULL;
    size_t end = slash ? (size_t)(slash - text) : length;
    if (begin && (slash || !wire->text_cut) && wire_is_authority(text + begin, end - begin))
        return true;
    return malformed(wire, "the target is neither a path nor an absolute http URI with a path");
}

static bool version_byte(struct wire *wire, unsigned char c) {
    static const char version[] = "HTTP/1.";
    size_t at = wire->text_length++;
    if (at == sizeof version - 1 && c >= '0' && c <= '9') {
        wire->http_1_0 = c == '0';
        return true;
    }
    if (at == sizeof version && c == '\r')
        return go(wire, LINE_LF);
    if (at < sizeof version - 1 && c == (unsigned char)version[at])
        return true;
    if (at == 5 && c >= '0' && c <= '9')
        return refuse_bytes(wire, API_HTTP_VERSION,
                            "the request uses another version of HTTP than 1.1 and 1.0");
    return malformed(wire, "the request line does not end with HTTP/1.1 or HTTP/1.0");
}

static bool line_byte(struct wire *wire, unsigned char c) {
    static const char stray[] = "the request line has a character that is not allowed there";
    switch ((enum state)wire->state) {
    case START:
        if (c == '\r')
            return go(wire, EMPTY_LF);
        if (!in_set(token_set, c))
            return malformed(wire, "the request line does not begin with a method");
        wire->head = 1;
        wire->left = wire->extensions = 0;
        wire->fields = wire->seen = 0;
        wire->asterisk = wire->http_1_0 = wire->chunked = false;
        wire->close_token = wire->keep_token = false;
        forget_text(wire);
        keep_byte(wire, c);
        return go(wire, METHOD);
    case EMPTY_LF:
        if (c != '\n' || ++wire->fields > WIRE_EMPTY_LINES_MAX)
            return malformed(wire, "there is no request line");
        return go(wire, START);
    case METHOD:
        if (c == ' ') {
            wire->options = wire->text_length == 7 && !memcmp(wire->text, "OPTIONS", 7);
            forget_text(wire);
            return go(wire, TARGET_FIRST);
        }
        keep_byte(wire, c);
        return in_set(token_set, c) ||
               malformed(wire, "the method has a character that is not allowed there");
    case TARGET_FIRST:
        if (c == '/')
            return go(wire, TARGET);
        keep_byte(wire, c);
        return in_set(target_set, c) ? go(wire, TARGET_OTHER) : malformed(wire, stray);
    case TARGET_OTHER:
        if (c == ' ' && !end_target(wire))
            return false;
        keep_byte(wire, c);
        /* fall through */
    case TARGET:
        if (c != ' ')
            return in_set(target_set, c) || malformed(wire, stray);
        forget_text(wire);
        return go(wire, VERSION);
    case VERSION:
        return version_byte(wire, c);
    default: /* LINE_LF */
        if (wire->asterisk && !wire->options)
            return malformed(wire, "only OPTIONS takes the target '*'");
        return c == '\n' ? go(wire, FIELD_FIRST)
                         : malformed(wire, "the request line does not end with CR LF");
    }
}

/* ------------------------------------------------------------------ fields */

/* Whether the list of tokens in `text` has this one. */
static bool has_token(const struct wire *wire, const char *token) {
    size_t length = strlen(token);
    for (size_t k = 0; k + length <= wire->text_length; k++) {
        bool begins = k == 0 || strchr(", \t", wire->text[k - 1]);
        bool ends = k + length == wire->text_length || strchr(", \t", wire->text[k + length]);
        if (begins && ends && !strncasecmp(wire->text + k, token, length))
            return true;
    }
    return false;
}

/* With the value in `text`. */
static bool end_field(struct wire *wire) {
    static const char *const twice[] = {
        "", "there is more than one Host", "there is more than one Content-Length",
        "there is more than one Transfer-Encoding", "there is more than one Authorization"};
    enum field field = (enum field)wire->field;
    bool huge = false;
    if (field == HOST)
        while (wire->text_length && strchr(" \t", wire->text[wire->text_length - 1]))
            wire->text_length--;
    if (field != OTHER && wire->state == TRAILER_LF)
        return malformed(wire, "a trailer has a field that belongs to the head");
    if (field != OTHER && field != CONNECTION && wire->seen >> field & 1)
        return malformed(wire, twice[field]);
    wire->seen = (unsigned char)(wire->seen | 1 << field);
    switch (field) {
    case HOST:
        if (wire->text_length &&
            (wire->text_cut || !wire_is_authority(wire->text, wire->text_length)))
            return malformed(wire, "Host is not a name or address with an optional port");
        break;
    case CONTENT_LENGTH:
        if (!wire->text_length || wire->text_cut)
            return malformed(wire, "Content-Length is not a number");
        for (size_t k = 0; k < wire->text_length; k++) {
            unsigned digit = (unsigned char)wire->text[k] - '0';
            if (digit > 9)
                return malformed(wire, "Content-Length is not a number");
            huge = huge || wire->left > ((uint64_t)INT64_MAX - digit) / 10;
            wire->left = huge ? 0 : wire->left * 10 + digit;
        }
        return !huge || refuse_bytes(wire, API_TOO_LARGE, "the body is too large");
    case TRANSFER_ENCODING:
        wire->chunked = wire->text_length == 7 && !strncasecmp(wire->text, "chunked", 7);
        return wire->chunked || malformed(wire, "Transfer-Encoding must be chunked");
    case CONNECTION:
        wire->close_token = wire->close_token || has_token(wire, "close");
        wire->keep_token = wire->keep_token || has_token(wire, "keep-alive");
        break;
    default:
        break;
    }
    return true;
}

/* How long the body is (RFC 9112, 6.3), and whether another message may follow. */
static bool end_head(struct wire *wire) {
    if (wire->chunked && wire->seen >> CONTENT_LENGTH & 1)
        return malformed(wire, "Content-Length and Transfer-Encoding exclude each other");
    if (wire->chunked && wire->http_1_0)
        return malformed(wire, "HTTP/1.0 has no Transfer-Encoding");
    if (!wire->http_1_0 && !(wire->seen >> HOST & 1))
        return malformed(wire, "there is no Host");
    wire->closing = wire->close_token || (wire->http_1_0 && !wire->keep_token);
    wire->line = 0;
    return wire->chunked ? go(wire, CHUNK_FIRST)
           : wire->left  ? go(wire, BODY)
                         : complete_message(wire);
}

static bool field_byte(struct wire *wire, unsigned char c) {
    static const char *const names[] = {
        "", "host", "content-length", "transfer-encoding", "authorization", "connection"};
    int part = wire->state < TRAILER_FIRST ? 0 : TRAILERS;
    static const char stray[] = "a header's value has a control character";
    switch (wire->state - part) {
    case FIELD_FIRST:
        if (c == '\r')
            return go(wire, (enum state)(HEAD_LF + part));
        if (c == ' ' || c == '\t')
            return malformed(wire, "a header is folded over two lines");
        if (!in_set(token_set, c))
            return malformed(wire, "a header's name has a character that is not allowed there");
        if (++wire->fields > WIRE_FIELDS_MAX)
            return refuse_bytes(wire, API_HEADERS_TOO_LARGE, "there are too many headers");
        forget_text(wire);
        keep_byte(wire, c);
        return go(wire, (enum state)(FIELD_NAME + part));
    case FIELD_NAME:
        if (c == ':') {
            wire->field = CONNECTION;
            while (wire->field != OTHER &&
                   (strlen(names[wire->field]) != wire->text_length ||
                    strncasecmp(wire->text, names[wire->field], wire->text_length) != 0))
                wire->field--;
            forget_text(wire);
            return go(wire, (enum state)(FIELD_BLANK + part));
        }
        keep_byte(wire, c);
        return in_set(token_set, c) ||
               malformed(wire, "a header's name has a character that is not allowed there");
    case FIELD_BLANK:
        if (c == ' ' || c == '\t')
            return true;
        go(wire, (enum state)(FIELD_VALUE + part));
        /* fall through */
    case FIELD_VALUE:
        if (c == '\r')
            return go(wire, (enum state)(FIELD_LF + part));
        if (wire->field != OTHER)
            keep_byte(wire, c);
        return in_set(value_set, c) || malformed(wire, stray);
    case FIELD_LF:
        if (c != '\n')
            return malformed(wire, "a header does not end with CR LF");
        return end_field(wire) && go(wire, (enum state)(FIELD_FIRST + part));
    default: /* HEAD_LF */
        if (c != '\n')
            return malformed(wire, "the head does not end with CR LF");
        return part ? complete_message(wire) : end_head(wire);
    }
}

/* ------------------------------------------------------------------ chunks */

/* After an extension's name, value or closing quote: another one, or the end of the line. */
static bool end_extension(struct wire *wire, unsigned char c) {
    if (c == ';')
        return go(wire, EXTENSION_FIRST);
    return c == '\r' ? go(wire, CHUNK_LF) : malformed(wire, "a chunk's extension is malformed");
}

static bool extension_byte(struct wire *wire, unsigned char c) {
    if (++wire->extensions > WIRE_EXTENSION_BYTES)
        return refuse_bytes(wire, API_TOO_LARGE, "the extensions of the chunks are too long");
    switch ((enum state)wire->state) {
    case EXTENSION_FIRST:
        return in_set(token_set, c) ? go(wire, EXTENSION_NAME) : end_extension(wire, 0);
    case EXTENSION_NAME:
        if (c == '=')
            return go(wire, EXTENSION_VALUE);
        return in_set(token_set, c) || end_extension(wire, c);
    case EXTENSION_VALUE:
        if (c == '"')
            return go(wire, EXTENSION_QUOTED);
        return in_set(token_set, c) ? go(wire, EXTENSION_TOKEN) : end_extension(wire, 0);
    case EXTENSION_TOKEN:
        return in_set(token_set, c) || end_extension(wire, c);
    case EXTENSION_QUOTED:
        if (c == '"')
            return go(wire, EXTENSION_END);
        if (c == '\\')
            return go(wire, EXTENSION_ESCAPED);
        return in_set(quoted_set, c) || end_extension(wire, 0);
    case EXTENSION_ESCAPED:
        return in_set(value_set, c) ? go(wire, EXTENSION_QUOTED) : end_extension(wire, 0);
    default: /* EXTENSION_END */
        return end_extension(wire, c);
    }
}

static bool chunk_byte(struct wire *wire, unsigned char c) {
    const bool first = wire->state == CHUNK_FIRST;
    const int digit = wire_hex_value(c);
    bool good;
    switch ((enum state)wire->state) {
    case CHUNK_LF:
        if (c != '\n')
            return malformed(wire, "a chunk's size does not end with CR LF");
        wire->head = wire->fields = 0;
        return go(wire, wire->left ? CHUNK_DATA : TRAILER_FIRST);
    case DATA_CR:
        return c == '\r' ? go(wire, DATA_LF)
                         : malformed(wire, "a chunk is longer than its size says");
    case DATA_LF:
        return c == '\n' ? go(wire, CHUNK_FIRST)
                         : malformed(wire, "a chunk does not end with CR LF");
    default:
        break;
    }
    if (first)
        wire->left = wire->line = 0;
    if (wire->state > CHUNK_SIZE) {
        good = extension_byte(wire, c);
    } else if (digit >= 0 && wire->left >> 59) {
        good = refuse_bytes(wire, API_TOO_LARGE, "a chunk of the body is too large");
    } else if (digit >= 0) {
        wire->left = wire->left << 4 | (unsigned)digit;
        good = go(wire, CHUNK_SIZE);
    } else if (!first && (c == '\r' || c == ';')) {
        good = go(wire, c == ';' ? EXTENSION_FIRST : CHUNK_LF);
    } else {
        good = malformed(wire, "a chunk's size is not a hexadecimal number");
    }
    if (good && ++wire->line > WIRE_CHUNK_LINE_BYTES)
        return refuse_bytes(wire, API_TOO_LARGE, "a chunk's size and extension are too long");
    return good;
}

/* ------------------------------------------------------------------ from byte to byte */

void wire_init(struct wire *wire) {
    memset(wire, 0, sizeof *wire);
}

/* Bytes that leave the state as it is are skipped together: in targets and values of which nothing
 * is kept, and in bodies. */
size_t wire_check(struct wire *wire, const char *bytes, size_t length, size_t *begun) {
    size_t at = 0, start = 0;
    while (wire->problem == API_OK && at < length) {
        const bool target = wire->state == TARGET;
        const size_t before = at;
        if (wire->state == START)
            start = at;
        if (wire->state == BODY || wire->state == CHUNK_DATA) {
            size_t count = wire->left < length - at ? (size_t)wire->left : length - at;
            at += count;
            wire->left -= count;
            if (wire->left == 0 && wire->state == BODY)
                complete_message(wire);
            else if (wire->left == 0)
                go(wire, DATA_CR);
        } else if (target || (wire->state == FIELD_VALUE && wire->field == OTHER)) {
            const uint32_t *bits = target ? target_set : value_set;
            size_t most = before + WIRE_HEAD_BYTES - wire->head;
            while (at < length && at < most && in_set(bits, (unsigned char)bytes[at]))
                at++;
            wire->head += (uint32_t)(at - before);
        }
        if (at > before)
            continue;
        const bool line = wire->state < FIELD_FIRST, trailers = wire->state >= TRAILER_FIRST;
        const unsigned char c = (unsigned char)bytes[at];
        if (wire->state >= BODY)
            at += chunk_byte(wire, c);
        else if (wire->state <= EMPTY_LF ||
                 wire->head++ < (trailers ? WIRE_TRAILER_BYTES : WIRE_HEAD_BYTES))
            at += line ? line_byte(wire, c) : field_byte(wire, c);
        else
            refuse_bytes(wire, line ? API_TARGET_TOO_LONG : API_HEADERS_TOO_LARGE,
                         line       ? "the request line is too long"
                         : trailers ? "the trailers are too long"
                                    : "the headers are too long");
    }
    if (begun)
        *begun = start;
    return at;
}

bool wire_between(const struct wire *wire) {
    return wire->state == START;
}
