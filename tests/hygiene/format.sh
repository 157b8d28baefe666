#!/bin/sh
# The sources are as clang-format 14 leaves them; other versions differ in details. Skipped without
# that version.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: format.sh PROJECT_DIR
set -eu
formatter=
for program in clang-format-14 clang-format; do
    if [ -z "$formatter" ] && "$program" --version 2>/dev/null | grep -q 'version 14\.'; then
        formatter=$program
    fi
done
[ -n "$formatter" ] || { echo "clang-format 14 is missing"; exit 77; }
cd "$1"
files=$(find include src tests examples bench web -name '*.[ch]' -o -name '*.cpp' | sort)
[ -n "$files" ] || { echo "no sources"; exit 1; }
# one process: it starts slowly
# shellcheck disable=SC2086 # files are several words
"$formatter" --dry-run -Werror $files || { echo "run $formatter -i on these"; exit 1; }
