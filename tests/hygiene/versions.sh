#!/bin/sh
# The version of base.h stands in CITATION.cff, debian/changelog, CHANGELOG.md and the recipes of packaging/; debian/ has the
# packages of its soname; the notice of the viewer names the versions that package.json asks for.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: versions.sh PROJECT_DIR
set -eu
cd "$1"
version=$(awk '/^#define MBSR_VERSION_(MAJOR|MINOR|PATCH) /{ printf "%s%s", dot, $3; dot = "." }' include/mbsrank/base.h)
status=0
# has FILE PATTERN: the pattern, an extended regular expression, is in it.
has() {
    grep -qE "$2" "$1" || { echo "$1 has no $2"; status=1; }
}
has CITATION.cff "^version: $version\$"
has debian/changelog "^libmbsrank \\($version-"
has CHANGELOG.md "^## \\[$version\\]"
for recipe in packaging/conda-forge/meta.yaml packaging/vcpkg/vcpkg.json packaging/homebrew/libmbsrank.rb packaging/spack/package.py; do
    has "$recipe" "(^|[^0-9.])$version([^0-9.]|\$)"
done
case $version in 0.*) soversion=${version%.*} ;; *) soversion=${version%%.*} ;; esac
has debian/control "^Package: libmbsrank$soversion\$"
sed -n 's/.*"\(three\|mediabunny\)": "\([0-9.]*\)".*/\1 \2/p' src/program/viewer/package.json | while read -r name number; do
    grep -q "^$name $number " src/program/viewer/NOTICE || { echo "src/program/viewer/NOTICE has no $name $number"; exit 1; }
done || status=1
for symbols in debian/*.symbols; do has "$symbols" "so\\.$soversion "; done
exit $status
