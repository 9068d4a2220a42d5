# SPDX-License-Identifier: MIT
# Left: shear of flat cloth on a hat profile, by chords and by gib. Right: the error estimate of gib4
# against the error on the saddle. Takes: data (folder), spacing (mm), out.
load 'tests/figures/style.gp'
eval sized(420)
set output out
set multiplot layout 1, 2 margins 0.09, 0.97, 0.17, 0.9 spacing 0.13
set title 'Flat cloth at 45° on a hat, d = '.spacing.' mm' font ',13'
set yrange [-0.1:0.8]
set xlabel 'across the profile, x (mm)'
set ylabel 'shear angle (degrees)' offset 1
set key top right
plot data.'/small_radii-basic.dat' using 1:2 every 2 linestyle style("basic") title 'basic (chords)', \
     data.'/small_radii-gib.dat' using 1:2 every 15 linestyle style('gib') title 'gib; right is 0'
set title 'Saddle, gib4, node by node' font ',13'
set logscale xy
set format xy '10^{%L}'
set xlabel 'error'
set ylabel 'error\_estimate' offset 1
set xrange [1e-10:1e-4]
set yrange [1e-10:1e-4]
set key bottom right
plot for [n = 1 : 3] sprintf('%s/small_radii-estimate-%s.dat', data, word('0.1 0.05 0.025', n)) \
         using 1:2 every 151 * 4 ** (n - 1) with points linestyle n title 'd = '.word('0.1 0.05 0.025', n), \
     x with lines linestyle 8 title 'estimate = error', 30 * x with lines linestyle 9 title '30 times'
