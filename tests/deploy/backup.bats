# SPDX-License-Identifier: MIT
# draped backup and draped restore with SQLite: while the daemon works, on a full disk, killed at any
# moment, with damaged copies. What was whole before is whole afterwards.
load helper

setup() {
    COPIES=$BATS_TEST_TMPDIR/copies
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    DATA=$HOME_DIR/data
}
teardown() { stop_daemon; }

backup() { "$DRAPED" backup --data "$DATA" "$@"; }
restore() { "$DRAPED" restore --data "$DATA" "$@"; }
last_copy() { echo "$COPIES/$(copies | tail -1)"; }

# A store of some 20 MB, and the number of its drapes.
fill() {
    local n
    for n in 1 2 3 4 5 6; do
        jq -c ".fabric.spacing = 0.04 + 0.0001 * $n" $EXAMPLES/saddle.json |
            post /v1/drapes - -H 'Prefer: wait=40' -o "$BATS_TEST_TMPDIR/large"
        expect 200
    done
}

@test "deploy: a back-up while drapes run is put back as it was, and what was there is kept" {
    drape 1.0
    kept=$id
    stop_workers # drapes queue up and run while the copy is made
    for n in 1 2 3; do quick "1.$n" | submit; done
    queued=$id
    backup "$COPIES" >"$BATS_TEST_TMPDIR/said"
    grep -q ': schema [0-9]*, 4 drapes, 1 results, 0 surfaces' "$BATS_TEST_TMPDIR/said"
    [ "$(stat -c %a "$(last_copy)")" = 600 ]
    # Nobody else's hands meanwhile.
    run restore "$COPIES"
    [ "$status" = 1 ]
    [[ "$output" == *"in use by another draped"* ]]
    kill_daemon
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    drape 1.5
    later=$id
    stop_daemon
    restore "$COPIES" >"$BATS_TEST_TMPDIR/said"
    old=$(sed -n 's/^the old store is kept as //p' "$BATS_TEST_TMPDIR/said")
    [ "$(sqlite3 "$old" "SELECT count(*) FROM jobs WHERE id = '$later'")" = 1 ]
    [ "$(sqlite3 "$DATA/draped.db" "SELECT count(*) FROM sqlite_schema WHERE name = 'backup'")" = 0 ]
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    result "$kept"
    cmp "$body" "$BATS_TEST_TMPDIR/1.0"
    wait_for "$queued" succeeded
    call GET "/v1/drapes/$later"
    expect 404
    not grep '"event":"store_error"' "$HOME_DIR/log"
}

@test "deploy: of several back-ups the newest are kept, and other files" {
    drape 1.0
    mkdir -p "$COPIES"
    echo mine >"$COPIES/draped-2001.backup"
    echo mine >"$COPIES/notes"
    for n in 1 2 3; do backup --keep 2 "$COPIES"; done
    [ "$(copies | wc -l)" = 2 ]
    [ "$(ls "$COPIES" | wc -l)" = 4 ]
    backup --keep 0 "$COPIES"
    [ "$(copies | wc -l)" = 3 ]
    # A folder or a database that is not there, another program's database, and words without sense.
    run backup --data "$BATS_TEST_TMPDIR/nowhere" "$BATS_TEST_TMPDIR/other"
    [ "$status" = 1 ]
    [ -z "$(ls "$BATS_TEST_TMPDIR/other")" ]
    sqlite3 "$BATS_TEST_TMPDIR/foreign.db" 'CREATE TABLE t (n)'
    run "$DRAPED" backup --store "$BATS_TEST_TMPDIR/foreign.db" "$BATS_TEST_TMPDIR/other"
    [ "$status" = 1 ]
    [[ "$output" == *"not a database of draped"* ]]
    for arguments in '' 'a b' '--keep x a' '--keep -1 a' '--nonsense a'; do
        run backup $arguments
        [ "$status" = 2 ]
    done
    "$DRAPED" backup --help | grep -q 'draped restore FILE'
}

@test "deploy: without room on the disk the copies of before stay, and no other comes" {
    fill
    backup "$COPIES"
    before=$(cd "$COPIES" && sha256sum *)
    for blocks in 0 64 4096; do # of 1 KiB
        run bash -c "ulimit -f $blocks; exec $DRAPED backup --keep 1 --data $DATA $COPIES"
        echo "$output"
        [ "$status" = 1 ]
        [ "$(cd "$COPIES" && sha256sum *)" = "$before" ]
    done
    stop_daemon
    before=$(sqlite3 "$DATA/draped.db" .dump | sha256sum)
    run bash -c "ulimit -f 4096; exec $DRAPED restore --data $DATA $COPIES"
    [ "$status" = 1 ]
    [ "$(sqlite3 "$DATA/draped.db" .dump | sha256sum)" = "$before" ]
    [ -z "$(ls "$DATA" | grep -E 'restoring|before')" ]
}

