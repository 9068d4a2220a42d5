/* SPDX-License-Identifier: MIT */
/* Answers: headers, bodies, documents that are made while they are sent, parts of them, and what
 * they are compressed to. */
#include "server/http/stream.h"
#include "tests/check.h"
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>
#include <zlib.h>
#include <zstd.h>

#define COUNT(table) (sizeof(table) / sizeof *(table))

/* The value of that header of the reply; NULL without. */
static const char *header_in(const struct reply *reply, const char *name) {
    for (size_t k = 0; k < reply->header_count; k++)
        if (!strcmp(reply->headers[k].name, name))
            return reply->headers[k].value;
    return NULL;
}

static void test_reply_leaves_out_headers_that_would_split(void **state) {
    char value[REPLY_VALUE_SIZE + 2];
    (void)state;
    for (int c = 1; c < 256; c++) {
        struct reply reply = {0};
        reply_header(&reply, "X", "a%cb", c);
        assert_int_equal(reply.header_count, c >= ' ' && c != 0x7f);
    }
    for (int length = REPLY_VALUE_SIZE - 2; length <= REPLY_VALUE_SIZE + 1; length++) {
        struct reply reply = {0};
        snprintf(value, sizeof value, "%0*d", length, 7);
        reply_header(&reply, "X", "%s", value);
        assert_int_equal(reply.header_count, length < REPLY_VALUE_SIZE);
        assert_true(!reply.header_count || !strcmp(reply.headers[0].value, value));
    }
    struct reply reply = {0};
    for (int k = 0; k < REPLY_HEADERS_MAX + 1; k++)
        reply_header(&reply, k < REPLY_HEADERS_MAX ? "X" : "Y", "%d", k);
    assert_int_equal(reply.header_count, REPLY_HEADERS_MAX);
    assert_true(reply_has_header(&reply, "X"));
    assert_false(reply_has_header(&reply, "Y"));
    assert_string_equal(reply.headers[REPLY_HEADERS_MAX - 1].value, "19");
}

static void test_reply_has_one_body(void **state) {
    struct reply reply = {.request_id = "r"};
    (void)state;
    reply_text(&reply, 200, "text/plain", strdup("first"));
    assert_int_equal(reply.length, 5);
    reply_bytes(&reply, 201, NULL, strdup("second"), 3);
    assert_int_equal(reply.status, 201);
    assert_int_equal(reply.length, 3);
    assert_string_equal(reply.body, "second");
    assert_int_equal(reply.header_count, 1);
    reply_empty(&reply, 204);
    assert_null(reply.body);
    assert_int_equal(reply.status, 204);
    reply_literal(&reply, 200, "text/html", "<html>", 6);
    assert_int_equal(reply.length, 6);
    assert_string_equal(reply.literal, "<html>");
    reply_clear(&reply);
    assert_int_equal(reply.status + (int)reply.header_count + (int)reply.length, 0);
    reply_text(&reply, 200, "text/plain", NULL); /* no memory */
    assert_int_equal(reply.status, 500);
    assert_int_equal(reply.length, strlen(reply.literal));
    assert_string_equal(header_in(&reply, "Content-Type"), "application/problem+json");
    reply_clear(&reply);
}

static void test_reply_tells_problems(void **state) {
    struct reply reply = {.request_id = "r-7"};
    (void)state;
    reply_refuse_for(&reply, 42, API_QUOTA, "wait for %s", "it");
    assert_int_equal(reply.status, 429);
    assert_string_equal(header_in(&reply, "Retry-After"), "42");
    assert_non_null(strstr(reply.body, "\"wait for it\""));
    assert_non_null(strstr(reply.body, "r-7"));
    assert_int_equal(reply.length, strlen(reply.body));
    reply_clear(&reply);
    reply.request_id = "r-8";
    reply_no_memory(&reply);
    assert_int_equal(reply.status, 503);
    reply_clear(&reply);
}

static void test_reply_goes_to_a_socket(void **state) {
    int ends[2];
    char text[2000] = "";
    (void)state;
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    assert_int_equal(reply_on_socket(ends[0], "r-9", API_TIMEOUT, "too late"), 408);
    close(ends[0]);
    ssize_t length = read(ends[1], text, sizeof text - 1);
    assert_true(length > 0);
    assert_memory_equal(text, "HTTP/1.1 408 ", 13);
    const char *body = strstr(text, "\r\n\r\n"), *said = strstr(text, "Content-Length: ");
    assert_true(body && said);
    assert_int_equal(strtol(said + 16, NULL, 10), strlen(body + 4));
    assert_non_null(strstr(text, "\r\nX-Request-Id: r-9\r\n"));
    assert_non_null(strstr(text, "\r\nConnection: close\r\n"));
    assert_non_null(strstr(body, "too late"));
    close(ends[1]);
    assert_int_equal(reply_on_socket(-1, "r-9", API_TOO_LARGE, "gone"), 413);
}

