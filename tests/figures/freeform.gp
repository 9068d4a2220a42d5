# SPDX-License-Identifier: MIT
# In the kind of the paper's figure 13: the draped net in colours of its shear. The palette is
# Crameri's vik, even to the eye and safe for the colour-blind; grey lines keep the pale cells
# visible. Takes: data (folder), spacing, out.
load 'tests/figures/style.gp'
eval sized(540)
set output out
unset grid
unset key
set title sprintf('Free-form surface: shear of the net, spacing %s mm, method gib4', spacing)
set palette defined (0 '#001261', 1 '#033E7D', 2 '#1E6F9D', 3 '#71A8C4', 4 '#C9DDE7', 5 '#EDE7E1', \
    6 '#EACEBD', 7 '#D39774', 8 '#BE6533', 9 '#8B2706', 10 '#590008') maxcolors 20
set cbrange [-50:50]
set cbtics 10
set cblabel 'shear angle (degrees)'
set view map
set size ratio -1
set lmargin at screen 0.1
set rmargin at screen 0.83
set tmargin at screen 0.92
set bmargin at screen 0.12
set xrange [-10:400]
set yrange [-20:315]
set xtics 100 offset 0, 0.5
set ytics 100 offset 0.5
set xlabel 'x (mm)' offset 0, 0.5
set ylabel 'y (mm)' offset 1
# A map has no frame of its own.
do for [side in '0,0,0,1 0,1,1,1 1,1,1,0 1,0,0,0'] {
    x(n) = (real(side[2 * n - 1 : 2 * n - 1]))
    set arrow from graph x(1), graph x(2) to graph x(3), graph x(4) nohead linewidth 0.8 \
        linecolor rgb '#404040'
}
set pm3d corners2color c1
splot data . '/freeform-cells.dat' using 1:2:3:4 with pm3d
