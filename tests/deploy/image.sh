#!/bin/bash
# SPDX-License-Identifier: MIT
# Builds the image of deploy/container with buildah, without a registry: Debian's base image is made
# from Debian's packages by mmdebstrap. Then runs it, as its own user. With FULL the first stage,
# which compiles all of it once more, is built as well; else its place take the packages of this tree.
# As root; needs a mirror of Debian. BASE: a base that was made before, as a tar. Usage: tests/deploy/image.sh BUILD
set -eu
cd "$(dirname "$0")/../.."
build=$(realpath "$1")
work=$(mktemp -d)
daemon=
number=0

store() { buildah --root "$work/storage" --runroot "$work/run" "$@"; }
stop() {
    [ -z "$daemon" ] || kill "$daemon" 2>/dev/null || true
    store rm --all >/dev/null 2>&1 || true
    umount -l "$work/storage/overlay" 2>/dev/null || true
    rm -rf "$work"
}
trap stop EXIT
ok() { number=$((number + 1)); echo "ok $number - image: $1"; }
inside() { store run --isolation chroot "$@"; }
# The daemon among the processes below one.
daemon_of() {
    local child
    for child in $(pgrep -P "$1"); do
        if [ "$(cat "/proc/$child/comm")" = draped ]; then echo "$child"; else daemon_of "$child"; fi
    done
}
refuses() { if "$@" >"$work/refused" 2>&1; then return 1; fi; }

[ -n "${BASE:-}" ] || mmdebstrap --quiet --variant=minbase bookworm "$work/base.tar" \
    "$(sed -n 's/^URIs: *//p; s/^deb \([^ ]*\) bookworm main.*/\1/p' \
        /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null | head -1)"
base=$(store from scratch)
store add -q "$base" "${BASE:-$work/base.tar}" / >/dev/null
store commit -q --rm "$base" "$(sed -n 's/^FROM //p' deploy/container/Containerfile | tail -1)" >/dev/null
ok "its base is made of Debian's packages"

stage=
if [ -z "${FULL:-}" ]; then
    make -s deb B="$build" >/dev/null
    mkdir "$work/stage"
    cp "$build"/deb/draped_*.deb "$work/stage/draped.deb"
    cp "$build"/deb/draped-import_*.deb "$work/stage/draped-import.deb"
    stage="--build-context=build=$work/stage"
fi
store build --quiet --isolation chroot --pull-never --layers=false $stage \
    -f deploy/container/Containerfile -t draped . >"$work/log" 2>&1 || { tail -30 "$work/log"; exit 1; }
ok "it is built"

image=$(store from --pull-never localhost/draped)
refuses inside "$image" -- draped
grep -q -- '--tokens, or --allow-anonymous' "$work/refused"
ok "as it is it listens beyond loopback, and so does not start without tokens"

inside --env DRAPED_LISTEN=127.0.0.1:0 "$image" -- draped >"$work/out" 2>"$work/err" &
until grep -qs listening "$work/out"; do
    kill -0 $! || { cat "$work/err"; exit 1; }
    sleep 0.05
done
url=$(sed -n 's/^draped listening on //p' "$work/out")
daemon=$(daemon_of $!)
[ "$(awk '$1 == "Uid:" {print $2}' "/proc/$daemon/status")" = 10001 ]
ok "it runs as user 10001"

status=$(curl -sS -o "$work/result" -w '%{http_code}' -H 'Content-Type: application/json' -H 'Prefer: wait=60' \
    --data-binary @api/examples/saddle.json "$url/v1/drapes")
[ "$status" = 200 ]
"$build/drape" api/examples/saddle.json 2>/dev/null >"$work/here"
jq -e -n --slurpfile a "$work/result" --slurpfile b "$work/here" '$a[0].nodes == $b[0].nodes' >/dev/null
ok "it drapes, with the same numbers as the command on this machine"

"$build/tests/import/make_parts" "$work" >/dev/null
status=$(curl -sS -o "$work/answer" -w '%{http_code}' -H 'Content-Type: model/step' \
    --data-binary @"$work/box.step" "$url/v1/surfaces")
[ "$status" = 201 ]
ok "it reads a STEP file"

inside --env "DRAPED_LISTEN=${url#http://}" "$image" -- draped --healthcheck
refuses inside --env DRAPED_LISTEN=127.0.0.1:1 "$image" -- draped --healthcheck
ok "its health check tells a daemon from none"

kill -TERM "$daemon"
until ! kill -0 "$daemon" 2>/dev/null; do sleep 0.05; done
daemon=
grep -q '"event":"stopped"' "$work/err"
ok "it ends in order"
echo "1..$number"
