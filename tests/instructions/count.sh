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
number=0
while read -r kernel tree call bodies; do
    number=$((number + 1))
    awk -v case="$compiler,$kernel,$tree,$call" -v bodies="$bodies" '
        /^totals:/ { printf "%s,%.1f\n", case, $2 / bodies; found = 1 }
        END { exit !found }' "$work/dump.$number"
done < "$work/cases"
