/* An expression of xacro as a tree: see xacro_parse.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   test    = or ["if" or "else" test]             power = postfix ["**" sign]
 *   or      = and {"or" and}                       postfix = atom {call | index | "." name}
 *   and     = not {"and" not}                      atom  = value {value} | name | "(" list ")"
 *   not     = {"not"} compare                              | "[" list "]"
 *   compare = sum {("<" | ... | "not" "in") sum}   list  = [test {"," test} [","]]
 *   sum     = product {("+" | "-") product}
 *   product = sign {("*" | "/" | "//" | "%") sign}
 *   sign    = {"+" | "-"} power */
#include "files/xacro_parse.h"

#include "files/xacro_tokens.h"

#include <string.h>

typedef struct parser {
    mbsri_xacro *x;
    const char *rest;
    mbsri_token token; /* that comes next */
} parser;

static const mbsri_expression_node *parse_test(parser *p);

static bool next_token(parser *p)
{
    return mbsri_token_next(p->x, &p->rest, &p->token);
}

static bool is_mark(const parser *p, const char *mark)
{
    return p->token.kind == MBSRI_TOKEN_MARK && strcmp(p->token.text, mark) == 0;
}

static bool is_word(const parser *p, const char *word)
{
    return p->token.kind == MBSRI_TOKEN_NAME && strcmp(p->token.text, word) == 0;
}

/* One of these marks, a NULL behind them; NULL: none. */
static const char *one_of(const parser *p, const char *const *marks)
{
    while (*marks && !is_mark(p, *marks)) ++marks;
    return *marks;
}

static bool expect(parser *p, const char *mark)
{
    if (is_mark(p, mark)) return next_token(p);
    return mbsri_xacro_refuse(p->x, "'%s' is missing in an expression before '%.20s'", mark,
                              p->token.text ? p->token.text : "a value");
}

static mbsri_expression_node *make_node(parser *p, mbsri_node_kind kind,
                                        const mbsri_expression_node *a,
                                        const mbsri_expression_node *b)
{
    mbsri_expression_node *node = mbsri_xacro_take(p->x, sizeof *node);
    if (node) *node = (mbsri_expression_node){.kind = kind, .a = a, .b = b};
    return node;
}

static mbsri_item *add_item(parser *p, mbsri_item **last, const char *text,
                            const mbsri_expression_node *node)
{
    mbsri_item *item = node ? mbsri_xacro_take(p->x, sizeof *item) : NULL;
    if (!item) return NULL;
    *item = (mbsri_item){.text = text, .node = node};
    if (*last) (*last)->next = item;
    *last = item;
    return item;
}

static bool is_keyword(const char *text)
{
    static const char *const keywords[] = {
        "False", "None",     "True",  "and",    "as",   "assert", "async",  "await",    "break",
        "class", "continue", "def",   "del",    "elif", "else",   "except", "finally",  "for",
        "from",  "global",   "if",    "import", "in",   "is",     "lambda", "nonlocal", "not",
        "or",    "pass",     "raise", "return", "try",  "while",  "with",   "yield"};
    for (size_t k = 0; k < sizeof keywords / sizeof *keywords; ++k) {
        if (strcmp(text, keywords[k]) == 0) return true;
    }
    return false;
}

bool mbsri_is_name(const char *text)
{
    const char *s = text;
    if (*s >= '0' && *s <= '9') return false;
    while ((*s >= 'a' && *s <= 'z') || (*s >= 'A' && *s <= 'Z') || (*s >= '0' && *s <= '9') ||
           *s == '_' || (unsigned char)*s >= 128)
        ++s;
    return s > text && !*s && !is_keyword(text);
}

/* ---- atoms ---- */

