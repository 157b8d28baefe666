# Picture of 31_doubtful_masses all: run in the folder with its CSV files.
set datafile separator ","
set terminal pngcairo size 1000,420 font "sans,11"
set output "doubtful_masses.png"
set multiplot layout 1,2 title "Twenty doubtful moments of inertia in a drive train" font "sans,13"
set logscale xy
set format xy "10^{%L}"
set xlabel "error that its zero is predicted to make [rad]"
set ylabel "error measured [rad]"
set xrange [1e-8:1e-1]
set yrange [1e-8:1e-1]
set key top left
set grid
set arrow from 1e-4,1e-8 to 1e-4,1e-1 nohead lc rgb "#c03030"
set label "allowed" at 1.2e-4,3e-8 textcolor rgb "#c03030"
plot x with lines lc rgb "#a0a0a0" title "as predicted", \
     3*x with lines dashtype 2 lc rgb "#a0a0a0" title "factor 3", \
     x/3 with lines dashtype 2 lc rgb "#a0a0a0" notitle, \
     "doubtful_masses.csv" skip 1 using ($5==1?$3:NaN):4 with points pt 7 lc rgb "#2050a0" title "may be zero", \
     "" skip 1 using ($5==0?$3:NaN):4 with points pt 5 lc rgb "#c03030" title "may not"
unset logscale
unset arrow
unset label
unset key
unset xlabel
set format xy "%g"
set ylabel "steps of IDA"
set xrange [-0.6:1.6]
set yrange [0:*]
set style fill solid 0.6
set boxwidth 0.5
plot "doubtful_masses_steps.csv" skip 1 using 0:2:xtic(1) with boxes lc rgb "#606060", \
     "" skip 1 using 0:2:2 with labels offset 0,0.7
unset multiplot
