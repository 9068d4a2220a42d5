# SPDX-License-Identifier: MIT
# Calls answered by one process, drapes solved by another: over one file of SQLite, and over
# PostgreSQL. Whatever a caller does or waits for goes through the store.
load helper
load ../postgres.bash

teardown_file() { keep_contract; }

teardown() {
    local failed=0
    [ -z "${WORKER:-}" ] || DAEMON=$WORKER
    [ -z "${DAEMON:-}" ] || kill -CONT $(workers) 2>/dev/null || true
    HOME_DIR=$BATS_TEST_TMPDIR/worker stop_daemon || failed=1
    DAEMON=${API:-}
    HOME_DIR=$BATS_TEST_TMPDIR/api stop_daemon || failed=1
    postgres_stop
    rm -rf "${PG_FOLDER:-}"
    return $failed
}

# start_roles STORE: sets API and WORKER, processes, and WORKER_URL; URL is that of the api.
start_roles() {
    start_daemon "$BATS_TEST_TMPDIR/worker" --store "$1" --role worker --workers 1
    WORKER=$DAEMON WORKER_URL=$URL
    start_daemon "$BATS_TEST_TMPDIR/api" --store "$1" --role api
    API=$DAEMON
    DAEMON=$WORKER # `workers` are its children
}

store_of() {
    case $1 in
    SQLite) echo "sqlite:$BATS_TEST_TMPDIR/store.db" ;;
    *) echo "postgresql://draped@/postgres?host=$PG_FOLDER" ;;
    esac
}

start_with() {
    if [ "$1" = PostgreSQL ]; then
        PG_FOLDER=$(mktemp -d /tmp/draped-postgres-XXXXXX) # where its user may go
        postgres_make "$PG_FOLDER"
        postgres_start "$PG_FOLDER" ''
    fi
    start_roles "$(store_of "$1")"
}

works_apart() {
    start_with "$1"
    # Who waits gets the result, whoever solved it.
    quick 1.001 | post /v1/drapes - -H 'Prefer: wait=40'
    expect 200
    [ "$(field .summary.outcome)" = complete ]
    # Events and a waiting call see progress and the end.
    stop_workers
    slow 3.001 | jq '.method = "geodesic"' | submit
    curl -sSN --max-time 55 "$URL/v1/drapes/$id/events" >"$BATS_TEST_TMPDIR/events" 3>&- &
    local reader=$!
    curl -sS --max-time 55 -o "$BATS_TEST_TMPDIR/waited" "$URL/v1/drapes/$id?wait=50" 3>&- &
    local waiter=$!
    wait_until 10 grep -q '^event: progress' "$BATS_TEST_TMPDIR/events"
    kill -CONT $(workers)
    wait $reader
    wait $waiter
    [ "$(jq -r .status "$BATS_TEST_TMPDIR/waited")" = succeeded ]
    grep '^event: ' "$BATS_TEST_TMPDIR/events" | uniq | diff - <(printf 'event: progress\nevent: end\n')
    sed -n 's/^data: //p' "$BATS_TEST_TMPDIR/events" | jq -se \
        'any(.status == "running") and .[-1].status == "succeeded" and ([.[].progress] | . == sort)'
    # A cancelled drape stops where it runs, and the worker takes the next.
    slow 1.001 | submit
    wait_until 10 has_status "$id" running
    call POST "/v1/drapes/$id/cancel"
    expect 202
    quick 1.002 | post /v1/drapes - -H 'Prefer: wait=40'
    expect 200
    URL=$WORKER_URL
    [ "$(metric 'draped_drapes_total{outcome="stopped"}')" = 1 ]
    [ "$(metric 'draped_drapes_total{outcome="succeeded"}')" = 3 ]
}

@test "http: an api and a worker share the work over SQLite" { works_apart SQLite; }
@test "http: an api and a worker share the work over PostgreSQL" { works_apart PostgreSQL; }

@test "http: a worker answers probes and scrapes alone" {
    start_with SQLite
    quick 1.003 | post /v1/drapes - -H 'Prefer: wait=40'
    expect 200
    call GET /metrics
    expect 200
    not grep -q draped_workers_busy "$body" # it has none
    URL=$WORKER_URL
    for path in /healthz /readyz /metrics; do
        call GET "$path"
        expect 200
    done
    [ "$(metric draped_workers_busy)" = 0 ]
    for path in / /v1/drapes /v1/limits /version; do
        call GET "$path"
        expect_problem 404 not-found
    done
    quick 1 | post /v1/drapes -
    expect_problem 404 not-found
}

@test "http: what is no text is refused before the database sees it" {
    start_with PostgreSQL
    for id in %ff a%80 x; do
        call GET "/v1/surfaces/$id"
        expect_problem 404 not-found
        call DELETE "/v1/surfaces/$id"
        expect_problem 404 not-found
        call GET "/v1/drapes/$id"
        expect_problem 404 not-found
    done
    quick 1.006 | post /v1/drapes - -H $'Idempotency-Key: a\xff'
    expect_problem 422 invalid-request
    not grep -q store_failed "$BATS_TEST_TMPDIR/api/log"
}

@test "http: without a database calls are refused, and served again once it is back" {
    start_with PostgreSQL
    postgres_stop QUIT
    call GET /healthz
    expect 200
    call GET /readyz
    expect 503
    quick 1.004 | post /v1/drapes -
    expect_problem 503 unavailable
    postgres_start "$PG_FOLDER" ''
    ready() { call GET /readyz && [ "$status" = 200 ]; }
    wait_until 20 ready
    quick 1.005 | post /v1/drapes - -H 'Prefer: wait=40'
    expect 200
}

