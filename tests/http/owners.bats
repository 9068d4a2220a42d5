# SPDX-License-Identifier: MIT
# What one owner may have of what is there for all, and that others still get theirs. Callers at
# other addresses of loopback are other owners.

load helper
bats_require_minimum_version 1.5.0

teardown_file() { keep_contract; }

teardown() { stop_daemon; }

start() { start_daemon "$BATS_TEST_TMPDIR/daemon" --workers 1 "$@"; }

# as ADDRESS METHOD PATH...: a call from there.
as() { call "$2" "$3" --interface "$1" "${@:4}"; }

# post_as ADDRESS FACTOR [CURL OPTION...]: a drape of a caller there.
post_as() { quick "$2" | post /v1/drapes - --interface "$1" "${@:3}"; }

@test "owners: beyond its share of the queue an owner is 429, another is not" {
    start --queue-limit 10 --owner-queue 2
    stop_workers
    post_as 127.0.0.2 1
    expect 202
    wait_until 10 has_status "$(field .id)" running
    post_as 127.0.0.2 1.01
    post_as 127.0.0.2 1.02
    expect 202
    post_as 127.0.0.2 1.03
    expect_problem 429 quota-exceeded
    [[ $(field .detail) = *--owner-queue* ]]
    [ "$(header Retry-After)" -ge 1 ]
    post_as 127.0.0.3 1.03
    expect 202
    kill -CONT $(workers)
}

@test "owners: however much others queue, whoever comes finds a place" {
    start --queue-limit 12
    for owner in 127.0.0.2 127.0.0.3; do
        for k in {1..14}; do # each takes seconds
            slow "1.$k" | post /v1/drapes - --interface "$owner"
            [ "$status" = 202 ] || break
        done
        expect_problem 429 quota-exceeded
        [[ $(field .detail) = *--*queue* ]]
        [ "$(header Retry-After)" -ge 1 ]
    done
    post_as 127.0.0.5 1
    expect 202
}

@test "owners: beyond its stored bytes an owner is 429, another is not" {
    start --owner-bytes 100
    post_as 127.0.0.2 1
    expect_problem 429 quota-exceeded
    [[ $(field .detail) = *--owner-bytes* ]]
    stop_daemon
    start --owner-bytes 1M
    post_as 127.0.0.3 1
    expect 202
}

@test "owners: beyond its event streams an owner is 429, another is not" {
    start --owner-streams 1
    stop_workers
    post_as 127.0.0.2 1
    expect 202
    id=$(field .id)
    curl -sSN --interface 127.0.0.2 "$URL/v1/drapes/$id/events" >"$BATS_TEST_TMPDIR/events" &
    local stream=$!
    wait_until 10 grep -q progress "$BATS_TEST_TMPDIR/events"
    as 127.0.0.2 GET "/v1/drapes/$id/events"
    expect_problem 429 quota-exceeded
    [[ $(field .detail) = *--owner-streams* ]]
    as 127.0.0.2 GET "/v1/drapes/$id?wait=1"
    expect_problem 429 quota-exceeded
    post_as 127.0.0.2 1.1 -H 'Prefer: wait=1'
    expect_problem 429 quota-exceeded
    as 127.0.0.3 GET "/v1/drapes/$id?wait=1"
    expect 200
    kill "$stream"
    wait "$stream" || true
    free() { as 127.0.0.2 GET "/v1/drapes/$id?wait=1" && [ "$status" = 200 ]; }
    wait_until 10 free
    kill -CONT $(workers)
}

@test "owners: the addresses that a trusted proxy names are owners" {
    local size
    size=$(quick 1.01 | wc -c)
    start --owner-bytes $((size * 3 / 2)) --trusted-proxy 127.0.0.9,::1
    post_as 127.0.0.9 1.01 -H 'X-Forwarded-For: 192.0.2.7'
    expect 202
    for header in 'X-Forwarded-For: 192.0.2.7' 'X-Forwarded-For: 10.1.1.1, 192.0.2.7:4711' \
        'X-Forwarded-For: 192.0.2.7, 127.0.0.9' 'Forwarded: for=10.1.1.1, for="192.0.2.7:80";proto=http'; do
        post_as 127.0.0.9 1.02 -H "$header"
        expect_problem 429 quota-exceeded
    done
    post_as 127.0.0.9 1.03 -H 'Forwarded: for="[2001:db8::1]:80"'
    expect 202
    post_as 127.0.0.9 1.04 -H 'X-Forwarded-For: 2001:db8:0:0:ffff::2'
    expect_problem 429 quota-exceeded
    # From others the header counts for nothing.
    post_as 127.0.0.8 1.05 -H 'X-Forwarded-For: 192.0.2.7'
    expect 202
}

@test "owners: a token's caller is one owner from everywhere" {
    new_token() {
        "$DRAPED" hash-token "$1" write --generate 2>&1 >>"$BATS_TEST_TMPDIR/tokens" |
            sed -n 's/^the token: //p'
    }
    ann=(-H "Authorization: Bearer $(new_token ann)")
    bob=(-H "Authorization: Bearer $(new_token bob)")
    start --queue-limit 10 --owner-queue 1 --tokens "$BATS_TEST_TMPDIR/tokens"
    stop_workers
    post_as 127.0.0.2 1 "${ann[@]}"
    expect 202
    running() { call GET "/v1/drapes/$id" "${ann[@]}" && [ "$(field .status)" = running ]; }
    id=$(field .id)
    wait_until 10 running
    post_as 127.0.0.2 1.01 "${ann[@]}"
    expect 202
    post_as 127.0.0.3 1.02 "${ann[@]}"
    expect_problem 429 quota-exceeded
    post_as 127.0.0.3 1.02 "${bob[@]}"
    expect 202
    kill -CONT $(workers)
}

@test "owners: a small drape does not wait for another owner's long ones" {
    start
    stop_workers
    post_as 127.0.0.2 1
    id=$(field .id)
    wait_until 10 has_status "$id" running
    for k in 1 2 3 4 5; do
        post_as 127.0.0.3 "1.$k" -H 'Prefer: wait=50'
        expect 200
        has_status "$id" running
    done
    # Those of the owner who has all workers wait.
    post_as 127.0.0.2 1.6
    has_status "$(field .id)" queued
    kill -CONT $(workers)
}

@test "owners: a long drape gives way to another owner who has nothing running" {
    start
    stop_workers
    post_as 127.0.0.2 1
    local first
    first=$(field .id)
    wait_until 10 has_status "$first" running
    post_as 127.0.0.3 1 -H 'Prefer: wait=50'
    expect 200
    stop_workers # the fast one, too
    post_as 127.0.0.3 1.1
    expect 202
    # It is begun there and put back; then the first one's turn is over. Its worker goes with it.
    wait_for "$(field .id)" succeeded
    [ "$(field .attempts)" = 2 ]
    wait_for "$first" succeeded
    [ "$(field .attempts)" = 2 ]
}
