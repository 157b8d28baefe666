#!/usr/bin/env bash
# Makes a wheel that contains the shared libraries, and what they need but the C library, so that it
# runs where libmbsrank is not installed. Needs pip, wheel and patchelf.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: wheel.sh PREFIX [FOLDER]     PREFIX: where libmbsrank is installed; the wheel goes to
# FOLDER, default: dist
set -eu
prefix=$(cd "$1" && pwd)
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
mkdir -p "${2:-dist}"
to=$(cd "${2:-dist}" && pwd)
python=${PYTHON:-/usr/bin/python3}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cp -r "$here" "$work/source"
MBSRANK_PREFIX=$prefix "$python" -m pip wheel -q --no-deps --no-build-isolation \
    -w "$work/plain" "$work/source"
"$python" -m wheel unpack -d "$work/open" "$work"/plain/mbsrank-*.whl
libraries=$(find "$prefix"/lib* -name "libmbsrank*.so" -printf "%h\n" | sort -u | paste -sd:)
package=$(echo "$work"/open/mbsrank-*/mbsrank)
mkdir "$package/lib" "$package/bin"

# copy FILE: copies the libraries that it needs, theirs too.
copy() {
    local name path found
    found=$(LD_LIBRARY_PATH=$libraries ldd "$1")
    case $found in *"not found"*) echo "wheel.sh: $1: $found" >&2; exit 1 ;; esac
    echo "$found" | awk '/=> \// {print $1, $3}' | while read -r name path; do
        case $name in
        libc.so.* | libm.so.* | libdl.so.* | libpthread.so.* | librt.so.* | ld-linux*) ;;
        *) cp -Ln "$path" "$package/lib/$name" ;;
        esac
    done
}
copy "$package"/_c.*.so
if [ -x "$prefix/bin/mbsrank" ]; then
    cp "$prefix/bin/mbsrank" "$package/bin/"
    copy "$package/bin/mbsrank"
    patchelf --set-rpath '$ORIGIN/../lib' "$package/bin/mbsrank"
fi
if [ -f "$prefix/share/mbsrank/viewer.html" ]; then
    cp "$prefix/share/mbsrank/viewer.html" "$package/bin/"
fi
for library in "$package"/lib/*; do
    chmod u+w "$library"
    patchelf --set-rpath '$ORIGIN' "$library"
done
patchelf --set-rpath '$ORIGIN/lib' "$package"/_c.*.so
"$python" -m wheel pack -d "$to" "$work"/open/mbsrank-*
