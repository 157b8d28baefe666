# Picture of 32_flexible_arm: run in the folder with its CSV file.
set datafile separator ","
set terminal pngcairo size 1000,420 font "sans,11"
set output "flexible_arm.png"
set multiplot layout 1,2 title "Robot arm with flexible links: static modes" font "sans,13"
set xlabel "t [s]"
set grid
set title "the tip under the tool's push"
set ylabel "y [mm]"
plot "flexible_arm.csv" using 1:($2*1000) with lines lw 1.5 lc rgb "#2050a0" notitle
set key at graph 0.95,0.6
set title "distance from six normal modes and the static ones"
set ylabel "error [mm]"
plot "flexible_arm.csv" using 1:($3*1000) with lines lw 1.5 lc rgb "#c03030" title "left out", \
     "" using 1:($4*1000) with lines lw 1.5 lc rgb "#808080" title "with mass", \
     "" using 1:($5*1000) with lines lw 1.5 lc rgb "#2050a0" title "massless"
unset multiplot
