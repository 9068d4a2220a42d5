# SPDX-License-Identifier: MIT
# How far nets over facets are from the net on the exact face, along the far edge of the course.
load 'tests/figures/style.gp'
eval sized(340)
set output data.'/course.svg'
set xlabel 'along the course, m'
set ylabel 'distance from the exact net, mm'
set key top left
plot data.'/course.dat' using 1:3 with lines linestyle 1 title 'mosaic, facets of 40 mm', \
    '' using 1:2 with lines linestyle 8 title 'Abaqus Composites Modeler, facets of 40 mm', \
    '' using 1:4 with lines linestyle 2 title 'mosaic, 20 mm', \
    '' using 1:5 with lines linestyle 4 title 'mosaic, 10 mm'
