#!/bin/sh
# Fails when a call takes more than 5 % more instructions than baseline.csv says, one of ten times as many
# bodies in loops more than 10 % more for each, one of five times as many loops on one body more than 5^0.05
# times as many for each, a report of four times as many elastic loops more than 16 times as many, or a Newton
# system of a long chain with one loop more than 5 % more than that of the open chain and the loop, or one of
# bodies on loops more than five times that of the open chain (eight times with two bodies a loop), of couplers
# on joints of several axes and of coupled joints five times that of the same tree without closures.
# SPDX-License-Identifier: BSD-3-Clause
#
#   check.sh PROGRAM TREES COMPILER     as count.sh; exits with 77 where there is nothing to compare
set -eu

here=$(cd "$(dirname "$0")" && pwd)
skip() {
    echo "skipped: $1"
    exit 77
}
command -v valgrind > /dev/null || skip "valgrind is missing"
grep -q "^$3," "$here/baseline.csv" || skip "baseline.csv has nothing for $3; refresh.sh makes it"

counts=$(sh "$here/count.sh" "$@")
echo "$counts" | awk -F, '
    { at = $1 FS $2 FS $3 FS $4 }
    NR == FNR { if (/^[^#]/) baseline[at] = $5; next }
    {
        ++counted
        crowd = $3
        if ($2 == "crowds" && sub(/20$/, "", crowd)) few[crowd, $4] = $5
        crowd = $3
        if ($2 == "crowds" && sub(/100$/, "", crowd)) {
            printf "%-40s %8.1f %8.1f\n", at, $5, few[crowd, $4]
            if ($5 > 1.084 * few[crowd, $4]) {
                print at ": " $5 " instructions per body, of a fifth of the loops " few[crowd, $4]
                bad = 1
            }
        }
        if ($3 ~ /^cranks/) {
            printf "%-40s %8.1f\n", at, $5
            if ($3 == "cranks10") cranks = $5
            else if (!($5 <= cranks)) {
                print at ": " $5 " instructions for a body and direction, of a fourth of them " cranks
                bad = 1
            }
        }
        if ($2 == "crowds") next
        if ($2 == "front" && !(at in baseline)) next # counted with gcc alone
        if (!(at in baseline)) {
            print at ": " $5 " instructions per body, not in baseline.csv"
            bad = 1
            next
        }
        ratio = $5 / baseline[at]
        verdict = ratio > 1.05 ? "MORE" : ratio < 0.95 ? "fewer: refresh the baseline" : ""
        printf "%-40s %8.1f %8.1f %6.3f %s\n", at, $5, baseline[at], ratio, verdict
        if (ratio > 1.05) bad = 1
        # with closed loops too the cost is in proportion to the bodies
        model = $3
        size = sub(/100$/, "", model)
        if (!size) sub(/10$/, "", model)
        if ($2 == "loops" && size && $5 > 1.1 * small[model, $4]) {
            print at ": " $5 " instructions per body, of fewer bodies " small[model, $4]
            bad = 1
        }
        if ($2 == "loops" && !size) small[model, $4] = $5
        if ($2 == "loops" && ($4 == "factor" || $4 == "solve")) newton[$3] += $5
    }
    END {
        if (!counted) print "nothing was counted"
        limit = 1.05 * newton["open_chain1000"] + 4 / 1003 * newton["fourbars100"]
        for (model in newton) {
            open = model
            sub(/(_massless)?10+$/, "", open)
            open = "open_" open
            if (!(open in newton)) open = "open_chain1000"
            most = model ~ /^bars/ ? 8 : 5
            if (newton[model] > most * newton[open]) {
                print model ": factor and solve " newton[model] ", more than " most " times " open
                bad = 1
            }
            if (model !~ /^loop_at_/) continue
            printf "%s: factor and solve %.0f, at most %.0f\n", model, newton[model], limit
            if (newton[model] > limit) bad = 1
        }
        exit bad || !counted
    }' "$here/baseline.csv" -
