# Picture of 16_heavy_top: run in the folder with its CSV file.
set datafile separator ","
set terminal pngcairo size 1000,380 font "sans,11"
set output "heavy_top.png"
set multiplot layout 1,3 title "Tip of a heavy top on the sphere, 3 s" font "sans,13"
unset tics
unset border
unset key
set parametric
set urange [0:2*pi]
set vrange [0:pi/2]
set isosamples 25,10
set hidden3d
set view 40,30,1.7
set xrange [-1:1]
set yrange [-1:1]
set zrange [0:1]
set view equal xyz
array label[3] = ["released at rest", "pushed against its precession", "pushed along"]
do for [k=0:2] {
    set title label[k+1]
    splot cos(u)*sin(v),sin(u)*sin(v),cos(v) with lines lw 0.5 lc rgb "#d0d0d0", \
          "heavy_top.csv" index k using ($2*1.01):($3*1.01):($4*1.01) with lines lw 1.5 lc rgb "#c03030"
}
unset multiplot
