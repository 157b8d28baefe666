/* The value of an expression of xacro: see xacro_evaluate.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/xacro_evaluate.h"

#include "files/xacro_arithmetic.h"
#include "files/xacro_functions.h"
#include "files/xacro_methods.h"
#include "files/xacro_parse.h"

#include <string.h>

typedef struct evaluation {
    mbsri_xacro *x;
    struct mbsri_scope *scope;
} evaluation;

static bool evaluate_node(evaluation *e, const mbsri_expression_node *node, mbsri_value *out);

/* ---- names and members ---- */

static bool find_name(evaluation *e, const char *name, mbsri_value *out)
{
    const int found = e->scope ? e->x->look_up(e->x, e->scope, name, out) : 0;
    if (found) return found > 0;
    return mbsri_global_find(name, out) ||
           mbsri_xacro_refuse(e->x, "there is no property or function '%.50s'", name);
}

static bool find_member(evaluation *e, const mbsri_expression_node *node, mbsri_value *out)
{
    const char *name = node->text;
    mbsri_value *of = mbsri_xacro_take(e->x, sizeof *of);
    if (!of || !evaluate_node(e, node->a, of)) return false;
    if (of->kind == MBSRI_NAMESPACE) return find_name(&(evaluation){e->x, of->of.scope}, name, out);
    if (of->kind == MBSRI_MODULE && mbsri_module_find(of->of.module, name, out)) return true;
    if (mbsri_method_find(of, name, out)) return true;
    if (of->kind == MBSRI_DICTIONARY) {
        const mbsri_value key = mbsri_value_string(name);
        mbsri_value *found;
        if (!mbsri_value_find(e->x, of, &key, &found)) return false;
        if (!found) return mbsri_xacro_refuse(e->x, "a dictionary has no key '%.50s'", name);
        *out = *found;
        return true;
    }
    return mbsri_xacro_refuse(e->x, "%s has no '%.50s' here", mbsri_kind_name(of), name);
}

/* ---- parts of strings, lists and dictionaries ---- */

/* The length of what is indexed by places; -1: it is not. */
static int64_t indexed_length(mbsri_xacro *x, const mbsri_value *of)
{
    if (mbsri_is_sequence(of)) return of->of.list->count;
    if (of->kind != MBSRI_STRING) {
        mbsri_xacro_refuse(x, "%s has no parts", mbsri_kind_name(of));
        return -1;
    }
    for (const char *s = of->of.string; *s; ++s) {
        if ((unsigned char)*s < 128) continue;
        mbsri_xacro_refuse(x, "parts of texts beyond ASCII are not read");
        return -1;
    }
    const size_t length = strlen(of->of.string);
    return mbsri_xacro_spend(x, length) ? (int64_t)length : -1;
}

static bool find_part(evaluation *e, const mbsri_expression_node *node, mbsri_value *out)
{
    mbsri_value of, at;
    int64_t place;
    if (!evaluate_node(e, node->a, &of) || !evaluate_node(e, node->b, &at)) return false;
    if (of.kind == MBSRI_DICTIONARY) {
        mbsri_value *found;
        if (!mbsri_value_find(e->x, &of, &at, &found)) return false;
        const char *key = found ? "" : mbsri_value_text(e->x, &at);
        if (!found) return key && mbsri_xacro_refuse(e->x, "a dictionary has no key '%.50s'", key);
        *out = *found;
        return true;
    }
    const int64_t length = indexed_length(e->x, &of);
    if (length < 0) return false;
    if (!mbsri_is_whole(&at, &place))
        return mbsri_xacro_refuse(e->x, "an index is %s", mbsri_kind_name(&at));
    if (place < -length || place >= length)
        return mbsri_xacro_refuse(e->x, "an index is %lld, of %lld", (long long)place,
                                  (long long)length);
    if (place < 0) place += length;
    if (of.kind != MBSRI_STRING) {
        *out = mbsri_items(&of)[place];
        return true;
    }
    *out = mbsri_value_string(mbsri_xacro_copy(e->x, of.of.string + place, 1));
    return out->of.string != NULL;
}

/* One end of a slice, which may be missing or beyond the others. */
static bool find_end(evaluation *e, const mbsri_expression_node *node, int64_t length, int64_t *end)
{
    mbsri_value value;
    if (!node) return true;
    if (!evaluate_node(e, node, &value)) return false;
    if (value.kind == MBSRI_NOTHING) return true;
    if (!mbsri_is_whole(&value, end))
        return mbsri_xacro_refuse(e->x, "an index is %s", mbsri_kind_name(&value));
    if (*end < 0) *end = *end < -length ? 0 : *end + length;
    if (*end > length) *end = length;
    return true;
}

