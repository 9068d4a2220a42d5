# SPDX-License-Identifier: MIT
# What the figures share: size, fonts, and one colour (Okabe and Ito's, which the colour-blind can
# tell apart) and one mark for each method.
set encoding utf8
# out: the SVG; size in pixels.
wide = 700
sized(height) = sprintf("set terminal svg size %d,%d font 'Helvetica,Arial,sans-serif,15' ", wide, height) \
    . "background rgb 'white' enhanced linewidth 1.2"
set border linewidth 0.8 linecolor rgb '#404040'
set tics textcolor rgb '#202020'
set grid back linetype 1 linewidth 0.6 linecolor rgb '#dddddd'
set mytics 1
set mxtics 1
set key samplen 2 spacing 1.15

set style line 1 linecolor rgb '#E69F00' linewidth 1.6 pointtype 9 pointsize 0.7
set style line 2 linecolor rgb '#009E73' linewidth 1.6 pointtype 3 pointsize 0.7
set style line 3 linecolor rgb '#56B4E9' linewidth 1.6 pointtype 6 pointsize 0.9
set style line 4 linecolor rgb '#0072B2' linewidth 1.6 pointtype 2 pointsize 0.6
set style line 5 linecolor rgb '#D55E00' linewidth 1.6 pointtype 5 pointsize 0.5
set style line 8 linecolor rgb 'black' linewidth 1.2
set style line 9 linecolor rgb '#888888' linewidth 1 dashtype 2
known = 'basic mosaic geodesic gib gib4'
style(method) = sum [k = 1 : words(known)] (word(known, k) eq method ? k : 0)
