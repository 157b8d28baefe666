#!/bin/sh
# The code in the documents compiles as C11 and as C++17, or as C++20 where it has designated initialisers. With
# libraries it runs, too: programs print what the ```output behind them shows, statements leave no error in the
# world of snippet_world.c, whose names they find. Functions and tables are compiled.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: snippets.sh PROJECT_DIR C_COMPILER CXX_COMPILER [LIBRARY...]
# `none` for the C++ compiler: only C is tested. LIBRARY: shared ones, core first; without: nothing is run. What
# belongs to a component whose library is not there is not run either.
set -eu
cd "$1"
cc=$2
cxx=$3
shift 3
here=tests/hygiene
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
warnings="-Wall -Wextra -Wpedantic -Werror -Wno-unused -Wno-unused-parameter -Wno-missing-field-initializers"
flags="$warnings -Iinclude -I$here"

# One file for each piece of code between ```c and ```: complete programs as they are, and what they print beside.
for document in README.md docs/*.md bench/README.md; do
    awk -v document="$document" -v stem="$work/$(basename "$document" .md)" '
        function put() {
            kind = program ? "program" : functions ? "functions" : "statements"
            file = stem "-" first "." kind ".c"
            if (!program) print "#include \"snippet_world.h\"" >file
            if (!program) printf "%s", includes >file
            if (kind == "statements") print "void code(void);\nvoid code(void)\n{" >file
            print "#line " first + 1 " \"" document "\"" >file
            printf "%s", text >file
            if (kind == "statements") print "}" >file
            close(file)
            last = program ? file : ""
        }
        /^```c$/ { on = 1; first = FNR; text = includes = ""; program = functions = 0; next }
        /^```output$/ { shown = last ".shown"; if (last == "") { print document ":" FNR ": output of nothing"; exit 1 }
                        printf "" >shown; output = 1; next }
        /^```/ { if (on) put(); on = output = 0; next }
        output { print >shown }
        !on { next }
        /^int main\(/ { program = 1 }
        /^[{]$/ { functions = 1 }
        /^#include/ { includes = includes $0 "\n" }
        { text = text $0 "\n" }
    ' "$document"
done

status=0
bad() {
    echo "$@"
    status=1
}

# can_run FILE: whether the components it includes are among the libraries.
libraries=$*
can_run() {
    [ -n "$libraries" ] || return 1
    for component in ida:'ida|sensitivity|simulation|sundials' files:files contact:contact fe:'fe|sid' linear:linear fmu:fmu; do
        if grep -qE "^#include <mbsrank/(${component#*:})\.h>" "$1"; then
            case "$libraries" in *mbsrank_"${component%%:*}".*) ;; *) return 1 ;; esac
        fi
    done
}

# run FILE OPTION...: what was built last; it has to print what the document shows.
run() {
    file=$1
    shift
    (cd "$work" && ./run "$@" >printed) || { cat "$work/printed"; bad "$file does not run"; return; }
    if [ -f "$file.shown" ] && ! diff -u "$file.shown" "$work/printed"; then bad "$file prints something else"; fi
    ran=$((ran + 1))
}

# options_of FILE: what the world needs to know of it.
options_of() {
    ! grep -qE 'mbsr_model_add_.*\(model,|simulation_of' "$1" || echo unfinished
    ! grep -q 'simulation_of' "$1" || echo taken
    ! grep -q 'planar' "$1" || echo planar
    ! grep -q 'xacro' "$1" || echo xacro
}

# Statements are compiled together, each a function with the number of the piece: by a C++ compiler, which starts slowly, in
# all.STANDARD, and, those that run, in all.c, whose `code` the world calls.
together() { sed "s/^void code(void)/void code_$count(void)/" "$1"; }

paths=$(for library; do echo "-Wl,-rpath,$(dirname "$library")"; done | sort -u)
count=0
ran=0
for file in "$work"/*.c; do
    [ -f "$file" ] || continue
    count=$((count + 1))
    kind=${file%.c}
    kind=${kind##*.}
    if [ $kind = functions ] || ! can_run "$file"; then kind=compiled; fi
    # shellcheck disable=SC2086
    case $kind in
    compiled) "$cc" -std=c11 $flags -fsyntax-only "$file" || bad "not C11" ;;
    program) if "$cc" -std=c11 -O0 $flags "$file" "$@" -lm $paths -o "$work/run"; then run "$file"; else bad "not C11"; fi ;;
    statements)
        together "$file" >>"$work/all"
        echo "case $count: code_$count(); break;" >>"$work/cases"
        echo "$count $file" >>"$work/list" ;;
    esac
    [ "$cxx" != none ] || continue
    standard=c++17
    if grep -qE '[{ ]\.[a-z_]+ = ' "$file"; then standard=c++2a; fi
    case $file in
    *.statements.c) together "$file" >>"$work/all.$standard" ;;
    *)
        # shellcheck disable=SC2086
        "$cxx" -std=$standard $flags -fsyntax-only -x c++ "$file" || bad "not $standard" ;;
    esac
done
if [ -f "$work/all" ]; then
    { cat "$work/all"; echo "void code(int piece)"; echo "{ switch (piece) {"; cat "$work/cases"; echo "} }"; } >"$work/all.c"
    # shellcheck disable=SC2086
    if "$cc" -std=c11 -O0 $flags "$work/all.c" $here/snippet_world.c "$@" -lm $paths -o "$work/run"; then
        while read -r piece file; do run "$file" "$piece" $(options_of "$file"); done <"$work/list"
    else
        bad "not C11"
    fi
fi
for file in "$work"/all.c++*; do
    [ -f "$file" ] || continue
    # shellcheck disable=SC2086
    "$cxx" -std="${file##*.}" $flags -fsyntax-only -x c++ "$file" || bad "not ${file##*.}"
done
[ "$cxx" != none ] || echo "no C++ compiler: C++ not tested"
echo "$count pieces of code, $ran of them run"
[ "$count" -gt 0 ] || status=1
[ -z "$libraries" ] || [ "$ran" -gt 0 ] || status=1
exit $status
