# Picture of 40_quadruped: run in the folder with its CSV file.
set datafile separator ","
set terminal pngcairo size 1000,420 font "sans,11"
set output "quadruped.png"
set multiplot layout 1,2 title "A quadruped stands, and trots by PD control; its feet have no mass" font "sans,13"
set xlabel "t [s]"
set grid
set title "the trunk"
set ylabel "x [m]"
set y2label "z [m]"
set ytics nomirror
set y2tics
set y2range [0.3:0.4]
set key left top
plot "quadruped.csv" using 1:2 with lines lw 2 lc rgb "#2050a0" title "x", \
     "" using 1:3 axes x1y2 with lines lw 1.5 lc rgb "#c03030" title "z"
unset y2label
unset y2tics
set ytics mirror
set xrange [2:2.8]
set title "what the feet carry"
set ylabel "N [N]"
set key right top
plot "quadruped.csv" using 1:5 with lines lw 1.5 lc rgb "#2050a0" title "front left", \
     "" using 1:6 with lines lw 1.5 lc rgb "#c03030" title "front right", \
     "" using 1:7 with lines lw 1.5 dt 2 lc rgb "#c03030" title "rear left", \
     "" using 1:8 with lines lw 1.5 dt 2 lc rgb "#2050a0" title "rear right"
unset multiplot
