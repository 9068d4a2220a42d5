/* SPDX-License-Identifier: MIT */
/* The front with a handler of the test, over sockets: what is refused from the head, bodies at
 * their limits, streams, calls that wait and calls that take long, what each owner may have, and
 * the end. */
#include "server/clock.h"
#include "server/config.h"
#include "server/http/client.h"
#include "server/log.h"
#include "tests/check.h"
#include <arpa/inet.h>
#include <dirent.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

enum {
    BODY_MAX = 5000,
    SMALL_MAX = 10,
    LARGE_MAX = 2000000,
    BODIES_MAX = 800000,
    OWNER_BODIES = 100000,
    OWNER_CONNECTIONS = 4,
    ANSWER_MAX = 1 << 21,
    PIECE = 50000,
    LONG_WAIT_MS = 300,
    PATIENCE_MS = 10000
};

#define COUNT(table) (sizeof(table) / sizeof *(table))

static struct config config;
static struct http *front;
static struct job_events *events;
static atomic_int counted, last_status, released, waiting, early;

/* ------------------------------------------------------------------ the handler */

static char letter(size_t k) {
    return "abcdefghijklmnopqrstuvw"[(k + k / 1000) % 23];
}

/* A document of letters; `wait` and `slow` say what happens before each piece. */
struct letters {
    size_t length, made, breaks_at;
    bool wait, waited, slow;
    struct request *request;
};

static ssize_t next_letters(void *context, char *buffer, size_t size) {
    struct letters *letters = context;
    size_t left = letters->length - letters->made, part = left < size ? left : size;
    part = part < PIECE ? part : PIECE;
    if (part == 0)
        return REPLY_END;
    if (letters->made >= letters->breaks_at)
        return REPLY_BROKEN;
    letters->waited = letters->wait && !letters->waited;
    if (letters->waited) {
        letters->request->wake_at = clock_ms() + 5;
        return REPLY_WAIT;
    }
    if (letters->slow)
        usleep(2 * SLOW_CALLS_SLOW_US);
    for (size_t k = 0; k < part; k++)
        buffer[k] = letter(letters->made + k);
    letters->made += part;
    return (ssize_t)part;
}

/* /letters?length=N and any of known, wait, slow, breaks. */
static void answer_letters(struct request *request, struct reply *reply) {
    struct letters *letters = calloc(1, sizeof *letters);
    const char *breaks = request_query(request, "breaks");
    assert_non_null(letters);
    letters->length = strtoul(request_query(request, "length"), NULL, 10);
    letters->breaks_at = breaks ? strtoul(breaks, NULL, 10) : SIZE_MAX;
    letters->wait = request_query(request, "wait") != NULL;
    letters->slow = request_query(request, "slow") != NULL;
    letters->request = request;
    reply_stream(reply, 200, "text/plain", (struct reply_stream){next_letters, free, letters, 0},
                 request_query(request, "known") ? letters->length : 0);
}

static bool has_path(const struct request *request, const char *path) {
    return request->segment_count == 1 && !strcmp(request->segments[0], path);
}

static bool check_head(void *context, struct request *request, struct reply *reply) {
    (void)context;
    request->quiet = has_path(request, "probe");
    if (has_path(request, "small"))
        request->limit = (struct request_limit){SMALL_MAX, "max-small"};
    if (has_path(request, "large"))
        request->limit = (struct request_limit){LARGE_MAX, "max-large"};
    if (has_path(request, "none"))
        reply_refuse(reply, API_NOT_FOUND, "there is none");
    return reply->status != 0;
}

/* Answers the first time it is called, or waits until it may. */
static enum http_next handle(void *context, struct request *request, struct reply *reply) {
    char *text = NULL, name[17] = "";
    (void)context;
    if (has_path(request, "letters")) {
        answer_letters(request, reply);
        return HTTP_DONE;
    }
    if (has_path(request, "stream") && !http_take_stream(request, reply))
        return HTTP_DONE;
    atomic_fetch_add(&early, request->woken_us > clock_us());
    const bool long_wait = has_path(request, "wait-long");
    if ((has_path(request, "wait") || long_wait) && !request->state) {
        request->state = calloc(1, 1);
        request->wake_at = clock_ms() + (long_wait ? LONG_WAIT_MS : 30);
        atomic_fetch_add(&waiting, long_wait);
        return HTTP_WAIT;
    }
    if (has_path(request, "watch") || has_path(request, "stream")) {
        http_watch(request, "a job", JOB_CHANGED);
        request->wake_at = INT64_MAX;
        if (!atomic_load(&released) && !request->stopping) {
            atomic_fetch_add(&waiting, 1);
            return HTTP_WAIT;
        }
    }
    if (has_path(request, "sleep"))
        usleep(2 * SLOW_CALLS_SLOW_US);
    prctl(PR_GET_NAME, name);
    if (has_path(request, "owner"))
        text = strdup(request->owner);
    else if (request->body)
        text = strndup(request->body, request->body_length);
    else if (asprintf(&text, "%s%s%s", strstr(name, "MHD") ? "at once" : "by another",
                      request->stopping ? ", stopping" : "",
                      request->draining ? ", draining" : "") < 0)
        text = NULL;
    reply_text(reply, 200, "text/plain", text);
    return HTTP_DONE;
}

