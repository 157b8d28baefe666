# Picture of the demo's second part: run in the folder with the CSV files of demo_tree.
set datafile separator ","
set terminal pngcairo size 1500,560 font "sans,11"
set output "tree.png"
# The table's line of the largest tree without mass.
cell(column) = system(sprintf("awk -F, '$2==0 && $3==\"tree\" && $1>=most {most=$1; x=$%d} END {print x}' tree.csv", column))
# Rods of a radius from `least` to `most` at rest, and in frame k with the displacement of their ends.
rods(k, least, most) = sprintf("< paste -d, tree_0.csv tree_%d.csv | awk -F, '$1==\"\" {print \"\"; next} " \
    . "$4>%g && $4<=%g {print $1 \",\" $3 \",\" $5 \",\" $7 \",\" $5-$1}'", k, least, most)
set multiplot title "A tree of ".cell(1)." bodies, two of three without mass, shaken at its foot: ".cell(4)." steps of IDA; grey: at rest" font "sans,13"
set xlabel "x [m]"
set size ratio -1
set xrange [-3.5:3.3]
set yrange [0:6.5]
set xtics 1
unset key
set palette defined (-0.25 "#1040c0", -0.1 "#40a0e0", 0 "#a0a090", 0.1 "#f09030", 0.25 "#c01010")
set cbrange [-0.25:0.25]
set cblabel "displacement along x [m]"
set tmargin at screen 0.86
set bmargin at screen 0.12
at = "0.3 0.58 0.86"
array what[3] = ["the foot has moved, the crown lags", "the crown at its farthest", "back beyond rest, but the top"]
do for [k = 1:3] {
    set lmargin at screen 0.035 + 0.255*(k - 1)
    set rmargin at screen 0.035 + 0.255*(k - 1) + 0.235
    set title sprintf("t = %s s: %s", word(at, k), what[k])
    if (k == 1) { set ylabel "height [m]" } else { unset ylabel }
    if (k == 3) { set colorbox user origin 0.79,0.2 size 0.01,0.58 } else { unset colorbox }
    plot rods(k, 0.05, 1) using 1:2 with lines lw 6 lc rgb "#d8d8d8", \
         rods(k, 0.02, 0.05) using 1:2 with lines lw 2.5 lc rgb "#d8d8d8", \
         rods(k, 0.008, 0.02) using 1:2 with lines lw 1 lc rgb "#d8d8d8", \
         rods(k, 0, 0.008) using 1:2 with lines lw 0.5 lc rgb "#d8d8d8", \
         rods(k, 0.05, 1) using 3:4:5 with lines lw 6 lc palette, \
         rods(k, 0.02, 0.05) using 3:4:5 with lines lw 2.5 lc palette, \
         rods(k, 0.008, 0.02) using 3:4:5 with lines lw 1 lc palette, \
         rods(k, 0, 0.008) using 3:4:5 with lines lw 0.5 lc palette
}
set size noratio
set lmargin at screen 0.875
set rmargin at screen 0.99
set title "the last twig, along x [m]"
set xlabel "t [s]"
unset ylabel
set xrange [0:3]
set yrange [*:*]
set grid
plot "tree_motion.csv" using 1:2 with lines lw 2 lc rgb "#2050a0"
unset multiplot
