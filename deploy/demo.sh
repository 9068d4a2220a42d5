#!/bin/bash
# SPDX-License-Identifier: MIT
# Starts the daemon on a free port, drapes the examples over HTTP with curl, prints what came back
# against the exact answers, and stops the daemon. Usage: deploy/demo.sh BUILD
set -eu
cd "$(dirname "$0")/.."
build=$1 out=$1/demo daemon=

stop() {
    [ -z "$daemon" ] || { kill "$daemon" && wait "$daemon"; } 2>/dev/null || true
    daemon=
}
trap stop EXIT
rm -rf "$out"
mkdir -p "$out"

"$build/draped" --listen 127.0.0.1:0 --data "$out/data" >"$out/stdout" 2>"$out/log" &
daemon=$!
url=
for _ in $(seq 100); do
    url=$(sed -n 's/^draped listening on //p' "$out/stdout")
    [ -z "$url" ] || break
    kill -0 "$daemon" 2>/dev/null || break
    sleep 0.1
done
[ -n "$url" ] || {
    echo "the daemon did not start:" >&2
    cat "$out/log" >&2
    exit 1
}
echo "draped runs at $url"

# post PATH TYPE FILE OUTPUT
post() {
    curl --silent --show-error --fail-with-body --max-time 60 --output "$4" \
        --header "Content-Type: $2" --header 'Prefer: wait=60' --data-binary "@$3" "$url$1" ||
        { cat "$4" >&2; exit 1; }
}

# The request for the tool side of the STEP file: all that is smooth from its spherical face.
dome_request() {
    post /v1/surfaces model/step api/examples/dome.step "$out/dome-surface.json"
    jq '{surface: {id, grow_from: 6, up_to_deg: 20}, fabric: {spacing: 4}}' \
        "$out/dome-surface.json" >"$out/dome-request.json"
}

# drape NAME REQUEST: posts the request and waits for the result.
drape() {
    post /v1/drapes application/json "$2" "$out/$1.json"
    local id
    id=$(jq --raw-output .id "$out/$1.json")
    curl --silent --show-error --fail --max-time 60 --output "$out/$1-cells.csv" \
        "$url/v1/drapes/$id/result?format=csv&table=cells"
}

# Largest difference to the exact shear angle of z = (x^2 - y^2) / 2 at the nodes.
saddle_error() {
    jq --raw-output '[.nodes | [.x, .y, .shear_deg] | transpose[] |
        . as [$x, $y, $shear] | ($x * $x + 1) * ($y * $y + 1) |
        (-$x * $y / sqrt | asin * 45 / (1 | atan) - $shear) | fabs] | max' "$1"
}

# The same on a sphere: z w'"' + w' = -sin w, w(0) = 90 deg, z = s t / R^2, by classical Runge-Kutta
# from the series w = pi/2 - z at 0.
sphere_error() {
    jq --raw-output --argjson radius 48 '.grid.spacing as [$a, $b] | .nodes |
        [.i, .j, .shear_deg] | transpose[] |
        "\(.[0] * $a * .[1] * $b / $radius / $radius) \(.[2])"' "$1" | sort -g | awk '
        function slope(z, w, p) { return z == 0 ? 0 : (-sin(w) - p) / z }
        function step(h,   k1, k2, k3, l1, l2, l3, l4) {
            l1 = slope(z, w, p); k1 = p + h / 2 * l1
            l2 = slope(z + h / 2, w + h / 2 * p, k1); k2 = p + h / 2 * l2
            l3 = slope(z + h / 2, w + h / 2 * k1, k2); k3 = p + h * l3
            l4 = slope(z + h, w + h * k2, k3)
            w += h / 6 * (p + 2 * k1 + 2 * k2 + k3); p += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4)
            z += h
        }
        BEGIN { pi = atan2(0, -1) }
        { to = $1 < 0 ? -$1 : $1; shear[NR] = $1 < 0 ? -$2 : $2; at[NR] = to }
        END {
            for (k = 1; k <= NR; k++) {
                z = at[k] < 1e-3 ? at[k] : 1e-3; w = pi / 2 - z + z ^ 3 / 18; p = -1 + z ^ 2 / 6
                for (n = 0; n < 200 && at[k] > z; n++) { left = at[k] - z; step(left / (200 - n)) }
                e = 90 - w * 180 / pi - shear[k]; e = e < 0 ? -e : e
                if (e > worst) worst = e
            }
            print worst
        }'
}

row() { printf '%-10s %7s %9s %11s %9s   %s\n' "$@"; }

row surface nodes coverage 'max shear' 'solve ms' 'against the exact answer'
for name in saddle sphere freeform dome; do
    request=api/examples/$name.json
    [ "$name" != dome ] || { dome_request; request=$out/dome-request.json; }
    drape "$name" "$request"
    case $name in
    saddle) exact=$(printf 'shear within %.4f deg' "$(saddle_error "$out/saddle.json")") ;;
    sphere) exact=$(printf 'shear within %.4f deg' "$(sphere_error "$out/sphere.json")") ;;
    dome) exact='no closed form: 3 of 9 faces of a STEP file' ;;
    *) exact='no closed form' ;;
    esac
    row "$name" $(jq --raw-output '.summary | .nodes, (.coverage * 10000 | round / 10000),
        (.max_shear_deg * 1000 | round / 1000), (.timing_ms.solve * 100 | round / 100)' \
        "$out/$name.json") "$exact"
done
stop
cat <<END

The results are in $out: NAME.json, and NAME-cells.csv for a spreadsheet. For example:
  jq .summary $out/saddle.json
  jq -c '[.front | .i, .j, .reason] | transpose[]' $out/freeform.json | head
Start it yourself with $build/draped and look at http://127.0.0.1:8080/
END