static void count(void *context, const struct request *request, int status, int64_t us) {
    (void)context, (void)request;
    assert_true(us >= 0);
    atomic_store(&last_status, status);
    atomic_fetch_add(&counted, 1);
}

/* ------------------------------------------------------------------ the client */

/* A connection from that address of loopback. */
static int dial(const char *from) {
    struct sockaddr_in own = {.sin_family = AF_INET};
    struct sockaddr_in to = {.sin_family = AF_INET,
                             .sin_addr.s_addr = htonl(INADDR_LOOPBACK),
                             .sin_port = htons(http_port(front))};
    const struct timeval patience = {PATIENCE_MS / 1000, 0};
    int file = socket(AF_INET, SOCK_STREAM, 0);
    assert_true(file >= 0);
    assert_int_equal(inet_pton(AF_INET, from, &own.sin_addr), 1);
    assert_int_equal(bind(file, (struct sockaddr *)&own, sizeof own), 0);
    assert_int_equal(setsockopt(file, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience), 0);
    assert_int_equal(connect(file, (struct sockaddr *)&to, sizeof to), 0);
    return file;
}

/* False when the other end has closed. */
static bool say(int file, const char *text, size_t length) {
    while (length > 0) {
        ssize_t sent = send(file, text, length, MSG_NOSIGNAL);
        if (sent <= 0)
            return false;
        text += sent;
        length -= (size_t)sent;
    }
    return true;
}

static char answer[ANSWER_MAX];

/* One answer with its length, or what comes until the connection ends; in `answer`, whose status it
 * returns; 0 without one. */
static int hear(int file) {
    size_t length = 0, wanted = ANSWER_MAX - 1;
    ssize_t got = 1;
    bool head = true;
    for (; length < wanted && got > 0; length += got > 0 ? (size_t)got : 0) {
        got = read(file, answer + length, head ? 1 : wanted - length);
        answer[length + (got > 0 ? (size_t)got : 0)] = '\0';
        if (!head || length < 3 || strcmp(answer + length - 3, "\r\n\r\n") != 0)
            continue;
        const char *said = strstr(answer, "Content-Length: ");
        if (said)
            wanted = length + 1 + strtoul(said + 16, NULL, 10);
        head = false;
    }
    return strncmp(answer, "HTTP/1.1 ", 9) ? 0 : atoi(answer + 9);
}

static const char *body_of_answer(void) {
    const char *body = strstr(answer, "\r\n\r\n");
    return body ? body + 4 : "";
}

/* Until an owner holds that much. */
static void wait_for_quota(const char *owner, enum quotas_kind kind, int64_t amount) {
    for (int k = 0; k < PATIENCE_MS && quotas_of(front->quotas, owner, kind) != amount; k++)
        usleep(1000);
    assert_int_equal(quotas_of(front->quotas, owner, kind), amount);
}

/* Closes a connection and waits until it no longer counts as one of its owner's, who had so many
 * without it. */
static void hang_up(int file, const char *owner, int64_t others) {
    close(file);
    for (int k = 0; k < PATIENCE_MS && quotas_of(front->quotas, owner, QUOTAS_CONNECTIONS) > others;
         k++)
        usleep(1000);
}

/* Asks that alone, from that address, on a connection of its own. */
static int ask_from(const char *from, const char *text) {
    char owner[REQUEST_CALLER_SIZE];
    snprintf(owner, sizeof owner, "@%s", from);
    int64_t others = quotas_of(front->quotas, owner, QUOTAS_CONNECTIONS);
    int file = dial(from);
    (void)say(file, text, strlen(text));
    int status = hear(file);
    hang_up(file, owner, others);
    return status;
}

static int ask(const char *text) {
    return ask_from("127.0.0.1", text);
}

/* Until so many calls more have been told to wait. */
static void hold(int calls) {
    for (int k = 0; k < PATIENCE_MS && atomic_load(&waiting) < calls; k++)
        usleep(1000);
    check_at_least(atomic_exchange(&waiting, 0), calls);
}

