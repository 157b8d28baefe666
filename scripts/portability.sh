#!/usr/bin/env bash
# The core on other processors: compiled by cross compilers, its examples, which check their results, run by qemu's
# emulation. With the library's own routines in place of LAPACK. Needs gcc-*-linux-gnu and qemu-user-static.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: portability.sh [PROCESSOR]...    aarch64, i686, s390x (big endian); all of them without an argument
set -eu
cd "$(dirname "${BASH_SOURCE[0]}")/.."
bash scripts/install.sh build test emulation
jobs=$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)
status=0
for processor in ${*:-aarch64 i686 s390x}; do
    emulator=qemu-$processor-static
    if [ "$processor" = i686 ]; then emulator=qemu-i386-static; fi
    echo "==== $processor"
    tree=build/portability-$processor
    cmake -S . -B "$tree" -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR="$processor" \
        -DCMAKE_C_COMPILER="$processor-linux-gnu-gcc" -DCMAKE_CXX_COMPILER=NOTFOUND -DCMAKE_CROSSCOMPILING_EMULATOR="$emulator;-L;/usr/$processor-linux-gnu" \
        -DCMAKE_BUILD_TYPE=Release -DMBSR_LAPACK=OFF -DMBSR_IDA=OFF -DMBSR_FILES=OFF -DMBSR_TESTS=OFF -DMBSR_EXAMPLES=ON \
        >"$tree.log" 2>&1 || { cat "$tree.log"; status=1; continue; }
    cmake --build "$tree" --parallel "$jobs" >>"$tree.log" 2>&1 || { tail -50 "$tree.log"; status=1; continue; }
    ctest --test-dir "$tree" --output-on-failure --no-tests=error --parallel "$jobs" || status=1
done
exit $status