/* Up to the closing mark, which is taken; *single: one item without a comma. */
static const mbsri_expression_node *parse_items(parser *p, mbsri_node_kind kind,
                                                const char *closing, bool *single)
{
    mbsri_expression_node *node = make_node(p, kind, NULL, NULL);
    mbsri_item *last = NULL;
    *single = false;
    if (!node || !next_token(p)) return NULL;
    while (!is_mark(p, closing)) {
        mbsri_item *item = add_item(p, &last, NULL, parse_test(p));
        if (!item) return NULL;
        *single = !node->first;
        if (*single) node->first = item;
        if (is_mark(p, closing)) break;
        *single = false;
        if (is_word(p, "for")) {
            mbsri_xacro_refuse(p->x, "comprehensions ('for') are not read");
            return NULL;
        }
        if (!expect(p, ",")) return NULL;
    }
    return next_token(p) ? node : NULL;
}

/* Strings beside each other are one. */
static const mbsri_expression_node *parse_value(parser *p)
{
    mbsri_expression_node *node = make_node(p, MBSRI_NODE_CONSTANT, NULL, NULL);
    if (!node) return NULL;
    node->value = p->token.value;
    if (!next_token(p)) return NULL;
    while (p->token.kind == MBSRI_TOKEN_VALUE && p->token.value.kind == MBSRI_STRING &&
           node->value.kind == MBSRI_STRING) {
        const char *more = p->token.value.of.string;
        const size_t length = strlen(node->value.of.string);
        char *both = mbsri_xacro_take(p->x, length + strlen(more) + 1);
        if (!both) return NULL;
        memcpy(both, node->value.of.string, length);
        memcpy(both + length, more, strlen(more));
        node->value.of.string = both;
        if (!next_token(p)) return NULL;
    }
    return node;
}

static const mbsri_expression_node *parse_name(parser *p)
{
    const char *text = p->token.text;
    const bool constant = is_word(p, "True") || is_word(p, "False") || is_word(p, "None");
    if (!constant && is_keyword(text)) {
        mbsri_xacro_refuse(p->x, "'%s' is nothing that expressions have here", text);
        return NULL;
    }
    mbsri_expression_node *node =
        make_node(p, constant ? MBSRI_NODE_CONSTANT : MBSRI_NODE_NAME, NULL, NULL);
    if (!node) return NULL;
    node->text = text;
    if (constant && *text != 'N') node->value = mbsri_value_truth(*text == 'T');
    return next_token(p) ? node : NULL;
}

static const mbsri_expression_node *parse_atom(parser *p)
{
    bool single;
    if (p->token.kind == MBSRI_TOKEN_VALUE) return parse_value(p);
    if (p->token.kind == MBSRI_TOKEN_NAME) return parse_name(p);
    if (is_mark(p, "(")) {
        const mbsri_expression_node *inner = parse_items(p, MBSRI_NODE_TUPLE, ")", &single);
        return inner && single ? inner->first->node : inner;
    }
    if (is_mark(p, "[")) return parse_items(p, MBSRI_NODE_LIST, "]", &single);
    mbsri_xacro_refuse(p->x, "an expression has '%.20s' where a value should be", p->token.text);
    return NULL;
}

/* ---- calls, indices, attributes ---- */

static const mbsri_expression_node *parse_call(parser *p, const mbsri_expression_node *function)
{
    mbsri_expression_node *node = make_node(p, MBSRI_NODE_CALL, function, NULL);
    mbsri_item *last = NULL;
    if (!node || !next_token(p)) return NULL;
    while (!is_mark(p, ")")) {
        const char *keyword = NULL;
        const mbsri_expression_node *value = parse_test(p);
        if (value && value->kind == MBSRI_NODE_NAME && is_mark(p, "=")) {
            keyword = value->text;
            value = next_token(p) ? parse_test(p) : NULL;
        }
        mbsri_item *item = add_item(p, &last, keyword, value);
        if (!item) return NULL;
        if (!node->first) node->first = item;
        if (!is_mark(p, ")") && !expect(p, ",")) return NULL;
    }
    return next_token(p) ? node : NULL;
}

