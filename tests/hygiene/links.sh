#!/bin/sh
# Links of the documents lead somewhere: to files that are there and to headings that the page has. What documents
# name as functions, types and constants stands in a header, in the build files or, of names within the library, in
# the sources.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: links.sh PROJECT_DIR
set -eu
cd "$1"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
documents="README.md CHANGELOG.md CONTRIBUTING.md SECURITY.md bench/README.md $(echo docs/*.md)"

# "FILE#ANCHOR" of all headings, as GitHub makes them: small letters, digits, - and _; a hyphen for each space.
# shellcheck disable=SC2086 # documents are several words
awk '
    /^```/ { fence = !fence }
    !fence && /^#+ / {
        text = tolower($0)
        sub(/^#+ +/, "", text)
        gsub(/[][!"#$%&\047()*+,.\/:;<=>?@\\^`{|}~]/, "", text)
        gsub(/…|–|—|·/, "", text)
        gsub(/ /, "-", text)
        print FILENAME "#" text
    }' $documents >"$work/anchors"

# Links, one a line: document, line, the file they lead to, its "FOLDER/.." taken out, and the heading.
# shellcheck disable=SC2086
awk '
    /^```/ { fence = !fence }
    !fence {
        gsub(/`[^`]*`/, "")
        for (rest = $0; match(rest, /\]\([^)]+\)/);) {
            target = substr(rest, RSTART + 2, RLENGTH - 3)
            rest = substr(rest, RSTART + RLENGTH)
            if (target ~ /:\/\/|^mailto:/) continue
            file = heading = target
            sub(/#.*/, "", file)
            if (!sub(/^[^#]*#/, "", heading)) heading = ""
            if (file == "") file = FILENAME
            else file = substr(FILENAME, 1, match(FILENAME, /\/[^\/]*$/)) file
            while (sub(/(^|\/)[^\/.][^\/]*\/\.\.\//, "/", file)) sub(/^\//, "", file)
            print FILENAME, FNR, file, heading
        }
    }' $documents >"$work/links"
while read -r document line file heading; do
    [ -e "$file" ] || echo "$document:$line: there is no $file"
done <"$work/links" >"$work/dead"
awk 'NR == FNR { there[$0]; next }
    $4 != "" && $3 ~ /\.md$/ && !($3 "#" $4 in there) { print $1 ":" $2 ": " $3 " has no heading #" $4 }' \
    "$work/anchors" "$work/links" >>"$work/dead"

# Names in the documents, with where they stand first; ours begin with mbsr_, mbsri_ or MBSR_.
# The first column of docs/renamed.md has names that are no more.
# shellcheck disable=SC2086
awk '{
    if (FILENAME == "docs/renamed.md") sub(/^[|][^|]*[|]/, "")
    for (rest = $0; match(rest, /(mbsr|mbsri|MBSR)_[A-Za-z0-9_]*/); rest = substr(rest, RSTART + RLENGTH)) {
        name = substr(rest, RSTART, RLENGTH)
        if (name !~ /_$/ && !(name in seen)) { seen[name] = 1; print name, FILENAME ":" FNR }
    }
}' $documents | sort >"$work/names"
cat include/mbsrank/*.h CMakeLists.txt cmake/* src/CMakeLists.txt tests/CMakeLists.txt tests/*/CMakeLists.txt \
    tests/support/*.[ch] scripts/*.sh | grep -ohE '(mbsr|MBSR)_[A-Za-z0-9_]+' | sort -u >"$work/there"
grep -rohE '(mbsri|MBSRI)_[A-Za-z0-9_]+' src | sort -u >>"$work/there"
sort -u -o "$work/there" "$work/there"
join -v 1 "$work/names" "$work/there" | sed 's/\(.*\) \(.*\)/\2: nothing is called \1/' >>"$work/dead"

cat "$work/dead"
echo "$(wc -l <"$work/links") links, $(wc -l <"$work/names") names"
[ -s "$work/links" ] && [ -s "$work/names" ] && [ ! -s "$work/dead" ]
