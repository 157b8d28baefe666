#!/bin/sh
# Doxygen makes the reference of the public headers without a warning. Skipped without Doxygen.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: reference.sh PROJECT_DIR
set -eu
command -v doxygen >/dev/null || { echo "doxygen is missing"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
sh "$1/docs/site/reference.sh" NO "$work"
count=$(grep -c '<member kind="function">' "$work/reference.tag")
echo "$count functions"
[ "$count" -gt 300 ]
