# Picture of 34_spin_up_beam: run in the folder with its CSV files.
set datafile separator ","
set terminal pngcairo size 1000,420 font "sans,11"
set output "spin_up_beam.png"
set title "Spin-up of a beam: deflection of its tip behind the hub" font "sans,13"
set xlabel "t [s]"
set ylabel "v [m]"
set grid
set yrange [-0.75:0.1]
set key bottom right
plot "spin_up_beam.csv" using 1:2 with lines lw 1.5 lc rgb "#c03030" title "2 modes, linear: breaks away", \
     "" using 1:3 with lines lw 1.5 lc rgb "#808080" title "1 mode, stiffening", \
     "" using 1:5 with lines lw 1.5 lc rgb "#2050a0" title "3 modes, stiffening", \
     "elastica.csv" using 1:2 with points pt 6 ps 1.4 lw 1.5 lc rgb "#000000" title "elastica"
