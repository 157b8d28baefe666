#!/usr/bin/env bash
# The core on other processors and C libraries: numerical tests and examples, which check their results, compiled by
# cross compilers and run by qemu's emulation, or as they are. CMocka and the LAPACK that results are compared
# with are Debian's for that processor, unpacked beside the build; where there are none (musl, mingw), examples alone run.
# What was run, with what result: docs/portability.md.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: portability.sh [TARGET[-scalar] | lapack | bits]...    all of them without an argument
#     TARGET: aarch64, i686, s390x (big endian), musl, mingw (mingw-w64, run by wine); -scalar: without vector code
#     lapack: dense algebra, modes, finite elements and references with the LAPACK of each that lapack.sh knows
#     bits: without fused multiply-add, the same bits from the vector code of every level
#     MBSR_PORTABILITY_FLAGS=-O1: of the compiler, in place of a Release build; JOBS: at a time
set -eu
cd "$(dirname "${BASH_SOURCE[0]}")/.."
jobs=${JOBS:-$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)}
tests='unit\.(any_bytes|blocks|dense|derivatives|frames|jacobi|kinematics|lapack|locale|null_space|stepper|sweeps|tables)'
tests+='|reference\.(index_models|paper_equations|small_verdicts|tree_files)|property\.(loops_dynamics|newton|random_trees|verdicts)'
status=0

# unpack ARCHITECTURE TO: Debian's packages of that architecture, by lists of its own.
unpack() {
    local apt=(-q -o "APT::Architecture=$1" -o "APT::Architectures=$1" -o "Dir::State::lists=$2/apt/lists" -o Dir::State::status=/dev/null
               -o "Dir::Cache=$2/apt" -o APT::Sandbox::User=root)
    mkdir -p "$2/apt/lists/partial" "$2/apt/archives/partial"
    apt-get "${apt[@]}" update || echo "$1: some lists are missing" # what they lack fails to download
    (cd "$2/apt" && apt-get "${apt[@]}" download libcmocka-dev libcmocka0 liblapack-dev liblapack3 libblas-dev libblas3 libgfortran5 &&
        for package in *.deb; do dpkg-deb -x "$package" "$2"; done)
}

# cross TARGET: sets the options of cmake for it.
cross() {
    local architecture emulator=$1 triplet=$1-linux-gnu root=$PWD/build/portability-$1-root
    bash scripts/install.sh build test emulation
    case $1 in
    aarch64) architecture=arm64 ;;
    i686) architecture=i386 emulator=i386 ;;
    s390x) architecture=s390x ;;
    esac
    local folder=$root/usr/lib/$emulator-linux-gnu
    [ -d "$folder/cmake/cmocka" ] || unpack "$architecture" "$root"
    options=(-DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR="$1" -DCMAKE_C_COMPILER="$triplet-gcc" -DCMAKE_CXX_COMPILER=NOTFOUND
        "-DCMAKE_CROSSCOMPILING_EMULATOR=qemu-$emulator-static;-L;/usr/$triplet;-E;LD_LIBRARY_PATH=$folder:$folder/lapack:$folder/blas"
        -DMBSR_TESTS=ON -DMBSR_TEST_ONLY="$tests" -DMBSR_INSTALL=OFF -Dcmocka_DIR="$folder/cmake/cmocka"
        -DLAPACK_LIBRARIES="$folder/lapack/liblapack.so.3" -DBLAS_LIBRARIES="$folder/blas/libblas.so.3"
        "-DCMAKE_EXE_LINKER_FLAGS=-Wl,-rpath-link,$folder:$folder/blas" -DCMAKE_EXE_LINKER_FLAGS_RELEASE=)
}

