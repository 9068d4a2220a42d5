#!/bin/bash
# SPDX-License-Identifier: MIT
# Takes the pictures of the page that README and docs show, from the page as it is, by the browser's own
# tests. Usage: tests/figures/page.sh BUILD
set -eu
cd "$(dirname "$0")/../.."
export BUILD=$1
shots=$1/tests/browser
rm -f "$shots"/readme*.png "$shots"/docs_*.png
for file in page part study cuts pieces steering; do
    node --test --test-name-pattern='the picture of the (README|docs)' "tests/browser/$file.test.mjs" \
        >"$shots/$file.log" 2>&1 || { cat "$shots/$file.log" >&2; exit 1; }
done
cp "$shots/readme.png" server/viewer/screenshot.png
cp "$shots/readme_part.png" docs/figures/part.png
cp "$shots/docs_study.png" docs/figures/study.png
for name in cuts pieces courses steering; do cp "$shots/docs_$name.png" "docs/figures/$name.png"; done