static int get(const char *target) {
    char text[200];
    snprintf(text, sizeof text, "GET %s HTTP/1.1\r\nHost: a\r\n\r\n", target);
    return ask(text);
}

/* A POST with a body of `length` letters, in one piece or as chunks. */
static int post(const char *target, size_t length, bool chunked, const char *more) {
    char head[300], *body = malloc(length + 1);
    int64_t others = quotas_of(front->quotas, "@127.0.0.1", QUOTAS_CONNECTIONS);
    int file = dial("127.0.0.1");
    assert_non_null(body);
    for (size_t k = 0; k < length; k++)
        body[k] = letter(k);
    int size = chunked ? snprintf(head, sizeof head,
                                  "POST %s HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n"
                                  "%s\r\n%zx\r\n",
                                  target, more, length)
                       : snprintf(head, sizeof head,
                                  "POST %s HTTP/1.1\r\nHost: a\r\nContent-Length: %zu\r\n%s\r\n",
                                  target, length, more);
    (void)!(say(file, head, (size_t)size) && say(file, body, length) &&
            say(file, "\r\n0\r\n\r\n", chunked ? 7 : 0));
    int status = hear(file);
    assert_true(status != 200 || !strncmp(body_of_answer(), body, length));
    hang_up(file, "@127.0.0.1", others);
    free(body);
    return status;
}

