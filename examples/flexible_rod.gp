# Picture of 35_flexible_rod: run in the folder with its CSV file.
set datafile separator ","
set terminal pngcairo size 1000,420 font "sans,11"
set output "flexible_rod.png"
set multiplot layout 1,2 title "Slider-crank with a flexible rod: static modes" font "sans,13"
set xlabel "t [ms]"
set grid
set title "the rod's middle, off the line between its pins"
set ylabel "[mm]"
plot "flexible_rod.csv" using ($1*1000):($2*1000) with lines lw 1.5 lc rgb "#2050a0" notitle
set title "distance from six normal modes and the static ones"
set ylabel "error [mm]"
set yrange [-0.012:0.018]
plot "flexible_rod.csv" using ($1*1000):($3*1000) with lines lw 1.5 lc rgb "#c03030" title "left out", \
     "" using ($1*1000):($4*1000) with lines lw 1.5 lc rgb "#808080" title "with mass", \
     "" using ($1*1000):($5*1000) with lines lw 1.5 lc rgb "#2050a0" title "massless"
unset multiplot
