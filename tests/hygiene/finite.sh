#!/bin/sh
# Every MBSR_API function of the headers stands in a table of the tests that nothing returns MBSR_OK
# with a number that is not finite (tests/support/finite.h).
# SPDX-License-Identifier: BSD-3-Clause
# Usage: finite.sh PROJECT_DIR
set -eu
cd "$1"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for header in include/mbsrank/*.h; do
    { sed '/^[[:space:]]*#/d' "$header" | tr '\n' ' '; echo; } |
        sed 's/MBSR_API/\nMBSR_API/g' |
        sed -n 's/^MBSR_API[^(]*[^(A-Za-z0-9_]\([A-Za-z0-9_]*\)[[:space:]]*(.*/\1/p'
done | sort -u >"$work/declared"
find tests -name 'test_*finite*.c' -exec grep -ho '"mbsr_[a-z0-9_][a-z0-9_]*"' {} + | tr -d '"' |
    sort -u >"$work/listed"

echo "$(wc -l <"$work/declared") functions declared, $(wc -l <"$work/listed") in tables"
status=0
[ -s "$work/declared" ] || { echo "no MBSR_API functions found in the headers"; status=1; }
missing=$(comm -23 "$work/declared" "$work/listed")
extra=$(comm -13 "$work/declared" "$work/listed")
[ -z "$missing" ] || { printf 'in no table of tests/**/test_*finite*.c:\n%s\n' "$missing"; status=1; }
[ -z "$extra" ] || { printf 'in a table, but not declared:\n%s\n' "$extra"; status=1; }
exit $status
