#!/bin/sh
# No function is longer than a given number of lines. The braces of a function's body stand in the
# first column, as the format demands.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: function_length.sh LINES SOURCE_DIR
set -eu
find "$2" -name '*.[ch]' | grep -q . || { echo "no sources in $2"; exit 1; }
find "$2" -name '*.[ch]' | sort | while read -r file; do
    awk -v limit="$1" -v file="$file" '
        /^{/ { start = NR }
        /^}/ && start {
            lines = NR - start + 1
            if (lines > limit) printf "%s:%d: %d lines, %d allowed\n", file, start, lines, limit
            start = 0
        }' "$file"
done | {
    if grep .; then exit 1; fi
}
