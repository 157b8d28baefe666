# Groups of sources that one compilation can include together, of one folder, no two with a name of their own in common:
# "GROUP FILE" for each file but those that stay alone: what takes memory, by which tests know it, and what defines something
# before it includes. At most `most` files a group.
# SPDX-License-Identifier: BSD-3-Clause
function own(name) { names[name] = 1 }
function place(    g, name, free, folder) {
    if (file == "" || alone) return
    folder = file
    sub(/[^\/]*$/, "", folder)
    for (g = 1; g <= groups; ++g) {
        free = count[g] < most && of[g] == folder
        if (free) for (name in names) if ((g, name) in taken) free = 0
        if (free) break
    }
    if (g > groups) groups = g
    of[g] = folder
    ++count[g]
    for (name in names) taken[g, name] = 1
    print g, file
}
FNR == 1 { place(); file = FILENAME; alone = listed = defined = 0; split("", names) }
/^(static|MBSRI_INLINE) / {
    line = $0
    sub(/[(=;].*/, "", line)
    gsub(/\[[^]]*\]| +$/, "", line)
    sub(/.*[ *]/, "", line)
    own(line)
}
/^typedef .*\(\*/ { line = $0; sub(/.*\(\*/, "", line); sub(/\).*/, "", line); own(line) }
/^} [a-z]/ { line = $2; sub(/;.*/, "", line); own(line) }
/^(typedef )?(struct|union|enum) [a-z_]+ \{/ { own($1 == "typedef" ? $3 : $2) }
/^#define / { line = $2; sub(/\(.*/, "", line); own(line); defined = 1; if (line ~ /^_/) alone = 1 }
/^#include/ && defined { alone = 1 } # what is defined before says what a header has
/(^|[^a-z_])(malloc|calloc|realloc|free)\(/ && FILENAME ~ /\// { alone = 1 } # of the libraries
/^enum/ { listed = 1 }
listed {
    line = $0
    sub(/\/\*.*/, "", line)
    while (match(line, /[A-Z][A-Z0-9_]+/)) { own(substr(line, RSTART, RLENGTH)); line = substr(line, RSTART + RLENGTH) }
    if ($0 ~ /}/) listed = 0
}
END { place() }
