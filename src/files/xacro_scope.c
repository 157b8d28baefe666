/* Scopes of xacro and texts: see xacro_scope.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/xacro_scope.h"

#include "files/xacro_evaluate.h"

#include <string.h>

typedef enum property_state { VALUE, TEXT, IN_EVALUATION, REMOVED } property_state;

typedef struct property {
    mbsri_value value;
    property_state state;
} property;

mbsri_scope *mbsri_scope_open(mbsri_xacro *x, mbsri_scope *parent, bool is_namespace)
{
    mbsri_scope *scope = mbsri_xacro_take(x, sizeof *scope);
    if (scope) *scope = (mbsri_scope){.parent = parent, .is_namespace = is_namespace};
    return scope;
}

static property *find_here(const mbsri_scope *scope, const char *name)
{
    const int k = mbsri_names_find(&scope->names, name);
    property *p = scope->properties.items;
    return k >= 0 && p[k].state != REMOVED ? p + k : NULL;
}

bool mbsri_scope_has(const mbsri_scope *scope, const char *name)
{
    while (scope && !find_here(scope, name)) scope = scope->parent;
    return scope != NULL;
}

void mbsri_scope_remove(mbsri_scope *scope, const char *name)
{
    for (; scope; scope = scope->parent) {
        property *p = find_here(scope, name);
        if (p) p->state = REMOVED;
    }
}

bool mbsri_scope_name(mbsri_xacro *x, mbsri_names *names, const char *name, int number)
{
    const size_t room = names->room;
    const char *copy = mbsri_xacro_copy(x, name, strlen(name));
    return copy && mbsri_names_add(x->s->arena, names, copy, number) &&
           mbsri_xacro_spend(x, (names->room - room) * sizeof(mbsri_name));
}

bool mbsri_scope_set(mbsri_xacro *x, mbsri_scope *scope, const char *name, const mbsri_value *value,
                     bool lazy)
{
    const int k = mbsri_names_find(&scope->names, name);
    property *p = k < 0 ? NULL : (property *)scope->properties.items + k;
    if (!p) {
        if (!mbsri_scope_name(x, &scope->names, name, scope->properties.count) ||
            !mbsri_xacro_spend(x, 2 * sizeof *p))
            return false;
        p = mbsri_list_add(x->s->arena, &scope->properties, sizeof *p);
        if (!p) return false;
    }
    if (value->kind == MBSRI_STRING && !mbsri_xacro_spend(x, strlen(value->of.string)))
        return false;
    p->value = mbsri_value_literal(x, value);
    p->state = lazy && p->value.kind == MBSRI_STRING ? TEXT : VALUE;
    return !x->s->message[0];
}

/* A text that is used becomes a value. */
static bool evaluate_property(mbsri_xacro *x, mbsri_scope *scope, const char *name, int k)
{
    property *p = (property *)scope->properties.items + k;
    mbsri_value value;
    if (p->state == IN_EVALUATION)
        return mbsri_xacro_refuse(x, "the property '%.50s' depends on itself", name);
    if (p->state != TEXT) return true;
    p->state = IN_EVALUATION;
    if (!mbsri_xacro_enter(x) || !mbsri_xacro_value(x, scope, p->value.of.string, &value))
        return false;
    mbsri_xacro_leave(x);
    p = (property *)scope->properties.items + k; /* the list may have moved */
    p->value = mbsri_value_literal(x, &value);
    p->state = VALUE;
    return true;
}

int mbsri_scope_find(mbsri_xacro *x, mbsri_scope *scope, const char *name, mbsri_value *value)
{
    while (scope && !find_here(scope, name)) scope = scope->parent;
    if (!scope) return 0;
    const int k = mbsri_names_find(&scope->names, name);
    if (!evaluate_property(x, scope, name, k)) return -1;
    *value = ((property *)scope->properties.items)[k].value;
    return 1;
}

/* ---- texts ---- */

/* The folder of a package, without a slash at its end; NULL: refused. */
static const char *find_package(mbsri_xacro *x, const char *name)
{
    const mbsr_file_opt *opt = x->s->opt;
    for (int k = 0; k < opt->packages; ++k) {
        const char *folder = opt->package[k].folder;
        size_t length = strlen(folder);
        if (strcmp(opt->package[k].name, name) != 0) continue;
        while (length > 1 && folder[length - 1] == '/') --length;
        return mbsri_xacro_copy(x, folder, length);
    }
    mbsri_xacro_refuse(x, "where the package '%.50s' is, is not said", name);
    return NULL;
}

