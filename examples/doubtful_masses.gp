# Picture of 31_doubtful_masses all: run in the folder with its CSV files.
set datafile separator ","
set terminal pngcairo size 1000,420 font "sans,11"
set output "doubtful_masses.png"
set multiplot title "Drive train with twenty doubtful moments of inertia: which may be zero" font "sans,13"
set size 0.68,0.92
set origin 0,0
set logscale xy
set format xy "10^{%T}"
set xlabel "moment of inertia [kg m^2]"
set ylabel "largest error in a twist [rad]"
set xrange [3e-7:5e-2]
set yrange [2e-8:2e-2]
set grid
set key top left
plot "doubtful_masses.csv" skip 1 using 2:3 with points pt 6 ps 1.8 lw 1.5 lc rgb "#606060" title "predicted", \
     "" skip 1 using 2:($5 == 1 ? $4 : NaN) with points pt 7 ps 0.9 lc rgb "#2050a0" title "measured, may be zero", \
     "" skip 1 using 2:($5 == 0 ? $4 : NaN) with points pt 7 ps 0.9 lc rgb "#c03030" title "measured, may not", \
     1e-4 with lines lw 1.5 dt 2 lc rgb "#c03030" title "allowed"
set size 0.32,0.92
set origin 0.68,0
unset logscale
unset key
set format "%g"
set format x "%s"
set xlabel " "
set ylabel "steps of IDA"
set xrange [-0.7:1.7]
set yrange [0:*]
set offsets 0,0,200,0
set style fill solid 0.6
set boxwidth 0.6
plot "doubtful_masses_steps.csv" skip 1 using 0:2:xtic(1) with boxes lc rgb "#606060", \
     "" skip 1 using 0:2:2 with labels offset 0,0.7
unset multiplot
