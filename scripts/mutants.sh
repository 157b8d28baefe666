#!/usr/bin/env bash
# Whether the tests see a changed operator: COUNT places in src/, by a seed, one after the other. Works on a copy of the
# project in build/mutants, in which scripts/coverage.sh says first which tests reach which lines. Fails where fewer than
# nine in ten are seen; survivors are argued in tests/mutants.md. Hours; needs ninja.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: mutants.sh [--again] [--seed S] [COUNT [FIRST]]    S: 1, COUNT: 100, FIRST: 1, the first change to be judged
#     --again    with the copy and the counters that are there
set -eu
again=no
seed=1
if [ "${1:-}" = --again ]; then
    again=yes
    shift
fi
if [ "${1:-}" = --seed ]; then
    seed=$2
    shift 2
fi
[ $# -le 2 ] || { echo "usage: mutants.sh [--again] [--seed S] [COUNT [FIRST]]" >&2; exit 2; }
cd "$(dirname "${BASH_SOURCE[0]}")/.."
copy=$PWD/build/mutants
if [ "$again" = no ]; then
    mkdir -p "$copy"
    git ls-files -z | tar --null -T - -cf - | tar -C "$copy" -xf -
    bash "$copy/scripts/coverage.sh" || echo "coverage.sh failed; what it counted is used all the same"
fi
export MBSR_TEST_FEW=1 OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
nice python3 scripts/mutants.py "$copy" "$seed" "${1:-100}" tests/mutants.md ${2:+"$2"}
