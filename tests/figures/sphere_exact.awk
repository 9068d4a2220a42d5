# SPDX-License-Identifier: MIT
# The net of a sphere with two geodesic generators at right angles: its yarn angle w depends on
# z = s t / R^2 alone, z w'' + w' = -sin w, w(0) = 90 deg, by classical Runge-Kutta from its series
# at 0. On the diagonal s = t the net goes along a great circle, and the polar
# angle there is the integral of 2 cos(w / 2) / R ds.
#
# awk -v mode=diagonal -v end=DEGREES: prints polar angle and shear along the diagonal, in degrees.
# awk -v mode=error -v radius=R -v d=SPACING -v count=N: reads i,j,shear_deg; prints the largest
#     error of the shear among the nodes with |i|, |j| <= N.
# awk -v mode=along: reads z in any order; prints z and the shear in degrees.
function slope(z, w, p) { return z == 0 ? 0 : (-sin(w) - p) / z }
function step(h,   k1, k2, k3, l1, l2, l3, l4) {
    l1 = slope(z, w, p); k1 = p + h / 2 * l1
    l2 = slope(z + h / 2, w + h / 2 * p, k1); k2 = p + h / 2 * l2
    l3 = slope(z + h / 2, w + h / 2 * k1, k2); k3 = p + h * l3
    l4 = slope(z + h, w + h * k2, k3)
    w += h / 6 * (p + 2 * k1 + 2 * k2 + k3); p += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4)
    z += h
}
# w = pi/2 - z + z^3/18 - 7 z^5/1800 + 521 z^7/1587600 - ..: to rounding up to `first`.
function restart(at) {
    z = at < first ? at : first
    w = pi / 2 - z + z ^ 3 / 18 - 7 * z ^ 5 / 1800 + 521 * z ^ 7 / 1587600
    p = -1 + z ^ 2 / 6 - 7 * z ^ 4 / 360 + 521 * z ^ 6 / 226800
}
function go(to,   n, left) {
    if (to > z) {
        n = int((to - z) / 0.002) + 1
        for (left = (to - z) / n; n > 0; n--) step(left)
    }
}
# Shear in degrees at z; the last one is where the next starts, if it lies beyond.
function shear(at) {
    if (at < z || z < first) restart(at)
    go(at)
    return 90 - w * 180 / pi
}
function diagonal(end,   s, h, phi, before, middle, gamma) {
    h = 0.01
    print 0, 0
    before = 2 * cos(pi / 4)
    for (s = 0; phi < end * pi / 180; s += h) {
        shear((s + h / 2) ^ 2); middle = 2 * cos(w / 2)
        gamma = shear((s + h) ^ 2)
        phi += h / 6 * (before + 4 * middle + 2 * cos(w / 2))
        before = 2 * cos(w / 2)
        printf "%.12g %.12g\n", phi * 180 / pi, gamma
    }
}
BEGIN {
    FS = "[, ]"; pi = atan2(0, -1); first = 0.02; z = 0
    if (mode == "diagonal") { diagonal(end); exit }
}
mode == "error" && $1 ~ /^-?[0-9]/ && $1 * $1 <= count * count && $2 * $2 <= count * count {
    at = $1 * $2 * d * d / radius / radius
    sign = at < 0 ? -1 : 1
    key = $1 * $2 * sign
    if (!(key in exact)) exact[key] = shear(at * sign)
    e = sign * exact[key] - $3; e = e < 0 ? -e : e
    if (e > worst) worst = e
}
mode == "along" { printf "%s %.12g\n", $1, shear($1) }
END { if (mode == "error") printf "%.6g\n", worst }
