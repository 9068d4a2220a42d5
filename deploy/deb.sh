#!/bin/bash
# SPDX-License-Identifier: MIT
# Makes the Debian packages of this tree in BUILD/deb, and says where they are. They are compiled with
# Debian's hardening in a folder of its own, which a second run finds again.
# Usage: deploy/deb.sh BUILD VERSION
set -eu
cd "$(dirname "$0")/.."
out=$(realpath -m "$1/deb") tree=$1/deb/draped-$2
rm -rf "$tree" "$out"/*.deb
mkdir -p "$tree" "$out/obj"
cp -a Makefile LICENSE README.md api cli docs server solver deploy "$tree"
install -D -m 644 -t "$tree/tests" tests/tests.mk
for lock in tests/*/package-lock.json; do # for the bill of materials
    install -D -m 644 "$lock" "$tree/$lock"
done
mv "$tree/deploy/debian" "$tree/debian"
(cd "$tree" && OBJECTS=$out/obj dpkg-buildpackage --build=binary --no-pre-clean -us -uc) \
    >"$out/log" 2>&1 || { cat "$out/log" >&2; exit 1; }
ls "$out"/draped_"$2"_*.deb "$out"/draped-import_"$2"_*.deb
