#!/bin/sh
# The lines of shell in the documents run, one page after the other, in a folder that has the examples. What the
# page of a model needs may be missing from the build, and gnuplot from the machine.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: documents.sh PROGRAM PROJECT_DIR
set -eu
program=$1
project=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/bin"
ln -s "$program" "$work/bin/mbsrank"
PATH=$work/bin:$PATH
status=0
count=0
for document in "$project"/README.md "$project"/docs/*.md; do
    awk '/^```sh$/ { on = 1; next } /^```/ { on = 0 } on && /^mbsrank / { print FNR " " $0 }' "$document" >"$work/lines"
    [ -s "$work/lines" ] || continue
    folder=$work/$(basename "$document" .md)
    mkdir "$folder"
    ln -s "$project/examples" "$folder/examples"
    while read -r line command; do
        count=$((count + 1))
        if (cd "$folder" && sh -c "$command") >"$work/said" 2>&1; then continue; fi
        case $command in "mbsrank plot "*) ! grep -q 'gnuplot is missing' "$work/said" || continue ;; esac
        case $command in "mbsrank view "*) ! grep -q 'built without\|no bundle\|npm' "$work/said" || continue ;; esac
        echo "$document:$line: $command"
        cat "$work/said"
        status=1
    done <"$work/lines"
done
echo "$count lines"
[ "$count" -gt 0 ] || status=1
exit $status
