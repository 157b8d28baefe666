#!/bin/sh
# No file of the project names a folder of somebody's machine or a file outside the project.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: paths.sh PROJECT_DIR
set -eu
cd "$1"
if git ls-files >/dev/null 2>&1 && [ -n "$(git ls-files -co --exclude-standard | head -n 1)" ]; then
    files=$(git ls-files -co --exclude-standard)
else
    files=$(find . -name build -prune -o -name demo-output -prune -o -type f -print)
fi

# The brackets keep this file from matching itself.
folders='(^|[^A-Za-z0-9_./])/([w]ork|[r]oot|[h]ome|[U]sers|[t]mp/bash)([^A-Za-z0-9_-]|$)'
outside='(\.\./[s]hared|(^|[^A-Za-z0-9_./-])[s]hared)/|[T]HEORY\.md|[B]RIEF\.md'
found=$(printf '%s\n' "$files" | tr '\n' '\0' | xargs -0 grep -sHnIE "$folders|$outside" || true)
if [ -n "$found" ]; then
    printf '%s\n' "$found"
    exit 1
fi