/* ------------------------------------------------------------------ documents */

/* One that is made in pieces of up to `piece` bytes, and breaks at `breaks_at` if that is within.
 */
struct document {
    size_t length, piece, breaks_at, made;
    int freed;
};

enum { HEAD = 64 * 1024, BUFFER = 10000, LONGEST = 5 << 20 };

static char letter(size_t k) {
    return "the quick brown fox"[(k * k + k / 19) % 19];
}

static ssize_t make_letters(void *context, char *buffer, size_t size) {
    struct document *document = context;
    size_t left = document->length - document->made;
    size_t part = left < size ? left : size;
    part = part < document->piece ? part : document->piece;
    if (document->made + part > document->breaks_at)
        return -1;
    for (size_t k = 0; k < part; k++)
        buffer[k] = letter(document->made + k);
    document->made += part;
    return (ssize_t)part;
}

static void free_document(void *context) {
    ((struct document *)context)->freed++;
}

/* What the whole body of the reply is, in `bytes`; its length. REPLY_BROKEN ends it, too. */
static size_t fetch(struct reply *reply, char *bytes, int *waits) {
    size_t length = 0;
    ssize_t got = 0;
    *waits = 0;
    if (!reply->streamed) {
        memcpy(bytes, reply->body, reply->length);
        return reply->length;
    }
    while ((got = reply->stream.next(reply->stream.context, bytes + length, BUFFER)) >= 0) {
        length += (size_t)got;
        *waits += got == REPLY_WAIT;
    }
    return length;
}

static char fetched[LONGEST + BUFFER];

struct expectation {
    int status;
    size_t first, length, announced;
    bool streamed;
};

/* Answers with the document and compares what comes. */
static void expect_reply(struct document document, const struct request *request, const char *etag,
                         uint64_t known, struct expectation wanted) {
    const struct stream_source source = {make_letters, free_document, &document, etag, known};
    struct reply reply = {.request_id = ""};
    int waits;
    stream_reply(request, &reply, "text/plain", COMPRESS_IDENTITY, &source);
    assert_int_equal(reply.status, wanted.status);
    assert_int_equal(reply.length, wanted.announced);
    assert_int_equal(reply.streamed, wanted.streamed);
    size_t length = fetch(&reply, fetched, &waits);
    assert_int_equal(length, wanted.length);
    for (size_t k = 0; k < length; k++)
        if (fetched[k] != letter(wanted.first + k))
            fail_msg("byte %zu of %zu is another", k, length);
    reply_clear(&reply);
    assert_int_equal(document.freed, 1);
}

/* With their length when they are short, or when it is known. */
static void test_stream_sends_documents(void **state) {
    static const size_t pieces[] = {1000, HEAD, LONGEST};
    const struct request request = {.method = "GET"};
    (void)state;
    for (size_t k = 0; k < COUNT(pieces); k++)
        for (size_t length = HEAD - 1; length <= HEAD + 1; length++) {
            struct document document = {length, pieces[k], LONGEST, 0, 0};
            bool whole = length < HEAD;
            expect_reply(document, &request, NULL, 0,
                         (struct expectation){200, 0, length, whole ? length : 0, !whole});
            expect_reply(document, &request, NULL, length,
                         (struct expectation){200, 0, length, length, !whole});
        }
    expect_reply((struct document){0, 1, LONGEST, 0, 0}, &request, NULL, 0,
                 (struct expectation){200, 0, 0, 0, false});
}

/* One that was begun with more than the usual: in pieces, but with its length. */
static void test_stream_sends_long_heads_in_pieces(void **state) {
    const struct request request = {.method = "GET"};
    int waits;
    (void)state;
    for (size_t length = HEAD; length <= HEAD + 1; length++) {
        struct document document = {length, 5000, LONGEST, 0, 0};
        const struct stream_source source = {make_letters, free_document, &document, NULL, 0};
        struct reply reply = {.request_id = ""};
        struct stream *stream = stream_begin(&source, 2 * HEAD);
        assert_non_null(stream);
        stream_send(&request, &reply, "text/plain", COMPRESS_IDENTITY, stream);
        assert_int_equal(reply.streamed, length > HEAD);
        assert_int_equal(reply.stream.block, length > HEAD ? HEAD : 0);
        assert_int_equal(reply.length, length);
        assert_int_equal(fetch(&reply, fetched, &waits), length);
        reply_clear(&reply);
        assert_int_equal(document.freed, 1);
    }
    stream_free(NULL);
}

