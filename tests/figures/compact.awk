# SPDX-License-Identifier: MIT
# Shortens gnuplot's SVG without loss. Groups with nothing in them go. The cells of a coloured net,
# each a polygon in groups of its own, become one path for each colour, in tenths of a pixel, with
# thin lines round the cells; they do not hide each other, so they all go right on the background.
function keep(line) { kept[++count] = line }
function is_open(line) { return line ~ /^<g / }
# x,y in tenths of a pixel.
function tenths(text,   xy) {
    split(text, xy, ",")
    x = int(xy[1] * 10 + 0.5)
    y = int(xy[2] * 10 + 0.5)
}
function join(a, b) { return b < 0 ? a b : a " " b }
function outline(points,   n, at, k, x0, y0, text) {
    n = split(points, at, " ")
    tenths(at[1])
    text = "M" join(x, y) "l"
    for (k = 2; k <= n; k++) {
        x0 = x; y0 = y
        tenths(at[k])
        text = join(text (k == 2 ? x - x0 : join("", x - x0)), y - y0)
    }
    return text "z"
}
function add_cell(colour, points) {
    if (!cells[colour]) colours[++colour_count] = colour
    cells[colour] = cells[colour] outline(points)
}
# The steps of a colour box, of which several have the same colour.
function add_step(colour, points) {
    if (colour != step_colour || count != step_at) {
        keep("<path transform='scale(.1)' fill='" colour "' d=''/>")
        step_colour = colour
        step_at = count
    }
    sub(/'\/>$/, outline(points) "'/>", kept[count])
}
function in_plot(   k) {
    for (k = depth; k > 0; k--) if (group[k] ~ /gnuplot_plot/) return 1
    return 0
}
function take(line,   part) {
    sub(/^[ \t]+/, "", line); sub(/[ \t]+$/, "", line)
    if (line == "") return
    if (is_open(line)) { group[++depth] = line; keep(line); return }
    if (line == "</g>") {
        depth--
        if (is_open(kept[count])) count--; else keep(line)
        return
    }
    if (line ~ /^<polygon fill = 'rgb/) {
        split(line, part, "'")
        gsub(/ /, "", part[2])
        if (in_plot()) add_cell(part[2], part[4]); else add_step(part[2], part[4])
        return
    }
    keep(line)
}
{
    gsub(/ stroke-linecap="butt" stroke-linejoin="miter"/, "") # what they are unless said
    gsub(/<g /, "\n&"); gsub(/<\/g>/, "\n&\n")
    lines = split($0, line, "\n")
    for (l = 1; l <= lines; l++) take(line[l])
}
END {
    for (k = 1; k <= count; k++) {
        print kept[k]
        if (kept[k] !~ /^<rect/ || painted++ || !colour_count) continue
        print "<g transform='scale(.1)' stroke='#888' stroke-width='4'>"
        for (c = 1; c <= colour_count; c++)
            printf "<path fill='%s' d='%s'/>\n", colours[c], cells[colours[c]]
        print "</g>"
    }
}
