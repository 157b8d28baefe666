#!/usr/bin/env bash
# Whether the tests see a changed operator: COUNT places in src/, by a seed, one after the other. Works on a copy of the
# project in build/mutants, in which scripts/coverage.sh says first which tests reach which lines. Fails where fewer than
# nine in ten are seen; survivors are argued in tests/mutants.md. Hours; needs ninja.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: mutants.sh [--again] [--only REGEX] [--seed S] [--seconds T] [COUNT [FIRST]]
#     --again      with the copy and the counters that are there
#     --only       these tests alone, by their names; what none of them reaches counts as not seen
#     --seed       1 where it is left out
#     --seconds    of tests for each change: 60 where it is left out
#     COUNT        100; FIRST is the first change to be judged, 1
set -eu
again=no seed=1 seconds=60 only=
usage() {
    echo "usage: mutants.sh [--again] [--only REGEX] [--seed S] [--seconds T] [COUNT [FIRST]]" >&2
    exit 2
}
while [ $# -gt 0 ]; do
    case $1 in
    --again) again=yes ;;
    --only | --seed | --seconds)
        [ $# -ge 2 ] || usage
        case $1 in --only) only=$2 ;; --seed) seed=$2 ;; *) seconds=$2 ;; esac
        shift
        ;;
    -*) usage ;;
    *) break ;;
    esac
    shift
done
[ $# -le 2 ] || usage
cd "$(dirname "${BASH_SOURCE[0]}")/.."
copy=$PWD/build/mutants
if [ "$again" = no ]; then
    mkdir -p "$copy"
    git ls-files -z | tar --null -T - -cf - | tar -C "$copy" -xf -
    bash "$copy/scripts/coverage.sh" ${only:+--only "$only"} || echo "coverage.sh failed; what it counted is used all the same"
fi
export MBSR_TEST_FEW=1 OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
nice python3 scripts/mutants.py "$copy" "$seed" "${1:-100}" tests/mutants.md "${2:-1}" "$seconds"
