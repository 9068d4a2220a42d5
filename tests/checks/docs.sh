#!/bin/bash
# SPDX-License-Identifier: MIT
# What the documents refer to is there: links, headings, paths and tests by their names, and documents
# that comments name; and the table of settings is what the daemon prints. Usage: docs.sh BUILD
set -u
bad=0
for page in $(grep -rhoE --include='*.[ch]' --include='*.cc' --exclude-dir=node_modules \
    '[A-Za-z_./-]+\.md\b' solver api cli server tests | sort -u); do
    [ -e "$page" ] || { echo "a comment names $page, which is not there"; bad=1; }
done
python3 tests/checks/references.py README.md CONTRIBUTING.md docs/*.md api/examples/*.md || bad=1
if ! diff docs/settings.md <("${1:-build}/draped" --help | awk -f docs/settings.awk); then
    echo 'docs/settings.md differs from --help: make golden writes it'
    bad=1
fi
exit $bad
