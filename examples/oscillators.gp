# Picture of the demo: run in the folder with the CSV files of demo_oscillators.
set datafile separator ","
set terminal pngcairo size 1500,460 font "sans,11"
set output "oscillators.png"
steps(name) = system(sprintf("awk -F, '$1==\"%s\" {print $3}' oscillators.csv", name))
set multiplot layout 1,4 title "Two coupled oscillators, IDA at rtol = atol = 1e-4: the motion of both masses" font "sans,13"
set xlabel "t [s]"
set ylabel "position [m]"
set xrange [0:2]
set yrange [-0.1:1.5]
set key top left
set grid
do for [name in "1e-3 1e-4 0"] {
    set title (name eq "0" ? "m1 = 0" : "m1 = ".name." m2").": ".steps(name)." steps"
    plot "oscillators_".name.".csv" using 1:2 with lines lw 1 lc rgb "#c03030" title "p1", \
         "" using 1:3 with lines lw 2 lc rgb "#2050a0" title "p2"
}
set title "steps needed"
unset key
unset xrange
set xlabel "m1/m2"
set ylabel "steps"
set logscale y
set yrange [10:20000]
set style fill solid 0.6
set boxwidth 0.7
set xrange [-0.7:4.7]
plot "oscillators.csv" using 0:3:xtic(1) with boxes lc rgb "#606060", \
     "" using 0:3:3 with labels offset 0,0.7
unset multiplot
