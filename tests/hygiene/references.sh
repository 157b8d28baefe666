#!/bin/sh
# The files and folders that the documents name are there, and so are the sources that comments name
# with their folder (room/file.c). Functions stand in the files that the tables of "Where do I find" have beside them.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: references.sh PROJECT_DIR
set -eu
cd "$1"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# named PATTERN FILE...: one a line, where it is named, and the path; not where it is part of an address.
named() {
    pattern=$1
    shift
    awk -v path="$pattern" '
        /^[ \t]*#[ \t]*include/ { next }
        {
            for (rest = $0; match(rest, path); rest = substr(rest, RSTART + RLENGTH)) {
                before = substr(" " rest, RSTART, 1)
                after = substr(rest, RSTART + RLENGTH, 1)
                if (before !~ /[A-Za-z0-9_.\/-]/ && after !~ /[A-Za-z0-9_]/)
                    print FILENAME ":" FNR, substr(rest, RSTART, RLENGTH)
            }
        }' "$@"
}
named '(src|include|tests|examples|bench|docs|scripts|cmake)/([A-Za-z0-9_-]+[/.])*[A-Za-z0-9_-]*' \
    README.md CHANGELOG.md CONTRIBUTING.md SECURITY.md docs/*.md bench/README.md >"$work/named"
# shellcheck disable=SC2046 # files are several words
named '([A-Za-z0-9_-]+/)+[a-z0-9_]+[.][ch]' $(find src include tests examples bench -name '*.[ch]') >>"$work/named"

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
# Of all sources, which of these names stand in which file; then the rows none of whose files has its name.
# shellcheck disable=SC2046
awk '
    FILENAME == ARGV[1] { wanted[$2] = 1; rows[++count] = $0; next }
    {
        gsub(/[^A-Za-z0-9_]+/, " ")
        for (k = split($0, word, " "); k > 0; --k)
            if (word[k] in wanted && !((word[k], FILENAME) in found)) {
                found[word[k], FILENAME] = 1
                where[word[k]] = where[word[k]] " " FILENAME
            }
    }
    END {
        for (r = 1; r <= count; ++r) {
            parts = split(rows[r], part, " ")
            there = 0
            n = split(where[part[2]], file, " ")
            for (p = 3; p <= parts; ++p)
                for (k = 1; k <= n; ++k)
                    there = there || index(file[k], part[p]) == 1 ||
                        substr("/" file[k], length(file[k]) - length(part[p]) + 1) == "/" part[p]
            if (!there) {
                sub(/^[^ ]* [^ ]* */, " ", rows[r])
                print "docs/architecture.md:" part[1] ": " part[2] " is not in" rows[r]
            }
        }
    }' "$work/functions" $(cat "$work/sources") >>"$work/missing"

cat "$work/missing"
echo "$(wc -l <"$work/named") references, $(wc -l <"$work/functions") functions"
[ -s "$work/named" ] && [ -s "$work/functions" ] && [ ! -s "$work/missing" ]
