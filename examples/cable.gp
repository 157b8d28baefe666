# Picture of 14_cable: run in the folder with its CSV file.
set datafile separator ","
set terminal pngcairo size 1000,400 font "sans,11"
set output "cable.png"
set multiplot layout 1,2 title "A cable of 100 massless segments, let go at one end and pushed sideways: its shape every 0.1 s" font "sans,13"
set size ratio -1
set grid
set key top left
set xlabel "x [m]"
set xrange [-1.6:1.8]
set xtics 0.5
set palette defined (0 "#2050a0", 1 "#c03030")
set cbrange [0:1]
set cblabel "t [s]"
unset colorbox
set ylabel "height z [m]"
set yrange [-2:0.1]
set title "from the side"
plot for [k=0:10] "cable.csv" index k using 1:3:(k*0.1) with lines lw 2 lc palette notitle
set colorbox
set ylabel "y [m]"
set yrange [-1:1.1]
set title "from above"
plot for [k=0:10] "cable.csv" index k using 1:2:(k*0.1) with lines lw 2 lc palette notitle
unset multiplot
