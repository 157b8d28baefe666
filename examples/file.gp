# Plots what `scripts/demo.sh file` writes: a quarter car and an arm, both read from files.
# SPDX-License-Identifier: BSD-3-Clause
set terminal pngcairo size 1000,700
set output "file.png"
set datafile separator ","
set multiplot layout 2,1
set key outside right
set xlabel "t, s"
set ylabel "quarter car, mm"
plot for [k = 2:4] "quarter_car.csv" using 1:(1e3 * column(k)) skip 1 with lines title word("tyre damper rubber", k - 1)
set ylabel "arm, rad"
plot for [k = 2:4] "arm.csv" using 1:k skip 1 with lines title word("shoulder elbow pitch", k - 1)
unset multiplot
