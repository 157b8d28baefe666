# Pictures of bench_precision: docs/precision.png and docs/bead.png. run.sh calls this where bead.csv
# is, with the paths `results` (precision.csv) and `pictures` (a folder).
# SPDX-License-Identifier: BSD-3-Clause
set datafile separator ","
set datafile commentschars "#"
set style line 1 lc rgb "#2050a0" lw 2 pt 7 ps 0.9
set style line 2 lc rgb "#208040" lw 2 pt 5 ps 0.9
set style line 3 lc rgb "#c03030" lw 2 pt 9 ps 1.0
set style line 4 lc rgb "#c08020" lw 2 pt 11 ps 1.0

forms = "momentum index1 recursive inverse_dynamics"
titles = "momentum index-1 recursive inverse-dynamics"
# The runs of one curve that came to their end: tolerance, steps, residuals, error.
rows(mass, damping, form) = sprintf("< awk -F, '$1==\"bead\" && $2==\"%s\" && $3==\"%s\" && " \
    . "$4==\"%s\" && $6==\"ok\" {print $5 \",\" $7 \",\" $8 \",\" $14}' %s", mass, damping, form, results)

set terminal pngcairo size 1500,860 font "sans,11"
set output pictures . "/precision.png"
set multiplot layout 2,3 title "Pendulum on a bead, t = 0 .. 10 s, IDA, rtol = atol = 1e-4 ... 1e-10" font "sans,13"
set logscale xy
set grid
set format x "10^{%L}"
set format y "10^{%L}"
set xrange [6e2:1e7]
set yrange [1e-11:1e1]
set xlabel "residual evaluations"
set ylabel "largest error of q at the end"
set key top right
do for [case in "0:5 1e-06:5 0:0"] {
    mass = case[1:strstrt(case, ":")-1]
    damping = case[strstrt(case, ":")+1:*]
    set title (damping eq "0" ? "bead mass 0, springs only (index 2; the others fail)" : "bead mass ".mass.", damping 5")
    plot for [k=1:(damping eq "0" ? 2 : 4)] rows(mass, damping, word(forms, k)) using 3:4 \
        with linespoints ls k title word(titles, k)
}
set xrange [2e-4:5e-11]
set yrange [1e2:3e6]
set xlabel "tolerance"
set ylabel "steps"
set key top left Left reverse
do for [case in "0:5 1e-06:5 0:0"] {
    mass = case[1:strstrt(case, ":")-1]
    damping = case[strstrt(case, ":")+1:*]
    unset title
    plot for [k=1:(damping eq "0" ? 2 : 4)] rows(mass, damping, word(forms, k)) using 1:2 \
        with linespoints ls k title word(titles, k)
}
unset multiplot

reset
set datafile separator ","
set terminal pngcairo size 700,760 font "sans,11"
set output pictures . "/bead.png"
set title "Pendulum on a bead without mass, t = 0 .. 10 s"
set size ratio -1
set grid
set xlabel "x [m]"
set ylabel "y [m]"
set key below vertical maxrows 3
# Four positions of the rod at the beginning.
plot "bead.csv" using 4:5 with lines lw 1 lc rgb "#2050a0" title "path of the mass", \
     "" using 2:3 with lines lw 1.5 lc rgb "#c03030" title "path of the bead", \
     "" every 20::0::60 using 2:3:($4-$2):($5-$3) with vectors nohead lw 2 lc rgb "#808080" \
         title "rod at t = 0, 0.1, 0.2, 0.3 s", \
     "" every 20::0::60 using 4:5 with points pt 7 ps 1.5 lc rgb "#2050a0" notitle, \
     "" every 20::0::60 using 2:3 with points pt 7 ps 1 lc rgb "#c03030" notitle