static int start_front(void **state) {
    static struct http_settings settings = {.config = &config,
                                            .handler = {NULL, check_head, handle, count}};
    struct sockaddr_in *own = (struct sockaddr_in *)&config.address;
    (void)state;
    log_init(LOG_LEVEL_ERROR);
    config = (struct config){.inherited = -1,
                             .listen = "127.0.0.1:0",
                             .address_length = sizeof *own,
                             .max_connections = 32,
                             .owner_connections = OWNER_CONNECTIONS,
                             .owner_streams = 2,
                             .max_body = BODY_MAX,
                             .max_bodies = BODIES_MAX,
                             .owner_bodies = OWNER_BODIES,
                             .trusted_proxy = "127.0.0.9",
                             .public_name = "",
                             .cors_origin = ""};
    *own = (struct sockaddr_in){.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    settings.events = events = job_events_new();
    return events && http_start(&settings, &front) ? 0 : -1;
}

static int stop_front(void **state) {
    (void)state;
    http_stop(front);
    http_stop(NULL);
    job_events_free(events);
    return 0;
}

/* ------------------------------------------------------------------ heads */

static void test_front_answers(void **state) {
    static const struct {
        const char *request;
        int status;
        const char *said; /* somewhere in the answer */
    } rows[] = {
        {"GET /echo HTTP/1.1\r\nHost: a\r\n\r\n", 200, "\r\nContent-Type: text/plain\r\n"},
        {"GET /echo HTTP/1.1\r\nHost: a\r\nX-Request-Id: mine\r\n\r\n", 200,
         "X-Request-Id: mine\r\n"},
        {"GET /echo HTTP/1.1\r\nHost: a\r\n\r\n", 200, "X-Content-Type-Options: nosniff\r\n"},
        {"POST /echo HTTP/1.1\r\nHost: a\r\nContent-Length: 5\r\n\r\nhello", 200, "\r\n\r\nhello"},
        {"POST /echo HTTP/1.1\r\nHost: a\r\nContent-Length: 5\r\nContent-Encoding: Identity\r\n"
         "\r\nhello",
         200, "\r\n\r\nhello"},
        {"POST /echo HTTP/1.1\r\nHost: a\r\nContent-Length: 5\r\nContent-Encoding: gzip\r\n\r\n"
         "hello",
         415, "Accept-Encoding: identity\r\n"},
        {"GET /echo HTTP/1.1\r\nHost: a\r\nContent-Encoding: gzip\r\n\r\n", 200, "text/plain"},
        {"GET /none HTTP/1.1\r\nHost: a\r\n\r\n", 404, "there is none"},
        {"POST /none HTTP/1.1\r\nHost: a\r\nContent-Length: 5\r\n\r\nhello", 404, "there is none"},
        {"POST /none HTTP/1.1\r\nHost: a\r\nContent-Length: 5\r\nExpect: 100-continue\r\n\r\n", 404,
         "there is none"}, /* without its body */
        {"GET /%zz HTTP/1.1\r\nHost: a\r\n\r\n", 400, "a % that does not begin an escape"},
        {"GET / HTTP/1.1\r\nHost: a\r\nRange: a\r\nRange: b\r\n\r\n", 400, "more than one Range"},
        {"POST /small HTTP/1.1\r\nHost: a\r\nContent-Length: 11\r\n\r\n", 413,
         "over the limit of 10 bytes (--max-small)"}, /* without its body */
        {"GET /owner HTTP/1.1\r\nHost: a\r\n\r\n", 200, "\r\n\r\n@127.0.0.1"},
        {"GET /owner HTTP/1.1\r\nHost: a\r\nX-Forwarded-For: 192.0.2.7\r\n\r\n", 200,
         "\r\n\r\n@127.0.0.1"},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        int before = atomic_load(&counted);
        int status = ask(rows[k].request);
        if (status != rows[k].status || !strstr(answer, rows[k].said))
            fail_msg("%s: %s", rows[k].request, answer);
        for (int n = 0; n < PATIENCE_MS && atomic_load(&counted) == before; n++)
            usleep(1000);
        assert_int_equal(atomic_load(&last_status), status);
    }
    assert_int_equal(ask_from("127.0.0.9", "GET /owner HTTP/1.1\r\nHost: a\r\n"
                                           "X-Forwarded-For: 192.0.2.7\r\n\r\n"),
                     200);
    assert_string_equal(body_of_answer(), "@192.0.2.7");
}

/* What the check of the wire refuses, and what the library would answer with a page. */
static void test_front_refuses_what_is_malformed(void **state) {
    static char long_target[40000] = "GET /", long_headers[60000] = "GET / HTTP/1.1\r\nHost: a\r\n";
    static const struct {
        const char *request;
        int status;
    } rows[] = {
        {"GET / HTTP/2.0\r\nHost: a\r\n\r\n", 505},
        {"GET /\r\n\r\n", 400},
        {" / HTTP/1.1\r\n\r\n", 400},
        {"GET / HTTP/1.1\r\n\r\n", 400}, /* no Host */
        {"GET / HTTP/1.1\r\nHost: a\r\n b\r\n\r\n", 400},
        {"POST / HTTP/1.1\r\nHost: a\r\nContent-Length: x\r\n\r\n", 400},
        {"POST / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\nx\r\n", 400},
        {long_target, 414},
        {long_headers, 431},
    };
    (void)state;
    memset(long_target + 5, 'a', sizeof long_target - 6);
    for (size_t at = strlen(long_headers); at < sizeof long_headers - 600; at += 510)
        snprintf(long_headers + at, 511, "X: %0505d\r\n", 0);
    for (size_t k = 0; k < COUNT(rows); k++) {
        int before = atomic_load(&counted), status = ask(rows[k].request);
        for (int n = 0; n < PATIENCE_MS && atomic_load(&counted) == before; n++)
            usleep(1000);
        assert_int_equal(atomic_load(&counted), before + 1);
        if (status != rows[k].status || !strstr(answer, "application/problem+json") ||
            !strstr(answer, "Connection: close\r\n"))
            fail_msg("%.60s: %s", rows[k].request, answer);
    }
}

/* One after the other on a connection; the ones before a malformed one are answered. */
static void test_front_keeps_connections(void **state) {
    static const char two[] = "POST /echo HTTP/1.1\r\nHost: a\r\nContent-Length: 3\r\n\r\none"
                              "POST /echo HTTP/1.1\r\nHost: a\r\nContent-Length: 3\r\n\r\ntwo";
    static const char good_and_bad[] =
        "POST /echo HTTP/1.1\r\nHost: a\r\nContent-Length: 3\r\n\r\none GET / HTTP/1.1\r\n\r\n";
    int file = dial("127.0.0.1");
    (void)state;
    for (int k = 0; k < 3; k++) {
        assert_true(say(file, two, sizeof two - 1));
        assert_int_equal(hear(file), 200);
        assert_string_equal(body_of_answer(), "one");
        assert_int_equal(hear(file), 200);
        assert_string_equal(body_of_answer(), "two");
        assert_null(strstr(answer, "Connection: close"));
    }
    assert_true(say(file, good_and_bad, sizeof good_and_bad - 1));
    assert_int_equal(hear(file), 200);
    assert_string_equal(body_of_answer(), "one");
    assert_int_equal(hear(file), 400);
    assert_int_equal(read(file, answer, 1), 0);
    close(file);
}

/* ------------------------------------------------------------------ bodies */

static void test_front_takes_bodies_up_to_their_limit(void **state) {
    static const char go_on[] = "Expect: 100-continue\r\n";
    (void)state;
    for (int chunked = 0; chunked < 2; chunked++) {
        assert_int_equal(post("/small", SMALL_MAX, chunked, ""), 200);
        assert_int_equal(post("/small", SMALL_MAX + 1, chunked, ""), 413);
        assert_non_null(strstr(answer, "--max-small"));
        assert_int_equal(post("/echo", BODY_MAX, chunked, ""), 200);
        assert_int_equal(post("/echo", BODY_MAX + 1, chunked, ""), 413);
        assert_non_null(strstr(answer, "--max-body"));
        assert_int_equal(post("/large", OWNER_BODIES, chunked, ""), 200);
        /* the only body may have more than the owner's share */
        assert_int_equal(post("/large", BODIES_MAX, chunked, ""), 200);
        assert_int_equal(post("/large", BODIES_MAX + 1, chunked, ""), 503);
        assert_non_null(strstr(answer, "--max-bodies"));
        assert_non_null(strstr(answer, "Retry-After: 1\r\n"));
    }
    assert_int_equal(post("/small", SMALL_MAX + 1, false, go_on), 413);
    assert_int_equal(post("/large", BODIES_MAX, false, ""), 200); /* all was given back */
}

/* Two bodies of one owner: the second finds no more than its bound leaves; another owner does. */
static void test_front_shares_room_for_bodies(void **state) {
    static char piece[80000];
    char head[200];
    int files[2] = {dial("127.0.0.1"), dial("127.0.0.1")}, other = dial("127.0.0.2");
    (void)state;
    memset(piece, 'x', sizeof piece);
    int length = snprintf(head, sizeof head,
                          "POST /large HTTP/1.1\r\nHost: a\r\nContent-Length: %zu\r\n\r\n",
                          sizeof piece + 1);
    assert_true(say(files[0], head, (size_t)length) && say(files[0], piece, sizeof piece));
    wait_for_quota("@127.0.0.1", QUOTAS_BODIES, sizeof piece);
    assert_true(say(files[1], head, (size_t)length) && say(files[1], piece, sizeof piece));
    (void)say(files[1], "x", 1);
    assert_int_equal(hear(files[1]), 429);
    assert_non_null(strstr(answer, "as one owner may have: 100000 (--owner-bodies)"));
    assert_true(say(other, head, (size_t)length) && say(other, piece, sizeof piece));
    assert_true(say(other, "x", 1) && say(files[0], "x", 1));
    assert_int_equal(hear(other), 200);
    assert_int_equal(hear(files[0]), 200);
    assert_int_equal(strlen(body_of_answer()), sizeof piece + 1);
    close(files[0]);
    close(files[1]);
    close(other);
}

/* ------------------------------------------------------------------ streams */

/* Joins the chunks of the answer's body; its length; SIZE_MAX when it is cut. */
static size_t join_chunks(char *text) {
    char *out = text, *in = text;
    for (;;) {
        char *end;
        size_t length = strtoul(in, &end, 16);
        if (end == in || end[0] != '\r')
            return SIZE_MAX;
        if (length == 0)
            return (size_t)(out - text);
        memmove(out, end + 2, length);
        out += length;
        in = end + 2 + length + 2;
    }
}

/* Asks for letters, from a daemon to which reads are quick or slow. */
static void expect_letters(size_t length, const char *more) {
    char text[200];
    snprintf(text, sizeof text,
             "GET /letters?length=%zu%s HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n", length,
             more);
    assert_int_equal(ask(text), 200);
    bool known = strstr(more, "known") != NULL;
    assert_int_equal(strstr(answer, "Content-Length: ") != NULL, known);
    assert_int_equal(strstr(answer, "chunked\r\n") != NULL, !known);
    char *body = strstr(answer, "\r\n\r\n") + 4;
    assert_int_equal(known ? strlen(body) : join_chunks(body), length);
    for (size_t k = 0; k < length; k++)
        if (body[k] != letter(k))
            fail_msg("byte %zu of %zu%s is another", k, length, more);
}

static void test_front_sends_streams(void **state) {
    static const size_t lengths[] = {1, 2 * PIECE + 1};
    static const char *const ways[] = {
        "",        "&known=1",        "&wait=1",        "&known=1&wait=1",
        "&slow=1", "&known=1&slow=1", "&wait=1&slow=1", "&known=1&wait=1&slow=1"};
    (void)state;
    for (size_t k = 0; k < COUNT(lengths) * COUNT(ways); k++)
        expect_letters(lengths[k % COUNT(lengths)], ways[k / COUNT(lengths)]);
    for (int k = 0; k < 4; k++) { /* one that cannot be made to its end is cut */
        static const char *const cut[] = {"", "&wait=1", "&slow=1", "&wait=1&slow=1"};
        char text[200];
        snprintf(text, sizeof text,
                 "GET /letters?length=300000&breaks=100000%s HTTP/1.1\r\n"
                 "Host: a\r\nConnection: close\r\n\r\n",
                 cut[k]);
        assert_int_equal(ask(text), 200);
        assert_int_equal(join_chunks(strstr(answer, "\r\n\r\n") + 4), SIZE_MAX);
    }
}

/* ------------------------------------------------------------------ waiting */

static void *ask_for_watch(void *status) {
    int file = dial("127.0.0.1");
    static const char text[] = "GET /watch HTTP/1.1\r\nHost: a\r\n\r\n";
    char said[2000];
    (void)!say(file, text, sizeof text - 1);
    ssize_t got = read(file, said, sizeof said - 1);
    said[got > 0 ? got : 0] = '\0';
    *(int *)status = atoi(said + 9) + (strstr(said, "stopping") ? 1000 : 0) +
                     (strstr(said, "draining") ? 2000 : 0);
    close(file);
    return NULL;
}

/* Answered when its time has come, or when there is news of what it watches; not before. */
static void test_front_has_calls_wait(void **state) {
    pthread_t asking;
    int status = 0;
    (void)state;
    int64_t late = INT64_MAX;
    for (int k = 0; k < 20 && late > 50; k++) { /* another time, if the machine is busy */
        int64_t begun = clock_ms();
        assert_int_equal(get("/wait"), 200);
        late = clock_ms() - begun - 30;
        check_at_least(late, 0);
    }
    check_at_most(late, 50);
    assert_int_equal(atomic_load(&early), 0); /* what it is to look at has been */

    atomic_store(&released, 0);
    assert_int_equal(pthread_create(&asking, NULL, ask_for_watch, &status), 0);
    hold(1);
    job_events_notify(events, "a job", JOB_CHANGED); /* not yet what it waits for */
    hold(1);
    assert_int_equal(status, 0);
    atomic_store(&released, 1);
    for (int k = 0; k < 100; k++) /* while it is being resumed, and after it */
        job_events_notify(events, "a job", JOB_CHANGED);
    pthread_join(asking, NULL);
    assert_int_equal(status, 200);
}

static int64_t processor_us(void) {
    struct timespec time;
    assert_int_equal(clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time), 0);
    return (int64_t)time.tv_sec * 1000000 + time.tv_nsec / 1000;
}

