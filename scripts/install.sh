#!/usr/bin/env bash
# Installs what building, testing or the demo needs, if it is missing (Debian and Ubuntu, by
# apt-get). On other systems it says what to install.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: install.sh build|test|demo|page|docs|package|emulation|musl|mingw|lapacks|web|wheel...
set -eu

# Packages by purpose; "package:command" counts as there when the command is.
build=(gcc:cc libc6-dev ninja-build:ninja cmake:cmake pkg-config:pkg-config
       liblapack-dev libblas-dev libsundials-dev libexpat1-dev libsuitesparse-dev)
# libomp-dev: the CMake package of Debian's SUNDIALS asks for OpenMP, which clang has apart.
test=(build-essential:g++ clang:clang libomp-dev lld:ld.lld clang-format:clang-format binutils:objdump
      libcmocka-dev valgrind:valgrind tcc:tcc libhdf5-dev libpng-dev doxygen:doxygen python3:python3
      python3-dev python3-cffi python3-numpy python3-scipy python3-setuptools)
demo=(gnuplot-nox:gnuplot libhdf5-dev)
page=(nodejs:node npm:npm zlib1g-dev)
package=(debhelper:dh lintian:lintian debootstrap:debootstrap zlib1g-dev libhdf5-dev libpng-dev libomp-dev xz-utils:xz)
emulation=(qemu-user-static:qemu-aarch64-static gcc-aarch64-linux-gnu:aarch64-linux-gnu-gcc gcc-i686-linux-gnu:i686-linux-gnu-gcc
           gcc-s390x-linux-gnu:s390x-linux-gnu-gcc libc6-dev-arm64-cross libc6-dev-i386-cross libc6-dev-s390x-cross)
lapacks=(liblapack3 libblas3 libopenblas0-pthread libopenblas0-serial libblis4-pthread)
musl=(musl-tools:musl-gcc)
mingw=(gcc-mingw-w64-x86-64:x86_64-w64-mingw32-gcc wine64)
docs=(doxygen:doxygen python3-sphinx python3-myst-parser python3-sphinx-rtd-theme libjs-mathjax)
web=(clang:clang lld:wasm-ld llvm:llvm-ar wasi-libc libclang-rt-14-dev-wasm32 nodejs:node ninja-build:ninja cmake:cmake)
wheel=(python3-dev python3-cffi python3-numpy python3-setuptools python3-wheel python3-pip python3-venv patchelf:patchelf pkg-config)

wanted=()
for purpose; do
    case $purpose in
    build) wanted+=("${build[@]}") ;;
    test) wanted+=("${test[@]}") ;;
    demo) wanted+=("${demo[@]}") ;;
    page) wanted+=("${page[@]}") ;;
    docs) wanted+=("${docs[@]}") ;;
    package) wanted+=("${package[@]}") ;;
    emulation) wanted+=("${emulation[@]}") ;;
    lapacks) wanted+=("${lapacks[@]}") ;;
    musl) wanted+=("${musl[@]}") ;;
    mingw) wanted+=("${mingw[@]}") ;;
    web) wanted+=("${web[@]}") ;;
    wheel) wanted+=("${wheel[@]}") ;;
    *) echo "install.sh: unknown purpose '$purpose'" >&2; exit 2 ;;
    esac
done

installed() {
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    echo "This is not Debian or Ubuntu. What these Debian packages hold must be installed:"
    echo "    ${wanted[*]%%:*}"
    echo "Going on with what is there."
    exit 0
fi

root=()
if [ "$(id -u)" -ne 0 ]; then root=(sudo); fi
updated=no

# get PACKAGE...: installs these, with fresh package lists.
get() {
    echo "Installing: $*"
    if [ "$updated" = no ]; then
        "${root[@]}" apt-get update -q
        updated=yes
    fi
    "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "$@"
}

missing=()
for item in "${wanted[@]}"; do
    package=${item%%:*}
    program=
    case $item in *:*) program=${item#*:} ;; esac
    if [ -n "$program" ]; then
        command -v "$program" >/dev/null || missing+=("$package")
    else
        installed "$package" || missing+=("$package")
    fi
done
if [ ${#missing[@]} -gt 0 ]; then get "${missing[@]}"; fi

# optional PACKAGE: installs it where the release has it.
optional() {
    if ! installed "$1" && [ -n "$(apt-cache search --names-only "^$1\$")" ]; then get "$1"; fi
}

if [[ " $* " = *" test "* ]]; then
    # The sanitizers of clang have a package of their own on some releases.
    if command -v clang >/dev/null; then
        optional "libclang-rt-$(clang -dumpversion | cut -d. -f1)-dev"
    fi
    # A second LAPACK for scripts/lapack.sh. Debian makes it the default by installing it, unless
    # `update-alternatives --config` has chosen one.
    optional libopenblas0-pthread
    # For the example of a swing-up, which is left out without.
    optional coinor-libipopt-dev
fi
