# Picture of 33_squeezer: run in the folder with its CSV file.
set datafile separator ","
set terminal pngcairo size 1000,420 font "sans,11"
set output "squeezer.png"
set multiplot layout 2,3 title "Andrews' squeezer: seven bodies, three loops, 30 ms [mm]" font "sans,13"
set size ratio -1
set xrange [-80:10]
set yrange [-25:40]
set xtics 20
set ytics 20
do for [k=0:5] {
    set title sprintf("%d ms", 5 * (k + 1))
    plot "squeezer.csv" index k using 1:2 with linespoints lw 2 pt 7 ps 0.7 lc rgb "#2050a0" notitle
}
unset multiplot
