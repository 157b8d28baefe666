#!/bin/sh
# Instructions per body of the calls in count.c, counted by callgrind; CSV on standard output.
# SPDX-License-Identifier: BSD-3-Clause
#
#   count.sh PROGRAM TREES COMPILER     the built count.c, tests/reference/trees, such as gcc-12
set -eu

program=$1
trees=$2
compiler=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

valgrind --tool=callgrind --callgrind-out-file="$work/dump" --toggle-collect=measured \
    --dump-after=measured "$program" "$trees" > "$work/cases" 2> "$work/log" || {
    cat "$work/log" >&2
    exit 1
}
awk -v compiler="$compiler" -v dump="$work/dump" '{
    file = dump "." NR
    found = 0
    while ((getline line <file) > 0) {
        if (line !~ /^totals:/) continue
        split(line, totals)
        printf "%s,%s,%s,%s,%.1f\n", compiler, $1, $2, $3, totals[2] / $4
        found = 1
    }
    close(file)
    if (!found) exit 1
}' "$work/cases"
