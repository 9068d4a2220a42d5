# SPDX-License-Identifier: MIT
# The Debian package: made, looked over by lintian, unpacked and run, and, on a machine of the test's
# own with systemd as process 1 (machine.sh), installed, started, restarted, upgraded and removed.
load helper

setup_file() {
    # Compressed little: nobody fetches this one.
    DPKG_DEB_COMPRESSOR_LEVEL=1 make -s deb B="${BUILD:-build}"
    DEB=$(realpath "${BUILD:-build}"/deb/draped_*.deb)
    export DEB
}

teardown() {
    local failed=0
    stop_daemon || failed=1
    [ -z "${MACHINE:-}" ] || { kill -TERM "$MACHINE"; wait "$MACHINE" || true; }
    return $failed
}

@test "deploy: the package has no errors for lintian" {
    run lintian --fail-on error,warning "$DEB"
    echo "$output"
    [ "$status" = 0 ]
}

@test "deploy: the importer is a package of its own, which alone has Open CASCADE" {
    import=$(realpath "${BUILD:-build}"/deb/draped-import_*.deb)
    run lintian --fail-on error,warning "$import"
    echo "$output"
    [ "$status" = 0 ]
    dpkg-deb -f "$import" Depends | grep -q libocct
    not grep -q libocct <(dpkg-deb -f "$DEB" Depends)
    # Beside the daemon it is found; without it STEP is refused.
    dpkg-deb -x "$DEB" "$BATS_TEST_TMPDIR/root"
    mkdir "$BATS_TEST_TMPDIR/parts"
    "${BUILD:-build}/tests/import/make_parts" "$BATS_TEST_TMPDIR/parts" >/dev/null
    DRAPED=$BATS_TEST_TMPDIR/root/usr/bin/draped
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    call POST /v1/surfaces -H 'Content-Type: model/step' --data-binary @"$BATS_TEST_TMPDIR/parts/box.step"
    expect_problem 415 unsupported-media-type
    dpkg-deb -x "$import" "$BATS_TEST_TMPDIR/root"
    call POST /v1/surfaces -H 'Content-Type: model/step' --data-binary @"$BATS_TEST_TMPDIR/parts/box.step"
    expect 201
}

@test "deploy: the library is two packages, which need neither the daemon nor its libraries" {
    mkdir "$BATS_TEST_TMPDIR/root"
    for package in libdrape1 libdrape-dev; do
        deb=$(realpath "${BUILD:-build}"/deb/${package}_*.deb)
        run lintian --fail-on error,warning "$deb"
        echo "$output"
        [ "$status" = 0 ]
        not grep -qE 'draped|libmicrohttpd|libpq|libhdf5' <(dpkg-deb -f "$deb" Depends)
        dpkg-deb -x "$deb" "$BATS_TEST_TMPDIR/root"
    done
    cd "$BATS_TEST_TMPDIR/root/usr"
    [ -e lib/*/libdrape.so ]
    [ "$(cat lib/*/pkgconfig/drape.pc include/drape.h share/doc/libdrape-dev/examples/cloth.c | wc -l)" -gt 150 ]
}

@test "deploy: the package is of this version, and builds from what setup.sh installs" {
    [ "$(dpkg-deb -f "$DEB" Version)" = "$("$DRAPED" --version | sed 's/draped //; s/-rc/~rc/')" ]
    # What `make` needs is a build dependency, but for compilers and what the demo calls.
    sed -n "/^compile='/,/'\$/p; /^import='/p" deploy/setup.sh | tr -s " '" '\n\n' |
        grep -E -- '-dev$|^python3' | sort >"$BATS_TEST_TMPDIR/setup"
    [ -s "$BATS_TEST_TMPDIR/setup" ]
    sed -n '/^Build-Depends:/,/^[^ B]/p' deploy/debian/control | grep -oE '^ [a-z0-9-]+' |
        tr -d ' ' | sort >"$BATS_TEST_TMPDIR/control"
    [ -z "$(comm -23 "$BATS_TEST_TMPDIR/setup" "$BATS_TEST_TMPDIR/control")" ] ||
        { echo 'deploy/debian/control lacks:'; comm -23 "$BATS_TEST_TMPDIR/setup" "$BATS_TEST_TMPDIR/control"; false; }
}

