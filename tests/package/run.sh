#!/bin/sh
# Builds and installs the library, moves the installed tree, and uses it by CMake and by pkg-config.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: run.sh CMAKE SOURCE WORK CC GENERATOR VERSION SHARED IDA LINEAR(each ON|OFF) [TREE]
# TREE: has been built; else the library is built, and installed, as part of the consumer.
set -eu
cmake=$1 source=$2 work=$3 cc=$4 generator=$5 version=$6 shared=$7 ida=$8 linear=$9
shift 9
tree=${1:-}
consumer=$source/tests/package/consumer
prefix=$work/moved
programs="use_core use_fe"
[ "$linear" = OFF ] || programs="$programs use_linear"
[ "$ida" = OFF ] || programs="$programs use_ida"

step() { printf '== %s\n' "$*"; }
fail() { printf 'FAILED: %s\n' "$*"; exit 1; }

rm -rf "$work"
mkdir -p "$work"

# configure NAME OPTION...: configures the consumer; the log stays in the folder.
configure() {
    name=$1
    shift
    "$cmake" -S "$consumer" -B "$work/$name" -G "$generator" -DCMAKE_C_COMPILER="$cc" \
        -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG=-O0 -DCMAKE_PREFIX_PATH="$prefix" "$@" >"$work/$name.log" 2>&1
}

# build_and_run NAME: the consumer and its programs.
build_and_run() {
    "$cmake" --build "$work/$1" || fail "$1: the build"
    for program in $programs; do "$work/$1/$program" || fail "$1: $program"; done
}

components="core;fe"
[ "$linear" = OFF ] || components="$components;linear"
[ "$ida" = OFF ] || components="$components;ida"
if [ -z "$tree" ]; then
    step "as part of another project"
    tree=$work/subproject
    # what is not asked for is not built
    configure subproject "-DMBSRANK_SOURCE=$source" "-DWANT_COMPONENTS=$components" -DMBSR_FILES=OFF -DMBSR_CONTACT=OFF -DMBSR_STUDY=OFF -DMBSR_UNITY=ON \
        -DMBSR_INSTALL=ON -DBUILD_SHARED_LIBS="$shared" -DMBSR_IDA="$ida" -DMBSR_LINEAR="$linear" -DMBSR_FMU=OFF -DMBSR_VIEWER=OFF ||
        { cat "$work/subproject.log"; fail "add_subdirectory"; }
    build_and_run subproject
fi
if [ -n "${1:-}" ]; then
    step "uninstall"
    "$cmake" --install "$tree" --prefix "$work/installed"
    touch "$work/installed/include/another.h"
    "$cmake" --build "$tree" --target uninstall || fail "uninstall"
    left=$(find "$work/installed" ! -type d -o -name '*mbsrank*')
    [ "$left" = "$work/installed/include/another.h" ] || fail "left behind, or taken out too: $left"
    rm -r "$work/installed"
fi
step "install"
"$cmake" --install "$tree" --prefix "$work/installed"
mv "$work/installed" "$prefix"
rm -rf "$work/subproject"

if [ -f "$prefix/share/mbsrank/viewer.html" ]; then # found from where the program stands
    "$prefix/bin/mbsrank" view "$source/examples/models/arm.urdf" -o "$work/page.html" || fail "view"
fi
[ -f "$prefix/include/mbsrank/mbsrank.h" ] || fail "headers are not installed"
find "$prefix" -name LICENSE | grep -q . || fail "the licence is not installed"
if [ "$ida" = OFF ]; then
    [ ! -e "$prefix/include/mbsrank/ida.h" ] || fail "ida.h is installed without the component"
    ! find "$prefix" -name '*ida*' | grep . || fail "files of the component ida"
else
    [ -f "$prefix/include/mbsrank/ida.h" ] || fail "ida.h is not installed"
