#!/usr/bin/env bash
# Runs a command with another LAPACK and BLAS than the system's default, in one thread, on Debian
# and its relatives: their folders come first where the dynamic loader looks. Nothing is installed
# or switched.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: lapack.sh reference|openblas|openblas-serial|blis COMMAND...
#        lapack.sh reference|openblas|openblas-serial|blis --for PROGRAM
# blis: with the reference LAPACK, since BLIS is a BLAS alone.
# The second form says whether that changes what PROGRAM is run with: 0 yes, 1 it has that one by
# itself, 3 there is none, or PROGRAM does not take it.
set -eu

name=$1
shift
case $name in
reference) choices=(lapack:blas) ;;
openblas) choices=(openblas-pthread openblas-serial openblas-openmp) ;;
openblas-serial) choices=(openblas-serial) ;;
blis) choices=(lapack:blis-pthread lapack:blis-openmp lapack:blis-serial) ;;
*) echo "lapack.sh: unknown LAPACK '$name'" >&2; exit 2 ;;
esac

# folders CHOICE: where its libraries are, joined by colons; 1 if they are not there.
root=/usr/lib/$(gcc -print-multiarch 2>/dev/null || true)
folders() {
    local first=$root/${1%%:*} last=$root/${1##*:}
    [ -e "$first/liblapack.so.3" ] && [ -e "$last/libblas.so.3" ] || return 1
    if [ "$first" = "$last" ]; then echo "$first"; else echo "$first:$last"; fi
}

# lapack_of PROGRAM: the file that it is run with, links followed.
lapack_of() {
    local file
    file=$(ldd "$1" | sed -n 's/^.*liblapack\.so[^ ]* => \([^ ]*\) .*$/\1/p' | head -n 1)
    [ -n "$file" ] && readlink -f "$file"
}

path=
for choice in "${choices[@]}"; do
    if [ -z "$path" ]; then path=$(folders "$choice" || true); fi
done
if [ "${1:-}" = --for ]; then
    [ -n "$path" ] || exit 3
    before=$(lapack_of "$2") || exit 3
    after=$(LD_LIBRARY_PATH=$path lapack_of "$2") || exit 3
    [ "$after" = "$(readlink -f "${path%%:*}/liblapack.so.3")" ] || exit 3
    [ "$before" != "$after" ] || exit 1
    exit 0
fi
if [ -z "$path" ]; then
    echo "lapack.sh: no folder of $name below $root" >&2
    exit 3
fi
export LD_LIBRARY_PATH=$path${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
export OPENBLAS_NUM_THREADS=1
exec "$@"
