#!/usr/bin/env bash
# Whether the tests see a changed operator: COUNT places in src/, by a seed, one after the other. Works on a copy of the
# project in build/mutants. Fails where fewer than nine in ten are seen; survivors are argued in tests/mutants.md. Hours.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: mutants.sh [--seed S] [COUNT]    S: 1, COUNT: 100
set -eu
seed=1
if [ "${1:-}" = --seed ]; then
    seed=$2
    shift 2
fi
count=${1:-100}
[ $# -le 1 ] || { echo "usage: mutants.sh [--seed S] [COUNT]" >&2; exit 2; }
cd "$(dirname "${BASH_SOURCE[0]}")/.."
bash scripts/install.sh build test
copy=$PWD/build/mutants
mkdir -p "$copy"
git ls-files -z | tar --null -T - -cf - | tar -C "$copy" -xf -
generator="Unix Makefiles"
if command -v ninja >/dev/null; then generator=Ninja; fi
# The short forms of the tests, each linked when it is asked for.
cmake -S "$copy" -B "$copy/build" -G "$generator" -DCMAKE_BUILD_TYPE=Release -DMBSR_EXAMPLES=OFF -DMBSR_VIEWER=OFF >/dev/null
CMAKE_BUILD_PARALLEL_LEVEL=$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)
export CMAKE_BUILD_PARALLEL_LEVEL MBSR_TEST_FEW=1 OPENBLAS_NUM_THREADS=1
nice python3 scripts/mutants.py "$copy" "$seed" "$count" tests/mutants.md