fi
library=$(find "$prefix" -name 'libmbsrank.so' -o -name 'libmbsrank.a' -o -name 'libmbsrank.dylib')
[ -n "$library" ] || fail "the library is not installed"
pc=$(dirname "$(find "$prefix" -name mbsrank.pc)")

# refused NAME PATTERN OPTION...: the configuration must fail and say why.
refused() {
    name=$1 pattern=$2
    shift 2
    ! configure "$name" "$@" || fail "$name was not refused"
    tr '\n' ' ' <"$work/$name.log" | tr -s ' ' | grep -q "$pattern" ||
        { cat "$work/$name.log"; fail "$name: no message '$pattern'"; }
}

step "CMake package"
# Whoever links a shared library need not have what it is made from.
private=
[ "$shared" = OFF ] ||
    private="-DCMAKE_DISABLE_FIND_PACKAGE_LAPACK=ON -DCMAKE_DISABLE_FIND_PACKAGE_SUNDIALS=ON"
# shellcheck disable=SC2086 # private is several words
configure cmake "-DWANT_COMPONENTS=$components" $private ||
    { cat "$work/cmake.log"; fail "find_package"; }
build_and_run cmake

step "requests that must be refused"
refused version "version" -DWANT_VERSION=99.0
refused component "mbsrank" "-DWANT_COMPONENTS=core;nonsense"
[ "$linear" = ON ] ||
    refused no_linear "without the component linear" "-DWANT_COMPONENTS=core;linear"
if [ "$ida" = OFF ]; then
    refused no_ida "without the component ida" "-DWANT_COMPONENTS=core;ida"
    configure optional -DWANT_OPTIONAL=ida || { cat "$work/optional.log"; fail "optional ida"; }
    grep -q "ida found: FALSE" "$work/optional.log" || fail "mbsrank_ida_FOUND is not FALSE"
elif [ "$shared" = OFF ]; then
    refused no_sundials "needs SUNDIALS" "-DWANT_COMPONENTS=core;ida" \
        -DCMAKE_DISABLE_FIND_PACKAGE_SUNDIALS=ON
fi

step "pkg-config"
if ! command -v pkg-config >/dev/null; then
    echo "pkg-config is missing: not tested"
    exit 0
fi
export PKG_CONFIG_PATH="$pc"
static=
[ "$shared" = ON ] || static=--static
for program in $programs; do
    case $program in
    use_core) module=mbsrank ;;
    *) module=mbsrank_${program#use_} ;;
    esac
    [ "$(pkg-config --modversion $module)" = "$version" ] || fail "version of $module.pc"
    # shellcheck disable=SC2046,SC2086 # flags are several words
    "$cc" -std=c11 -o "$work/$program" "$consumer/$program.c" \
        $(pkg-config --cflags --libs $static $module) -lm -Wl,-rpath,"$(dirname "$library")" ||
        fail "pkg-config: $program does not build"
    "$work/$program" || fail "pkg-config: $program"
done

step "the programs of docs/getting_started.md"
# program NUMBER MODULE: builds and runs the one, which has to print what the text says.
program() {
    awk -v wanted="$1" '/^```c$/ { on = 1; text = ""; next }
         /^```$/ { if (on && text ~ /int main/ && ++count == wanted) printf "%s", text; on = 0 }
         on { text = text $0 "\n" }' "$source/docs/getting_started.md" >"$work/program$1.c"
    # shellcheck disable=SC2046,SC2086
    "$cc" "$work/program$1.c" -o "$work/program$1" $(pkg-config --cflags --libs $static "$2") -lm ||
        fail "program $1 does not build"
    printed=$(LD_LIBRARY_PATH=$(dirname "$library") "$work/program$1") || fail "program $1 does not run"
    printf '%s\n' "$printed" | while IFS= read -r line; do
        grep -qF -- "$line" "$source/docs/getting_started.md" || fail "program $1 prints $line"
    done || exit 1
}
program 1 mbsrank
[ "$ida" = OFF ] || program 2 mbsrank_ida
