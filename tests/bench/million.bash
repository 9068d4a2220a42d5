# SPDX-License-Identifier: MIT
# For the benches of results: a daemon with one worker and a drape of a million nodes.

# start_million BUILD FILTER: the saddle with so fine a net that it has a million nodes, changed by
# jq's FILTER besides. Sets work (a folder), daemon (the process), url and id; all ends with the shell.
start_million() {
    local status=queued
    work=$(mktemp -d)
    "$1/draped" --listen 127.0.0.1:0 --data "$work/data" --workers 1 >"$work/out" 2>"$work/log" &
    daemon=$!
    trap 'kill "$daemon"; wait "$daemon" || true; rm -rf "$work"' EXIT
    until grep -q listening "$work/out"; do sleep 0.1; done
    url=$(sed -n 's/^draped listening on //p' "$work/out")
    id=$(jq -c ".fabric.spacing = 0.0059 | $2" api/examples/saddle.json |
        curl -sS -H 'Content-Type: application/json' --data-binary @- "$url/v1/drapes" | jq -r .id)
    while [ "$status" = queued ] || [ "$status" = running ]; do
        status=$(curl -sS "$url/v1/drapes/$id?wait=60" | jq -r .status)
    done
    curl -sS "$url/v1/drapes/$id" | jq -r '"\(.summary.nodes) nodes, \(.summary.cells) cells"'
}
