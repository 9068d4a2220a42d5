# SPDX-License-Identifier: MIT
# Back-up and restore of a PostgreSQL store, by the commands of docs/operations.md as they stand,
# on a server of the test's own.
load helper

PROGRAMS=$(ls -d /usr/lib/postgresql/*/bin 2>/dev/null | tail -1)

# PostgreSQL does not run as root.
as_server() {
    if [ "$(id -u)" = 0 ]; then
        setpriv --reuid nobody --regid nogroup --clear-groups "$@"
    else
        "$@"
    fi
}

setup() {
    [ -n "$PROGRAMS" ]
    # Unix sockets and their owner are of short paths and known users.
    SERVER=$(mktemp -d /tmp/draped-backup-XXXXXX)
    [ "$(id -u)" != 0 ] || chown nobody "$SERVER"
    local port
    port=$(free_port)
    as_server "$PROGRAMS/initdb" -D "$SERVER/data" -U draped -A trust >"$BATS_TEST_TMPDIR/initdb"
    as_server "$PROGRAMS/pg_ctl" -D "$SERVER/data" -l "$SERVER/log" -w start \
        -o "-p $port -k $SERVER -c listen_addresses=127.0.0.1 -c fsync=off" >"$BATS_TEST_TMPDIR/start" 3>&-
    ADMIN="postgresql://draped@127.0.0.1:$port/postgres"
    export DRAPED_STORE="postgresql://draped@127.0.0.1:$port/draped"
    psql -qd "$ADMIN" -c 'CREATE DATABASE draped'
}

teardown() {
    local failed=0
    stop_daemon || failed=1
    [ -z "${SERVER:-}" ] || {
        as_server "$PROGRAMS/pg_ctl" -D "$SERVER/data" -m immediate stop >"$BATS_TEST_TMPDIR/stop" || true
        rm -rf "$SERVER"
    }
    return $failed
}

# documented NAME: the commands of that block.
documented() {
    sed -n "/^\`\`\`sh $1\$/,/^\`\`\`\$/p" docs/operations.md | sed '1d;$d' >"$BATS_TEST_TMPDIR/$1"
    [ -s "$BATS_TEST_TMPDIR/$1" ]
    (cd "$BATS_TEST_TMPDIR" && bash -eu "$1")
}

result() {
    call GET "/v1/drapes/$id/result?format=csv"
    expect 200
}

@test "deploy: PostgreSQL backed up and restored as documented" {
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    post /v1/drapes $EXAMPLES/saddle.json -H 'Prefer: wait=30'
    expect 200
    id=$(field .id)
    result
    cp "$body" "$BATS_TEST_TMPDIR/before"
    documented back-up-postgresql # while it runs
    stop_daemon
    psql -qd "$ADMIN" -c 'DROP DATABASE draped' -c 'CREATE DATABASE draped'
    documented restore-postgresql
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    result
    cmp "$body" "$BATS_TEST_TMPDIR/before"
    post /v1/drapes $EXAMPLES/sphere.json -H 'Prefer: wait=30'
    expect 200
}
