# SPDX-License-Identifier: MIT
# The net of z = (x^2 - y^2) / 2 from its middle: sin shear = -x y / sqrt((1 + x^2) (1 + y^2)), where
# s = (x sqrt(1 + x^2) + asinh x) / 2 along warp, and alike y along weft.
#
# awk -v mode=diagonal -v end=X: prints x and the absolute shear in degrees along the diagonal.
# awk -v mode=error -v d=SPACING -v count=N: reads i,j,shear_deg; prints the largest error of the
#     shear among the nodes with |i|, |j| <= N.
function asin(x) { return atan2(x, sqrt(1 - x * x)) }
function shear(x, y) { return -asin(x * y / sqrt((1 + x * x) * (1 + y * y))) * 180 / pi }
# x of arc length s, by Newton.
function place(s,   x, root, n) {
    x = s
    for (n = 0; n < 50; n++) {
        root = sqrt(1 + x * x)
        x -= ((x * root + (x < 0 ? -log(root - x) : log(x + root))) / 2 - s) / root
    }
    return x
}
BEGIN {
    FS = "[, ]"; pi = atan2(0, -1)
    if (mode == "diagonal") {
        for (n = 0; n <= 100; n++) printf "%.12g %.12g\n", end * n / 100, -shear(end * n / 100, end * n / 100)
        exit
    }
    for (n = -count; n <= count; n++) at[n] = place(n * d)
}
$1 ~ /^-?[0-9]/ && ($1 in at) && ($2 in at) {
    e = shear(at[$1 + 0], at[$2 + 0]) - $3; e = e < 0 ? -e : e
    if (e > worst) worst = e
}
END { if (mode == "error") printf "%.6g\n", worst }