/* One that waits for its time gets it though another is told of news again and again; until then
 * nothing is done. */
static void test_front_wakes_calls_at_their_time(void **state) {
    static const char text[] = "GET /wait-long HTTP/1.1\r\nHost: a\r\n\r\n";
    pthread_t asking;
    int status = 0, file = dial("127.0.0.1");
    (void)state;
    int64_t begun = clock_ms();
    assert_true(say(file, text, sizeof text - 1));
    hold(1);
    atomic_store(&released, 0);
    assert_int_equal(pthread_create(&asking, NULL, ask_for_watch, &status), 0);
    hold(1);
    atomic_store(&released, 1);
    for (int k = 0; k < 100; k++)
        job_events_notify(events, "a job", JOB_CHANGED);
    pthread_join(asking, NULL);
    assert_int_equal(status, 200);
    int64_t idle = clock_ms(), spent = processor_us();
    assert_int_equal(hear(file), 200);
    check_at_least(clock_ms() - begun, LONG_WAIT_MS);
    if (clock_ms() - idle > LONG_WAIT_MS / 2)
        check_below(processor_us() - spent, 100 * (clock_ms() - idle));
    hang_up(file, "@127.0.0.1", 0);
}

/* One that waits is let go within about a second of its client; until then nothing is done. */
static void test_front_lets_go_of_clients_that_are_gone(void **state) {
    static const char text[] = "GET /watch HTTP/1.1\r\nHost: a\r\n\r\n";
    int file = dial("127.0.0.1");
    (void)state;
    atomic_store(&released, 0);
    assert_true(say(file, text, sizeof text - 1));
    hold(1);
    int before = atomic_load(&counted);
    int64_t begun = clock_ms(), spent = processor_us();
    close(file);
    for (int k = 0; k < PATIENCE_MS && atomic_load(&counted) == before; k++)
        usleep(1000);
    assert_int_equal(atomic_load(&counted), before + 1);
    assert_int_equal(atomic_load(&last_status), 0);
    if (clock_ms() - begun > 300)
        check_below(processor_us() - spent, 200 * (clock_ms() - begun));
}

