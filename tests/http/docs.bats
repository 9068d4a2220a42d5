# SPDX-License-Identifier: MIT
# What the documentation shows is what happens: its commands are run, in a folder like the project's,
# and their output is compared with the block that follows them.
load helper

setup_file() { start_shared_daemon; }
teardown_file() { end_file; }

# blocks FILE: each pair of blocks to N.sh and N.expected.
blocks() {
    awk -v folder="$BATS_TEST_TMPDIR" '
        /^```/ && inside {inside = 0; next}
        /^```sh$/ {inside = 1; file = folder "/" ++n ".sh"; next}
        /^```./ {inside = 1; file = "/dev/null"; next}
        /^```$/ {inside = 1; file = folder "/" n ".expected"; next}
        inside {print >file}' "$1"
}

# shows FILE COUNT: runs the COUNT blocks of the file in a folder `project` and compares. The daemon
# that a document takes to be on port 8080 is the one of the test.
shows() {
    local project=$PWD n
    blocks "$1"
    mkdir -p "$BATS_TEST_TMPDIR/project/build"
    cd "$BATS_TEST_TMPDIR/project"
    ln -s "$project/api" api
    ln -s "$project/clients" clients
    ln -s "$project/$DRAPE" build/drape
    for ((n = 1; n <= $2; n++)); do
        sed -i "s|http://127.0.0.1:8080|$URL|" "../$n.sh"
        DRAPED_URL=$URL bash -eu -o pipefail "../$n.sh" >"../$n.said"
        [ -z "${DOCS_SHOW:-}" ] || { echo "# $n" >&3; sed 's/^/# /' "../$n.said" >&3; }
        diff "../$n.expected" "../$n.said"
    done
    [ ! -e "../$n.sh" ]
    cd "$project"
}

@test "docs: the question of studies.md has the answer that it shows" {
    shows docs/studies.md 4
}

@test "docs: the worked example of fields.md gives what it shows" {
    shows docs/fields.md 4
    (cd "$BATS_TEST_TMPDIR/project" &&
        "${PYTHON:-/usr/bin/python3}" "$OLDPWD/tests/readers/read.py" lcmsim case)
}

@test "docs: the dart of pieces.md does what it shows" {
    shows docs/pieces.md 1
}

@test "docs: the calls of the README give what it shows" {
    shows README.md 5
}
