# Picture of 15_flyball_governor: run in the folder with its CSV file.
set datafile separator ","
set terminal pngcairo size 1000,420 font "sans,11"
set output "governor.png"
set multiplot layout 1,2 title "Flyball governor: the massless sleeve follows the speed" font "sans,13"
set xlabel "t [s]"
set y2label "height of the sleeve [cm]"
set ytics nomirror
set y2tics
set grid
set title "6 s: the spindle speeds up at t = 2 s"
set ylabel "speed [rad/s]"
set yrange [8:16]
set y2range [-22:-12]
set key bottom right
plot "governor.csv" using 1:2 with lines lw 1.5 lc rgb "#808080" title "speed of the spindle", \
     "" using 1:($4*100) axes x1y2 with lines lw 2 lc rgb "#c03030" title "height of the sleeve"
set title "the first 0.3 s: arms released 0.1 rad too high"
set ylabel "angle of the arms [deg]"
set xrange [0:0.3]
set yrange [50:58]
set y2range [-21:-19]
set key top right
plot "governor.csv" using 1:3 with lines lw 1.5 lc rgb "#2050a0" title "angle of the arms", \
     "" using 1:($4*100) axes x1y2 with lines lw 2 lc rgb "#c03030" title "height of the sleeve"
unset multiplot
