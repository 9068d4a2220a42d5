#!/bin/bash
# SPDX-License-Identifier: MIT
# Makes the Debian packages of this tree in BUILD/deb, and says where they are. They have what BUILD
# was made of and the tests have run: the Makefile has all of Debian's hardening, and -O3, which the
# solver needs. `dpkg-buildpackage` alone compiles with Debian's flags.
# Usage: deploy/deb.sh BUILD VERSION
set -eu
cd "$(dirname "$0")/.."
build=$(realpath "$1") out=$(realpath -m "$1/deb") tree=$1/deb/draped-$2
rm -rf "$tree" "$out"/*.deb
mkdir -p "$tree"
cp -a Makefile LICENSE README.md api library cli docs import server solver deploy "$tree"
install -D -m 644 -t "$tree/tests" tests/tests.mk
for lock in tests/*/package-lock.json; do # for the bill of materials
    install -D -m 644 "$lock" "$tree/$lock"
done
mv "$tree/deploy/debian" "$tree/debian"
deploy/version.py --debian >"$tree/debian/changelog"
(cd "$tree" && OBJECTS=$build dpkg-buildpackage --build=binary --no-pre-clean -us -uc) \
    >"$out/log" 2>&1 || { cat "$out/log" >&2; exit 1; }
ls "$out"/{draped,draped-import,libdrape1,libdrape-dev}_"${2/-rc/~rc}"_*.deb
