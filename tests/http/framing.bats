# SPDX-License-Identifier: MIT
# Bytes on the socket that no HTTP library would send.
load helper

setup_file() { start_shared_daemon --max-body 1M; }
teardown_file() { end_file; }

teardown() {
    call GET /healthz
    expect 200
}

POST='POST /v1/drapes HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n'

# raw FORMAT: printf's format as it goes to the socket; the answer, until the connection closes,
# becomes headers, body and status.
raw() {
    local line method path
    # shellcheck disable=SC2059
    line=$(printf "$1" | tr -d '\0' | head -1)
    read -r method path _ <<<"$line"
    [[ "$line" =~ ^[A-Z]+\ /[^\ ]*\ HTTP ]] || method='?' path='?'
    keep_answer "$method" "$path raw"
    exec 5<>"/dev/tcp/127.0.0.1/$PORT"
    # shellcheck disable=SC2059
    printf "$1" >&5
    timeout "${2:-10}" cat <&5 >"$BATS_TEST_TMPDIR/answer" || true
    exec 5>&- 5<&-
    split_answer
}

split_answer() {
    sed '/^\r$/q' "$BATS_TEST_TMPDIR/answer" >"$headers"
    sed '1,/^\r$/d' "$BATS_TEST_TMPDIR/answer" >"$body"
    status=$(awk 'NR == 1 {print $2}' "$headers")
}

# Refused, and the connection was closed: what follows on it cannot be taken for a request.
refused() {
    raw "$@"
    expect_problem "${wanted:-400}" "${slug:-bad-request}"
    [ "$(header Connection)" = close ]
}

@test "http: two ways to tell the length of a body are refused" {
    refused "${POST}Content-Length: 2\r\nContent-Length: 2\r\n\r\n{}"
    refused "${POST}Content-Length: 2\r\nContent-Length: 3\r\n\r\n{}"
    refused "${POST}Content-Length: 2, 2\r\n\r\n{}"
    refused "${POST}Content-Length: 2\r\nTransfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n"
    refused "${POST}Transfer-Encoding: chunked\r\nContent-Length: 2\r\n\r\n2\r\n{}\r\n0\r\n\r\n"
}

@test "http: a length that is no number is refused" {
    for length in abc -1 +2 0x2 '2 3' '' 1e3; do
        refused "${POST}Content-Length: $length\r\n\r\n{}"
    done
    wanted=413 slug=too-large refused "${POST}Content-Length: 99999999999999999999999\r\n\r\n{}"
    wanted=413 slug=too-large refused "${POST}Content-Length: 999999999999\r\n\r\n{}"
}

@test "http: transfer codings other than chunked are refused" {
    for coding in gzip 'gzip, chunked' 'chunked, gzip' identity 'chunked, chunked' xchunked; do
        refused "${POST}Transfer-Encoding: $coding\r\n\r\n2\r\n{}\r\n0\r\n\r\n"
    done
    refused "${POST}Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"
    refused "POST /v1/drapes HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"
}

@test "http: malformed chunks are refused, well-formed ones read" {
    CHUNKED="${POST}Connection: close\r\nTransfer-Encoding: chunked\r\n\r\n"
    refused "${CHUNKED}zz\r\n{}\r\n0\r\n\r\n"
    refused "${CHUNKED}-1\r\n{}\r\n0\r\n\r\n"
    refused "${CHUNKED}2\r\n{}XX\r\n0\r\n\r\n"
    wanted=413 slug=too-large refused "${CHUNKED}fffffffffffffffffff\r\n{}\r\n0\r\n\r\n"
    raw "${CHUNKED}1\r\n{\r\n1;note=x\r\n}\r\n0\r\n\r\n"
    expect_problem 422 invalid-request
}

@test "http: one Host, no more and no less" {
    refused 'GET /healthz HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n\r\n'
    refused 'GET /healthz HTTP/1.1\r\nHost: localhost\r\nHost: b\r\n\r\n'
    refused 'GET /healthz HTTP/1.1\r\n\r\n'
    raw 'GET /healthz HTTP/1.0\r\n\r\n'
    expect 200
}

@test "http: a zero byte, a control character or a stray percent in the path is refused" {
    for path in '/v1/drapes/%%00' '/%%00' '/v1/drapes/a\0b' '/v1/drapes?limit=1%%00' \
        '/v1/drapes/%%zz' '/v1/drapes/%%' '/v1/drapes/%%1' '/v1/drapes/a b' '/v1/ drapes' \
        '/v1/drapes/\x01' 'v1/drapes'; do
        refused "GET $path HTTP/1.1\r\nHost: localhost\r\n\r\n"
    done
    refused 'CONNECT a:80 HTTP/1.1\r\nHost: localhost\r\n\r\n'
}

@test "http: malformed lines are refused" {
    refused 'GET /healthz HTTP/1.1\r\nHost: localhost\r\nnocolon\r\n\r\n'
    refused 'GET /healthz HTTP/1.1\r\nHost: localhost\r\nContent-Length : 0\r\n\r\n'
    refused 'GET /healthz HTTP/1.1\r\nHost: localhost\r\nX Y: 0\r\n\r\n'
    refused 'GET /healthz HTTP/1.1\r\n Host: localhost\r\n\r\n'
    refused 'GET /healthz HTTX/1.1\r\nHost: localhost\r\n\r\n'
    refused 'GET /healthz\r\n\r\n'
    refused 'G@T /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n'
    wanted=505 slug=http-version-not-supported refused 'GET /healthz HTTP/9.9\r\nHost: localhost\r\n\r\n'
    wanted=505 slug=http-version-not-supported refused 'PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n'
}

