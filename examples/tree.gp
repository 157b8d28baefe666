# Picture of the demo's second part: run in the folder with the CSV files of demo_tree.
set datafile separator ","
set terminal pngcairo size 1500,560 font "sans,11"
set output "tree.png"
# The table's line of the largest tree without mass.
cell(column) = system(sprintf("awk -F, '$2==0 && $3==\"tree\" && $1>=most {most=$1; x=$%d} END {print x}' tree.csv", column))
set multiplot layout 1,4 title "A tree of ".cell(1)." bodies, two of three without mass: ".cell(4)." steps, ".cell(8)." s" font "sans,13"
set xlabel "x [m]"
set ylabel "height [m]"
set size ratio -1
set xrange [-3.2:3.2]
set yrange [0:6.4]
unset key
width(r) = r > 0.05 ? 5 : r > 0.02 ? 2.5 : r > 0.01 ? 1.2 : 0.4
at = "0.0 0.6 1.05"
do for [k = 0:2] {
    set title sprintf("t = %s s", word(at, k + 1))
    plot "< awk -F, '!NF || $4>0.05' tree_".k.".csv" using 1:3 with lines lw 6 lc rgb "#5a3a1a", \
         "< awk -F, '!NF || ($4>0.02 && $4<=0.05)' tree_".k.".csv" using 1:3 with lines lw 2.5 lc rgb "#6a4a2a", \
         "< awk -F, '!NF || ($4>0.008 && $4<=0.02)' tree_".k.".csv" using 1:3 with lines lw 1 lc rgb "#6a5a3a", \
         "< awk -F, '!NF || $4<=0.008' tree_".k.".csv" using 1:3 with lines lw 0.5 lc rgb "#3a7a3a"
}
set size noratio
set title "the last twig"
set xlabel "t [s]"
set ylabel "displacement [m]"
set xrange [0:*]
set yrange [*:*]
set grid
plot "tree_motion.csv" using 1:2 with lines lw 2 lc rgb "#2050a0"
unset multiplot
