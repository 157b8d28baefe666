# Picture of 10_quarter_car: run in the folder with its CSV files.
set datafile separator ","
set terminal pngcairo size 1000,400 font "sans,11"
set output "quarter_car.png"
set multiplot layout 1,2 title "Quarter car with a massless wheel carrier on a bump of 5 cm" font "sans,13"
set xlabel "t [s]"
set ylabel "height above rest [cm]"
set key top right
set grid
plot "quarter_car.csv" using 1:($2*100) with lines lw 1 lc rgb "#808080" title "road", \
     "" using 1:($3*100) with lines lw 2 lc rgb "#c03030" title "carrier, no mass", \
     "" using 1:($5*100) with lines lw 2 lc rgb "#2050a0" title "body, 400 kg"
unset key
set xlabel "mass of carrier and of spring seat [kg]"
set ylabel "steps of IDA"
set yrange [0:600]
set style fill solid 0.6
set boxwidth 0.7
plot "quarter_car_steps.csv" using 0:2:xtic(1) with boxes lc rgb "#606060", \
     "" using 0:2:2 with labels offset 0,0.7
unset multiplot
