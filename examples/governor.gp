# Picture of 15_flyball_governor: run in the folder with its CSV file.
set datafile separator ","
set terminal pngcairo size 800,400 font "sans,11"
set output "governor.png"
set title "Flyball governor: the massless sleeve follows the speed" font "sans,13"
set xlabel "t [s]"
set ylabel "speed [rad/s]"
set y2label "height of the sleeve [cm]"
set yrange [8:16]
set y2range [-22:-12]
set ytics nomirror
set y2tics
set grid
set key bottom right
plot "governor.csv" using 1:2 with lines lw 1.5 lc rgb "#808080" title "speed of the spindle", \
     "" using 1:($4*100) axes x1y2 with lines lw 2 lc rgb "#c03030" title "height of the sleeve"
