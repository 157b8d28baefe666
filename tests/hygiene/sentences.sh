#!/bin/sh
# Of the sentences in the documents at most some are longer than a given number of words: two in a hundred of
# all of them, five in a hundred of one page. Code, formulas and headings are no sentences; the cells of tables
# are, and a code span, a formula or an address is one word.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: sentences.sh PROJECT_DIR WORDS [--list]
set -eu
cd "$1"
limit=$2
list=${3:-}

awk -v limit="$limit" -v list="$list" '
    # Sentences of a text, each counted.
    function count(text, first,    rest, sentence) {
        gsub(/`[^`]*`/, "code", text)
        gsub(/<br>/, ". ", text)
        gsub(/!?\[|\]\([^)]*\)|\$[^$]*\$|\*\*|<!--.*-->/, " ", text)
        gsub(/(e\.g|i\.e|vs|cf|eqs?|Eqs?|Sci|Fig|Mech|et al|No)\. /, "abbreviation ", text)
        gsub(/M\. Arnold/, "Arnold", text)
        for (rest = text; match(rest, /[.!?]["”)]*([ \t]+|$)/); rest = substr(rest, RSTART + RLENGTH)) {
            sentence = substr(rest, 1, RSTART)
            judge(sentence, first)
        }
        judge(rest, first)
    }
    function judge(sentence, first,    words, n, k, real) {
        n = split(sentence, words, /[ \t]+/)
        real = 0
        for (k = 1; k <= n; ++k) if (words[k] ~ /[A-Za-z0-9]/) ++real
        if (real < 2) return
        ++sentences[file]
        if (real > limit) {
            ++long_ones[file]
            if (list != "") printf "%s:%d: %d words: %s\n", file, first, real, sentence
        }
    }
    function flush() {
        if (text != "") count(text, start)
        text = ""
    }
    FNR == 1 { flush(); file = FILENAME; fence = 0; blank = 1; names[++files] = file }
    /^ *```/ { flush(); fence = !fence; next }
    /^\$\$/ { flush(); if ($0 !~ /^\$\$.+\$\$/) fence = !fence; next }
    fence { next }
    /^[ \t]*$/ { flush(); blank = 1; next }
    /^#/ { flush(); blank = 1; next }
    /^ *<!--/ { next }
    /^    / && blank && !item { next }
    /^ *\|/ {
        flush()
        cells = split($0, cell, /\|/)
        for (k = 1; k <= cells; ++k) count(cell[k], FNR)
        next
    }
    /^ *([-*]|[0-9]+\.) / { flush(); sub(/^ *([-*]|[0-9]+\.) /, ""); item = 1 }
    /^[^ ]/ && blank { item = 0 }
    { if (text == "") start = FNR; text = text " " $0; blank = 0 }
    END {
        flush()
        for (k = 1; k <= files; ++k) {
            file = names[k]
            all += sentences[file]
            all_long += long_ones[file]
            printf "%s: %d sentences, %d longer than %d words\n", file, sentences[file], long_ones[file], limit
            if (100 * long_ones[file] > 5 * sentences[file] && long_ones[file] > 1) { print "    too many"; bad = 1 }
        }
        printf "all: %d sentences, %d longer than %d words\n", all, all_long, limit
        if (all == 0 || 100 * all_long > 2 * all) { print "    too many"; bad = 1 }
        exit bad
    }' README.md CHANGELOG.md CONTRIBUTING.md SECURITY.md bench/README.md docs/*.md