static const mbsri_expression_node *parse_index(parser *p, const mbsri_expression_node *of)
{
    mbsri_expression_node *node = make_node(p, MBSRI_NODE_INDEX, of, NULL);
    if (!node || !next_token(p)) return NULL;
    if (!is_mark(p, ":") && !(node->b = parse_test(p))) return NULL;
    if (is_mark(p, ":")) {
        node->kind = MBSRI_NODE_SLICE;
        if (!next_token(p)) return NULL;
        if (!is_mark(p, "]") && !(node->c = parse_test(p))) return NULL;
    }
    return expect(p, "]") ? node : NULL;
}

static const mbsri_expression_node *parse_postfix(parser *p)
{
    const mbsri_expression_node *node = parse_atom(p);
    while (node) {
        if (is_mark(p, "(")) {
            node = parse_call(p, node);
        } else if (is_mark(p, "[")) {
            node = parse_index(p, node);
        } else if (is_mark(p, ".")) {
            mbsri_expression_node *of = make_node(p, MBSRI_NODE_ATTRIBUTE, node, NULL);
            if (!of || !next_token(p)) return NULL;
            of->text = p->token.text;
            if (p->token.kind != MBSRI_TOKEN_NAME) {
                mbsri_xacro_refuse(p->x, "an expression has no name behind '.'");
                return NULL;
            }
            node = next_token(p) ? of : NULL;
        } else {
            break;
        }
    }
    return node;
}

/* ---- operators ---- */

static const mbsri_expression_node *parse_sign(parser *p)
{
    static const char *const signs[] = {"+", "-", NULL};
    const char *sign = one_of(p, signs);
    if (!mbsri_xacro_enter(p->x)) return NULL;
    const mbsri_expression_node *node;
    if (sign) {
        mbsri_expression_node *unary = make_node(p, MBSRI_NODE_UNARY, NULL, NULL);
        if (!unary || !next_token(p) || !(unary->a = parse_sign(p))) return NULL;
        unary->text = sign;
        node = unary;
    } else {
        node = parse_postfix(p);
        if (node && is_mark(p, "**")) {
            mbsri_expression_node *power = make_node(p, MBSRI_NODE_BINARY, node, NULL);
            if (!power || !next_token(p) || !(power->b = parse_sign(p))) return NULL;
            power->text = "**";
            node = power;
        }
    }
    mbsri_xacro_leave(p->x);
    return node;
}

/* Operands of one rank between marks, from left to right. */
static const mbsri_expression_node *parse_row(parser *p, const char *const *marks,
                                              const mbsri_expression_node *(*operand)(parser *p))
{
    const mbsri_expression_node *node = operand(p);
    for (const char *mark; node && (mark = one_of(p, marks));) {
        mbsri_expression_node *both = make_node(p, MBSRI_NODE_BINARY, node, NULL);
        if (!both || !next_token(p) || !(both->b = operand(p))) return NULL;
        both->text = mark;
        node = both;
    }
    return node;
}

static const mbsri_expression_node *parse_product(parser *p)
{
    static const char *const marks[] = {"*", "/", "//", "%", NULL};
    return parse_row(p, marks, parse_sign);
}

static const mbsri_expression_node *parse_sum(parser *p)
{
    static const char *const marks[] = {"+", "-", NULL};
    return parse_row(p, marks, parse_product);
}

/* "<", "in", "not in", "is not" ..., which is taken; "": none; NULL: refused. */
static const char *take_comparison(parser *p)
{
    static const char *const marks[] = {"==", "!=", "<=", ">=", "<", ">", NULL};
    const char *mark = one_of(p, marks);
    const bool no = is_word(p, "not"), is = is_word(p, "is"), in = is_word(p, "in");
    if (!mark && !no && !is && !in) return "";
    if (!next_token(p)) return NULL;
    if (mark || in) return mark ? mark : "in";
    if (is && !is_word(p, "not")) return "is";
    if (no && !is_word(p, "in")) {
        mbsri_xacro_refuse(p->x, "an expression has 'not' behind a value");
        return NULL;
    }
    return next_token(p) ? no ? "not in" : "is not" : NULL;
}

