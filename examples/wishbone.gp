# Picture of 20_double_wishbone: run in the folder with its CSV file.
set datafile separator ","
set terminal pngcairo size 1000,420 font "sans,11"
set output "wishbone.png"
set multiplot layout 1,2 title "Double wishbone with massless links over a bump" font "sans,13"
set xlabel "t [s]"
set grid
set ylabel "height [mm]"
plot "wishbone.csv" using 1:($3*1000-300) with lines lw 2 lc rgb "#2050a0" title "wheel, rigid joints", \
     "" using 1:($5*1000-300) with lines lw 1 lc rgb "#c03030" title "with a bushing", \
     "" using 1:($2*1000) with lines lw 1 lc rgb "#808080" title "road"
set ylabel "steer angle [deg]"
set key bottom right
plot "wishbone.csv" using 1:4 with lines lw 2 lc rgb "#2050a0" title "rigid joints", \
     "" using 1:6 with lines lw 1 lc rgb "#c03030" title "with a bushing"
unset multiplot
