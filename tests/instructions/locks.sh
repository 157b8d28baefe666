#!/bin/sh
# Fails when a call on an arm with locked joints takes more than 2 % more instructions than on the arm built
# without these.
# SPDX-License-Identifier: BSD-3-Clause
#
#   locks.sh PROGRAM     built from locks.c; exits with 77 without valgrind
set -eu

command -v valgrind > /dev/null || {
    echo "skipped: valgrind is missing"
    exit 77
}
here=$(cd "$(dirname "$0")" && pwd)
sh "$here/count.sh" "$1" "" "" | awk -F, '
    $3 == "built" { built[$4] = $5; next }
    {
        ++compared
        printf "%-10s %8.0f %8.0f %6.3f\n", $4, $5, built[$4], $5 / built[$4]
        if (!($5 <= 1.02 * built[$4])) bad = 1
    }
    END { exit bad || compared != 5 }'