/* Once calls are slow other threads attend to them; probes are answered at once. */
static void test_front_hands_slow_calls_over(void **state) {
    (void)state;
    for (int k = 0; k < 100 && (get("/echo"), !strstr(answer, "at once")); k++)
        continue;
    assert_non_null(strstr(answer, "at once"));
    assert_int_equal(get("/sleep"), 200);
    assert_int_equal(get("/echo"), 200);
    assert_string_equal(body_of_answer(), "by another");
    assert_int_equal(get("/wait"), 200);
    assert_int_equal(get("/probe"), 200);
    assert_string_equal(body_of_answer(), "at once");
    for (int k = 0; k < 100 && (post("/echo", 0, false, ""), !strstr(answer, "at once")); k++)
        continue;
    assert_string_equal(body_of_answer(), "at once"); /* changes are quick */
    assert_int_equal(ask("HEAD /echo HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n"), 200);
}

/* ------------------------------------------------------------------ owners */

static const char probe[] = "GET /probe HTTP/1.1\r\nHost: a\r\n\r\n";
static const char echo[] = "GET /echo HTTP/1.1\r\nHost: a\r\n\r\n";

static void test_front_bounds_the_connections_of_an_owner(void **state) {
    static const char owner[] = "127.0.0.3";
    int files[OWNER_CONNECTIONS];
    (void)state;
    atomic_store(&released, 0);
    config.owner_streams = 10;
    for (int k = 0; k < OWNER_CONNECTIONS; k++) { /* busy ones, which do not give way */
        static const char text[] = "GET /watch HTTP/1.1\r\nHost: a\r\n\r\n";
        files[k] = dial(owner);
        assert_true(say(files[k], text, sizeof text - 1));
    }
    hold(OWNER_CONNECTIONS);
    assert_int_equal(ask_from(owner, echo), 429);
    assert_non_null(strstr(answer, "as one owner may have: 4 (--owner-connections)"));
    assert_non_null(strstr(answer, "Connection: close\r\n"));
    assert_int_equal(ask_from(owner, probe), 200);
    assert_non_null(strstr(answer, "Connection: close\r\n"));
    assert_int_equal(ask_from("127.0.0.4", echo), 200);
    atomic_store(&released, 1);
    job_events_notify(events, "a job", JOB_CHANGED);
    for (int k = 0; k < OWNER_CONNECTIONS; k++) {
        assert_int_equal(hear(files[k]), 200);
        close(files[k]);
    }
}

