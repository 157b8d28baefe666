#!/bin/sh
# The code in the documents compiles as C11 and as C++17, or as C++20 where it has designated
# initialisers. Statements are put into a function, and find the names declared here that the text
# around them takes for granted.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: snippets.sh PROJECT_DIR C_COMPILER CXX_COMPILER
# `none` for the C++ compiler: only C is tested.
set -eu
cd "$1"
cc=$2
cxx=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
flags="-Wall -Wextra -Wpedantic -Werror -Wno-unused -Wno-unused-parameter
       -Wno-missing-field-initializers -fsyntax-only -Iinclude"

cat >"$work/names.h" <<'END'
#include <mbsrank/mbsrank.h>
#include <math.h>
#include <stdio.h>
extern mbsr_model *m, *model;
extern mbsr_data *d, *data;
extern mbsr_newton *newton;
extern mbsr_body_def body;
extern mbsr_joint_table table;
extern mbsr_error error;
extern double t, c, *q, *u, *y, *yp, *F, *delta;
extern int status, n;
extern void *user;
extern const char *text;
extern size_t size;
END

# One file for each piece of code between ```c and ```: complete programs as they are.
for document in README.md docs/*.md bench/README.md; do
    awk -v document="$document" -v stem="$work/$(basename "$document" .md)" -v names="$work/names.h" '
        function put() {
            file = stem "-" first ".c"
            if (!program) print "#include \"" names "\"" >file
            if (!program) printf "%s", includes >file
            if (!functions) print "void code(void);\nvoid code(void)\n{" >file
            print "#line " first + 1 " \"" document "\"" >file
            printf "%s", text >file
            if (!functions) print "}" >file
            close(file)
        }
        /^```c$/ { on = 1; first = FNR; text = includes = ""; program = functions = 0; next }
        /^```$/ { if (on) put(); on = 0 }
        !on { next }
        /^int main\(/ { program = 1 }
        /^[{]$/ { functions = 1 }
        /^#include/ { includes = includes $0 "\n" }
        { text = text $0 "\n" }
    ' "$document"
done

# An #include among statements is harmless the second time: headers have guards.
status=0
count=0
for file in "$work"/*.c; do
    [ -f "$file" ] || continue
    count=$((count + 1))
    # shellcheck disable=SC2086 # flags are several words
    "$cc" -std=c11 $flags "$file" || { echo "not C11"; status=1; }
    [ "$cxx" != none ] || continue
    standard=c++17
    if grep -qE '[{ ]\.[a-z_]+ = ' "$file"; then standard=c++2a; fi
    # shellcheck disable=SC2086
    "$cxx" -std=$standard $flags -x c++ "$file" || { echo "not $standard"; status=1; }
done
[ "$cxx" != none ] || echo "no C++ compiler: C++ not tested"
echo "$count pieces of code"
[ "$count" -gt 0 ] || status=1
exit $status
