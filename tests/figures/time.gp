# SPDX-License-Identifier: MIT
# The paper's figure 9. Takes: data (folder), methods, tics (of nodes), out.
load 'tests/figures/style.gp'
eval sized(460)
set output out
set lmargin 10
set rmargin 4
set title 'Free-form surface, 390 × 300 mm: time to solve on one thread' offset 0, 0.8
set tmargin 6
set xlabel 'grid size: spacing of the nodes (mm)'
set ylabel 'time (ms)'
set logscale xyx2
set xrange [13:0.5]
set x2range [13:0.5]
set xtics (10, 5, 2.5, 1.25, 0.625)
set xtics nomirror
set x2label 'nodes' offset 0, -0.3
eval 'set x2tics (' . tics . ')'
set format y '10^{%L}'
set yrange [1:1e5]
set key top center horizontal maxrows 1 samplen 1.5
file(m) = sprintf('%s/time-%s.dat', data, m)
plot for [m in methods] file(m) using 1:2 with linespoints linestyle style(m) title m
