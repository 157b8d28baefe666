#!/bin/sh
# Counts anew what baseline.csv holds, with gcc and clang as far as they are installed; lines of
# other compilers stay. Crowds of loops are compared with each other alone.
# SPDX-License-Identifier: BSD-3-Clause
set -eu

here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
for compiler in gcc clang; do
    if ! command -v "$compiler" > /dev/null; then continue; fi
    tree=$root/build/instructions-$compiler
    cmake -S "$root" -B "$tree" -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_COMPILER="$compiler" \
        -DMBSR_IDA=OFF -DMBSR_EXAMPLES=OFF > /dev/null
    cmake --build "$tree" --parallel "$(getconf _NPROCESSORS_ONLN)" --target instructions_count
    name=$(cat "$tree/tests/instructions/compiler")
    sh "$here/count.sh" "$tree/tests/instructions/instructions_count" \
        "$root/tests/reference/trees" "$name" | grep -v ",crowds," > "$tree/counts"
    grep -v "^$name," "$here/baseline.csv" > "$tree/others"
    cat "$tree/others" "$tree/counts" > "$here/baseline.csv"
done