static const mbsri_expression_node *parse_compare(parser *p)
{
    const mbsri_expression_node *a = parse_sum(p);
    mbsri_expression_node *chain = NULL;
    mbsri_item *last = NULL;
    for (const char *mark; a;) {
        if (!(mark = take_comparison(p))) return NULL;
        if (!*mark) return chain ? chain : a;
        if (!chain && !(chain = make_node(p, MBSRI_NODE_COMPARE, a, NULL))) return NULL;
        mbsri_item *item = add_item(p, &last, mark, parse_sum(p));
        if (!item) return NULL;
        if (!chain->first) chain->first = item;
    }
    return NULL;
}

static const mbsri_expression_node *parse_not(parser *p)
{
    if (!is_word(p, "not")) return parse_compare(p);
    mbsri_expression_node *node = make_node(p, MBSRI_NODE_UNARY, NULL, NULL);
    if (!node || !mbsri_xacro_enter(p->x) || !next_token(p) || !(node->a = parse_not(p)))
        return NULL;
    node->text = "not";
    mbsri_xacro_leave(p->x);
    return node;
}

static const mbsri_expression_node *parse_and(parser *p)
{
    const mbsri_expression_node *node = parse_not(p);
    while (node && is_word(p, "and")) {
        mbsri_expression_node *both = make_node(p, MBSRI_NODE_AND, node, NULL);
        if (!both || !next_token(p) || !(both->b = parse_not(p))) return NULL;
        node = both;
    }
    return node;
}

static const mbsri_expression_node *parse_or(parser *p)
{
    const mbsri_expression_node *node = parse_and(p);
    while (node && is_word(p, "or")) {
        mbsri_expression_node *both = make_node(p, MBSRI_NODE_OR, node, NULL);
        if (!both || !next_token(p) || !(both->b = parse_and(p))) return NULL;
        node = both;
    }
    return node;
}

static const mbsri_expression_node *parse_test(parser *p)
{
    if (!mbsri_xacro_enter(p->x)) return NULL;
    const mbsri_expression_node *node = parse_or(p);
    if (node && is_word(p, "if")) {
        mbsri_expression_node *choice = make_node(p, MBSRI_NODE_CONDITIONAL, node, NULL);
        if (!choice || !next_token(p) || !(choice->b = parse_or(p))) return NULL;
        if (!is_word(p, "else")) {
            mbsri_xacro_refuse(p->x, "an expression has 'if' without 'else'");
            return NULL;
        }
        if (!next_token(p) || !(choice->c = parse_test(p))) return NULL;
        node = choice;
    }
    mbsri_xacro_leave(p->x);
    return node;
}

const mbsri_expression_node *mbsri_xacro_parse(mbsri_xacro *x, const char *text)
{
    parser p = {.x = x, .rest = text};
    if (!next_token(&p)) return NULL;
    const mbsri_expression_node *node = parse_test(&p);
    if (node && is_mark(&p, ",")) { /* a tuple without brackets */
        mbsri_expression_node *tuple = make_node(&p, MBSRI_NODE_TUPLE, NULL, NULL);
        mbsri_item *last = NULL;
        if (!tuple || !(tuple->first = add_item(&p, &last, NULL, node))) return NULL;
        while (is_mark(&p, ",")) {
            if (!next_token(&p)) return NULL;
            if (p.token.kind == MBSRI_TOKEN_END) break;
            if (!add_item(&p, &last, NULL, parse_test(&p))) return NULL;
        }
        node = tuple;
    }
    if (!node || p.token.kind == MBSRI_TOKEN_END) return node;
    mbsri_xacro_refuse(x, "an expression has '%.20s' where it should end",
                       p.token.text ? p.token.text : "a value");
    return NULL;
}
