#!/usr/bin/env bash
# Computes the public references of docs/validation.md anew and writes its tables.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: validation.sh [--check PROGRAM]
#     --check    fails where a row is not in the page, or differs from the published digits by more than is allowed;
#                PROGRAM is the built test (tests/reference_validation)
set -eu
cd "$(dirname "${BASH_SOURCE[0]}")/.."
page=docs/validation.md
program=
if [ "${1:-}" = --check ]; then
    program=$2
else
    bash scripts/install.sh build test
    tree=build/validation
    cmake -S . -B "$tree" -DCMAKE_BUILD_TYPE=Release -DMBSR_EXAMPLES=OFF -DMBSR_PROGRAM=OFF >/dev/null
    cmake --build "$tree" --target reference_validation --parallel "$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)"
    program=$tree/tests/reference_validation
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$program" --table >"$work/tables"
"$program"

# Everything but the digits computed here, which may end differently elsewhere.
published() { awk -F'|' 'NF > 4 { print $2 "|" $3 "|" $5; next } { print }' "$1"; }

between='/^<!-- tables -->$/,/^<!-- end -->$/'
if [ "${1:-}" = --check ]; then
    sed -n "$between p" "$page" | sed '1d;$d' >"$work/page"
    published "$work/page" >"$work/page.published"
    published "$work/tables" >"$work/tables.published"
    diff -u "$work/page.published" "$work/tables.published"
else
    { sed '/^<!-- tables -->$/q' "$page"; cat "$work/tables"; sed -n '/^<!-- end -->$/,$p' "$page"; } >"$work/new"
    cp "$work/new" "$page"
fi
