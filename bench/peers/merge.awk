# One table from the results of all programs and rounds, and the ratios of their medians.
# SPDX-License-Identifier: BSD-3-Clause
#
#   awk -f merge.awk ROUND/LIBRARY.csv...
#
# Of a library's rounds: the least minimum, the middle one of the medians, the largest third
# quartile. The first library is the one that the others are divided by.
BEGIN { FS = OFS = "," }

FNR == 1 {
    name = FILENAME
    sub(/.*\//, "", name)
    sub(/\.csv$/, "", name)
    if (!(name in known)) library[++libraries] = name
    first = !(name in known)
    known[name] = 1
}

/^#/ {
    # Machine and date from the first file, what is special about a library once for each.
    if (libraries == 1 && first) print
    else if (first && /^# (compiler|flags):/) print "# " name ":" substr($0, 2)
    else if (first && !/^# (date|machine|load average|library|BLAS|dynamics)/) print
    next
}

$1 == "tree" { columns = $0; next }

NF == 9 {
    place = $1 OFS $3
    if (!(place in order)) { order[place] = ++places; key[places] = place }
    at = name OFS place
    bodies[at] = $2
    defect[at] = $4
    if (!(at in rounds) || $5 < build[at]) build[at] = $5
    bytes[at] = $6
    if (!(at in rounds) || $7 < least[at]) least[at] = $7
    if (!(at in rounds) || $9 > most[at]) most[at] = $9
    median[at, ++rounds[at]] = $8
}

function middle(at,    n, k, l, x) {
    n = rounds[at]
    for (k = 1; k <= n; ++k)
        for (l = k + 1; l <= n; ++l)
            if (median[at, l] + 0 < median[at, k] + 0) {
                x = median[at, k]
                median[at, k] = median[at, l]
                median[at, l] = x
            }
    return n % 2 ? median[at, (n + 1) / 2] : (median[at, n / 2] + median[at, n / 2 + 1]) / 2
}

END {
    print "library", columns
    for (l = 1; l <= libraries; ++l) {
        for (p = 1; p <= places; ++p) {
            at = library[l] OFS key[p]
            if (!(at in rounds)) continue
            split(key[p], part, OFS)
            value[at] = middle(at)
            print library[l], part[1], bodies[at], part[2], defect[at], build[at], bytes[at],
                  least[at], value[at], most[at]
        }
    }
    line = "# tree,call," library[1] "_ns"
    for (l = 2; l <= libraries; ++l) line = line OFS library[l]
    print "# medians of the other columns, divided by that of " library[1] " (above 1: slower)"
    print line
    for (p = 1; p <= places; ++p) {
        own = library[1] OFS key[p]
        if (!(own in rounds)) continue
        line = "# " key[p] OFS sprintf("%.1f", value[own])
        for (l = 2; l <= libraries; ++l) {
            at = library[l] OFS key[p]
            line = line OFS (at in rounds ? sprintf("%.2f", value[at] / value[own]) : "")
        }
        print line
    }
}