static void test_stream_tells_what_cannot_be_made(void **state) {
    const struct request request = {.method = "GET"};
    struct document document = {1000, 100, 500, 0, 0};
    struct stream_source source = {make_letters, free_document, &document, NULL, 0};
    struct reply reply = {.request_id = ""};
    char buffer[BUFFER];
    ssize_t got = 0;
    (void)state;
    stream_reply(&request, &reply, "text/plain", COMPRESS_IDENTITY, &source);
    assert_int_equal(reply.status, 500);
    assert_int_equal(document.freed, 1);
    reply_clear(&reply);

    static const enum compress_coding codings[] = {COMPRESS_IDENTITY, COMPRESS_ZSTD, COMPRESS_GZIP};
    for (size_t k = 0; k < COUNT(codings); k++) {
        document = (struct document){3 * HEAD, 1000, 2 * HEAD, 0, 0};
        reply = (struct reply){.request_id = ""};
        stream_reply(&request, &reply, "text/plain", codings[k], &source);
        assert_int_equal(reply.status, 200);
        for (int turn = 0; turn < 100 && got >= 0; turn++)
            got = reply.stream.next(reply.stream.context, buffer, sizeof buffer);
        assert_int_equal(got, REPLY_BROKEN);
        got = 0;
        reply_clear(&reply);
        assert_int_equal(document.freed, 1);
    }
}

static void test_stream_sends_parts(void **state) {
    static const struct {
        const char *method, *etag, *range, *if_range;
        struct expectation wanted;
        const char *said; /* Content-Range */
    } rows[] = {
        {"GET", "\"e\"", NULL, NULL, {200, 0, 1000, 1000, false}, NULL},
        {"GET", "\"e\"", "bytes=0-0", NULL, {206, 0, 1, 1, true}, "bytes 0-0/1000"},
        {"GET", "\"e\"", "bytes=10-19", NULL, {206, 10, 10, 10, true}, "bytes 10-19/1000"},
        {"GET", "\"e\"", "bytes=-1", NULL, {206, 999, 1, 1, true}, "bytes 999-999/1000"},
        {"GET", "\"e\"", "bytes=0-", NULL, {206, 0, 1000, 1000, true}, "bytes 0-999/1000"},
        {"GET", "\"e\"", "bytes=1-0", NULL, {200, 0, 1000, 1000, false}, NULL},
        {"GET", "\"e\"", "bytes=10-19", "\"e\"", {206, 10, 10, 10, true}, "bytes 10-19/1000"},
        {"GET", "\"e\"", "bytes=10-19", "\"f\"", {200, 0, 1000, 1000, false}, NULL},
        {"HEAD", "\"e\"", "bytes=10-19", NULL, {200, 0, 1000, 1000, false}, NULL},
        {"GET", NULL, "bytes=10-19", NULL, {200, 0, 1000, 1000, false}, NULL},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        struct request request = {.method = rows[k].method};
        if (rows[k].range)
            request_add_header(&request, "Range", rows[k].range);
        if (rows[k].if_range)
            request_add_header(&request, "If-Range", rows[k].if_range);
        struct document document = {1000, 300, LONGEST, 0, 0};
        struct stream_source source = {make_letters, free_document, &document, rows[k].etag, 0};
        struct reply reply = {.request_id = ""};
        stream_reply(&request, &reply, "text/plain", COMPRESS_IDENTITY, &source);
        const char *said = header_in(&reply, "Content-Range");
        if (!said != !rows[k].said || (said && strcmp(said, rows[k].said) != 0))
            fail_msg("row %zu: Content-Range is %s", k, said);
        assert_int_equal(reply_has_header(&reply, "Accept-Ranges"),
                         rows[k].etag && !strcmp(rows[k].method, "GET"));
        reply_clear(&reply);
        document.made = (size_t)(document.freed = 0);
        expect_reply(document, &request, rows[k].etag, 0, rows[k].wanted);
    }
}

