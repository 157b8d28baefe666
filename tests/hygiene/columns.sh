#!/bin/sh
# No line of the sources is longer than 100 columns, which clang-format does not see where a line cannot be broken; and the
# licence has a line of its own in the head of each file.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: columns.sh PROJECT_DIR
set -eu
cd "$1"
files=$(find include src tests examples bench web -name '*.[ch]' | sort)
[ -n "$files" ] || { echo "no sources"; exit 1; }
# columns are characters: bytes that continue one do not count
# shellcheck disable=SC2086 # files are several words
long=$(LC_ALL=C awk '{ line = $0; gsub(/[\200-\277]/, "", line) } length(line) > 100 { print FILENAME ":" FNR ": " length(line) " columns" }' \
    $(printf '%s\n' $files | grep -E '^(include|src)/'))
# shellcheck disable=SC2086
bare=$(grep -LE '^(/\*| \*) SPDX-License-Identifier: BSD-3-Clause( \*/)?$' $files || true)
[ -z "$long" ] || printf '%s\n' "$long"
[ -z "$bare" ] || printf '%s: no licence on a line of its own\n' $bare
echo "$(printf '%s\n' $files | wc -l) files"
[ -z "$long" ] && [ -z "$bare" ]