@test "http: what is no HTTP at all is closed" {
    raw '\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n'
    raw 'HELLO\r\n\r\n'
    raw '\r\n\r\n\r\nGET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n'
    expect 200
}

@test "http: heads that are too large are refused" {
    long=$(printf 'a%.0s' {1..60000})
    wanted=431 slug=headers-too-large refused "GET / HTTP/1.1\r\nHost: localhost\r\nX: $long\r\n\r\n"
    wanted=431 slug=headers-too-large \
        refused "GET / HTTP/1.1\r\nHost: localhost\r\nX: ${long:0:34000}\r\n\r\n"
    wanted=414 slug=target-too-long refused "GET /?$long HTTP/1.1\r\nHost: localhost\r\n\r\n"
    wanted=414 slug=target-too-long refused "GET /?${long:0:34000} HTTP/1.1\r\nHost: localhost\r\n\r\n"
    wanted=431 slug=headers-too-large \
        refused "GET / HTTP/1.1\r\nHost: localhost\r\n$(printf 'X: a\\r\\n%.0s' {1..5000})\r\n"
    raw "GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nX: ${long:0:31000}\r\n\r\n"
    expect 200
}

@test "http: too many headers or query parameters are refused" {
    wanted=431 slug=headers-too-large \
        refused "GET / HTTP/1.1\r\nHost: localhost\r\n$(printf 'X: a\\r\\n%.0s' {1..200})\r\n"
    refused "GET /?$(printf 'a&%.0s' {1..300}) HTTP/1.1\r\nHost: localhost\r\n\r\n"
    # More than the library has memory for.
    wanted=431 slug=headers-too-large \
        refused "GET /?$(printf 'a&%.0s' {1..8000}) HTTP/1.1\r\nHost: localhost\r\n\r\n"
}

@test "http: a good request before a bad one on the same connection is answered" {
    raw 'GET /version HTTP/1.1\r\nHost: localhost\r\n\r\nGET / HTTP/1.1\r\nHost: localhost\r\nnocolon\r\n\r\n'
    [ "$(grep -o 'HTTP/1.1 200' "$BATS_TEST_TMPDIR/answer" | wc -l)" = 1 ]
    [ "$(grep -o 'HTTP/1.1 400' "$BATS_TEST_TMPDIR/answer" | wc -l)" = 1 ]
}

@test "http: requests in a row on one connection are answered in order" {
    raw "$(printf 'GET /version HTTP/1.1\\r\\nHost: localhost\\r\\n\\r\\n%.0s' {1..20})"'GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n'
    [ "$(grep -o 'HTTP/1.1 200' "$BATS_TEST_TMPDIR/answer" | wc -l)" = 21 ]
}

@test "http: a body without end is cut off at the limit" {
    body=$BATS_TEST_TMPDIR/body headers=$BATS_TEST_TMPDIR/headers
    exec 5<>"/dev/tcp/127.0.0.1/$PORT"
    # shellcheck disable=SC2059
    {
        printf "${POST}Transfer-Encoding: chunked\r\n\r\n"
        for _ in {1..600}; do printf '1000\r\n%4096s\r\n' ' '; done
    } >&5 2>/dev/null || true
    timeout 10 cat <&5 >"$BATS_TEST_TMPDIR/answer" || true
    exec 5>&- 5<&-
    split_answer
    expect_problem 413 too-large
}

# drip SECONDS FORMAT NAME [DRIP]: sends that, and then DRIP (a blank) once a second.
drip() {
    body=$BATS_TEST_TMPDIR/$3 headers=$BATS_TEST_TMPDIR/$3.headers
    exec 5<>"/dev/tcp/127.0.0.1/$PORT"
    # shellcheck disable=SC2059
    printf "$2" >&5
    timeout $(($1 + 2)) cat <&5 >"$BATS_TEST_TMPDIR/$3.answer" &
    local reader=$! end=$((SECONDS + $1))
    while kill -0 $reader 2>/dev/null && [ "$SECONDS" -lt "$end" ]; do
        sleep 1
        # shellcheck disable=SC2059
        printf "${4- }" >&5 2>/dev/null || break
    done
    wait $reader || true
    grep -q '^HTTP/1.1 408' "$BATS_TEST_TMPDIR/$3.answer"
    grep -q '"type":"/problems/request-timeout"' "$BATS_TEST_TMPDIR/$3.answer"
}

@test "http: headers and bodies that come a byte a second are 408, and others are served" {
    drip 20 'GET / HTTP/1.1\r\nHost: localhost\r\nX: ' head &
    head=$!
    drip 22 "${POST}Content-Length: 1000\r\n\r\n" body &
    slow=$!
    drip 20 '' nothing '\r\n' &
    nothing=$!
    for _ in {1..20}; do
        call GET /version
        expect 200
    done
    wait $head
    wait $slow
    wait $nothing
}

@test "http: two hundred connections that say nothing leave room for others" {
    for descriptor in {100..299}; do
        eval "exec $descriptor<>/dev/tcp/127.0.0.1/$PORT"
    done
    call GET /version
    expect 200
    for descriptor in {100..299}; do
        eval "exec $descriptor>&-"
    done
}
