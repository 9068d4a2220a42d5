#!/bin/bash
# SPDX-License-Identifier: MIT
# Makes what is released of the commit that is checked out, in BUILD/release: the source, the Debian
# packages, the bill of materials and the checksums of all. Everything is built from the source
# archive, twice, in folders and at times of their own: where a byte differs nothing is kept.
# Usage: deploy/release.sh BUILD VERSION
set -eu -o pipefail
cd "$(dirname "$0")/.."
[ -z "$(git status --porcelain)" ] || { echo 'the tree has changes: commit them first' >&2; exit 1; }
out=$1/release name=draped-$2
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export SOURCE_DATE_EPOCH
rm -rf "$out"
mkdir -p "$out"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
git archive --format=tar --prefix="$name/" HEAD | gzip -9n >"$work/$name.tar.gz"

# build FOLDER: of the source archive, into FOLDER/made.
build() {
    mkdir -p "$work/$1/made"
    tar -xzf "$work/$name.tar.gz" -C "$work/$1"
    # what debuggers read, and the build-id follows from, has no folder
    make -s -C "$work/$1/$name" DEBUG="-g -ffile-prefix-map=$work/$1/$name=." deb \
        >"$work/$1/log" 2>&1 || { tail -30 "$work/$1/log" >&2; return 1; }
    cp "$work/$1/$name"/build/deb/*.deb "$work/$1/$name/build/draped.cdx.json" "$work/$1/made"
}
echo "building $name"
build one
echo "building it again, to compare"
build the-other
diff -rq "$work/one/made" "$work/the-other/made" >&2 ||
    { echo 'two builds of the same source differ: nothing is kept' >&2; exit 1; }
cp "$work/$name.tar.gz" "$work/one/made"/* "$out"
(cd "$out" && sha256sum -- * >"$work/sums" && mv "$work/sums" SHA256SUMS && ls -l)
