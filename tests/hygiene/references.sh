#!/bin/sh
# The files and folders that the documents name are there, and so are the sources that comments name
# with their folder (room/file.c). Functions stand in the files that the tables of "Where do I find" have beside them.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: references.sh PROJECT_DIR
set -eu
cd "$1"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# One a line: where it is named, and the path; not where it is part of an address.
named() {
    awk -v path="$1" '
        /^[ \t]*#[ \t]*include/ { next }
        {
            for (rest = $0; match(rest, path); rest = substr(rest, RSTART + RLENGTH)) {
                before = substr(" " rest, RSTART, 1)
                after = substr(rest, RSTART + RLENGTH, 1)
                if (before !~ /[A-Za-z0-9_.\/-]/ && after !~ /[A-Za-z0-9_]/)
                    print FILENAME ":" FNR, substr(rest, RSTART, RLENGTH)
            }
        }' "$2"
}
for document in README.md CHANGELOG.md docs/*.md bench/README.md; do
    named '(src|include|tests|examples|bench|docs|scripts|cmake)/([A-Za-z0-9_-]+[/.])*[A-Za-z0-9_-]*' \
        "$document"
done >"$work/named"
find src include tests examples bench -name '*.[ch]' | while read -r source; do
    named '([A-Za-z0-9_-]+/)+[a-z0-9_]+[.][ch]' "$source"
done >>"$work/named"

while read -r place path; do
    for from in . src include tests tests/unit bench; do
        if [ -e "$from/${path%.}" ]; then continue 2; fi
    done
    echo "$place: there is no $path"
done <"$work/named" >"$work/missing"

# "LINE NAME FILE ..." of each function in a row
find src python web -name '*.[ch]' -o -name '*.py' >"$work/sources"
awk '/^## /{ inside = /Where do I find/ } inside && /^[|].*`/ {
    files = ""
    for (rest = $0; match(rest, /[A-Za-z0-9_\/-]+[.](c|h|py)|src\/[a-z\/]+/); rest = substr(rest, RSTART + RLENGTH))
        files = files " " substr(rest, RSTART, RLENGTH)
    for (rest = $0; match(rest, /`[A-Za-z_][A-Za-z0-9_.]*`/); rest = substr(rest, RSTART + RLENGTH)) {
        name = substr(rest, RSTART + 1, RLENGTH - 2)
        sub(/.*[.]/, "", name)
        print FNR, name files
    }
}' docs/architecture.md >"$work/functions"
while read -r line name files; do
    for file in $files; do
        if grep -e "/$file\$" -e "^$file" "$work/sources" | xargs grep -qw -e "$name"; then continue 2; fi
    done
    echo "docs/architecture.md:$line: $name is not in$(printf ' %s' $files)"
done <"$work/functions" >>"$work/missing"

cat "$work/missing"
echo "$(wc -l <"$work/named") references, $(wc -l <"$work/functions") functions"
[ -s "$work/named" ] && [ -s "$work/functions" ] && [ ! -s "$work/missing" ]
