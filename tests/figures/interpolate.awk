# SPDX-License-Identifier: MIT
# awk -f interpolate.awk CURVE -: for every line "x y" its absolute distance from the curve at x, as
# a third column. The curve is a table with increasing x, read between by cubics through four points.
FNR == NR { x[NR] = $1; y[NR] = $2; count = NR; next }
{
    for (k = 2; k < count - 2 && x[k + 1] < $1; k++);
    sum = 0
    for (a = k - 1; a <= k + 2; a++) {
        weight = 1
        for (b = k - 1; b <= k + 2; b++) if (b != a) weight *= ($1 - x[b]) / (x[a] - x[b])
        sum += weight * y[a]
    }
    e = $2 - sum
    printf "%.10g %.10g %.4g\n", $1, $2, e < 0 ? -e : e
}
