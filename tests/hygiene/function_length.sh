#!/bin/sh
# No function is longer than a given number of lines. The braces of a function's body stand in the
# first column, as the format demands.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: function_length.sh LINES SOURCE_DIR
set -eu
find "$2" -name '*.[ch]' | grep -q . || { echo "no sources in $2"; exit 1; }
find "$2" -name '*.[ch]' | sort | xargs awk -v limit="$1" '
    FNR == 1 { start = 0 }
    /^{/ { start = FNR }
    /^}/ && start {
        lines = FNR - start + 1
        if (lines > limit) { printf "%s:%d: %d lines, %d allowed\n", FILENAME, start, lines, limit; bad = 1 }
        start = 0
    }
    END { exit bad }'