@test "deploy: the pages of the package lead to files that are in it, and each block of the guide is run" {
    dpkg-deb -x "$DEB" "$BATS_TEST_TMPDIR/root"
    cd "$BATS_TEST_TMPDIR/root/usr/share/doc/draped"
    for page in *.md; do
        grep -oE '\]\([^)# ]+' "$page" | sed 's/](//' | grep -v '^http' | while read -r target; do
            [ -e "$target" ] || { echo "$page: $target is not there"; false; }
        done
    done
    # Of the guide's blocks those of a shell have names, and the tests below run them.
    [ "$(sed -n 's/^```//p' operations.md | grep . | sort | tr '\n' ' ')" = \
        'nginx sh back-up sh back-up-postgresql sh check sh install sh kubernetes-secret sh link sh restore sh restore-postgresql sh status ' ]
}

@test "deploy: the block for Kubernetes makes the files that it names (kubectl is a stand-in)" {
    dpkg-deb -x "$DEB" "$BATS_TEST_TMPDIR/root"
    block kubernetes-secret "$BATS_TEST_TMPDIR/root/$GUIDE"
    kubectl() { echo "$*" >>asked; }
    PATH=$BATS_TEST_TMPDIR/root/usr/bin:$PATH
    export -f kubectl
    (cd "$BATS_TEST_TMPDIR" && bash -eu -o pipefail commands)
    grep -q -- '--from-file=tokens --from-file=metrics-token$' "$BATS_TEST_TMPDIR/asked"
    # The token is one of the role that /metrics takes, from other machines too.
    start_daemon "$BATS_TEST_TMPDIR/daemon" --tokens "$BATS_TEST_TMPDIR/tokens" --trusted-proxy 127.0.0.1
    call GET /metrics -H 'X-Forwarded-For: 10.1.1.1'
    expect 401
    call GET /metrics -H 'X-Forwarded-For: 10.1.1.1' -H "Authorization: Bearer $(cat "$BATS_TEST_TMPDIR/metrics-token")"
    expect 200
}

@test "deploy: the block for links makes one that shows the drape (the address is that of a daemon here)" {
    dpkg-deb -x "$DEB" "$BATS_TEST_TMPDIR/root"
    block link "$BATS_TEST_TMPDIR/root/$GUIDE"
    TOKEN=$("$DRAPED" hash-token anna write --generate 2>&1 >"$BATS_TEST_TMPDIR/tokens" | sed -n 's/^the token: //p')
    start_daemon "$BATS_TEST_TMPDIR/daemon" --tokens "$BATS_TEST_TMPDIR/tokens"
    post /v1/drapes $EXAMPLES/saddle.json -H 'Prefer: wait=30' -H "Authorization: Bearer $TOKEN"
    expect 200
    ID=$(field .id)
    curl() { command curl -sS "${@//http:\/\/draped.example/$URL}"; }
    export -f curl
    export ID TOKEN URL
    shown=$(cd "$BATS_TEST_TMPDIR" && bash -eu -o pipefail commands | jq -r .token)
    unset -f curl
    call GET "/v1/drapes/$ID/result" -H "Authorization: Bearer $shown"
    expect 200
}

@test "deploy: the programs of the package drape, with the bits of this build" {
    dpkg-deb -x "$DEB" "$BATS_TEST_TMPDIR/root"
    DRAPED=$BATS_TEST_TMPDIR/root/usr/bin/draped
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    post /v1/drapes $EXAMPLES/freeform.json -H 'Prefer: wait=30'
    expect 200
    jq -S 'del(.id, .summary.timing_ms)' "$body" >"$BATS_TEST_TMPDIR/package"
    "$DRAPE" $EXAMPLES/freeform.json | jq -S 'del(.id, .summary.timing_ms)' >"$BATS_TEST_TMPDIR/build"
    cmp "$BATS_TEST_TMPDIR/package" "$BATS_TEST_TMPDIR/build"
    # Hardened as Debian's own programs are.
    readelf -hW "$DRAPED" | grep -q 'Type:.*DYN'
    readelf -dW "$DRAPED" | grep -q 'BIND_NOW'
    nm -D "$DRAPED" | grep -q '__stack_chk_fail'
}

