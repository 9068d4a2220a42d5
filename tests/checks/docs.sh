#!/bin/bash
# SPDX-License-Identifier: MIT
# What the documents refer to is there: links, headings, paths and tests by their names, and documents
# that comments name; the table of settings is what the daemon prints, and the files of deploy/ are
# those of its settings and routes, the version is one. Usage: docs.sh BUILD
set -u
bad=0
for page in $(grep -rhoE --include='*.[ch]' --include='*.cc' --exclude-dir=node_modules \
    '[A-Za-z_./-]+\.md\b' solver api library cli import server tests | sort -u); do
    [ -e "$page" ] || { echo "a comment names $page, which is not there"; bad=1; }
done
python3 tests/checks/references.py README.md CONTRIBUTING.md docs/*.md api/examples/*.md benchmark/README.md || bad=1
if ! diff docs/settings.md <("${1:-build}/draped" --help | awk -f docs/settings.awk); then
    echo 'docs/settings.md differs from --help: make golden writes it'
    bad=1
fi
if ! deploy/render.py "${1:-build}/draped" --check; then
    echo 'files of deploy/ are not what follows from settings and routes: make golden writes them'
    bad=1
fi
deploy/version.py --check || bad=1
exit $bad
