#!/bin/bash
# SPDX-License-Identifier: MIT
# Draws docs/figures/*.svg from the program's own results, and prints what they show. Exact curves are
# computed here by awk, apart from the program. Usage: tests/figures/figures.sh BUILD
set -eu
cd "$(dirname "$0")/../.."
build=$1 drape=$1/drape here=tests/figures data=$1/figures out=docs/figures
methods=${METHODS:-basic mosaic geodesic gib gib4}
rm -rf "$data"
mkdir -p "$data" "$out"

# gnuplot is for the figures alone, so deploy/setup.sh leaves it out.
if ! command -v gnuplot >/dev/null; then
    root=
    [ "$(id -u)" -eq 0 ] || root=sudo
    echo 'installing: gnuplot-nox' >&2
    { $root apt-get update && $root env DEBIAN_FRONTEND=noninteractive \
        apt-get install --yes --no-install-recommends gnuplot-nox; } >"$data/apt.log" 2>&1 ||
        { cat "$data/apt.log" >&2; exit 1; }
fi

# plot NAME VARIABLE=VALUE...: draws out/NAME.svg by NAME.gp.
plot() {
    local name=$1 set="data = '$data'; methods = '$methods'; out = '$data/$1.svg'" pair
    shift
    for pair; do set="$set; ${pair%%=*} = '${pair#*=}'"; done
    gnuplot -e "$set" "$here/$name.gp"
    awk -f "$here/compact.awk" "$data/$name.svg" >"$out/$name.svg"
}

# nodes REQUEST METHOD SPACING: the nodes i, j, x, y, z, shear.
nodes() {
    jq --arg method "$2" --argjson d "$3" '.method = $method | .fabric.spacing = $d' "$1" |
        "$drape" --format csv --fields nodes.i,nodes.j,nodes.x,nodes.y,nodes.z,nodes.shear_deg |
        sed 1d
}

# worst FILE...: for each the largest of its third column, behind its method.
worst() {
    local method
    for method in $methods; do
        awk -v method="$method" '$3 > most { most = $3 } END { printf " %s %.2g", method, most }' \
            "$data/$1-$method.dat"
    done
}

# An octant of the sphere and a little more, by stereographic projection from its other pole:
# r = R (2a, 2b, 1 - a^2 - b^2) / (1 + a^2 + b^2) for a, b in [0, c]. The start is the pole, the
# generators go along two meridians, as in the paper's figure 7.
octant() {
    jq --null-input --argjson radius 100 --argjson c 0.75 '
        [0, $c / 2, $c] as $a | [0, 0, $c * $c] as $square |
        [range(3) as $i | range(3) as $j | (1 + $square[$i] + $square[$j]) as $w |
            { $w, p: [2 * $a[$i], 2 * $a[$j], 2 - $w] | map(. * $radius / $w) }] as $points |
        { surface: { degree_u: 2, degree_v: 2, size_u: 3, size_v: 3,
                     knotvector_u: [0, 0, 0, 1, 1, 1], knotvector_v: [0, 0, 0, 1, 1, 1],
                     control_points: { points: [$points[].p], weights: [$points[].w] } },
          length_unit: "mm", start: { uv: [0, 0] }, direction: { angle_deg: 0 },
          fabric: { spacing: 1, thickness: 0.3, fiber_volume_fraction: 0.5,
                    locking_angle_deg: 40 } }'
}

figure_sphere() {
    local method radius=100 d=8
    octant >"$data/octant.json"
    awk -v mode=diagonal -v end=92 -f $here/sphere_exact.awk >"$data/sphere-exact.dat"
    for method in $methods; do
        # Polar angle, shear, and its error against the curve at that angle.
        nodes "$data/octant.json" "$method" "$d" | awk -F, -v radius=$radius '
            BEGIN { degree = atan2(0, -1) / 180 }
            $1 == $2 && $1 > 0 { print atan2(sqrt($3 ^ 2 + $4 ^ 2), $5) / degree, $6 }' |
            awk -f $here/interpolate.awk "$data/sphere-exact.dat" - >"$data/sphere-$method.dat"
    done
    plot sphere "spacing=$(jq -n "$d / $radius")"
    echo "sphere.svg: largest error on the diagonal, degrees:$(worst sphere)"
}