@test "http: a password in the URL of the store is told nowhere" {
    mkdir -p "$BATS_TEST_TMPDIR/none"
    run timeout 30 "$DRAPED" --listen 127.0.0.1:0 --log-level debug \
        --store "postgresql://draped:hush@/draped?host=$BATS_TEST_TMPDIR/none"
    [ "$status" = 1 ]
    [[ "$output" == *"the database cannot be used"* && "$output" != *hush* ]]
    run "$DRAPED" --check-config --store postgresql://draped:hush@host/draped
    [ "$status" = 0 ]
    [[ "$output" != *hush* ]]
}

@test "http: one line of jq follows a drape through its call, a crashed worker and another" {
    start_with SQLite
    quick 1.01 | submit -H 'X-Request-Id: the-call-of-anna'
    wait_for "$id" succeeded
    stop_workers
    quick 1.02 | submit -H 'X-Request-Id: the-call-of-bert'
    wait_until 20 has_status "$id" running
    kill -KILL $(workers)
    wait_for "$id" succeeded
    mkdir "$BATS_TEST_TMPDIR/logs"
    cp "$BATS_TEST_TMPDIR/api/log" "$BATS_TEST_TMPDIR/logs/api"
    cp "$BATS_TEST_TMPDIR/worker/log" "$BATS_TEST_TMPDIR/logs/worker"
    sed -n '/^```sh follow$/,/^```$/p' docs/runbook.md | sed '1d;$d' >"$BATS_TEST_TMPDIR/follow"
    follow() { (cd "$BATS_TEST_TMPDIR" && ID=$1 bash -eu follow) >"$BATS_TEST_TMPDIR/lines"; }
    follow "$id"
    cat "$BATS_TEST_TMPDIR/lines"
    jq -se --arg id "$id" '[.[] | select(.event == "request" and .method == "POST")] |
        length == 1 and .[0].drape == $id and .[0].request_id == "the-call-of-bert"' "$BATS_TEST_TMPDIR/lines"
    jq -se '[.[] | select(.event == "job_left_worker")] | length == 2 and
        all(.request_id == "the-call-of-bert") and
        .[0].level == "warning" and .[0].outcome == "crashed" and (.[0].worker | contains("signal 9")) and
        .[1].level == "info" and .[1].outcome == "done" and .[1].attempt == 2' "$BATS_TEST_TMPDIR/lines"
    # By the call's own id: the call, and what the workers did for it.
    follow the-call-of-bert
    jq -se 'length == 3' "$BATS_TEST_TMPDIR/lines"
}

# status: what `draped status` says of the store; sets status.
store_status() {
    status=0
    "$DRAPED" status --store "$(store_of "$1")" >"$BATS_TEST_TMPDIR/status" 2>&1 || status=$?
    cat "$BATS_TEST_TMPDIR/status"
}
says() { store_status "$kind" >"$BATS_TEST_TMPDIR/shown"; grep -qE "$1" "$BATS_TEST_TMPDIR/status"; }

tells_its_status() {
    kind=$1
    start_with "$1"
    wait_until 20 says '^workers  1, 0 busy, on 2 hosts$'
    [ "$status" = 0 ]
    grep -qE ', api, version [0-9.]+(-rc[0-9]+)?, 0 workers, 0 busy, wrote [0-9] s ago$' "$BATS_TEST_TMPDIR/status"
    grep -qx 'failed   none' "$BATS_TEST_TMPDIR/status"
    stop_workers
    quick 1.01 | submit
    wait_until 20 has_status "$id" running
    wait_until 20 says '^workers  1, 1 busy'
    quick 1.02 | submit
    says '^queue    1 waiting, the first for [0-9]+ s, 1 running$'
    kill -CONT $(workers)
    wait_for "$id" succeeded
    jq -c '.start = {point: [100, 0, 0]}' $EXAMPLES/saddle.json | submit
    wait_for "$id" failed
    says "^failed   $id 20.*Z .*/problems/start-off-surface"
    says '^ended    2 succeeded, 1 failed \(0 by crashes\), 0 cancelled$'
    # Without workers what waits is told; so is it when nobody is there.
    HOME_DIR=$BATS_TEST_TMPDIR/worker stop_daemon
    WORKER=
    quick 1.03 | submit
    wait_until 20 says '^verdict  drapes wait, and there are no workers$'
    [ "$status" = 1 ]
    DAEMON=$API HOME_DIR=$BATS_TEST_TMPDIR/api stop_daemon
    API=
    says '^verdict  no host has written to the store for half a minute$'
    [ "$status" = 1 ]
}
@test "http: draped status shows queue, hosts, workers and the last error over SQLite" { tells_its_status SQLite; }
@test "http: draped status shows queue, hosts, workers and the last error over PostgreSQL" { tells_its_status PostgreSQL; }
@test "http: draped status of a store that is not there, and of words without sense" {
    run "$DRAPED" status --store "$BATS_TEST_TMPDIR/nothing.db"
    [ "$status" = 1 ]
    [ ! -e "$BATS_TEST_TMPDIR/nothing.db" ]
    run "$DRAPED" status --store postgresql://draped:SECRET@127.0.0.1:1/draped
    [ "$status" = 1 ]
    [[ "$output" != *SECRET* ]]
    run "$DRAPED" status everything
    [ "$status" = 2 ]
}
