#!/bin/sh
# A shared library exports exactly the MBSR_API functions of its headers, and debian/ lists them.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: symbols.sh LIBRARY HEADER... (names in include/mbsrank without .h), run in the source tree
set -eu
command -v nm >/dev/null || { echo "nm is missing"; exit 77; }
library=$1
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Directives go, lines are joined, and the word before the first parenthesis is the name.
for header; do
    { sed '/^[[:space:]]*#/d' "include/mbsrank/$header.h" | tr '\n' ' '; echo; } |
        sed 's/MBSR_API/\nMBSR_API/g' |
        sed -n 's/^MBSR_API[^(]*[^(A-Za-z0-9_]\([A-Za-z0-9_]*\)[[:space:]]*(.*/\1/p'
done | sort -u >"$work/declared"
nm -D --defined-only "$library" | awk '{ print $3 }' | sed 's/@.*//' | sort -u >"$work/exported"

echo "$(wc -l <"$work/declared") functions declared, $(wc -l <"$work/exported") symbols exported"
status=0
[ -s "$work/declared" ] || { echo "no MBSR_API functions found in the headers"; status=1; }
missing=$(comm -23 "$work/declared" "$work/exported")
extra=$(comm -13 "$work/declared" "$work/exported")
# A prototype starts in the first column.
for header; do
    if grep -HnE '^[a-z].*[^A-Za-z0-9_]mbsr_[a-z0-9_]+\(' "include/mbsrank/$header.h" |
        grep -v ':typedef '; then
        echo "declared without MBSR_API"
        status=1
    fi
done
package=$(basename "$library" | sed 's/\.so.*//; s/_/-/')
sed -n 's/^ \(mbsr_[a-z0-9_]*\)@.*/\1/p' debian/"$package"[0-9]*.symbols | sort -u >"$work/packaged"
unlisted=$(comm -3 "$work/declared" "$work/packaged")
[ -z "$unlisted" ] || { printf 'declared, or in debian/%s*.symbols, alone:\n%s\n' "$package" "$unlisted"; status=1; }
[ -z "$missing" ] || { printf 'declared but not exported:\n%s\n' "$missing"; status=1; }
[ -z "$extra" ] || { printf 'exported but not declared:\n%s\n' "$extra"; status=1; }
exit $status
