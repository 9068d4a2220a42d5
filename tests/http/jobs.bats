# SPDX-License-Identifier: MIT
# The life of drapes: waiting, cancelling, retries, restarts, limits. Each test has its own daemon.
load helper

teardown_file() { keep_contract; }

teardown() {
    [ -z "${DAEMON:-}" ] || kill -CONT $(workers) 2>/dev/null || true
    stop_daemon
}

start() { start_daemon "$BATS_TEST_TMPDIR/daemon" "$@"; }

@test "http: a worker killed in mid-solve costs one attempt" {
    start --workers 1
    stop_workers
    quick 2.01 | submit
    wait_until 10 has_status "$id" running
    kill -KILL $(workers)
    wait_for "$id" succeeded
    [ "$(field .attempts)" = 2 ]
    quick 2.02 | post /v1/drapes - -H 'Prefer: wait=20'
    expect 200
    [ "$(metric draped_worker_crashes_total)" = 1 ]
}

@test "http: a drape whose worker dies every time fails as solver-crashed" {
    start --workers 1
    attempt() { has_status "$id" running && [ "$(field .attempts)" = "$1" ]; }
    slow 1.02 | submit
    for k in 1 2 3; do
        wait_until 10 attempt $k
        kill -KILL $(workers)
    done
    wait_for "$id" failed
    [ "$(field .attempts)" = 3 ]
    [ "$(field .error.type)" = /problems/solver-crashed ]
    call GET "/v1/drapes/$id/result"
    expect_problem 500 solver-crashed
    quick 2.03 | post /v1/drapes - -H 'Prefer: wait=20'
    expect 200
}

@test "http: killed with drapes in the queue and started again, the daemon has lost nothing" {
    start --workers 1
    stop_workers
    ids=()
    for k in {1..12}; do
        quick "3.$k" | submit
        ids+=("$id")
    done
    left=$(workers)
    kill_daemon
    start --workers 2
    kill -KILL $left 2>/dev/null || true
    for id in "${ids[@]}"; do
        wait_for "$id" succeeded
        call GET "/v1/drapes/$id/result?fields=nodes.x"
        expect 200
    done
    call GET '/v1/drapes?limit=100'
    [ "$(field '.drapes | length')" = 12 ]
}

@test "http: killed and started again, results are still there" {
    start
    quick 4 | post /v1/drapes - -H 'Prefer: wait=20'
    expect 200
    id=$(field .id) tag=$(header ETag)
    kill_daemon
    start
    call GET "/v1/drapes/$id/result"
    expect 200
    [ "$(header ETag)" = "$tag" ]
}

@test "http: two hundred submits at once are all answered" {
    start --workers 2
    mkdir "$BATS_TEST_TMPDIR/answers"
    for k in {1..200}; do quick "1.0$k" >"$BATS_TEST_TMPDIR/answers/$k.json"; done
    for k in {1..200}; do
        printf 'next\nurl = "%s/v1/drapes"\nheader = "%s"\ndata-binary = "@%s"\noutput = "%s"\n' \
            "$URL" "$JSON" "$BATS_TEST_TMPDIR/answers/$k.json" "$BATS_TEST_TMPDIR/answers/$k"
        printf 'write-out = "%%{http_code}\\n"\n'
    done | sed 1d >"$BATS_TEST_TMPDIR/config"
    curl -sS --max-time 50 --parallel --parallel-immediate --parallel-max 200 \
        -K "$BATS_TEST_TMPDIR/config" >"$BATS_TEST_TMPDIR/codes"
    [ "$(grep -c '^202$' "$BATS_TEST_TMPDIR/codes")" = 200 ]
    [ "$(cat "$BATS_TEST_TMPDIR"/answers/*[0-9] | jq -r .id | sort -u | wc -l)" = 200 ]
    all_done() { [ "$(metric 'draped_jobs{status="succeeded"}')" = 200 ]; }
    wait_until 40 all_done
}

