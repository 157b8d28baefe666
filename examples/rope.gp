# Picture of 18_sdirk: run in the folder with its CSV file.
set datafile separator ","
set terminal pngcairo size 1000,440 font "sans,11"
set output "rope.png"
set multiplot layout 1,2 title "A rope of 20 massless segments swings against a wall that it meets askew: its shape every 0.1 s" font "sans,13"
# From the wall, through (-0.4, 0) with the normal (1, 0.6).
off(x, y) = (x + 0.4 + 0.6*y)/sqrt(1.36)
set size ratio -1
set grid
set xtics 0.5
set palette defined (0 "#2050a0", 1 "#c03030")
set cbrange [0:1]
set cblabel "t [s]"
unset colorbox
set xlabel "distance from the wall [m]"
set xrange [-0.3:2]
set ylabel "height z [m]"
set yrange [-0.1:2.1]
set title "along the wall"
set object 1 rectangle from -0.3,-0.1 to 0,2.1 fillcolor rgb "#d8d8d8" fillstyle solid border rgb "#555555" behind
plot for [k=0:10] "rope.csv" index k using (off($2, $3)):4:1 with lines lw 2 lc palette notitle
unset object 1
set colorbox
set xlabel "x [m]"
set ylabel "y [m]"
set xrange [-0.9:0.9]
set yrange [-0.5:0.9]
set title "from above"
set object 2 polygon from -0.94,0.9 to -0.1,-0.5 to -0.9,-0.5 to -0.9,0.9 to -0.94,0.9 fillcolor rgb "#d8d8d8" fillstyle solid border rgb "#555555" behind
plot for [k=0:10] "rope.csv" index k using 2:3:1 with lines lw 2 lc palette notitle
unset multiplot