static bool slice(evaluation *e, const mbsri_expression_node *node, mbsri_value *out)
{
    mbsri_value of;
    if (!evaluate_node(e, node->a, &of)) return false;
    const int64_t length = indexed_length(e->x, &of);
    int64_t from = 0, to = length;
    if (length < 0 || !find_end(e, node->b, length, &from) || !find_end(e, node->c, length, &to))
        return false;
    if (to < from) to = from;
    if (of.kind == MBSRI_STRING) {
        *out = mbsri_value_string(mbsri_xacro_copy(e->x, of.of.string + from, (size_t)(to - from)));
        return out->of.string != NULL;
    }
    mbsri_list *list = mbsri_value_begin(e->x, of.kind, out);
    for (; list && from < to; ++from) {
        if (!mbsri_value_add(e->x, list, mbsri_items(&of) + from)) return false;
    }
    return list != NULL;
}

/* ---- operators ---- */

static bool negate(evaluation *e, const mbsri_expression_node *node, mbsri_value *out)
{
    const mbsri_value zero = mbsri_value_whole(0);
    mbsri_value a;
    double number;
    if (!evaluate_node(e, node->a, &a)) return false;
    if (strcmp(node->text, "not") == 0) {
        *out = mbsri_value_truth(!mbsri_value_true(&a));
        return true;
    }
    if (!mbsri_is_number(&a, &number))
        return mbsri_xacro_refuse(e->x, "%s has no sign", mbsri_kind_name(&a));
    if (a.kind != MBSRI_REAL) return mbsri_arithmetic(e->x, node->text, &zero, &a, out);
    *out = mbsri_value_real(*node->text == '-' ? -number : number);
    return true;
}

/* Whether a is in b. */
static bool contains(mbsri_xacro *x, const mbsri_value *a, const mbsri_value *b, bool *inside)
{
    *inside = false;
    if (b->kind == MBSRI_DICTIONARY) {
        mbsri_value *found;
        const bool good = mbsri_value_find(x, b, a, &found);
        *inside = found != NULL;
        return good;
    }
    if (b->kind == MBSRI_STRING && a->kind == MBSRI_STRING) {
        *inside = strstr(b->of.string, a->of.string) != NULL;
        return mbsri_xacro_spend(x, strlen(a->of.string) + strlen(b->of.string));
    }
    if (!mbsri_is_sequence(b))
        return mbsri_xacro_refuse(x, "%s cannot be in %s", mbsri_kind_name(a), mbsri_kind_name(b));
    for (int k = 0; k < b->of.list->count && !*inside; ++k) {
        if (!mbsri_value_equal(x, a, mbsri_items(b) + k, inside)) return false;
    }
    return true;
}

static bool holds(mbsri_xacro *x, const char *mark, const mbsri_value *a, const mbsri_value *b,
                  bool *result)
{
    int order;
    if (strcmp(mark, "in") == 0 || strcmp(mark, "not in") == 0) {
        const bool good = contains(x, a, b, result);
        if (*mark == 'n') *result = !*result;
        return good;
    }
    if (strcmp(mark, "is") == 0 || strcmp(mark, "is not") == 0) {
        if (a->kind > MBSRI_TRUTH && b->kind > MBSRI_TRUTH)
            return mbsri_xacro_refuse(x, "'is' is read for None, True and False only");
        *result = a->kind == b->kind && (a->kind == MBSRI_NOTHING || a->of.truth == b->of.truth);
        if (mark[2]) *result = !*result;
        return true;
    }
    if (strcmp(mark, "==") == 0 || strcmp(mark, "!=") == 0) {
        const bool good = mbsri_value_equal(x, a, b, result);
        if (*mark == '!') *result = !*result;
        return good;
    }
    if (!mbsri_value_compare(x, a, b, &order)) return false;
    *result = (mark[1] && order == 0) || (*mark == '<' ? order < 0 : order > 0);
    return true;
}

static bool compare_values(evaluation *e, const mbsri_expression_node *node, mbsri_value *out)
{
    mbsri_value a, b;
    bool result = true;
    if (!evaluate_node(e, node->a, &a)) return false;
    for (const mbsri_item *item = node->first; item && result; item = item->next) {
        if (!evaluate_node(e, item->node, &b) || !holds(e->x, item->text, &a, &b, &result))
            return false;
        a = b;
    }
    *out = mbsri_value_truth(result);
    return true;
}

