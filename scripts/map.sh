#!/bin/sh
# Draws docs/architecture.svg: the rooms of the table in docs/architecture.md from ground to roof, with the way of one
# residual (blue) and of one call of the driver (red) between them.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: map.sh >docs/architecture.svg
set -eu
cd "$(dirname "$0")/.."
awk '
    /^\| *[0-9]+ *\| *`[a-z\/]+\/`/ {
        split($0, cell, "|")
        name = cell[3]
        gsub(/[ `]|\/`/, "", name)
        sub(/\/$/, "", name)
        text = cell[4]
        gsub(/`|^ +/, "", text)
        sub(/[;:,.(].*$/, "", text)
        sub(/ +$/, "", text)
        room[++rooms] = name
        if (length(text) > 46) {
            text = substr(text, 1, 46)
            sub(/ [^ ]*$/, " …", text)
        }
        about[rooms] = text
        place[name] = rooms
    }
    function xml(text) { gsub(/&/, "\\&amp;", text); gsub(/</, "\\&lt;", text); return text }
    # The middle of the row of a room; 0: above the roof.
    function middle(name) {
        if (name == "") return 34
        if (!(name in place)) { print "map.sh: no room " name >"/dev/stderr"; exit 1 }
        return top + (rooms - place[name] + 0.5) * row
    }
    function box(name, from, to, text, ink, paper) {
        printf "<rect x=\"%d\" y=\"%.1f\" width=\"%d\" height=\"20\" rx=\"4\" fill=\"%s\" stroke=\"%s\" stroke-width=\"1.4\"/>\n",
            from, middle(name) - 10, to - from, paper, ink
        printf "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%s</text>\n", (from + to) / 2, middle(name) + 4, xml(text)
    }
    function blue(name, from, to, text) { box(name, from, to, text, "#257", name == "" ? "#fff" : "#eff4f8") }
    function red(name, from, to, text) { box(name, from, to, text, "#b22", name == "" ? "#fff" : "#fdecee") }
    # An arrow between two rooms at x, from edge to edge of their boxes; heads: "to", "both" or "none".
    function arrow(x, from, to, ink, heads, dashed,    down, y1, y2) {
        down = middle(to) > middle(from) ? 1 : -1
        y1 = middle(from) + 10 * down
        y2 = middle(to) - 10 * down
        printf "<path d=\"M%d %.1fV%.1f\" stroke=\"%s\" stroke-width=\"1.6\" fill=\"none\"%s%s%s/>\n", x, y1, y2,
            ink == "blue" ? "#257" : "#b22", heads == "none" ? "" : " marker-end=\"url(#" ink ")\"",
            heads == "both" ? " marker-start=\"url(#" ink ")\"" : "", dashed ? " stroke-dasharray=\"6 4\"" : ""
    }
    function label(x, y, text, ink) {
        printf "<text x=\"%d\" y=\"%.1f\" font-weight=\"bold\" fill=\"%s\">%s</text>\n", x, y, ink == "blue" ? "#257" : "#b22", text
    }
    function between(a, b) { return (middle(a) + middle(b)) / 2 }
    END {
        row = 26; top = 92; width = 1120
        ground = top + rooms * row
        printf "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" font-family=\"sans-serif\" font-size=\"11\">\n", width, ground + 60
        print "<!-- Made by scripts/map.sh from the table of rooms. SPDX-License-Identifier: BSD-3-Clause -->"
        print "<defs>"
        split("blue #257 red #b22", ink, " ")
        for (k = 1; k < 4; k += 2)
            printf "<marker id=\"%s\" viewBox=\"0 0 8 8\" refX=\"7\" refY=\"4\" markerWidth=\"6\" markerHeight=\"6\" orient=\"auto-start-reverse\"><path d=\"M0 0.5L8 4L0 7.5z\" fill=\"%s\"/></marker>\n", ink[k], ink[k + 1]
        print "</defs>"
        printf "<rect width=\"%d\" height=\"%d\" fill=\"#fff\"/>\n", width, ground + 60
        printf "<path d=\"M4 %d L110 56 H%d L%d %d Z\" fill=\"#e8dec8\" stroke=\"#b9a36c\"/>\n", top, width - 110, width - 4, top
        for (k = 1; k <= rooms; ++k) {
            if (k % 2) printf "<rect x=\"10\" y=\"%d\" width=\"%d\" height=\"%d\" fill=\"#f7f3e9\"/>\n", top + (rooms - k) * row, width - 20, row
            y = middle(room[k]) + 4
            printf "<text x=\"34\" y=\"%.1f\" text-anchor=\"end\" fill=\"#777\">%d</text>", y, k
            printf "<text x=\"42\" y=\"%.1f\" font-weight=\"bold\">%s/</text>", y, room[k]
            printf "<text x=\"138\" y=\"%.1f\" fill=\"#555\" font-size=\"10\">%s</text>\n", y, xml(about[k])
        }
        printf "<path d=\"M10 %d V%d M380 %d V%d M800 %d V%d M%d %d V%d\" stroke=\"#b9a36c\"/>\n", top, ground, top, ground, top, ground, width - 10, top, ground
        printf "<path d=\"M0 %d H%d\" stroke=\"#111\" stroke-width=\"2\"/>\n", ground, width

        # One evaluation.
        arrow(420, "forms", "", "blue", "to"); label(405, between("ida", "files"), "F", "blue"); label(426, between("ida", "files"), "6", "blue")
        arrow(480, "", "forms", "blue", "to"); label(486, between("ida", "files"), "1&#160; t, y, y\x27", "blue")
        arrow(440, "forms", "dynamics", "blue", "to"); label(424, middle("batch") + 4, "2", "blue")
        arrow(470, "dynamics", "forms", "blue", "to")
        arrow(590, "forms", "sweeps", "blue", "to"); label(576, middle("batch") + 4, "3", "blue")
        arrow(620, "sweeps", "forms", "blue", "to"); label(626, middle("batch") + 4, "5", "blue")
        arrow(560, "sweeps", "joints", "blue", "both"); label(546, middle("model") + 4, "4", "blue")
        arrow(622, "sweeps", "recursion", "blue", "none")
        arrow(620, "recursion", "forces", "blue", "both"); label(626, middle("closures") + 4, "4", "blue")
        printf "<path d=\"M650 %.1fH706V%.1f\" stroke=\"#257\" stroke-width=\"1.6\" fill=\"none\" stroke-dasharray=\"6 4\" marker-end=\"url(#blue)\"/>\n", middle("forms") - 4, middle("recursion") - 10
        printf "<path d=\"M730 %.1fV%.1fH652\" stroke=\"#257\" stroke-width=\"1.6\" fill=\"none\" stroke-dasharray=\"6 4\" marker-end=\"url(#blue)\"/>\n", middle("recursion") - 10, middle("forms") + 5
        label(670, middle("results") + 4, "or 3", "blue"); label(736, middle("results") + 4, "5", "blue")
        arrow(690, "recursion", "forces", "blue", "both", 1)
        arrow(750, "recursion", "inertias", "blue", "both", 1)
        arrow(780, "recursion", "joints", "blue", "both", 1)
        blue("", 395, 510, "your solver")
        blue("forms", 395, 510, "mbsr_dae_residual"); blue("forms", 530, 650, "momentum.c")
        printf "<path d=\"M510 %.1fH529\" stroke=\"#257\" stroke-width=\"1.6\" marker-end=\"url(#blue)\" marker-start=\"url(#blue)\"/>\n", middle("forms")
        blue("dynamics", 395, 510, "mbsri_enter: checks")
        blue("sweeps", 530, 650, "sweeps: all of F")
        blue("recursion", 575, 650, "elements.c"); blue("recursion", 662, 792, "stages, one by one")
        blue("forces", 575, 730, "forces of each element")
        blue("inertias", 735, 770, "M, h")
        blue("joints", 530, 792, "pose, K, H, J, kI, kII of each joint")

        # One call of the driver.
        arrow(840, "ida", "", "red", "to"); label(812, 80, "y, y\x27", "red")
        arrow(880, "", "ida", "red", "to"); label(886, 80, "t_end", "red")
        printf "<path d=\"M990 45L930 %.1f\" stroke=\"#b22\" stroke-width=\"1.6\" marker-end=\"url(#red)\" marker-start=\"url(#red)\"/>\n", middle("ida") - 11
        label(985, 104, "steps", "red")
        arrow(1040, "", "ida", "red", "both")
        printf "<path d=\"M972 %.1fV%.1fH936\" stroke=\"#b22\" stroke-width=\"1.6\" fill=\"none\" marker-end=\"url(#red)\" marker-start=\"url(#red)\"/>\n", middle("ida") + 10, middle("forms")
        label(960, between("ida", "newton"), "F", "red")
        arrow(1050, "ida", "newton", "red", "both"); label(1056, between("ida", "newton"), "δ", "red")
        arrow(1010, "newton", "newton/sweeps", "red", "to")
        arrow(1098, "newton", "newton/front", "red", "to", 1)
        arrow(1098, "newton/front", "newton/linear", "red", "to", 1)
        arrow(1010, "newton/sweeps", "newton/slopes", "red", "both")
        arrow(1098, "newton/linear", "newton/slopes", "red", "both", 1)
        arrow(1010, "newton/slopes", "forces", "red", "both")
        arrow(1060, "newton/slopes", "joints", "red", "both", 1)
        red("", 810, 935, "your program"); red("", 970, 1100, "SUNDIALS IDA")
        red("ida", 810, 950, "mbsr_ida_advance"); red("ida", 960, 1104, "callbacks.c, linear.c")
        red("forms", 815, 935, "mbsr_dae_residual")
        printf "<text x=\"875\" y=\"%.1f\" text-anchor=\"middle\" font-style=\"italic\" fill=\"#555\">on as to the left</text>\n", middle("batch") + 4
        red("newton", 985, 1104, "factor, solve")
        red("newton/sweeps", 985, 1035, "sweeps"); red("newton/carried", 985, 1035, "loops")
        red("newton/front", 1042, 1104, "fronts"); red("newton/linear", 1042, 1104, "linear")
        red("newton/slopes", 985, 1104, "slopes")
        red("forces", 985, 1045, "derivatives"); red("joints", 985, 1104, "tangents")

        y = ground + 24
        printf "<path d=\"M40 %dH80\" stroke=\"#555\" stroke-width=\"1.6\"/><text x=\"88\" y=\"%d\">what the sweeps serve, and ranks that are clear</text>\n", y, y + 4
        printf "<path d=\"M40 %dH80\" stroke=\"#555\" stroke-width=\"1.6\" stroke-dasharray=\"6 4\"/><text x=\"88\" y=\"%d\">everything else</text>\n", y + 20, y + 24
        printf "<path d=\"M530 %dH570\" stroke=\"#257\" stroke-width=\"1.6\"/><text x=\"578\" y=\"%d\">one evaluation of the momentum form</text>\n", y, y + 4
        printf "<path d=\"M530 %dH570\" stroke=\"#b22\" stroke-width=\"1.6\"/><text x=\"578\" y=\"%d\">one call of the driver for IDA</text>\n", y + 20, y + 24
        print "</svg>"
    }' docs/architecture.md
