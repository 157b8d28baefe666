# Picture of 19_engine: run in the folder with its CSV file.
set datafile separator ","
set terminal pngcairo size 1000,420 font "sans,11"
set output "engine.png"
set multiplot layout 1,2 title "Slider-crank engine with a massless connecting rod" font "sans,13"
set xlabel "t [s]"
set grid
set title "speed of the crank"
set ylabel "speed [rad/s]"
plot "engine.csv" using 1:3 with lines lw 1.5 lc rgb "#2050a0" notitle
set title "the last 0.05 s"
set xrange [0.25:0.3]
set xtics 0.01
set ylabel "force along the rod [N]"
set y2label "piston [mm]"
set ytics nomirror
set y2tics
plot "engine.csv" using 1:5 with lines lw 2 lc rgb "#c03030" title "force along the rod", \
     "" using 1:($4*1000) axes x1y2 with lines lw 1.5 lc rgb "#808080" title "piston"
unset multiplot
