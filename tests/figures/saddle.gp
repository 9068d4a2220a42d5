# SPDX-License-Identifier: MIT
# The paper's figure 11, with the exact curve that it did not have.
# Takes: data (folder), methods, spacing, out.
load 'tests/figures/style.gp'
eval sized(620)
set output out
set multiplot
set lmargin 11
set rmargin 3
set xrange [0:2]
set xtics 0.25
file(m) = sprintf('%s/saddle-%s.dat', data, m)

set origin 0, 0.4
set size 1, 0.6
set bmargin 1
set tmargin 3
set title sprintf('Saddle z = (x^2 − y^2)/2 m: shear on the diagonal, spacing %s m', spacing)
set ylabel 'absolute shear angle (degrees)'
set yrange [0:60]
set format x ''
set key top left reverse Left
plot data . '/saddle-exact.dat' using 1:2 with lines linestyle 8 \
         title 'exact: sin γ = xy / √((1 + x^2)(1 + y^2))', \
     for [m in methods] file(m) using 1:2 with points linestyle style(m) title m

set origin 0, 0
set size 1, 0.4
set tmargin 0.5
set bmargin 3.5
unset title
unset key
set xlabel 'x = y (m)'
set ylabel 'error (degrees)' offset -0.3
set format x '%g'
set logscale y
set yrange [*:*]
set format y '10^{%L}'
plot for [m in methods] file(m) using 1:($3 > 0 ? $3 : NaN) with linespoints linestyle style(m)
