# Picture of 18_sdirk: run in the folder with its CSV file.
set datafile separator ","
set terminal pngcairo size 1000,420 font "sans,11"
set output "rope.png"
set multiplot layout 1,2 title "A rope of 20 massless segments swings against a wall that it meets askew: its shape every 0.1 s" font "sans,13"
set size ratio -1
set grid
set xlabel "x [m]"
set xrange [-1.1:1.9]
set xtics 0.5
set palette defined (0 "#2050a0", 1 "#c03030")
set cbrange [0:1]
set cblabel "t [s]"
unset colorbox
set ylabel "height z [m]"
set yrange [-0.1:2.1]
set title "from the side"
plot for [k=0:10] "rope.csv" index k using 2:4:1 with lines lw 2 lc palette notitle
set colorbox
set ylabel "y [m]"
set xrange [-0.9:0.9]
set yrange [-0.5:0.9]
set title "from above, with the wall"
plot for [k=0:10] "rope.csv" index k using 2:3:1 with lines lw 2 lc palette notitle, \
     "+" using (-0.4-0.6*$1):1 with lines lw 3 lc "#555555" notitle
unset multiplot
