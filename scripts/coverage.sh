#!/usr/bin/env bash
# What the tests reach in src/: builds it for gcov in build/coverage, runs the tests, prints lines and branches, and
# fails where they are below the figures in tests/coverage.txt. What nobody reaches is written to
# build/coverage/left.txt, the tests with their seconds and arcs to build/coverage/tests.txt.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: coverage.sh [--again] [--only REGEX]
#     --again    without building and running: figures of the counters that are there
#     --only     these tests alone, by their names; the figures are those of fewer tests
set -eu
again=no only='.*'
while [ $# -gt 0 ]; do
    case $1 in
    --again) again=yes ;;
    --only) only=${2:?--only REGEX}; shift ;;
    *) echo "usage: coverage.sh [--again] [--only REGEX]" >&2; exit 2 ;;
    esac
    shift
done
cd "$(dirname "${BASH_SOURCE[0]}")/.."
tree=build/coverage
counters=$PWD/$tree/counters
if [ "$again" = no ]; then
    bash scripts/install.sh build test
    jobs=$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)
    generator="Unix Makefiles"
    if command -v ninja >/dev/null; then generator=Ninja; fi
    # Branches as they are written: -O0, which MinSizeRel leaves as it is. Tests are not counted. A processor has one of the
    # upper two kernel levels. Forked processes write their counters where they end by exit.
    cmake -S . -B "$tree" -G "$generator" -DCMAKE_C_COMPILER=gcc -DCMAKE_BUILD_TYPE=MinSizeRel \
        -DCMAKE_C_FLAGS_MINSIZEREL= -DMBSR_VIEWER=OFF -DMBSR_DEFAULT_O2=OFF -DMBSR_HAS_V4=OFF -DMBSR_TEST_COUNTERS="$counters" \
        -DMBSR_TEST_ONLY="$only" \
        -DCMAKE_C_FLAGS="-O0 -DNDEBUG -D_exit=exit --coverage -fprofile-filter-files=.*/src/.*"
    nice cmake --build "$tree" --parallel "$jobs"
    rm -rf "$counters"
    mkdir -p "$counters"
    # Packages and hygiene have builds of their own, or run none of src/; gcov exports names. -O0 is slow: short forms of long tests.
    (cd "$tree" && MBSR_TEST_FEW=1 OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 nice ctest --parallel "$jobs" \
        -R "^($only)\$" -E '^fmu\.exports$' -LE 'package|hygiene|instructions' --output-on-failure --output-junit junit.xml) ||
        echo "tests failed: what they reached counts all the same"
fi
python3 scripts/coverage.py tests "$tree" "$counters" "$tree/junit.xml" >"$tree/tests.txt"
python3 scripts/coverage.py figures "$tree" "$counters" tests/coverage.txt "$tree/left.txt"