# With every LAPACK that is there, the same programs.
try_lapacks() {
    local tree=build/portability-lapack name result=0
    bash scripts/install.sh build test lapacks
    cmake -S . -B "$tree" -DCMAKE_BUILD_TYPE=Release -DMBSR_EXAMPLES=OFF -DMBSR_PROGRAM=OFF \
        -DMBSR_TEST_ONLY='(linear|fe)\..*|unit\.(lapack|jacobi|dense|null_space)' >"$tree.log" 2>&1 || { cat "$tree.log"; return 1; }
    cmake --build "$tree" --parallel "$jobs" >>"$tree.log" 2>&1 || { tail -50 "$tree.log"; return 1; }
    for name in reference openblas openblas-serial blis; do
        echo "== $name"
        bash scripts/lapack.sh "$name" ctest --test-dir "$tree" --output-on-failure --no-tests=error --parallel "$jobs" \
            -R '^(linear|fe|unit)\.|^reference\.validation' || result=1
    done
    return $result
}

compare_bits() {
    local tree=build/portability-bits
    bash scripts/install.sh build test
    cmake -S . -B "$tree" -DCMAKE_BUILD_TYPE=Release -DMBSR_FMA=OFF -DMBSR_IDA=OFF -DMBSR_FILES=OFF -DMBSR_EXAMPLES=OFF \
        -DMBSR_TEST_ONLY='unit\.(sweeps|newton_sweeps|batch)' >"$tree.log" 2>&1 || { cat "$tree.log"; return 1; }
    cmake --build "$tree" --parallel "$jobs" >>"$tree.log" 2>&1 || { tail -50 "$tree.log"; return 1; }
    ctest --test-dir "$tree" --output-on-failure --no-tests=error -R '^unit\.'
}

for target in ${*:-aarch64 i686 s390x musl mingw lapack bits}; do
    echo "==== $target"
    case $target in
    lapack) try_lapacks || status=1; continue ;;
    bits) compare_bits || status=1; continue ;;
    esac
    tree=build/portability-$target
    options=(-DMBSR_TESTS=OFF -DCMAKE_CXX_COMPILER=NOTFOUND)
    case $target in
    aarch64* | i686* | s390x*) cross "${target%-scalar}" ;;
    musl*)
        bash scripts/install.sh build musl
        options+=(-DCMAKE_C_COMPILER=musl-gcc -DBUILD_SHARED_LIBS=OFF)
        ;;
    mingw*)
        bash scripts/install.sh build mingw
        export WINEPREFIX=$PWD/build/portability-wine WINEDEBUG=-all
        options+=(-DCMAKE_SYSTEM_NAME=Windows -DCMAKE_SYSTEM_PROCESSOR=x86_64 -DCMAKE_C_COMPILER=x86_64-w64-mingw32-gcc
            -DCMAKE_CROSSCOMPILING_EMULATOR=/usr/lib/wine/wine64 -DBUILD_SHARED_LIBS=OFF -DCMAKE_EXE_LINKER_FLAGS=-static)
        ;;
    esac
    case $target in *-scalar) options+=(-DMBSR_VECTORS=OFF) ;; esac
    type=(-DCMAKE_BUILD_TYPE=Release)
    if [ -n "${MBSR_PORTABILITY_FLAGS:-}" ]; then # the build type in which no source has -O3
        type=(-DCMAKE_BUILD_TYPE=MinSizeRel "-DCMAKE_C_FLAGS_MINSIZEREL=$MBSR_PORTABILITY_FLAGS -DNDEBUG")
    fi
    mkdir -p build
    cmake -S . -B "$tree" "${options[@]}" "${type[@]}" \
        -DMBSR_LAPACK=OFF -DMBSR_IDA=OFF -DMBSR_FILES=OFF -DMBSR_CONTACT=OFF -DMBSR_FE=OFF -DMBSR_STUDY=OFF -DMBSR_EXAMPLES=ON \
        >"$tree.log" 2>&1 || { cat "$tree.log"; status=1; continue; }
    cmake --build "$tree" --parallel "$jobs" >>"$tree.log" 2>&1 || { tail -50 "$tree.log"; status=1; continue; }
    MBSR_TEST_FEW=1 ctest --test-dir "$tree" --output-on-failure --no-tests=error --parallel "$jobs" \
        -R '^(unit|reference|property|example)\.' || status=1
done
exit $status
