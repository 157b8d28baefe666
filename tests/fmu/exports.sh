#!/bin/sh
# The shared object of FMUs exports the functions of the standard, all of them and nothing else, and needs libc, libm and threads alone.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: exports.sh LIBRARY FMI2_HEADER FMI3_HEADER
set -eu
command -v readelf >/dev/null || { echo "readelf is missing"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
nm -D --defined-only "$1" | awk '{ print $3 }' | sort -u >"$work/exported"
cat "$2" "$3" | grep -oE '\bfmi[23][A-Z][A-Za-z0-9]*\(' | tr -d '(' | sort -u >"$work/declared"
diff "$work/declared" "$work/exported" || { echo "exported are others than declared"; exit 1; }
[ "$(wc -l <"$work/declared")" -eq 119 ] || { echo "the standards have 44 and 75 functions"; exit 1; }
strange=$(readelf -d "$1" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' |
    grep -vE '^(libc|libm|libpthread|ld-linux.*)\.so' || true)
[ -z "$strange" ] || { echo "needs $strange"; exit 1; }
if readelf -d "$1" | grep -qE 'RPATH|RUNPATH|TEXTREL'; then echo "has a path or text relocations"; exit 1; fi
if nm -D -u "$1" | grep -wE 'setlocale|uselocale|exit|_exit|abort|system'; then
    echo "ends the process, or changes its locale"
    exit 1
fi
