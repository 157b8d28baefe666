#!/bin/sh
# The compiled library keeps no writable globals, does not print or end the program, and takes
# and releases memory only in the files named.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: objects.sh ARCHIVE ALLOCATOR_SOURCE...
set -eu
command -v objdump >/dev/null || { echo "objdump is missing"; exit 77; }
archive=$1
shift
status=0

# Tables of pointers in .data.rel.ro are written by the dynamic linker only.
writable=$(objdump -h "$archive" | awk '
    /file format/ { object = $1 }
    $2 ~ /^\.(data|bss|tdata|tbss|sdata|sbss)/ && $2 !~ /^\.data\.rel\.ro/ && $3 !~ /^0+$/ {
        print object, $2, "0x" $3
    }')
common=$(nm -A "$archive" | awk '$(NF - 1) == "C" { print }')
[ -z "$writable$common" ] || { printf 'writable globals:\n%s\n%s\n' "$writable" "$common"; status=1; }

# Of the printf family only snprintf and vsnprintf are welcome, and their checked twins.
undefined=$(nm -A -u "$archive" | awk '{ print $1, $NF }' | sed 's/@.*//')
bad=$(printf '%s\n' "$undefined" | grep -E \
    ' (_*(f|d|v|vf|vd|s|vs|as|vas|w|fw|vw|vfw)?printf(_chk)?|f?puts|putc|f?putc(har)?|fwrite|perror|stdout|stderr|fopen|_?exit|_Exit|quick_exit|abort)$' ||
    true)
[ -z "$bad" ] || { printf 'forbidden functions:\n%s\n' "$bad"; status=1; }

memory=$(printf '%s\n' "$undefined" |
    grep -E ' (malloc|calloc|realloc|free|aligned_alloc|posix_memalign|alloca)$' |
    grep -v -F "$(printf ':%s.o\n' "$@")" || true)
[ -z "$memory" ] || { printf 'memory functions outside %s:\n%s\n' "$*" "$memory"; status=1; }

objects=$(objdump -h "$archive" | grep -c 'file format' || true)
[ "$objects" -gt 0 ] || { echo "no objects in $archive"; status=1; }
echo "$objects objects"
exit $status
