#!/usr/bin/env bash
# Builds the npm package of web/: the library as a module of WebAssembly, by clang, lld and wasi-libc, with expat and
# SUNDIALS from Debian's source packages, or from a folder.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: wasm.sh [--fetch] FOLDER [SOURCES]
#   --fetch  the sources alone, into FOLDER
#   FOLDER   where the build is; FOLDER/package is what npm packs
#   SOURCES  a folder with the sources unpacked, as folders sundials-* and *expat*
# MBSR_WEB_BUILD=Debug: nothing is optimised, which takes a third of the time and serves tests.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
fetch=
if [ "${1:-}" = --fetch ]; then
    fetch=only
    shift
fi
mkdir -p "${1:?usage: wasm.sh FOLDER [SOURCES]}"
out=$(cd "$1" && pwd)
sources=${2:-$out/sources}
if [ -n "$fetch" ]; then sources=$out; fi
jobs=${JOBS:-$(nproc)}
generator=()
if command -v ninja >/dev/null; then generator=(-G Ninja); fi

# Source packages with a list of their own: a fresh Debian has no deb-src entry.
if [ -z "${2:-}" ] && ! compgen -G "$sources/sundials-*" >/dev/null; then
    mkdir -p "$out/apt/lists/partial" "$sources"
    . /etc/os-release
    echo "deb-src http://deb.debian.org/debian ${VERSION_CODENAME:?} main" >"$out/apt/sources.list"
    apt=(-q -o "Dir::Etc::sourcelist=$out/apt/sources.list" -o Dir::Etc::sourceparts=-
         -o "Dir::State::lists=$out/apt/lists" -o "Dir::Cache=$out/apt" -o APT::Sandbox::User=root)
    apt-get "${apt[@]}" update
    (cd "$sources" && apt-get "${apt[@]}" source --download-only sundials expat &&
        for archive in *.orig.tar.*; do tar -xf "$archive"; done)
fi
if [ -n "$fetch" ]; then exit 0; fi
sundials=$(compgen -G "$sources/sundials-*/CMakeLists.txt" | head -n 1)
expat=$(compgen -G "$sources/*expat*/expat/CMakeLists.txt" | head -n 1 || compgen -G "$sources/*expat*/CMakeLists.txt")
[ -n "$sundials" ] && [ -n "$expat" ] || { echo "wasm.sh: $sources has no sources" >&2; exit 1; }

# make NAME SOURCE OPTION...: configures and builds.
make() {
    local name=$1 source=$2
    shift 2
    cmake -S "$source" -B "$out/$name" "${generator[@]}" -DCMAKE_TOOLCHAIN_FILE="$root/cmake/Wasm.cmake" \
        -DCMAKE_BUILD_TYPE="${MBSR_WEB_BUILD:-MinSizeRel}" -DCMAKE_C_FLAGS_DEBUG=-O0 \
        -DCMAKE_INSTALL_PREFIX="$out/prefix" "$@" >"$out/$name.log"
    cmake --build "$out/$name" -j "$jobs" >>"$out/$name.log" || { tail -n 40 "$out/$name.log" >&2; exit 1; }
}
unity=OFF
if [ "${MBSR_WEB_BUILD:-}" = Debug ]; then unity=ON; fi
if [ ! -e "$out/prefix/lib/libsundials_ida.a" ]; then
    make sundials "$(dirname "$sundials")" -DBUILD_SHARED_LIBS=OFF -DEXAMPLES_ENABLE_C=OFF -DEXAMPLES_INSTALL=OFF \
        -DBUILD_ARKODE=OFF -DBUILD_CVODE=OFF -DBUILD_CVODES=OFF -DBUILD_IDAS=OFF -DBUILD_KINSOL=OFF \
        -DBUILD_NVECTOR_MANYVECTOR=OFF -DSUNDIALS_INDEX_SIZE=32 -DCMAKE_UNITY_BUILD=$unity
    cmake --install "$out/sundials" >>"$out/sundials.log" 2>&1
fi
# Three files, and what expat's own configuration finds: it takes ten times as long as they do.
if [ ! -e "$out/prefix/lib/libexpat.a" ]; then
    mkdir -p "$out/expat" "$out/prefix/include"
    lib=$(dirname "$expat")/lib optimise="-Os -DNDEBUG"
    if [ "${MBSR_WEB_BUILD:-}" = Debug ]; then optimise=-O0; fi
    printf '#define %s\n' 'BYTEORDER 1234' HAVE_ARC4RANDOM_BUF 'XML_CONTEXT_BYTES 1024' XML_DTD 'XML_GE 1' XML_NS >"$out/expat/expat_config.h"
    for name in xmlparse xmlrole xmltok; do # shellcheck disable=SC2086 # optimise is several words
        clang --target=wasm32-wasi -msimd128 $optimise -w -fno-strict-aliasing -fvisibility=hidden -I"$out/expat" -c "$lib/$name.c" \
            -o "$out/expat/$name.o"
    done
    cp "$lib"/expat{,_external}.h "$out/prefix/include"
    archiver=$(command -v llvm-ar || command -v llvm-ar-14)
    "$archiver" rcs "$out/prefix/lib/libexpat.a" "$out"/expat/*.o
fi
make mbsrank "$root" -DMBSR_WEB=ON -DMBSR_UNITY=$unity -DMBSR_LAPACK=OFF -DMBSR_THREADS=OFF -DMBSR_FE=OFF -DMBSR_STUDY=OFF -DMBSR_PROGRAM=OFF -DMBSR_PNG=OFF \
    -DMBSR_TESTS=OFF -DMBSR_EXAMPLES=OFF -DMBSR_INSTALL=OFF -DBUILD_SHARED_LIBS=OFF -DMBSR_WERROR="${MBSR_WERROR:-OFF}" \
    -DCMAKE_FIND_ROOT_PATH="$out/prefix" -DCMAKE_PREFIX_PATH="$out/prefix" \
    -DSUNDIALS_DIR="$out/prefix/lib/cmake/sundials"

package=$out/package
mkdir -p "$package"
cp "$out/mbsrank/web/mbsrank.wasm" "$root"/web/{mbsrank.js,wasi.js,index.d.ts,README.md} "$root/LICENSE" "$package"
version=$(sed -n 's/^#define MBSR_VERSION_[A-Z]* *\([0-9]*\)$/\1/p' "$root/include/mbsrank/base.h" | paste -sd .)
sed "s/@VERSION@/$version/" "$root/web/package.json.in" >"$package/package.json"
size=$(stat -c %s "$package/mbsrank.wasm")
echo "$package: mbsrank.wasm $size bytes, $(gzip -9 <"$package/mbsrank.wasm" | wc -c) compressed"
