# SPDX-License-Identifier: MIT
# For the tests of deploy/: what those of the daemon have (tests/http/helper.bash), and this.
load ../http/helper

free_port() {
    python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'
}

# The whole copies that draped backup has made in $COPIES.
copies() { ls "$COPIES" | grep -E '^draped-[0-9]{8}T[0-9]{6}\.[0-9]{3}Z\.backup$'; }

# drape FACTOR: sets id, and the result in $BATS_TEST_TMPDIR/FACTOR.
drape() {
    quick "$1" | post /v1/drapes - -H 'Prefer: wait=40'
    expect 200
    id=$(field .id)
    result "$id"
    cp "$body" "$BATS_TEST_TMPDIR/$1"
}
result() {
    call GET "/v1/drapes/$1/result?format=csv"
    expect 200
}
