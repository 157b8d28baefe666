#!/usr/bin/env bash
# Builds the Debian packages from the committed tree, twice, and compares them; runs lintian; installs them into an empty
# root, where debian/tests/consumer runs, and takes them out again. Results are in build/package.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: package.sh [recipes | source | build | again | lint | root]...   all of them without an argument; each needs
#     those before it, but for recipes: version, options and syntax of what packaging/ has
#     source: the tarballs   build: the packages   again: once more elsewhere, the same bytes   root: needs to be root
set -eu
cd "$(dirname "${BASH_SOURCE[0]}")/.."
project=$PWD
work=$project/build/package
steps=${*:-recipes source build again lint root}
bash scripts/install.sh build page package
version=$(awk '/^#define MBSR_VERSION_(MAJOR|MINOR|PATCH) /{ printf "%s%s", dot, $3; dot = "." }' include/mbsrank/base.h)
name=libmbsrank-$version
stamp=$(git log -1 --format=%ct)

lint_recipes() {
    local recipe option
    for recipe in conda-forge/meta.yaml homebrew/libmbsrank.rb spack/package.py vcpkg/vcpkg.json; do
        grep -qF "\"$version\"" "packaging/$recipe" || { echo "$recipe: another version than $version"; exit 1; }
    done
    for option in $(grep -rhoE 'MBSR_[A-Z0-9]+' packaging --include='*.*' --exclude=README.md | sort -u); do
        grep -qE "(option|set)\($option " CMakeLists.txt src/CMakeLists.txt || { echo "no option $option"; exit 1; }
    done
    python3 -m json.tool packaging/vcpkg/vcpkg.json >/dev/null
    python3 -c 'import ast, sys; ast.parse(sys.stdin.read())' <packaging/spack/package.py
    if command -v ruby >/dev/null; then ruby -c packaging/homebrew/libmbsrank.rb; else echo "no ruby: the formula is not read"; fi
}

# pack FOLDER TO: the folder as a tarball that depends on nothing but its files.
pack() {
    tar --sort=name --owner=0 --group=0 --numeric-owner --mtime="@$stamp" --mode=u+rw,go+r-w,a+X \
        -C "$(dirname "$1")" -cf - "$(basename "$1")" | xz -9 >"$2"
}

# The project, the bundled page with what it is made of, and the description of the source package.
make_source() {
    rm -rf "$work"
    mkdir -p "$work/$name" "$work/bundle/viewer"
    git archive HEAD | tar -x -C "$work/$name"
    mv "$work/$name/debian" "$work/debian"
    pack "$work/$name" "$work/libmbsrank_$version.orig.tar.xz"
    cp "$work/$name"/src/program/viewer/* "$work/bundle"
    (cd "$work/bundle" && npm ci --prefer-offline --no-audit --no-fund --ignore-scripts && node bundle.mjs viewer/viewer.html --sources viewer)
    pack "$work/bundle/viewer" "$work/libmbsrank_$version.orig-viewer.tar.xz"
    cp -r "$work/bundle/viewer" "$work/$name/viewer"
    mv "$work/debian" "$work/$name/debian"
    (cd "$work" && dpkg-source -b "$name")
}

# build_in FOLDER: builds the packages from the source package there.
build_in() {
    rm -rf "$1"
    mkdir -p "$1"
    cp "$work"/libmbsrank_* "$1"
    (cd "$1" && dpkg-source -x libmbsrank_*.dsc "$name" && cd "$name" && DEB_BUILD_OPTIONS=noautodbgsym dpkg-buildpackage -us -uc -F)
}

compare() {
    TZ=Asia/Tokyo LC_ALL=C.UTF-8 build_in "$work/elsewhere"
    local file different=0
    for file in "$work"/built/*.deb; do
        if ! cmp "$file" "$work/elsewhere/$(basename "$file")"; then different=1; fi
    done
    [ $different = 0 ] || { echo "the packages of two builds differ"; exit 1; }
    echo "$(ls "$work"/built/*.deb | wc -l) packages are the same in two builds"
    rm -rf "$work/elsewhere"
}

# An empty root, the packages, a consumer; what they leave behind when they go.
try_in_root() {
    local root=$work/root mirror=${MBSR_DEBIAN_MIRROR:-http://deb.debian.org/debian} release left
    release=$(. /etc/os-release && echo "$VERSION_CODENAME")
    [ -d "$root/usr" ] || debootstrap --variant=minbase "$release" "$root" "$mirror"
    mkdir -p "$root/packages" "$root/source"
    cp "$work"/built/*.deb "$root/packages"
    cp -r "$work/$name/debian" "$work/$name/tests" "$work/$name/examples" "$root/source"
    local in_root=(chroot "$root" env DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8)
    cp /etc/resolv.conf /etc/hosts "$root/etc"
    cp -r /etc/apt/apt.conf.d "$root/etc/apt"
    "${in_root[@]}" apt-get update -q
    "${in_root[@]}" sh -c 'apt-get install -q -y --no-install-recommends /packages/*.deb'
    "${in_root[@]}" apt-get install -q -y --no-install-recommends cmake gcc libc6-dev make pkg-config
    "${in_root[@]}" sh /source/debian/tests/consumer
    "${in_root[@]}" sh -c 'apt-get purge -q -y $(dpkg-query -W -f "\${Package}\n" "*mbsrank*")'
    left=$(find "$root/usr" "$root/etc" "$root/var" -name '*mbsrank*' -not -path '*/apt/*' | head)
    [ -z "$left" ] || { echo "left behind: $left"; exit 1; }
    echo "installed, used and taken out again"
}

for step in $steps; do
    echo "==== $step"
    case $step in
    recipes) lint_recipes ;;
    source) make_source ;;
    build) build_in "$work/built" ;;
    again) compare ;;
    lint) lintian --allow-root --fail-on error,warning --info "$work"/built/libmbsrank_*.dsc "$work"/built/*.deb ;;
    root) try_in_root ;;
    *) echo "usage: package.sh [recipes | source | build | again | lint | root]..." >&2; exit 2 ;;
    esac
done
