#!/bin/sh
# A name of a function that is static is the function's own: of the names that stand in three or more files of src/ no more
# than MOST are there. With a third argument they are listed, with the files.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: names.sh PROJECT_DIR MOST [list]
set -eu
cd "$1"
most=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# "NAME FILE" of each definition: a line that begins with static and has the name before the first parenthesis. What
# stands in a table under the same name, ".energy = energy", has its name from the table and does not count.
find src -name '*.[ch]' | sort | xargs awk '
    /^static / && /\(/ && !/;[ ]*$/ && !/=/ {
        head = $0
        sub(/\(.*/, "", head)
        sub(/.*[ *]/, "", head)
        if (head ~ /^[a-z_0-9]+$/) print head, FILENAME
    }' | sort -u >"$work/defined"
find src -name '*.[ch]' | sort | xargs awk '
    { for (rest = $0; match(rest, /\.[a-z_0-9]+ = [a-z_0-9]+/); rest = substr(rest, RSTART + RLENGTH)) {
        split(substr(rest, RSTART + 1, RLENGTH - 1), side, " = ")
        if (side[1] == side[2]) print side[1], FILENAME
    } }' | sort -u >"$work/entries"
comm -23 "$work/defined" "$work/entries" >"$work/all"
cut -d' ' -f1 "$work/all" | uniq -c | awk '$1 >= 3 { print $1, $2 }' | sort -k1,1nr -k2 >"$work/shared"
if [ "${3:-}" = list ]; then
    while read -r count name; do
        echo "$count $name:" $(awk -v n="$name" '$1 == n { print $2 }' "$work/all")
    done <"$work/shared"
fi
count=$(wc -l <"$work/shared")
echo "$(wc -l <"$work/all") static functions, $count names in three or more files"
find src -name '*.[ch]' | sort | xargs awk '
    /^} mbsri_[a-z_0-9]+;/ { name = $2; sub(/;/, "", name); print name, FILENAME ":" FNR }' | sort >"$work/types"
twice=$(cut -d' ' -f1 "$work/types" | uniq -d)
for name in $twice; do echo "type $name:" $(awk -v n="$name" '$1 == n { print $2 }' "$work/types"); done
[ -s "$work/all" ] && [ -s "$work/types" ] && [ -z "$twice" ] && [ "$count" -le "$most" ]