figure_saddle() {
    local method d=0.2
    awk -v mode=diagonal -v end=2 -f $here/saddle_exact.awk >"$data/saddle-exact.dat"
    for method in $methods; do
        nodes api/examples/saddle.json "$method" "$d" |
            awk -F, '$1 == $2 && $1 > 0 { print $3, -$6 }' |
            awk -f $here/interpolate.awk "$data/saddle-exact.dat" - >"$data/saddle-$method.dat"
    done
    plot saddle "spacing=$d"
    echo "saddle.svg: largest error on the diagonal, degrees:$(worst saddle)"
}

# A hat profile whose fillets are smaller than the spacing, and the estimates on the saddle against
# its errors, measured by a net four times as fine.
figure_small_radii() {
    local method d finer fields=nodes.i,nodes.j,nodes.x,nodes.y,nodes.z,nodes.error_estimate line=
    for method in basic gib; do
        nodes "$here/hat.json" $method 5 | awk -F, '{ print $3, $6 }' >"$data/small_radii-$method.dat"
        line="$line $method $(awk '{ a = $2 < 0 ? -$2 : $2; if (a > most) most = a }
            END { printf "%.2g", most }' "$data/small_radii-$method.dat")"
    done
    for d in 0.1 0.05 0.025; do
        for finer in 1 4; do
            jq --argjson d "$(jq -n "$d / $finer")" '.method = "gib4" | .fabric.spacing = $d |
                .direction = { angle_deg: 30 }' api/examples/saddle.json |
                "$drape" --format csv --fields $fields --precision 17 | sed 1d >"$data/estimate-$finer.csv"
        done
        awk -F, '
            NR == FNR { at = 4 * $1 " " 4 * $2; x[at] = $3; y[at] = $4; z[at] = $5; e[at] = $6; next }
            { at = $1 " " $2 }
            at in x { dx = $3 - x[at]; dy = $4 - y[at]; dz = $5 - z[at]
                      print sqrt(dx ^ 2 + dy ^ 2 + dz ^ 2), e[at] }' \
            "$data/estimate-1.csv" "$data/estimate-4.csv" >"$data/small_radii-estimate-$d.dat"
        line="$line; d = $d: $(awk '{ n++; held += $1 <= $2 + 1e-12 }
            END { printf "%.4f of %d contained", held / n, n }' "$data/small_radii-estimate-$d.dat")"
    done
    plot small_radii spacing=5
    echo "small_radii.svg: largest shear, degrees:$line"
}

# What the test of estimates measures on all its surfaces, one node in 1,800.
figure_containment() {
    local nodes=$data/estimates.dat held
    LONG=1 DRAPED_ESTIMATES=$nodes "$build/tests/exact/test_exact_estimates" >"$data/estimates.log"
    for kind in random awkward grown; do
        awk -v kind=$kind -F '"' '
            { split($3, at, " "); is = at[3] + 0 ? "grown" : $2 == "random" ? "random" : "awkward" }
            is == kind && at[1] > 1e-9 && ++n % (kind == "grown" ? 100 : 1800) == 0 { print at[1], at[2] }' \
            "$nodes" >"$data/containment-$kind.dat"
    done
    held=$(awk '{ n++; held += $(NF - 2) <= $(NF - 1) + 1e-9 } END { printf "%.4f of %d", held / n, n }' "$nodes")
    plot containment
    echo "containment.svg: errors contained at $held nodes"
}

# The shortest of five runs, which go round all methods in turn, so that a busy spell of the machine
# meets them alike; a method that has once taken longer than `patience` goes no finer.
figure_time() {
    local method d run tics raw=$data/time.dat line= patience=2000
    : >"$raw"
    for run in 1 2 3 4 5; do
        for d in 10 5 2.5 1.25 0.625; do
            for method in $methods; do
                awk -v method="$method" -v d=$d -v patience=$patience '
                    $1 == method && $3 > patience && $2 >= d { exit 1 }' "$raw" || continue
                jq --arg method "$method" --argjson d "$d" \
                    '.method = $method | .fabric.spacing = $d' api/examples/freeform.json |
                    "$drape" --fields nodes.i |
                    jq --raw-output '.summary | "\(.timing_ms.solve) \(.nodes)"' |
                    sed "s/^/$method $d /" >>"$raw"
            done
        done
    done
    for method in $methods; do
        grep "^$method " "$raw" | sort --key 2,2gr --key 3,3g | awk '!seen[$2]++ { print $2, $3, $4 }' \
            >"$data/time-$method.dat"
        line="$line $(tail -n 1 "$data/time-$method.dat" |
            awk -v method="$method" '{ printf "%s %.3g us", method, $2 / $3 * 1000 }'),"
    done
    tics=$(awk '{ printf "%s\"%d\" %s", NR == 1 ? "" : ", ", $3, $1 }' "$data/time-${methods%% *}.dat")
    plot time "tics=$tics"
    echo "time.svg: for a node at the finest spacing:${line%,}"
}

