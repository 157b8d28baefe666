# Makes Doxygen comments of the comments in a public header: the head becomes a group, "/* ---- title ---- */" a
# section, a comment before a declaration its description, one behind it that of a member. Lines that are indented
# within a comment are formulas or code, and stay as they are.
# SPDX-License-Identifier: BSD-3-Clause

# The groups of the reference, as in the README.
function topic(name) {
    if (name ~ /^(mbsrank|base|spatial|data)$/) return "basics"
    if (name ~ /^(model|joint|verify|inertia|force|table|flex|fe|sid|files)$/) return "models"
    if (name ~ /^(dynamics|batch|threads|index|small_masses)$/) return "evaluation"
    if (name ~ /^(closure)$/) return "loops"
    if (name ~ /^(dae|ode|newton|completion)$/) return "equations"
    return "runs"
}

# Text of a comment that means nothing to Doxygen.
function escaped(text) {
    gsub(/\\/, "\\\\", text)
    gsub(/@/, "\\@", text)
    gsub(/</, "\\<", text)
    gsub(/#/, "\\#", text)
    gsub(/%/, "\\%", text)
    gsub(/&/, "\\\\\\&", text)
    gsub(/mbsr_[a-z0-9_]*[a-z0-9]/, "#&", text) # a link
    return text
}

# Writes a line, and remembers it: declarations below each other share the comment before the first.
function put(text) {
    print text
    if (!trailing) shared = shared text "\n"
}

# One line of a comment, without what opens and closes it.
function say(text,    formula) {
    formula = text ~ /^    *[^ ]/ && !trailing
    if (formula != verbatim) {
        if (text ~ /^ *$/) { held = held "\n"; return }
        put((verbatim ? "@endverbatim\n" : "") held (formula ? "@verbatim" : ""))
        verbatim = formula
        held = ""
    }
    put(held (verbatim ? text : escaped(text)))
    held = ""
}
function finish() {
    put((verbatim ? "@endverbatim\n" : "") "*/")
    described = !trailing
    verbatim = 0
    held = ""
}

# What stands in the comment of the line, from a place behind its opening; says whether it goes on.
function inside(text,    last) {
    last = index(text, "*/")
    if (last) text = substr(text, 1, last - 1)
    if (first_line || !comment) sub(/^ /, "", text)
    else if (!sub(/^ *\* ?/, "", text)) sub(/^ */, "", text)
    first_line = 0
    if (trailing) sub(/^ +/, "", text)
    if (text !~ /SPDX-License-Identifier/) say(trailing ? text : " " text)
    comment = !last
    if (last) finish()
}
FNR == 1 {
    name = FILENAME
    sub(/.*\//, "", name)
    sub(/\.h$/, "", name)
    title = $0
    sub(/^\/\* */, "", title)
    sub(/[.:,] *$/, "", title)
    sub(/[:.].*$/, "", title)
    print "/** @file\n * @brief " escaped(title) " */"
    print "/** @defgroup h_" name " " name ".h: " escaped(title) "\n@ingroup " topic(name)
    comment = 1; first_line = 1; trailing = 0; verbatim = 0
    inside(substr($0, 3))
    if (!comment) print "/** @addtogroup h_" name "\n@{ */"
    next
}
comment {
    was_head = !opened
    inside($0)
    if (!comment && was_head) { print "/** @addtogroup h_" name "\n@{ */"; opened = 1 }
    next
}
/^ *\/\* ---- .* ---- \*\/$/ {
    text = $0
    gsub(/^ *\/\* -+ *| *-+ \*\/$/, "", text)
    if (section) print "/** @} */"
    section = 1
    print "/** @name " escaped(text) "\n@{ */"
    next
}
# The list of statuses becomes an enumeration with texts.
/^#define MBSR_STATUS_MAP/ { listing = 1; next }
listing {
    if (match($0, /X\(MBSR_[A-Z_]+, -?[0-9]+, /)) {
        split(substr($0, RSTART + 2, RLENGTH - 2), part, /, */)
        text = substr($0, RSTART + RLENGTH + 1)
        sub(/"\).*$/, "", text)
        statuses = statuses "    " part[1] " = " part[2] ", /**< " escaped(text) " */\n"
    }
    listing = /\\$/
    next
}
/MBSR_STATUS_ENUM/ { next }
/^enum mbsr_status/ { print "/** The statuses of all functions. */"; print; printf "%s", statuses; next }
# Options and definitions that have no comment of their own, and the functions that give the defaults.
/^MBSR_API mbsr_[a-z_0-9]+ mbsr_default_[a-z_0-9]+\(void\);$/ && shared == "" { print "/** Defaults for all fields, and the mark that they are set. */" }
/^typedef struct mbsr_[a-z_0-9]+_(opt|def) \{$/ && !described {
    print "/** Options and definitions for the functions below; begin with the defaults. */"
}
/^typedef struct mbsr_[a-z_0-9]+ mbsr_[a-z_0-9]+;$/ && shared == "" { print "/** An opaque object. */" }
match($0, /\/\*/) {
    before = substr($0, 1, RSTART - 1)
    rest = substr($0, RSTART + 2)
    trailing = before ~ /[^ ]/
    if (before ~ /\{ *$/) { print $0; next }
    if (before ~ /^#(ifndef|ifdef|if|else|endif|include)/) { print before; next }
    if (!trailing) shared = ""
    put(before "/**" (trailing ? "<" : ""))
    first_line = 1; comment = 1; verbatim = 0
    again = 0
    inside(rest)
    next
}
# A declaration that follows another without a blank line has its comment.
/^ *$/ || /^ *[}#]/ { shared = ""; again = described = 0 }
again && shared != "" { printf "%s", shared }
{
    print
    again = /;$/
}
END {
    if (section) print "/** @} */"
    print "/** @} */"
}
