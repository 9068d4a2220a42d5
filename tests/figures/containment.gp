# SPDX-License-Identifier: MIT
# The error estimate of gib4 against the error, node by node, on random surfaces and awkward ones.
# Takes: data (folder), out.
load 'tests/figures/style.gp'
eval sized(520)
set output out
set logscale xy
set format xy '10^{%L}'
set xlabel 'error / spacing, by a net four times as fine'
set ylabel 'error\_estimate / spacing' offset 1
set xrange [1e-9:10]
set yrange [1e-9:100]
set key bottom right
plot data.'/containment-random.dat' using 1:2 with points linestyle 3 pointsize 0.3 title 'random surfaces', \
     data.'/containment-awkward.dat' using 1:2 with points linestyle 1 pointsize 0.4 title 'awkward surfaces', \
     data.'/containment-grown.dat' using 1:2 with points linestyle 2 pointsize 0.4 title 'grown nodes', \
     x with lines linestyle 8 title 'estimate = error', 30 * x with lines linestyle 9 title '30 times'