@test "http: beyond half of the queue limit one owner is 429 with Retry-After" {
    start --workers 1 --queue-limit 5 --owner-queue 9
    stop_workers
    quick 5.01 | submit
    wait_until 10 has_status "$id" running
    for k in 2 3 4; do quick "5.0$k" | submit; done
    quick 5.05 | post /v1/drapes -
    expect_problem 429 quota-exceeded
    [[ $(field .detail) = *--queue-limit* ]]
    [ "$(header Retry-After)" -ge 1 ]
    kill -CONT $(workers)
    wait_for "$id" succeeded
    quick 5.05 | submit
}

@test "http: one idempotency key is one drape" {
    start
    quick 6.01 >"$BATS_TEST_TMPDIR/one"
    post /v1/drapes "$BATS_TEST_TMPDIR/one" -H 'Idempotency-Key: a'
    expect 202
    id=$(field .id)
    post /v1/drapes "$BATS_TEST_TMPDIR/one" -H 'Idempotency-Key: a'
    expect 202
    [ "$(field .id)" = "$id" ]
    post /v1/drapes "$BATS_TEST_TMPDIR/one" -H 'Idempotency-Key: a' -H 'Prefer: wait=20'
    expect 200
    [ "$(field .id)" = "$id" ]
    quick 6.02 | post /v1/drapes - -H 'Idempotency-Key: a'
    expect_problem 422 idempotency-mismatch
    post /v1/drapes "$BATS_TEST_TMPDIR/one" -H 'Idempotency-Key: b'
    [ "$(field .id)" != "$id" ]
    kill_daemon
    start
    post /v1/drapes "$BATS_TEST_TMPDIR/one" -H 'Idempotency-Key: a'
    [ "$(field .id)" = "$id" ]
}

@test "http: ten at once with one key get one drape" {
    start
    quick 6.03 >"$BATS_TEST_TMPDIR/one"
    for k in {1..10}; do
        curl -sS --max-time 30 -H "$JSON" -H 'Idempotency-Key: c' -o "$BATS_TEST_TMPDIR/$k" \
            --data-binary "@$BATS_TEST_TMPDIR/one" "$URL/v1/drapes" &
    done
    wait $(jobs -p | grep -vx "$DAEMON")
    [ "$(jq -r .id "$BATS_TEST_TMPDIR"/[0-9]* | sort -u | wc -l)" = 1 ]
}

# When a running solve stops, its worker is killed and another takes its place.
@test "http: a running solve is cancelled within a second" {
    start --workers 1
    slow 1.01 | submit
    wait_until 10 has_status "$id" running
    worker=$(workers)
    call POST "/v1/drapes/$id/cancel"
    expect 202
    [ "$(field .status)" = cancelled ]
    begun=$(date +%s%N)
    wait_until 5 gone $worker
    [ $(($(date +%s%N) - begun)) -lt 1000000000 ]
    call POST "/v1/drapes/$id/cancel"
    expect 200
    [ "$(field .status)" = cancelled ]
    call GET "/v1/drapes/$id/result"
    expect_problem 409 cancelled
    quick 7.01 | post /v1/drapes - -H 'Prefer: wait=20'
    expect 200
}

@test "http: a queued drape is cancelled, a finished one stays" {
    start --workers 1
    stop_workers
    quick 7.02 | submit
    first=$id
    wait_until 10 has_status "$first" running
    quick 7.03 | submit
    call POST "/v1/drapes/$id/cancel"
    expect 202
    kill -CONT $(workers)
    wait_for "$first" succeeded
    call POST "/v1/drapes/$first/cancel"
    expect 200
    [ "$(field .status)" = succeeded ]
    wait_for "$id" cancelled
}

@test "http: a running drape can be deleted" {
    start --workers 1
    stop_workers
    quick 7.04 | submit
    wait_until 10 has_status "$id" running
    worker=$(workers)
    call DELETE "/v1/drapes/$id"
    expect 204
    wait_until 5 gone $worker
    call GET "/v1/drapes/$id"
    expect_problem 404 not-found
    quick 7.04 | post /v1/drapes - -H 'Prefer: wait=20'
    expect 200
}