/* ---- calls ---- */

/* A function may look at all of a string. */
static bool spend_on(mbsri_xacro *x, const mbsri_value *v)
{
    return !v || v->kind != MBSRI_STRING || mbsri_xacro_spend(x, strlen(v->of.string));
}

static bool call(evaluation *e, const mbsri_expression_node *node, mbsri_value *out)
{
    mbsri_value function;
    mbsri_list arguments = {.count = 0}, keywords = {.count = 0};
    if (!evaluate_node(e, node->a, &function)) return false;
    if (function.kind != MBSRI_FUNCTION)
        return mbsri_xacro_refuse(e->x, "%s is called", mbsri_kind_name(&function));
    if (!spend_on(e->x, function.self)) return false;
    const mbsri_function *f = function.of.function;
    for (const mbsri_item *item = node->first; item; item = item->next) {
        mbsri_value argument;
        if (item->text && strcmp(f->name, "dict") != 0)
            return mbsri_xacro_refuse(e->x, "%s() is given '%.40s' by name", f->name, item->text);
        if (!evaluate_node(e, item->node, &argument) || !spend_on(e->x, &argument) ||
            !mbsri_value_add(e->x, &arguments, &argument))
            return false;
        const char **keyword = mbsri_list_add(e->x->s->arena, &keywords, sizeof *keyword);
        if (!keyword) return false;
        *keyword = item->text;
    }
    if (arguments.count < f->least || arguments.count > f->most)
        return mbsri_xacro_refuse(e->x, "%s() is given %d arguments", f->name, arguments.count);
    const mbsri_macro_call c = {f, function.self, arguments.items, keywords.items, arguments.count};
    return f->call(e->x, &c, out);
}

static bool gather(evaluation *e, const mbsri_expression_node *node, mbsri_value *out)
{
    mbsri_list *list =
        mbsri_value_begin(e->x, node->kind == MBSRI_NODE_LIST ? MBSRI_LIST : MBSRI_TUPLE, out);
    for (const mbsri_item *item = node->first; list && item; item = item->next) {
        mbsri_value value;
        if (!evaluate_node(e, item->node, &value) || !mbsri_value_add(e->x, list, &value))
            return false;
    }
    return list != NULL;
}

/* ---- all ---- */

static bool evaluate_kind(evaluation *e, const mbsri_expression_node *node, mbsri_value *out)
{
    mbsri_value a, b;
    switch (node->kind) {
    case MBSRI_NODE_CONSTANT: *out = node->value; return true;
    case MBSRI_NODE_NAME: return find_name(e, node->text, out);
    case MBSRI_NODE_LIST:
    case MBSRI_NODE_TUPLE: return gather(e, node, out);
    case MBSRI_NODE_UNARY: return negate(e, node, out);
    case MBSRI_NODE_BINARY:
        return evaluate_node(e, node->a, &a) && evaluate_node(e, node->b, &b) &&
               mbsri_arithmetic(e->x, node->text, &a, &b, out);
    case MBSRI_NODE_AND:
    case MBSRI_NODE_OR:
        if (!evaluate_node(e, node->a, out)) return false;
        return mbsri_value_true(out) != (node->kind == MBSRI_NODE_AND) ||
               evaluate_node(e, node->b, out);
    case MBSRI_NODE_COMPARE: return compare_values(e, node, out);
    case MBSRI_NODE_CONDITIONAL:
        return evaluate_node(e, node->b, &a) &&
               evaluate_node(e, mbsri_value_true(&a) ? node->a : node->c, out);
    case MBSRI_NODE_CALL: return call(e, node, out);
    case MBSRI_NODE_INDEX: return find_part(e, node, out);
    case MBSRI_NODE_SLICE: return slice(e, node, out);
    case MBSRI_NODE_ATTRIBUTE: return find_member(e, node, out);
    }
    return false;
}

static bool evaluate_node(evaluation *e, const mbsri_expression_node *node, mbsri_value *out)
{
    if (!mbsri_xacro_spend(e->x, 16) || !mbsri_xacro_enter(e->x)) return false;
    const bool good = evaluate_kind(e, node, out);
    mbsri_xacro_leave(e->x);
    return good;
}

bool mbsri_xacro_evaluate(mbsri_xacro *x, struct mbsri_scope *scope, const char *text,
                          mbsri_value *value)
{
    const mbsri_expression_node *node = mbsri_xacro_parse(x, text);
    return node && evaluate_node(&(evaluation){x, scope}, node, value);
}
