#!/bin/sh
# Calls and includes go down the table of rooms in docs/architecture.md, and no files are tied in a
# circle. A source and the header of its name are one unit; a unit is tied to those whose headers it
# includes and whose functions or tables its object uses.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: rooms.sh PROJECT_DIR OBJECT... (objects: .../TARGET.dir/ROOM/FILE.c.o)
set -eu
project=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The table, from ground to roof:  | 1 | `room/` | ...
sed -n 's/^| *[0-9][0-9]* *| *`\([a-z/]*\)\/`.*/\1/p' "$project/docs/architecture.md" >"$work/rooms"

# Ties, one a line: unit, the unit it needs, and by what.
cd "$project/src"
find . -name '*.[ch]' | sed 's|^\./||' | sort >"$work/files"
xargs grep -H '^#include "' <"$work/files" |
    sed 's/^\(.*\)\.[ch]:#include "\([^"]*\)\.h".*/\1 \2 \2.h/' >"$work/ties"
while read -r unit other header; do
    [ -f "$header" ] || echo "src/$unit includes $header, not a path from src/"
done <"$work/ties" >"$work/wrong"
xargs awk -f ../tests/hygiene/ties.awk <"$work/files" >>"$work/ties"
awk '$1 != $2' "$work/ties" | sort -u >"$work/between"

status=0
if [ -s "$work/wrong" ]; then cat "$work/wrong"; status=1; fi
awk '
    FILENAME == ARGV[1] { place[$1] = ++rooms; next }
    function room(unit) { sub("/[^/]*$", "", unit); return unit }
    function known(unit) {
        if (room(unit) in place) return 1
        if (!(unit in told)) print unit " is in no room of the table"
        told[unit] = bad = 1
        return 0
    }
    known($1) && known($2) && place[room($1)] < place[room($2)] {
        print $1 " -> " $2 " goes up (" $3 ")"
        bad = 1
    }
    END { exit bad }' "$work/rooms" "$work/between" || status=1
if ! cut -d' ' -f1,2 "$work/between" | tsort >/dev/null 2>"$work/loops"; then
    echo "files in a circle:"
    sed 's/^tsort: //' "$work/loops"
    status=1
fi

echo "$(wc -l <"$work/rooms") rooms, $(wc -l <"$work/files") files," \
    "$(wc -l <"$work/between") ties"
[ -s "$work/rooms" ] && [ -s "$work/files" ] || { echo "nothing to look at"; status=1; }
exit $status
