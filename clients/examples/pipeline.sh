#!/bin/bash
# SPDX-License-Identifier: MIT
# The whole way with curl and jq alone: submit a drape, wait for it, look at its summary, save the
# net for ParaView, a picture for a browser and the cut pattern.
# Usage: pipeline.sh REQUEST.json FOLDER          (the service: DRAPED_URL)
set -euo pipefail
request=$1 folder=$2
url=${DRAPED_URL:-http://127.0.0.1:8080}

# call PATH [CURL OPTION...]: the answer on standard output; the service's own words when it fails.
call() {
    local path=$1 status answer
    shift
    answer=$(mktemp)
    status=$(curl -sS --compressed -o "$answer" -w '%{http_code}' "$@" "$url$path")
    if [ "$status" -ge 400 ]; then
        jq -r '"\(.title): \(.detail)", (.errors[]? | "  \(.pointer): \(.detail)")' "$answer" >&2
        rm -f "$answer"
        return 1
    fi
    cat "$answer"
    rm -f "$answer"
}

id=$(call /v1/drapes -H 'Content-Type: application/json' --data-binary "@$request" | jq -r .id)

# The answer is held until the drape ends, or a minute has passed.
while :; do
    status=$(call "/v1/drapes/$id?wait=60")
    case $(jq -r .status <<<"$status") in
    queued | running) ;;
    succeeded) break ;;
    *)
        jq -r '.error.detail // .status' <<<"$status" >&2
        exit 1
        ;;
    esac
done
jq -r '.summary | "\(.outcome): \(.nodes) nodes, shear up to \(.max_shear_deg * 100 | round / 100) deg, \(
    .locked_cells) cells beyond the locking angle"' <<<"$status"

mkdir -p "$folder"
call "/v1/drapes/$id/result?format=vtp" >"$folder/net.vtp"
call "/v1/drapes/$id/result?format=glb" >"$folder/net.glb"
call "/v1/drapes/$id/result?format=csv&table=cells&precision=6" >"$folder/cells.csv"
call "/v1/drapes/$id/pattern?format=svg" >"$folder/pattern.svg"

# The ten most sheared cells, straight from the columns.
call "/v1/drapes/$id/result?fields=cells.i,cells.j,cells.shear_deg&precision=4" |
    jq -r '.cells | [.i, .j, .shear_deg] | transpose | sort_by(-(.[2] | fabs)) | .[:10][] | @tsv'