static void test_front_bounds_the_streams_of_an_owner(void **state) {
    static const char text[] = "GET /stream HTTP/1.1\r\nHost: a\r\n\r\n";
    int files[2] = {dial("127.0.0.5"), dial("127.0.0.5")};
    (void)state;
    atomic_store(&released, 0);
    config.owner_streams = 2;
    for (int k = 0; k < 2; k++)
        assert_true(say(files[k], text, sizeof text - 1));
    hold(2);
    assert_int_equal(ask_from("127.0.0.5", text), 429);
    assert_non_null(strstr(answer, "as one owner may have: 2 (--owner-streams)"));
    assert_non_null(strstr(answer, "Retry-After: 1\r\n"));
    atomic_store(&released, 1);
    assert_int_equal(ask_from("127.0.0.6", text), 200);
    job_events_notify(events, "a job", JOB_CHANGED);
    for (int k = 0; k < 2; k++) {
        assert_int_equal(hear(files[k]), 200);
        close(files[k]);
    }
    wait_for_quota("@127.0.0.5", QUOTAS_STREAMS, 0);
    assert_int_equal(ask_from("127.0.0.5", text), 200); /* both were given back */
}

/* Others have all but a few of what there is for all: an owner gets as much as is left, then is
 * told to come again. */
static void test_front_keeps_places_for_others(void **state) {
    static const char text[] = "GET /stream HTTP/1.1\r\nHost: a\r\n\r\n";
    int file = dial("127.0.0.7");
    (void)state;
    atomic_store(&released, 0);
    config.owner_streams = 10;
    int64_t others = quotas_left(front->quotas, QUOTAS_STREAMS) - 2;
    assert_true(quotas_add(front->quotas, "others", QUOTAS_STREAMS, others));
    assert_true(say(file, text, sizeof text - 1));
    hold(1);
    assert_int_equal(ask_from("127.0.0.7", text), 429);
    assert_non_null(strstr(answer, "(--max-connections): try again later"));
    assert_non_null(strstr(answer, "Retry-After: 1\r\n"));
    quotas_give(front->quotas, "others", QUOTAS_STREAMS, others);
    atomic_store(&released, 1);
    job_events_notify(events, "a job", JOB_CHANGED);
    assert_int_equal(hear(file), 200);
    close(file);
}

