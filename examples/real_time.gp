# Picture of 37_real_time: run in the folder with its CSV file.
set datafile separator ","
set terminal pngcairo size 1000,460 font "sans,11"
set output "real_time.png"
set title "A figure jumps and lies down: steps of 1/60 s" font "sans,13"
set size ratio -1
set xlabel "m"
set ylabel "m"
set xrange [-0.5:2.9]
set yrange [-0.15:2.3]
set key inside right top
set object 1 rectangle from graph 0, first -0.15 to graph 1, first 0 fillcolor rgb "#e0e0e0" fillstyle solid noborder behind
array time[6] = ["0 s", "0.2 s", "0.4 s", "0.6 s", "1 s", "6 s"]
array colour[6] = ["#c0c0c0", "#9ab0d0", "#6a8fc0", "#3868a8", "#c08030", "#c03030"]
plot for [k=0:5] "real_time.csv" index k using 1:3 with lines lw 3 lc rgb colour[k+1] title time[k+1]
