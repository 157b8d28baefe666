# Ties by functions and tables: "UNIT OTHER NAME" where UNIT uses what the source of OTHER defines. Definitions begin in the
# first column, uses stand on indented lines; a type of the name of a function is no use of that. Of sources of which a build
# takes one, the first defines.
# SPDX-License-Identifier: BSD-3-Clause
function define() {
    if (!(name in home)) home[name] = unit
    name = ""
}
function tie(key,    part) {
    split(key, part, SUBSEP)
    if (part[2] in home && home[part[2]] != part[1]) print part[1], home[part[2]], part[2]
}
FNR == 1 { unit = FILENAME; sub(/\.[ch]$/, "", unit); source = FILENAME ~ /\.c$/; name = ""; comment = 0 }
{
    line = $0
    if (comment && !sub(/.*\*\//, "", line)) next
    gsub(/\/\*[^*]*(\*[^*\/]+)*\*\//, "", line)
    comment = sub(/\/\*.*/, "", line)
    gsub(/"([^"\\]|\\.)*"/, "", line)
}
/^extern / { declares = 1 }
declares { declares = line !~ /;$/; next }
line ~ /^}.*;$/ || line ~ /^typedef.*;$/ { sub(/;$/, "", line); sub(/.*[^a-z0-9_]/, "", line); type[line] = 1; next }
source && line ~ /^[a-z]/ && line !~ /^(static|typedef|extern) / && match(line, /mbsri?_[a-z0-9_]+( = |\(|\[)/) {
    name = substr(line, RSTART, RLENGTH)
    sub(/[^a-z0-9_].*/, "", name)
    if (line ~ /=/) define()
}
name != "" && line ~ /;$/ { name = "" }
name != "" && line ~ /^[{]/ { define() }
line ~ /^[ \t#]/ {
    while (match(line, /mbsri?_[a-z0-9_]+/)) {
        token = substr(line, RSTART, RLENGTH)
        line = substr(line, RSTART + RLENGTH)
        if (line ~ /^\(/) called[unit, token] = 1
        else named[unit, token] = 1
    }
}
END {
    for (key in called) tie(key)
    for (key in named) {
        split(key, part, SUBSEP)
        if (!(part[2] in type)) tie(key)
    }
}