# inside COMMAND...: on the machine of the test.
inside() { nsenter -t "$(cat "$BATS_TEST_TMPDIR/machine/init")" -a "$@"; }
machine_says() { grep -q . "$BATS_TEST_TMPDIR/machine/out" || ! kill -0 "$MACHINE"; }
main_process() { inside systemctl show -P MainPID draped; }
is_active() { [ "$(inside systemctl is-active draped)" = active ]; }
answers() { inside curl -sf -o /dev/null --max-time 5 http://127.0.0.1:8080/readyz; }
restarted() { [ "$(inside systemctl show -P NRestarts draped)" -ge 1 ] && answers; }

start_machine() {
    [ "$(id -u)" = 0 ] || skip 'a machine with its own systemd can only be made by root'
    unshare --mount --pid --fork --net --uts --ipc --cgroup true 2>"$BATS_TEST_TMPDIR/unshare" ||
        skip 'this system lets nobody make namespaces'
    grep -q '^[^ ]* [^ ]* cgroup2 ' /proc/mounts || skip 'this system has no control groups of version 2'
    mkdir -p "$BATS_TEST_TMPDIR/machine"
    : >"$BATS_TEST_TMPDIR/machine/out"
    tests/deploy/machine.sh "$BATS_TEST_TMPDIR/machine" >"$BATS_TEST_TMPDIR/machine/out" \
        2>"$BATS_TEST_TMPDIR/machine/errors" 3>&- &
    MACHINE=$!
    wait_until 30 machine_says
    grep -qx up "$BATS_TEST_TMPDIR/machine/out" || { cat "$BATS_TEST_TMPDIR/machine/errors"; false; }
}

install_package() {
    inside sh -c 'cat >/root/draped.deb && DEBIAN_FRONTEND=noninteractive dpkg --no-triggers -i /root/draped.deb' \
        <"$DEB" >"$BATS_TEST_TMPDIR/dpkg" 2>&1 || { cat "$BATS_TEST_TMPDIR/dpkg"; false; }
    wait_until 20 answers || { inside journalctl --no-pager -u draped; false; }
}

drape_inside() {
    inside curl -sS --fail-with-body --max-time 50 -H "$JSON" -H 'Prefer: wait=40' \
        --data-binary @- http://127.0.0.1:8080/v1/drapes <"$1"
}

@test "deploy: installed under systemd it starts, drapes, is locked in and recovers" {
    start_machine
    install_package
    is_active
    drape_inside $EXAMPLES/saddle.json >"$BATS_TEST_TMPDIR/result"
    id=$(jq -r .id "$BATS_TEST_TMPDIR/result")
    jq -S 'del(.id, .summary.timing_ms)' "$BATS_TEST_TMPDIR/result" >"$BATS_TEST_TMPDIR/package"
    "$DRAPE" $EXAMPLES/saddle.json | jq -S 'del(.id, .summary.timing_ms)' | cmp - "$BATS_TEST_TMPDIR/package"

    # The account is nobody's, has no rights and a filter of system calls; so have its workers.
    main=$(main_process)
    for process in $main $(inside cat "/proc/$main/task/$main/children"); do
        inside grep -qE '^Uid:	6[0-9]{4}	' "/proc/$process/status"
        inside grep -qE '^CapEff:	0+$' "/proc/$process/status"
        inside grep -qE '^NoNewPrivs:	1$' "/proc/$process/status"
        inside grep -qE '^Seccomp:	2$' "/proc/$process/status"
    done
    [ "$(inside stat -c %a /var/lib/private/draped)" = 700 ]
    not inside nsenter -t "$main" -m touch /etc/by-draped
    # No word of trouble from either.
    [ -z "$(inside journalctl --no-pager -q -u draped -p warning)" ]
    inside journalctl --no-pager -o cat -u draped | not grep -E '"level":"(warning|error)"'

    # A restart keeps what was there.
    inside systemctl restart draped
    wait_until 20 answers
    [ "$(inside curl -sS "http://127.0.0.1:8080/v1/drapes/$id" | jq -r .status)" = succeeded ]

    # A daemon that stands still is killed by the watchdog and comes back.
    inside mkdir -p /run/systemd/system/draped.service.d
    printf '[Service]\nWatchdogSec=1\n' |
        inside tee /run/systemd/system/draped.service.d/soon.conf >"$BATS_TEST_TMPDIR/tee"
    inside systemctl daemon-reload
    inside systemctl restart draped
    wait_until 20 answers
    inside kill -STOP "$(main_process)"
    wait_until 40 restarted
    inside journalctl --no-pager -o cat -u draped | grep -q 'Watchdog timeout'
    [ "$(inside curl -sS "http://127.0.0.1:8080/v1/drapes/$id" | jq -r .status)" = succeeded ]
    inside systemctl stop draped
}

GUIDE=usr/share/doc/draped/operations.md # as it is in the package

# block NAME FILE: the commands of that block of a page.
block() {
    sed -n "/^\`\`\`sh $1\$/,/^\`\`\`\$/p" "$2" | sed '1d;$d' >"$BATS_TEST_TMPDIR/commands"
    [ -s "$BATS_TEST_TMPDIR/commands" ]
}

# documented NAME: that block of the installed guide, run inside as it stands.
documented() {
    inside cat "/$GUIDE" >"$BATS_TEST_TMPDIR/guide"
    block "$1" "$BATS_TEST_TMPDIR/guide"
    (echo 'cd /root' && cat "$BATS_TEST_TMPDIR/commands") | inside bash -eu -o pipefail
}

result_inside() { inside curl -sS --fail --max-time 50 "http://127.0.0.1:8080/v1/drapes/$1/result?format=csv"; }

@test "deploy: backed up and restored as documented; a newer schema is refused" {
    start_machine
    install_package
    drape_inside $EXAMPLES/freeform.json >"$BATS_TEST_TMPDIR/result"
    kept=$(jq -r .id "$BATS_TEST_TMPDIR/result")
    result_inside "$kept" >"$BATS_TEST_TMPDIR/before"
    documented status | grep -x 'verdict  well'
    documented check | grep -x 'verdict  well'
    documented back-up
    drape_inside $EXAMPLES/sphere.json >"$BATS_TEST_TMPDIR/result"
    later=$(jq -r .id "$BATS_TEST_TMPDIR/result")

    # The database of a version to come: refused, and left as it is.
    inside systemctl stop draped
    inside sqlite3 /var/lib/private/draped/draped.db 'INSERT INTO schema_version VALUES (99, 0)'
    inside sqlite3 /var/lib/private/draped/draped.db .dump >"$BATS_TEST_TMPDIR/newer"
    not inside systemctl start draped
    inside journalctl --no-pager -o cat -u draped | grep -q 'has schema 99.*use a newer one'
    inside systemctl stop draped
    inside sqlite3 /var/lib/private/draped/draped.db .dump | cmp - "$BATS_TEST_TMPDIR/newer"

    documented restore
    wait_until 20 answers
    result_inside "$kept" | cmp - "$BATS_TEST_TMPDIR/before"
    not result_inside "$later"
    drape_inside $EXAMPLES/sphere.json >"$BATS_TEST_TMPDIR/result"
    inside journalctl --no-pager -o cat -u draped | not grep '"event":"store_error"'
}

@test "deploy: installed, and backed up and restored with PostgreSQL, as documented" {
    start_machine
    # The guide is that of the package which it installs.
    dpkg-deb -x "$DEB" "$BATS_TEST_TMPDIR/root"
    block install "$BATS_TEST_TMPDIR/root/$GUIDE"
    inside sh -c "cat >/root/$(basename "$DEB")" <"$DEB"
    (echo 'cd /root' && cat "$BATS_TEST_TMPDIR/commands") | inside bash -eu >"$BATS_TEST_TMPDIR/install" 2>&1 ||
        { cat "$BATS_TEST_TMPDIR/install"; false; }
    inside bash -eu -s <<'END' >"$BATS_TEST_TMPDIR/server" 2>&1 || { cat "$BATS_TEST_TMPDIR/server"; false; }
programs=$(ls -d /usr/lib/postgresql/*/bin | tail -1)
install -d -o postgres -g postgres /root/../srv/pg /run/pg
cd /srv/pg
as() { setpriv --reuid=postgres --regid=postgres --clear-groups "$@"; }
as "$programs/initdb" -D /srv/pg/data -U draped -A trust -E UTF8
as "$programs/pg_ctl" -D /srv/pg/data -w -l /srv/pg/log -o '-k /run/pg -c listen_addresses=127.0.0.1' start
as "$programs/createdb" -h 127.0.0.1 -U draped draped
install -m 600 /dev/null /etc/draped.env
echo DRAPED_STORE=postgresql://draped@127.0.0.1/draped >>/etc/draped.env
cat /etc/draped.env >>/etc/default/draped
systemctl restart draped
END
    wait_until 30 answers
    drape_inside $EXAMPLES/saddle.json >"$BATS_TEST_TMPDIR/result"
    kept=$(jq -r .id "$BATS_TEST_TMPDIR/result")
    result_inside "$kept" >"$BATS_TEST_TMPDIR/before"
    documented back-up-postgresql | grep -q '^backed up to .* 1 drapes, 1 results'
    drape_inside $EXAMPLES/sphere.json >"$BATS_TEST_TMPDIR/result"
    later=$(jq -r .id "$BATS_TEST_TMPDIR/result")
    inside systemctl stop draped
    documented restore-postgresql | grep -q '^the old store is kept as schema draped_before_'
    inside systemctl start draped
    wait_until 30 answers
    result_inside "$kept" | cmp - "$BATS_TEST_TMPDIR/before"
    not result_inside "$later"
}

@test "deploy: installed under systemd its socket starts it; it is upgraded and removed" {
    start_machine
    install_package
    drape_inside $EXAMPLES/sphere.json >"$BATS_TEST_TMPDIR/result"
    id=$(jq -r .id "$BATS_TEST_TMPDIR/result")
    inside systemctl stop draped
    inside systemctl start draped.socket
    not is_active
    [ "$(inside curl -sS --max-time 50 "http://127.0.0.1:8080/v1/drapes/$id" | jq -r .status)" = succeeded ]
    is_active
    inside systemctl stop draped.socket draped
    inside systemctl start draped
    # The same package again goes the way of an upgrade: the old one stops, the new one starts.
    before=$(main_process)
    install_package
    [ "$(main_process)" != "$before" ]
    [ "$(inside curl -sS "http://127.0.0.1:8080/v1/drapes/$id" | jq -r .status)" = succeeded ]
    # Settings of /etc/default are taken.
    echo DRAPED_QUEUE_LIMIT=77 | inside tee -a /etc/default/draped >"$BATS_TEST_TMPDIR/tee"
    inside systemctl restart draped
    wait_until 20 answers
    [ "$(inside curl -sS http://127.0.0.1:8080/v1/limits | jq .queue_limit)" = 77 ]
    # A setting that makes no sense is told once, without another try.
    echo DRAPED_WORKERS=none | inside tee -a /etc/default/draped >"$BATS_TEST_TMPDIR/tee"
    not inside systemctl restart draped
    [ "$(inside systemctl is-failed draped)" = failed ]
    inside journalctl --no-pager -o cat -u draped | grep -q "DRAPED_WORKERS: 'none' is not a number"
    [ "$(inside systemctl show -P NRestarts draped)" = 0 ]
    # Removed: programs gone, results of customers kept.
    inside dpkg -r draped >"$BATS_TEST_TMPDIR/dpkg" 2>&1
    not inside test -e /usr/bin/draped
    inside test -s /var/lib/private/draped/draped.db
}