# errors SURFACE REQUEST SIDE COARSEST..: largest error for each method and number of cells a side.
errors() {
    local surface=$1 request=$2 side=$3 method n d line=
    shift 3
    for method in $methods; do
        for n; do
            [ "$method" != mosaic ] || [ "$n" -le 32 ] || continue
            d=$(jq -n "$side / $n")
            # No further than the difference stencils need, which then are all centred.
            jq --argjson n "$n" '.extent = { warp: [-$n - 4, $n + 4], weft: [-$n - 4, $n + 4] }' \
                "$request" >"$data/part.json"
            nodes "$data/part.json" "$method" "$d" | awk -F, '{ print $1, $2, $6 }' |
                awk -v mode=error -v radius=48 -v d="$d" -v count="$n" -f "$here/${surface}_exact.awk" |
                sed "s:^:$(jq -n "1 / $n") :" >>"$data/error-$surface-$method.dat"
        done
        line="$line $method $(awk '{ h = $1; e = $2; if (NR > 1) o = log(e0 / e) / log(h0 / h)
            h0 = h; e0 = e } END { printf "%.1e order %.2f,", e, o }' "$data/error-$surface-$method.dat")"
    done
    echo "error.svg, $surface: at the finest spacing:${line%,}"
}

# guide METHOD FACTOR: where the guiding lines pass d/L = 1/16, a factor off the method's errors.
guide() {
    local surface
    for surface in sphere saddle; do
        awk -v factor="$2" '$1 == 0.0625 { print $2 * factor }' "$data/error-$surface-$1.dat"
    done | xargs
}

figure_error() {
    errors sphere api/examples/sphere.json 28.8 4 8 16 32 64 128
    errors saddle api/examples/saddle.json 1.2 4 8 16 32 64 128
    plot error "guide2=$(guide basic 3)" "guide4=$(guide gib4 0.3)"
}

# A cell is four corners in two scans, apart from all others.
figure_freeform() {
    local d=10
    nodes api/examples/freeform.json gib4 "$d" >"$data/freeform-nodes.csv"
    jq --argjson d "$d" '.method = "gib4" | .fabric.spacing = $d' api/examples/freeform.json |
        "$drape" --format csv --table cells --fields cells.i,cells.j,cells.shear_deg | sed 1d |
        awk -F, '
            FNR == NR { place[$1, $2] = sprintf("%.1f %.1f %.1f", $3, $4, $5); next }
            { i = $1; j = $2
              print place[i, j], $3; print place[i + 1, j], $3; print ""
              print place[i, j + 1], $3; print place[i + 1, j + 1], $3; print ""; print "" }' \
            "$data/freeform-nodes.csv" - >"$data/freeform-cells.dat"
    plot freeform "spacing=$d"
    awk 'NF == 4 { if ($4 < low) low = $4; if ($4 > high) high = $4; n++ }
        END { printf "freeform.svg: %d cells, shear from %.2f to %.2f degrees\n", n / 4, low, high }' \
        "$data/freeform-cells.dat"
}

# The pattern of the corner with a dart.
figure_dart() {
    jq '.cuts = [{path: [[0, 0, -60], [0, 0, 0]], name: "edge", allowance: 4}]' api/examples/corner.json |
        "$drape" --format svg --allowance 8 --part 'Corner of a box' 2>/dev/null >"$out/dart.svg"
}

figure_study() {
    "$here/study.py" "$drape" "$out/best_start.svg"
}

figure_sliding() {
    "$here/sliding.py" "$drape" "$out/sliding.svg"
}

for figure in ${FIGURES:-sphere saddle error time freeform small_radii containment study dart sliding}; do figure_$figure; done

# They are read in a browser beside the README, and every change of them stays in the history.
find "$out" -name '*.svg' -size +60000c | sed 's/$/ is larger than 60 kB/' | { ! grep .; }