@test "http: a solve over --job-timeout fails as job-timeout" {
    start --workers 1 --job-timeout 1
    stop_workers
    quick 8.01 | submit
    wait_for "$id" failed
    [ "$(field .error.type)" = /problems/job-timeout ]
    call GET "/v1/drapes/$id/result"
    expect_problem 500 job-timeout
    quick 8.02 | post /v1/drapes - -H 'Prefer: wait=20'
    expect 200
}

@test "http: many waiters on one drape are answered together" {
    start --workers 1
    stop_workers
    quick 9.01 | submit
    for k in {1..40}; do
        curl -sS --max-time 40 -o "$BATS_TEST_TMPDIR/$k" "$URL/v1/drapes/$id?wait=30" 3>&- &
    done
    wait_until 30 connected 40
    # Those who wait hold up nobody.
    call GET /version
    expect 200
    kill -CONT $(workers)
    wait $(jobs -p | grep -vx "$DAEMON")
    [ "$(jq -r .status "$BATS_TEST_TMPDIR"/[0-9]* | grep -c succeeded)" = 40 ]
}

# The library itself does not look at connections that wait.
@test "http: callers who go away while they wait leave room for others" {
    start --workers 1 --max-connections 32 --owner-streams 32
    stop_workers
    quick 9.04 | submit
    waiters=()
    wait_in_vain() {
        curl -sSN --max-time 55 -o /dev/null "$@" 3>&- &
        waiters+=($!)
    }
    for k in {1..6}; do
        wait_in_vain "$URL/v1/drapes/$id?wait=50"
        wait_in_vain "$URL/v1/drapes/$id/events"
        quick "9.1$k" >"$BATS_TEST_TMPDIR/$k.json"
        wait_in_vain -H "$JSON" -H 'Prefer: wait=50' --data-binary "@$BATS_TEST_TMPDIR/$k.json" \
            "$URL/v1/drapes"
    done
    full() { call GET /version && [ "$status" = 429 ]; }
    wait_until 20 full
    kill "${waiters[@]}"
    # Long before the waits end, and before a stream finds out by writing.
    room() { call GET "/v1/drapes/$id?wait=1" && [ "$status" = 200 ]; }
    wait_until 8 room
    # over ROUTE STATUS: four or more such requests have ended.
    over() { [ "$(metric "draped_http_requests_total{$1,status=\"$2\"}")" -ge 4 ]; }
    wait_until 8 over 'method="GET",route="/v1/drapes/{id}"' 0
    wait_until 8 over 'method="POST",route="/v1/drapes"' 0
    wait_until 8 over 'method="GET",route="/v1/drapes/{id}/events"' 200
}

@test "http: who closes the sending side is answered, but not waited for" {
    start --workers 1
    stop_workers
    quick 9.05 | submit
    half_closed() {
        python3 - "$PORT" "$1" <<'END'
import socket, sys
with socket.create_connection(("127.0.0.1", int(sys.argv[1])), 20) as client:
    client.sendall(f"GET {sys.argv[2]} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
    client.shutdown(socket.SHUT_WR)
    while piece := client.recv(65536):
        sys.stdout.buffer.write(piece)
END
    }
    half_closed "/v1/drapes/$id" | head -1 | grep -q '^HTTP/1.1 200 '
    half_closed "/v1/drapes/$id?wait=50" >"$BATS_TEST_TMPDIR/waited"
    [ ! -s "$BATS_TEST_TMPDIR/waited" ]
}

@test "http: a wait that is too short ends with what there is" {
    start --workers 1
    stop_workers
    quick 9.02 | submit
    begun=$SECONDS
    call GET "/v1/drapes/$id?wait=1"
    expect 200
    [ $((SECONDS - begun)) -ge 1 ]
    [ $((SECONDS - begun)) -lt 10 ]
    [[ "$(field .status)" =~ ^(queued|running)$ ]]
    call GET "/v1/drapes/$id/result"
    expect_problem 404 result-not-ready
    quick 9.03 | post /v1/drapes - -H 'Prefer: wait=1'
    expect 202
    [ -z "$(header Preference-Applied)" ]
    for wait in 61 -1 x ''; do
        call GET "/v1/drapes/$id?wait=$wait"
        expect_problem 422 invalid-request
    done
}

@test "http: events tell the progress and then the end" {
    start --workers 1
    stop_workers
    slow 1.6 | jq '.method = "geodesic"' | submit # some seconds of work, but a small result
    curl -sSN --max-time 55 "$URL/v1/drapes/$id/events" >"$BATS_TEST_TMPDIR/events" 3>&- &
    reader=$!
    wait_until 10 grep -q '^event: progress' "$BATS_TEST_TMPDIR/events"
    kill -CONT $(workers)
    wait $reader
    # Events are separated by empty lines; the last one is the end.
    grep '^event: ' "$BATS_TEST_TMPDIR/events" | uniq |
        diff - <(printf 'event: progress\nevent: end\n')
    sed -n 's/^data: //p' "$BATS_TEST_TMPDIR/events" >"$BATS_TEST_TMPDIR/data"
    jq -se --arg id "$id" 'all(.id == $id) and .[-1].status == "succeeded" and
        ([.[].progress] | . == sort) and ([.[] | select(.status == "running")] | length) >= 3' \
        "$BATS_TEST_TMPDIR/data"
    # Of a drape that has ended there is only the end.
    call GET "/v1/drapes/$id/events"
    expect 200
    [ "$(header Content-Type)" = text/event-stream ]
    [ "$(grep -c '^event: end' "$body")" = 1 ]
    [ "$(grep -c '^event: ' "$body")" = 1 ]
}

@test "http: SIGTERM lets a running drape finish, answers who waits, and exits 0" {
    start --workers 1
    stop_workers
    quick 10.01 | submit
    wait_until 10 has_status "$id" running
    curl -sSv --max-time 40 -o "$BATS_TEST_TMPDIR/waited" "$URL/v1/drapes/$id?wait=30" \
        2>"$BATS_TEST_TMPDIR/called" 3>&- &
    waiter=$!
    wait_until 10 grep -q '^> GET' "$BATS_TEST_TMPDIR/called"
    curl -sSN --max-time 40 -o "$BATS_TEST_TMPDIR/events" "$URL/v1/drapes/$id/events" 3>&- &
    reader=$!
    wait_until 10 grep -q progress "$BATS_TEST_TMPDIR/events"
    kill -TERM "$DAEMON"
    wait_until 10 grep -q '"event":"stopping"' "$HOME_DIR/log"
    kill -CONT $(workers)
    wait $waiter
    wait $reader
    join_daemon
    [ "$(jq -r .status "$BATS_TEST_TMPDIR/waited")" = succeeded ]
    grep -q '^event: end' "$BATS_TEST_TMPDIR/events"
    start
    wait_for "$id" succeeded
}

@test "http: SIGTERM puts what does not finish in time back into the queue" {
    start --workers 1 --drain-timeout 1
    stop_workers
    quick 10.02 | submit
    wait_until 10 has_status "$id" running
    quick 10.03 | submit
    begun=$SECONDS
    stop_daemon
    [ $((SECONDS - begun)) -lt 15 ]
    start
    wait_for "$id" succeeded
    call GET '/v1/drapes'
    [ "$(field '[.drapes[] | select(.status == "succeeded" or .status == "running")] | length')" = 2 ]
}

@test "http: while it drains, new connections are refused and kept ones get 503 for new work" {
    start --workers 1
    stop_workers
    quick 10.04 | submit
    wait_until 10 has_status "$id" running
    exec 5<>"/dev/tcp/127.0.0.1/$PORT"
    kill -TERM "$DAEMON"
    refused() { ! curl -sS --max-time 2 -o /dev/null "$URL/healthz" 2>/dev/null; }
    wait_until 5 refused
    printf 'GET /readyz HTTP/1.1\r\nHost: localhost\r\n\r\n' >&5
    timeout 10 cat <&5 >"$BATS_TEST_TMPDIR/answer" || true
    exec 5>&- 5<&-
    grep -q '^HTTP/1.1 503' "$BATS_TEST_TMPDIR/answer"
    grep -qi '^Retry-After' "$BATS_TEST_TMPDIR/answer"
    kill -CONT $(workers)
    join_daemon
}