/* The text of $(inner). */
static bool substitute_one(mbsri_xacro *x, const char *inner, mbsri_value *value)
{
    static const char space[] = " \t\r\n";
    char word[12] = "";
    const char *rest = inner + strspn(inner, space);
    const size_t length = strcspn(rest, space);
    if (length < sizeof word) memcpy(word, rest, length);
    rest += length + strspn(rest + length, space);
    size_t end = strlen(rest);
    while (end > 0 && strchr(space, rest[end - 1])) --end;
    const char *name = mbsri_xacro_copy(x, rest, end);
    if (!name) return false;
    if (strcmp(word, "arg") == 0) {
        value->of.string = mbsri_xacro_argument(x, name);
        if (!value->of.string)
            return mbsri_xacro_refuse(x, "the argument '%.50s' has no value", name);
    } else if (strcmp(word, "find") == 0) {
        value->of.string = find_package(x, name);
    } else {
        return mbsri_xacro_refuse(x, "$(%.60s) is not read", inner);
    }
    value->kind = MBSRI_STRING;
    return value->of.string != NULL;
}

/* Where the first piece of a text ends: ${...}, $(...), "$${" or what is none of these; NULL:
 * refused. */
static const char *end_of_piece(mbsri_xacro *x, const char *s)
{
    if (*s != '$') return s + strcspn(s, "$");
    const size_t dollars = strspn(s, "$");
    const char after = s[dollars];
    if (dollars > 1 && (after == '{' || after == '(')) return s + dollars + 1;
    const char *end = after == '{' ? strchr(s, '}') : after == '(' ? strchr(s, ')') : NULL;
    if (dollars == 1 && end) return end + 1;
    if (dollars == 1 && after != '{' && after != '(') return s + 1 + strcspn(s + 1, "{($");
    mbsri_xacro_refuse(x, "'%.60s' is no text of xacro", s);
    return NULL;
}

static bool evaluate_piece(mbsri_xacro *x, mbsri_scope *scope, const char *s, size_t length,
                           mbsri_value *value)
{
    const bool expression = s[0] == '$' && s[1] == '{', call = s[0] == '$' && s[1] == '(',
               escaped = s[0] == '$' && s[1] == '$';
    if (!expression && !call) {
        *value = mbsri_value_string(mbsri_xacro_copy(x, s + escaped, length - escaped));
        return value->of.string != NULL;
    }
    const char *inner = mbsri_xacro_copy(x, s + 2, length - 3);
    if (!inner || !mbsri_xacro_enter(x)) return false;
    inner = mbsri_xacro_text(x, scope, inner);
    if (!inner) return false;
    mbsri_xacro_leave(x);
    return expression ? mbsri_xacro_evaluate(x, scope, inner, value)
                      : substitute_one(x, inner, value);
}

/* Puts texts one behind the other. */
static const char *join_values(mbsri_xacro *x, const mbsri_list *pieces)
{
    const char *const *piece = pieces->items;
    size_t size = 0;
    for (int k = 0; k < pieces->count; ++k) size += strlen(piece[k]);
    if (size > MBSRI_XACRO_TEXT) {
        mbsri_xacro_refuse(x, "a text is too long");
        return NULL;
    }
    char *text = mbsri_xacro_take(x, size + 1), *at = text;
    for (int k = 0; text && k < pieces->count; ++k) {
        memcpy(at, piece[k], strlen(piece[k]));
        at += strlen(piece[k]);
    }
    return text;
}

bool mbsri_xacro_value(mbsri_xacro *x, mbsri_scope *scope, const char *text, mbsri_value *value)
{
    mbsri_list pieces = {.count = 0};
    *value = mbsri_value_string(text);
    if (!strchr(text, '$')) return mbsri_xacro_spend(x, strlen(text));
    for (const char *s = text, *end; *s; s = end) {
        end = end_of_piece(x, s);
        if (!end || !evaluate_piece(x, scope, s, (size_t)(end - s), value)) return false;
        if (s == text && !*end) return true;
        const char **piece =
            mbsri_xacro_spend(x, 32) ? mbsri_list_add(x->s->arena, &pieces, sizeof *piece) : NULL;
        if (!piece || !(*piece = mbsri_value_text(x, value))) return false;
    }
    *value = mbsri_value_string(join_values(x, &pieces));
    return value->of.string != NULL;
}

const char *mbsri_xacro_text(mbsri_xacro *x, mbsri_scope *scope, const char *text)
{
    mbsri_value value;
    return mbsri_xacro_value(x, scope, text, &value) ? mbsri_value_text(x, &value) : NULL;
}
