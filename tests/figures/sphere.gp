# SPDX-License-Identifier: MIT
# The paper's figure 8, and what it cannot show: how far each method is from the exact curve.
# Takes: data (folder), methods, spacing, out.
load 'tests/figures/style.gp'
eval sized(620)
set output out
set multiplot
set lmargin 11
set rmargin 3
set xrange [0:90]
set xtics 15
file(m) = sprintf('%s/sphere-%s.dat', data, m)

set origin 0, 0.4
set size 1, 0.6
set bmargin 1
set tmargin 3
set title sprintf('Sphere: shear on the diagonal of an octant, spacing %s of the radius', spacing)
set ylabel 'shear angle (degrees)'
set yrange [0:60]
set format x ''
set key top left reverse Left
plot data . '/sphere-exact.dat' using 1:2 with lines linestyle 8 title 'exact', \
     for [m in methods] file(m) using 1:2 with points linestyle style(m) title m

set origin 0, 0
set size 1, 0.4
set tmargin 0.5
set bmargin 3.5
unset title
unset key
set xlabel 'polar angle (degrees)'
set ylabel 'error (degrees)' offset -0.3
set format x '%g'
set logscale y
set yrange [*:*]
set format y '10^{%L}'
set ytics 100
plot for [m in methods] file(m) using 1:($3 > 0 ? $3 : NaN) with linespoints linestyle style(m)