# after COMMAND...: seconds that it takes, and then the command killed at each of eight moments of
# it; calls `whole` after each.
killed_at_any_moment() {
    local from to k
    from=$(date +%s%N)
    "$@" >"$BATS_TEST_TMPDIR/said"
    to=$(date +%s%N)
    for k in 1 2 3 4 5 6 7 8; do
        "$@" >"$BATS_TEST_TMPDIR/said" 2>&1 3>&- &
        sleep "$(((to - from) * k / 8 / 1000000))e-3"
        kill -KILL $! 2>/dev/null || true
        wait $! || true
        whole
    done
}

@test "deploy: what killed back-ups and restores have left beside their unfinished files is removed" {
    drape 1.0
    mkdir -p "$COPIES"
    local end
    for end in '' -journal -wal -shm; do
        echo left >"$COPIES/draped-20010909T014640.000Z.backup.part$end"
        echo left >"$DATA/draped.db.restoring$end"
    done
    backup "$COPIES"
    [ "$(ls "$COPIES")" = "$(copies)" ]
    stop_daemon
    restore "$COPIES"
    [ -z "$(ls "$DATA" | grep restoring)" ]
}

@test "deploy: a back-up that is killed at any moment leaves whole copies alone" {
    fill
    backup "$COPIES"
    cp -r "$COPIES" "$BATS_TEST_TMPDIR/first"
    whole() {
        local copy
        for copy in $(copies); do
            [ "$(sqlite3 "$COPIES/$copy" 'PRAGMA integrity_check')" = ok ]
            [ "$(sqlite3 "$COPIES/$copy" "SELECT rows FROM backup WHERE name = 'jobs'")" = 6 ]
        done
        cmp "$BATS_TEST_TMPDIR/first"/* "$COPIES/$(basename "$BATS_TEST_TMPDIR/first"/*)"
    }
    killed_at_any_moment "$DRAPED" backup --keep 0 --data "$DATA" "$COPIES"
    backup --keep 0 "$COPIES" # what was left is removed
    [ -z "$(ls "$COPIES" | grep -v '\.backup$')" ]
}

@test "deploy: a restore that is killed at any moment leaves the old store or the new one" {
    fill
    backup "$COPIES"
    drape 1.0
    later=$id
    stop_daemon
    whole() {
        [ "$(sqlite3 "$DATA/draped.db" 'PRAGMA integrity_check')" = ok ]
        local jobs
        jobs=$(sqlite3 "$DATA/draped.db" 'SELECT count(*) FROM jobs')
        [ "$jobs" = 6 ] || [ "$jobs" = 7 ]
        # And in the kept ones is what was there first.
        for old in "$DATA"/*.before-*Z; do
            [ ! -e "$old" ] || [ "$(sqlite3 "$old" 'PRAGMA integrity_check')" = ok ]
        done
    }
    killed_at_any_moment "$DRAPED" restore --data "$DATA" "$COPIES"
    restore "$COPIES"
    for old in "$DATA"/*.before-*Z; do sqlite3 "$old" 'SELECT id FROM jobs'; done | grep -q "$later"
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    call GET "/v1/drapes/$later"
    expect 404
    drape 1.1
}

@test "deploy: a damaged, shortened or strange copy is refused, and nothing changes" {
    fill
    backup "$COPIES"
    drape 1.0
    stop_daemon
    before=$(sqlite3 "$DATA/draped.db" .dump | sha256sum)
    good=$(last_copy) bad=$BATS_TEST_TMPDIR/bad
    size=$(stat -c %s "$good")
    for at in $((size / 3)) $((size / 2)) $((size * 9 / 10)); do # of results, mostly
        cp "$good" "$bad"
        printf 'draped' | dd of="$bad" bs=1 seek="$at" conv=notrunc status=none
        refused
    done
    head -c $((size / 2)) "$good" >"$bad"
    refused
    echo 'draped-backup 1 postgresql 1' >"$bad"
    refused
    : >"$bad"
    refused
    cp "$good" "$bad"
    sqlite3 "$bad" 'INSERT INTO schema_version VALUES (99, 0)'
    refused
    cp "$DATA/draped.db" "$bad" # a copy by hand
    refused
    restore "$good"
}
refused() {
    run restore "$bad"
    [ "$status" = 1 ] || { echo "$output"; return 1; }
    [ "$(sqlite3 "$DATA/draped.db" .dump | sha256sum)" = "$before" ]
}
