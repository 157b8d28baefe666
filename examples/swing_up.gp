# Picture of 41_swing_up: run in the folder with its CSV file.
set datafile separator ","
set terminal pngcairo size 1000,420 font "sans,11"
set output "swing_up.png"
set multiplot title "Swing-up of an arm without mass on an elastic gear, by collocation" font "sans,13"
set grid
set title "every second time, from blue to red"
set origin 0.0,0.0
set size 0.42,0.93
set xrange [-1.25:1.25]
set yrange [-1.25:1.25]
set size ratio -1
set xlabel "m"
set ylabel "m"
unset colorbox
set palette rgbformulae 33,13,10
plot for [k=0:80:2] "swing_up.csv" every ::k::k using (0):(0):9:10:1 with vectors nohead lw 1.5 lc palette notitle, \
     for [k=0:80:2] "swing_up.csv" every ::k::k using 9:10:($11-$9):($12-$10):1 with vectors nohead lw 1.5 lc palette notitle, \
     "swing_up.csv" using 11:12 with lines lc rgb "gray50" notitle
set size noratio
set origin 0.42,0.0
set size 0.57,0.93
set title "torque of the motor and twist of the gear"
set xrange [0:2.5]
set autoscale y
set xlabel "time [s]"
set ylabel "torque [Nm]"
set y2label "twist [deg]"
set y2tics
set ytics nomirror
set key top right
plot "swing_up.csv" using 1:8 with lines lw 2 title "torque", \
     "swing_up.csv" using 1:($3*180/pi) axes x1y2 with lines lw 2 title "twist of the gear"
unset multiplot
