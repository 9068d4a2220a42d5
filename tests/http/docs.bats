# SPDX-License-Identifier: MIT
# What the documentation shows is what happens: its commands are run, in a folder like the project's,
# and their output is compared with the block that follows them.
load helper

setup_file() { start_shared_daemon; }
teardown_file() { stop_daemon; }

# blocks FILE: each pair of blocks to N.sh and N.expected.
blocks() {
    awk -v folder="$BATS_TEST_TMPDIR" '
        /^```/ && inside {inside = 0; next}
        /^```sh$/ {inside = 1; file = folder "/" ++n ".sh"; next}
        /^```$/ {inside = 1; file = folder "/" n ".expected"; next}
        inside {print >file}' "$1"
}

@test "docs: the worked example of fields.md gives what it shows" {
    blocks docs/fields.md
    local project=$PWD
    mkdir "$BATS_TEST_TMPDIR/project"
    cd "$BATS_TEST_TMPDIR/project"
    ln -s "$project/api" api
    mkdir build
    ln -s "$project/$DRAPE" build/drape
    for n in 1 2 3 4; do
        DRAPED_URL=$URL bash -eu -o pipefail "../$n.sh" >"../$n.said"
        [ -z "${DOCS_SHOW:-}" ] || { echo "# $n" >&3; sed 's/^/# /' "../$n.said" >&3; }
        diff "../$n.expected" "../$n.said"
    done
    [ ! -e ../5.sh ]
    "${PYTHON:-/usr/bin/python3}" "$project/tests/readers/read.py" lcmsim case
}
