#!/bin/sh
# How another project that includes the library compiles it, as its compile commands say: with -O2
# where that project says nothing, and as that project says where it does. Nothing is compiled.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: optimisation.sh CMAKE SOURCE WORK CC GENERATOR IDA(ON|OFF)
set -eu
cmake=$1 source=$2 work=$3 cc=$4 generator=$5 ida=$6
case $generator in
Ninja | "Unix Makefiles") ;;
*) echo "$generator writes no compile commands of one configuration"; exit 77 ;;
esac
unset CFLAGS CMAKE_BUILD_TYPE # from the environment, they count as given by the project
rm -rf "$work"
mkdir -p "$work"
: >"$work/nothing.cmake"
failed=0

# levels FILE: its compile commands, one a line: object, and the last -O flag or none.
levels() {
    awk '/^ *"command":/ {
        object = level = "none"
        for (i = 1; i <= NF; ++i) {
            if ($i ~ /^-O/) level = $i
            if ($i == "-o") object = $(i + 1)
        }
        print object, level
    }' "$1"
}

# expect NAME LIBRARY KERNELS PROGRAM OPTION...: the last -O flags of the library's files, of its loops
# over small matrices, sweeps in vector code and others, and of the project's own program, configured
# with these options.
expect() {
    name=$1 library=$2 kernels=$3 program=$4
    shift 4
    # one tree for all, whose checks are made once; what the options leave out is as at first; without what is slow to find
    if ! "$cmake" -S "$source/tests/package/consumer" -B "$work/tree" -G "$generator" \
            -DCMAKE_C_COMPILER="$cc" -DCMAKE_EXPORT_COMPILE_COMMANDS=ON \
            -DMBSRANK_SOURCE="$source" -DMBSR_IDA="$ida" -DMBSR_VIEWER=OFF -DMBSR_HDF5=OFF -DMBSR_MPI=OFF \
            -DCMAKE_BUILD_TYPE= -DCMAKE_C_FLAGS= \
            -DCMAKE_PROJECT_consumer_INCLUDE="$work/nothing.cmake" \
            -DMBSR_DEFAULT_O2=ON "$@" >"$work/$name.log" 2>&1; then
        cat "$work/$name.log"
        failed=1
        return
    fi
    levels "$work/tree/compile_commands.json" >"$work/$name.levels"
    awk -v library="$library" -v kernels="$kernels" -v program="$program" -v name="$name" '
        BEGIN {
            wanted["kernels"] = kernels
            wanted["library"] = library
            wanted["program"] = program
        }
        {
            kind = $1 ~ /mbsrank_.*objects/ ? "library" : "program"
            if ($1 ~ /kernels_|sweeps\/bounded\.|\/(derivatives\/(derivatives|products)|(fronts|newton\/(carried|front|linear))\/)|ida\/vectors|algebra\/(jacobi|pivots)|slopes\/(axes|joint_slopes|body_slopes|planar_slopes)|joints\/chain\.|recursion\/(backward|errors|group|kinematics|rates)\./) kind = "kernels"
            ++count[kind]
            if ($2 != wanted[kind]) {
                print name ": " $1 " has " $2 " instead of " wanted[kind]
                wrong = 1
            }
        }
        END {
            print name ": " count["library"] + 0, count["kernels"] + 0, count["program"] + 0
            exit wrong || !count["library"] || !count["kernels"] || !count["program"]
        }' "$work/$name.levels" || failed=1
}

echo "files of the library, loops over small matrices, programs:"
expect nothing -O2 -O3 none
expect build_type -O1 -O3 -O1 -DCMAKE_BUILD_TYPE=Mine -DCMAKE_C_FLAGS_MINE=-O1
expect debug none none none -DCMAKE_BUILD_TYPE=Debug
expect flags -O1 -O3 -O1 "-DCMAKE_C_FLAGS=-g -O1"
echo 'add_compile_options(-O1)' >"$work/options.cmake"
expect options -O1 -O3 -O1 -DCMAKE_PROJECT_consumer_INCLUDE="$work/options.cmake"
expect fast -Ofast -O3 -Ofast "-DCMAKE_C_FLAGS=-Ofast -flto"
# NaN stays NaN in the library, whatever the project does.
awk -v failed=0 '/^ *"command":/ && (/mbsrank_[a-z_]*objects/ || /package\/consumer/) {
    if ((/ -fno-finite-math-only/ != 0) != (/mbsrank_[a-z_]*objects/ != 0)) { print "fast:", $0; failed = 1 }
} END { exit failed }' "$work/tree/compile_commands.json" || failed=1
expect off none -O3 none -DMBSR_DEFAULT_O2=OFF
exit $failed
