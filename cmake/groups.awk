# Groups of sources that one compilation can include together, no two with a name of their own, or of a header beside them, in
# common: "GROUP FILE" for each file but those that stay alone: what defines something before it includes and, of the libraries,
# what takes memory, by which tests know it. At most `most` files a group. Tests have headers in the folder `shared`; others are of
# one folder in a group, unless `over` is set.
# SPDX-License-Identifier: BSD-3-Clause
function own(name) { if (name != "") names[name] = origin }
function place(    g, name, free, folder) {
    if (file == "" || alone) return
    folder = file
    sub(/[^\/]*$/, "", folder)
    for (g = 1; g <= groups; ++g) {
        free = count[g] < most && (shared || over || of[g] == folder)
        if (free) for (name in names) if ((g, name) in taken && taken[g, name] != names[name]) free = 0
        if (free) break
    }
    if (g > groups) groups = g
    of[g] = folder
    ++count[g]
    for (name in names) taken[g, name] = names[name]
    print g, file
}
# What a declaration of one or several variables or functions calls them.
function declared(line,    parts, n, i) {
    while (gsub(/\{[^{}]*\}|\[[^]\[]*\]/, "", line)) continue
    if (line ~ /^[^=,;]*\(/) sub(/\(.*/, "", line)
    n = split(line, parts, ",")
    for (i = 1; i <= n; ++i) {
        sub(/[=;{(].*/, "", parts[i])
        sub(/ +$/, "", parts[i])
        sub(/.*[ *]/, "", parts[i])
        own(parts[i])
    }
}
function listing(line) {
    sub(/\/\*.*/, "", line)
    listed = line !~ /}/
    while (match(line, /[A-Z][A-Z0-9_]*/)) { own(substr(line, RSTART, RLENGTH)); line = substr(line, RSTART + RLENGTH) }
}
function scan(line) {
    if (line ~ /^(typedef )?enum/) listed = 1
    if (listed) listing(line)
    if (more || line ~ /^(static|MBSRI_INLINE) /) { more = line ~ /,$/ && line !~ /\(/; declared(line) }
    else if (line ~ /^typedef .*\(\*/) { sub(/.*\(\*/, "", line); sub(/\).*/, "", line); own(line) }
    else if (line ~ /^} [a-z]/) { sub(/^} /, "", line); sub(/;.*/, "", line); own(line) }
    else if (match(line, /^(typedef )?(struct|union|enum) [a-z_]+ \{/)) {
        sub(/^(typedef )?(struct|union|enum) /, "", line); sub(/ .*/, "", line); own(line)
    } else if (line ~ /^#define /) {
        sub(/^#define /, "", line); sub(/[( ].*/, "", line); own(line)
        return line
    }
    return ""
}
# The names of a header and of those that it includes, where it is one of the tests.
function header(name,    before, path, line, folder) {
    folder = file
    sub(/[^\/]*$/, "", folder)
    path = folder name
    if ((getline line <path) <= 0) {
        path = shared "/" name
        if (shared == "" || (getline line <path) <= 0) return
    }
    close(path)
    if (path in read) return
    read[path] = 1
    before = origin
    lines[path] = 0
    while ((getline line <path) > 0) text[path, ++lines[path]] = line
    close(path)
    for (at[path] = 1; at[path] <= lines[path]; ++at[path]) {
        origin = path
        line = text[path, at[path]]
        scan(line)
        if (line ~ /^#include "/) { split(line, quoted, "\""); header(quoted[2]) }
    }
    origin = before
}
FNR == 1 { place(); file = origin = FILENAME; alone = listed = defined = 0; split("", names); split("", read) }
/^#include "/ { split($0, quoted, "\""); header(quoted[2]) }
/^#include <complex.h>/ { alone = 1 } # it has I
/^#include/ && defined { alone = 1 } # what is defined before says what a header has
/(^|[^a-z_])(malloc|calloc|realloc|free)\(/ && FILENAME ~ /\// && !shared { alone = 1 } # of the libraries
{
    word = scan($0)
    if (word != "") defined = 1
    if (word ~ /^_/) alone = 1
}
END { place() }
