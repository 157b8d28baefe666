#!/bin/sh
# No record of the sources has more fields than a given number, but for those named, each with a number of its own. A
# record inside another counts as one field there, and has fields of its own.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: records.sh PROJECT_DIR FIELDS [NAME=FIELDS ...]
set -eu
cd "$1"
most=$2
shift 2
find src include -name '*.[ch]' | grep -q . || { echo "no sources"; exit 1; }
find src include -name '*.[ch]' | sort | xargs awk -v most="$most" -v named="$*" '
    BEGIN {
        count = split(named, pair, " ")
        for (k = 1; k <= count; ++k) {
            split(pair[k], side, "=")
            allowed[side[1]] = side[2]
        }
    }
    # "NAME" after the brace that closes a record, or behind struct before the one that opens it.
    function close_record(name) {
        name = tag[depth] != "" ? tag[depth] : name
        ++records
        limit = name in allowed ? allowed[name] : most
        if (fields[depth] > limit) {
            printf "%s: %s has %d fields, %d allowed\n", file, name, fields[depth], limit
            bad = 1
        }
        if (fields[depth] > most) met[name] = 1
    }
    FNR == 1 { text = ""; depth = 0; comment = 0; file = FILENAME }
    {
        line = $0
        if (comment) {
            if (!match(line, /\*\//)) next
            line = substr(line, RSTART + 2)
            comment = 0
        }
        while (match(line, /\/\*/)) {
            begin = RSTART
            rest = substr(line, begin + 2)
            line = substr(line, 1, begin - 1) " "
            if (match(rest, /\*\//)) line = line substr(rest, RSTART + 2)
            else { comment = 1; break }
        }
        if (line ~ /^[ \t]*#/) next
        text = text " " line
        # statements and braces one after the other
        while (match(text, /[;{}]/)) {
            mark = substr(text, RSTART, 1)
            part = substr(text, 1, RSTART - 1)
            text = substr(text, RSTART + 1)
            if (mark == "{") {
                ++depth
                record[depth] = part ~ /(^|[^a-zA-Z0-9_])(struct|union)[ \t]+[a-zA-Z0-9_]*[ \t]*$/ && part !~ /[(=]/
                fields[depth] = 0
                tag[depth] = part
                sub(/^.*(struct|union)[ \t]*/, "", tag[depth])
                sub(/[ \t]*$/, "", tag[depth])
            } else if (mark == "}") {
                waits = record[depth]
                if (waits) {
                    name = text
                    sub(/^[ \t]*/, "", name)
                    sub(/[^a-zA-Z0-9_].*/, "", name)
                    close_record(name)
                }
                --depth
            } else if (depth > 0 && record[depth]) {
                while (sub(/\([^()]*\)/, "", part)) { }
                fields[depth] += 1 + gsub(/,/, "", part)
            }
        }
    }
    END {
        for (name in allowed) if (!(name in met)) {
            printf "%s is named, and no record of that name has more than %d fields\n", name, most
            bad = 1
        }
        printf "%d records, of %d fields at most but for %d\n", records, most, count
        exit bad || records == 0
    }'
