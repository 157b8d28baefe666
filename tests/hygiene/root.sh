#!/bin/sh
# At the root of the project stand what is named here and no results of programs. Skipped where git does not know the folder.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: root.sh PROJECT_DIR
set -eu
cd "$1"
git rev-parse --is-inside-work-tree >/dev/null 2>&1 || exit 77
strangers=$(git ls-files | sed 's|/.*||' | sort -u | grep -vxE \
    '\.ci|\.clang-format|\.gitignore|CHANGELOG\.md|CITATION\.cff|CMakeLists\.txt|CMakePresets\.json|CONTRIBUTING\.md|LICENSE|README\.md|SECURITY\.md|bench|cmake|debian|docs|examples|include|packaging|python|scripts|src|tests|web' || true)
[ -z "$strangers" ] || { echo "at the root, and not expected there: $strangers"; exit 1; }