/* The peer is kept whole, whichever family it has. */
static void test_front_knows_its_peers(void **state) {
    static const struct {
        int family;
        const char *address, *owner;
    } rows[] = {{AF_INET, "192.0.2.7", "@192.0.2.7"},
                {AF_INET6, "::ffff:192.0.2.7", "@192.0.2.7"},
                {AF_INET6, "2001:db8::7", "@2001:db8::/64"},
                {AF_UNIX, "", "@"}};
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        union {
            struct sockaddr any;
            struct sockaddr_in v4;
            struct sockaddr_in6 v6;
        } peer;
        int ends[2];
        memset(&peer, 0, sizeof peer);
        peer.any.sa_family = (sa_family_t)rows[k].family;
        if (rows[k].family != AF_UNIX)
            assert_int_equal(inet_pton(rows[k].family, rows[k].address,
                                       rows[k].family == AF_INET ? (void *)&peer.v4.sin_addr
                                                                 : (void *)&peer.v6.sin6_addr),
                             1);
        assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
        struct client *client = client_open(front, ends[0], &peer.any);
        assert_non_null(client);
        assert_string_equal(client->admission.owner, rows[k].owner);
        if (rows[k].family != AF_UNIX)
            assert_memory_equal(&client->peer, &peer,
                                rows[k].family == AF_INET ? sizeof peer.v4 : sizeof peer.v6);
        client_close(client);
        close(ends[0]);
        close(ends[1]);
    }
}

/* ------------------------------------------------------------------ the end */

static void *ask_for_letters(void *length) {
    static const char text[] =
        "GET /letters?length=400000&slow=1 HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n";
    int file = dial("127.0.0.8");
    static char said[1 << 19];
    size_t had = 0;
    (void)!say(file, text, sizeof text - 1);
    for (ssize_t got = 1; got > 0; had += got > 0 ? (size_t)got : 0)
        got = read(file, said + had, sizeof said - 1 - had);
    char *body = strstr(said, "\r\n\r\n");
    *(size_t *)length = body ? join_chunks(body + 4) : 0;
    close(file);
    return NULL;
}

/* Of this process. */
static int threads(void) {
    int count = 0;
    DIR *folder = opendir("/proc/self/task");
    assert_non_null(folder);
    for (const struct dirent *each; (each = readdir(folder));)
        count += each->d_name[0] != '.';
    closedir(folder);
    return count;
}

/* Those that wait are answered, what is being sent comes to its end, new ones are refused, and
 * connections end with their answer. */
static void test_front_ends(void **state) {
    pthread_t asking, fetching;
    size_t length = 0;
    int status = 0, kept = dial("127.0.0.1");
    (void)state;
    assert_true(say(kept, echo, sizeof echo - 1));
    assert_int_equal(hear(kept), 200);
    atomic_store(&released, 0);
    assert_int_equal(pthread_create(&asking, NULL, ask_for_watch, &status), 0);
    hold(1);
    assert_int_equal(pthread_create(&fetching, NULL, ask_for_letters, &length), 0);
    for (int k = 0; k < PATIENCE_MS && atomic_load(&front->exchanges) < 2; k++)
        usleep(1000);
    int new = socket(AF_INET, SOCK_STREAM, 0);
    struct sockaddr_in to = {.sin_family = AF_INET,
                             .sin_addr.s_addr = htonl(INADDR_LOOPBACK),
                             .sin_port = htons(http_port(front))};
    http_drain(front);
    assert_int_equal(connect(new, (struct sockaddr *)&to, sizeof to), -1);
    close(new);
    http_drain(front);
    assert_true(say(kept, echo, sizeof echo - 1));
    assert_int_equal(hear(kept), 200);
    assert_non_null(strstr(answer, "Connection: close\r\n"));
    assert_non_null(strstr(answer, "draining"));
    assert_int_equal(read(kept, answer, 1), 0);
    close(kept);
    assert_int_equal(status, 0);
    http_stop(front);
    front = NULL;
    pthread_join(asking, NULL);
    pthread_join(fetching, NULL);
    assert_int_equal(threads(), 1);
    assert_int_equal(length, 400000);
    assert_int_equal(status, 3200);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_front_answers),
        cmocka_unit_test(test_front_refuses_what_is_malformed),
        cmocka_unit_test(test_front_keeps_connections),
        cmocka_unit_test(test_front_takes_bodies_up_to_their_limit),
        cmocka_unit_test(test_front_shares_room_for_bodies),
        cmocka_unit_test(test_front_sends_streams),
        cmocka_unit_test(test_front_has_calls_wait),
        cmocka_unit_test(test_front_wakes_calls_at_their_time),
        cmocka_unit_test(test_front_lets_go_of_clients_that_are_gone),
        cmocka_unit_test(test_front_hands_slow_calls_over),
        cmocka_unit_test(test_front_bounds_the_connections_of_an_owner),
        cmocka_unit_test(test_front_bounds_the_streams_of_an_owner),
        cmocka_unit_test(test_front_keeps_places_for_others),
        cmocka_unit_test(test_front_knows_its_peers),
        cmocka_unit_test(test_front_ends),
    };
    return cmocka_run_group_tests_name("front", tests, start_front, stop_front);
}
