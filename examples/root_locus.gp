# Picture of 39_root_locus: run in the folder with its CSV file.
set datafile separator ","
set terminal pngcairo size 1000,420 font "sans,11"
set rmargin at screen 0.46
set output "root_locus.png"
set multiplot layout 1,2 title "Eigenvalues of a vehicle on massless arms; the damper in front from 0 to 20000 N s/m" font "sans,13"
set grid
set xlabel "real part [1/s]"
set ylabel "imaginary part [1/s]"
set cblabel "damper [N s/m]"
set palette rgbformulae 33,13,10
set title "wheels on their tyres"
set xrange [-60:2]
set yrange [0:130]
unset colorbox
plot "root_locus.csv" using 2:3:1 with points pt 7 ps 0.5 lc palette notitle
set title "the chassis on its springs"
set colorbox
set rmargin at screen 0.88
set xrange [-16:0.5]
set yrange [0:16]
plot "root_locus.csv" using 2:3:1 with points pt 7 ps 0.5 lc palette notitle
unset multiplot
