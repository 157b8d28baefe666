#!/bin/sh
# Each public header compiles alone, and twice, as C11 and as C++17.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: headers.sh INCLUDE_DIR C_COMPILER CXX_COMPILER SUNDIALS_INCLUDE_DIR
# `none` for the C++ compiler or the folder of SUNDIALS: what needs it is not tested.
set -eu
include=$1
cc=$2
cxx=$3
sundials=$4
[ "$cxx" != none ] || cxx=
[ "$sundials" != none ] || sundials=
flags="-Wall -Wextra -Wpedantic -Werror -fsyntax-only -I$include"
[ -z "$sundials" ] || flags="$flags -idirafter $sundials"
status=0
count=0

for header in "$include"/mbsrank/*.h; do
    name=mbsrank/$(basename "$header")
    [ -n "$sundials" ] || [ "$name" != mbsrank/sundials.h ] || continue
    text=$(printf '#include <%s>\n#include <%s>\nextern int nothing;\n' "$name" "$name")
    # shellcheck disable=SC2086 # flags are several words
    if ! printf '%s\n' "$text" | "$cc" -std=c11 -Wstrict-prototypes $flags -x c -; then
        echo "$name does not compile alone as C11"
        status=1
    fi
    # shellcheck disable=SC2086
    if [ -n "$cxx" ] && ! printf '%s\n' "$text" | "$cxx" -std=c++17 $flags -x c++ -; then
        echo "$name does not compile alone as C++17"
        status=1
    fi
    count=$((count + 1))
done
[ "$count" -gt 0 ] || { echo "no headers in $include/mbsrank"; status=1; }
[ -n "$cxx" ] || echo "no C++ compiler: C++17 not tested"
[ -n "$sundials" ] || echo "no SUNDIALS: mbsrank/sundials.h not tested"
echo "$count headers"
exit $status
