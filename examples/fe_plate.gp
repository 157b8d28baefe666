# Picture of 36_fe_plate: run in the folder with its CSV files.
set datafile separator ","
set terminal pngcairo size 1000,420 font "sans,11"
set output "fe_plate.png"
set multiplot layout 1,2 title "Plate of solid elements as a flexible body" font "sans,13"
set grid
set logscale xy
set xrange [7:37]
set xtics (8, 16, 32)
set format y "10^{%T}"
set xlabel "elements along the plate"
set ylabel "error"
set title "frequencies of the free plate against closed form"
set key bottom left
plot "fe_plate.csv" using 1:(abs($2)) with linespoints pt 7 lc rgb "#2050a0" title "1st along x", \
     "" using 1:(abs($3)) with linespoints pt 7 lc rgb "#2090c0" title "2nd along x", \
     "" using 1:(abs($4)) with linespoints pt 7 lc rgb "#c03030" title "1st along y", \
     2.5/x**2 with lines dt 2 lc rgb "#808080" title "square of their edge"
unset logscale
set xrange [*:*]
set xtics auto
set format y "%g"
set key center right
set xlabel "t [s]"
set ylabel "error [mm]"
set title "a corner that is pushed, two normal modes; static modes"
plot "fe_plate_corner.csv" using 1:($3*1000) with lines lw 1.5 lc rgb "#c03030" title "left out", \
     "" using 1:($4*1000) with lines lw 1.5 lc rgb "#808080" title "with mass", \
     "" using 1:($5*1000) with lines lw 1.5 lc rgb "#2050a0" title "massless"
unset multiplot
