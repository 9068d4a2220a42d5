# SPDX-License-Identifier: MIT
# Largest error of the shear over the spacing; basic, gib and geodesic fall with its square, gib4
# with its fourth power. Takes: data (folder), methods, guide2 and guide4 (values at d/L = 1/16 on
# the sphere and on the saddle, two words each), out.
load 'tests/figures/style.gp'
eval sized(480)
set output out
set multiplot layout 1, 2 margins 0.125, 0.98, 0.14, 0.9 spacing 0.03
set logscale xy
set xrange [1.0 / 160 : 0.32]
set xtics ('1/128' 1.0/128, '1/64' 1.0/64, '1/32' 1.0/32, '1/16' 1.0/16, '1/8' 1.0/8, '1/4' 1.0/4)
set xtics font ',13'
set format y '10^{%L}'
set yrange [3e-10:20]
set ytics 100
set xlabel 'spacing over side of the region, d/L'
do for [n = 1 : 2] {
    surface = word('sphere saddle', n)
    if (n == 1) {
        set title 'Sphere, L = 0.6 R'
        set ylabel 'largest error of the shear angle (degrees)' offset 0.2
        unset key
    } else {
        set title 'Saddle, L = 1.2'
        unset ylabel
        set format y ''
        set key bottom right
    }
    a = real(word(guide2, n))
    b = real(word(guide4, n))
    plot for [m in methods] sprintf('%s/error-%s-%s.dat', data, surface, m) using 1:2 \
             with linespoints linestyle style(m) title m, \
         a * (16 * x) ** 2 with lines linestyle 9 title 'slopes 2 and 4', \
         b * (16 * x) ** 4 with lines linestyle 9 notitle
}
