#!/bin/sh
# The sources of the library contain no calls that print or end the program; its own program (program/) does.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: forbidden_calls.sh SOURCE_DIR
set -eu
find "$1" -name '*.[ch]' | grep -q . || { echo "no sources in $1"; exit 1; }
calls='v?f?printf|v?dprintf|v?sprintf|f?puts|f?putc|putchar|fwrite|perror|exit|_exit|_Exit'
calls="$calls|quick_exit|abort|system|getenv"
if grep -rnE --include='*.[ch]' --exclude-dir=program "(^|[^A-Za-z0-9_.>])($calls)[[:space:]]*\(" "$1"; then
    echo "calls that a library must not make"
    exit 1
fi