/* Far within a long document: what is before is thrown away, with a pause every 4 MB. */
static void test_stream_skips_to_a_part(void **state) {
    static const struct {
        const char *range;
        size_t first, length;
        int waits;
    } rows[] = {
        {"bytes=4194303-4194310", 4194303, 8, 0},
        {"bytes=4194304-4194400", 4194304, 97, 0},
        {"bytes=4194305-", 4194305, LONGEST - 4194305, 1},
        {"bytes=-20000", LONGEST - 20000, 20000, 1},
        {"bytes=65530-65540", 65530, 11, 0},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        struct request request = {.method = "GET"};
        struct document document = {LONGEST, 1 << 16, SIZE_MAX, 0, 0};
        struct stream_source source = {make_letters, free_document, &document, "\"e\"", LONGEST};
        struct reply reply = {.request_id = ""};
        int waits;
        request_add_header(&request, "Range", rows[k].range);
        stream_reply(&request, &reply, "text/plain", COMPRESS_IDENTITY, &source);
        assert_int_equal(reply.status, 206);
        assert_int_equal(reply.length, rows[k].length);
        assert_int_equal(fetch(&reply, fetched, &waits), rows[k].length);
        assert_int_equal(waits, rows[k].waits);
        for (size_t i = 0; i < rows[k].length; i++)
            if (fetched[i] != letter(rows[k].first + i))
                fail_msg("%s: byte %zu is another", rows[k].range, i);
        reply_clear(&reply);
    }
    struct request request = {.method = "GET"};
    struct document document = {LONGEST, 1 << 16, SIZE_MAX, 0, 0};
    struct stream_source source = {make_letters, free_document, &document, "\"e\"", LONGEST};
    struct reply reply = {.request_id = ""};
    request_add_header(&request, "Range", "bytes=5242880-");
    stream_reply(&request, &reply, "text/plain", COMPRESS_IDENTITY, &source);
    assert_int_equal(reply.status, 416);
    assert_string_equal(header_in(&reply, "Content-Range"), "bytes */5242880");
    assert_int_equal(document.freed, 1);
    reply_clear(&reply);
}

/* Compressed, and back again, by the libraries' own readers; without a length or parts. */
static void test_stream_compresses(void **state) {
    static const size_t lengths[] = {0, 1, 1000, HEAD, 300000};
    struct request request = {.method = "GET"};
    char *back = malloc(LONGEST);
    int waits;
    (void)state;
    assert_non_null(back);
    request_add_header(&request, "Range", "bytes=0-1");
    for (size_t k = 0; k < 2 * COUNT(lengths); k++) {
        bool gzip = k % 2;
        struct document document = {lengths[k / 2], 20000, LONGEST, 0, 0};
        struct stream_source source = {make_letters, free_document, &document, "\"e\"",
                                       document.length};
        struct reply reply = {.request_id = ""};
        stream_reply(&request, &reply, "text/plain", gzip ? COMPRESS_GZIP : COMPRESS_ZSTD, &source);
        assert_int_equal(reply.status, 200);
        assert_int_equal(reply.length, 0);
        assert_string_equal(header_in(&reply, "Content-Encoding"), gzip ? "gzip" : "zstd");
        size_t length = fetch(&reply, fetched, &waits), got;
        assert_int_equal(waits, 0);
        if (gzip) {
            z_stream reader = {.next_in = (Bytef *)fetched,
                               .avail_in = (uInt)length,
                               .next_out = (Bytef *)back,
                               .avail_out = LONGEST};
            assert_int_equal(inflateInit2(&reader, 31), Z_OK);
            assert_int_equal(inflate(&reader, Z_FINISH), Z_STREAM_END);
            assert_int_equal(reader.avail_in, 0);
            got = LONGEST - reader.avail_out;
            inflateEnd(&reader);
        } else {
            got = ZSTD_decompress(back, LONGEST, fetched, length);
        }
        assert_int_equal(got, lengths[k / 2]);
        for (size_t i = 0; i < got; i++)
            assert_int_equal(back[i], letter(i));
        assert_true(got < 1000 || length < got / 2);
        reply_clear(&reply);
        assert_int_equal(document.freed, 1);
    }
    free(back);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reply_leaves_out_headers_that_would_split),
        cmocka_unit_test(test_reply_has_one_body),
        cmocka_unit_test(test_reply_tells_problems),
        cmocka_unit_test(test_reply_goes_to_a_socket),
        cmocka_unit_test(test_stream_sends_documents),
        cmocka_unit_test(test_stream_sends_long_heads_in_pieces),
        cmocka_unit_test(test_stream_tells_what_cannot_be_made),
        cmocka_unit_test(test_stream_sends_parts),
        cmocka_unit_test(test_stream_skips_to_a_part),
        cmocka_unit_test(test_stream_compresses),
    };
    return cmocka_run_group_tests_name("reply", tests, NULL, NULL);
}
