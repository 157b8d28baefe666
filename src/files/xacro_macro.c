/* Macros of xacro: see xacro_macro.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/xacro_macro.h"

#include <string.h>

static const char white[] = " \t\r\n";

/* ---- definitions ---- */

static bool ends_word(char c)
{
    return c == '\0' || strchr(white, c) != NULL;
}

/* Behind the first `mark` that ends a word, from s on; NULL: there is none. */
static const char *end_of_braces(const char *s, char mark)
{
    while ((s = strchr(s, mark)) && !ends_word(s[1])) ++s;
    return s ? s + 1 : NULL;
}

/* Behind a default: ${...}, $(...), or a word in which quotes may hold white space; NULL: quotes
 * that do not end. */
static const char *end_of_default(const char *s)
{
    const char *end = NULL;
    if (s[0] == '$' && s[1] == '{') end = end_of_braces(s, '}');
    if (s[0] == '$' && s[1] == '(') end = end_of_braces(s, ')');
    if (end) return end;
    while (!ends_word(*s)) {
        const char *closing = *s == '\'' || *s == '"' ? strchr(s + 1, *s) : s;
        if (!closing) return NULL;
        s = closing + 1;
    }
    return s;
}

/* The parameter at *text, which moves behind it and the white space there. */
static bool read_parameter(mbsri_xacro *x, const char **text, mbsri_macro_parameter *p)
{
    const char *s = *text;
    size_t length = strcspn(s, " \t\r\n:=");
    const char *mark = s + length + strspn(s + length, white);
    const bool with_default = length > 0 && (mark[0] == '=' || (mark[0] == ':' && mark[1] == '='));
    *p = (mbsri_macro_parameter){.name = NULL};
    if (!with_default) length = strcspn(s, white);
    p->name = mbsri_xacro_copy(x, s, length);
    s += length;
    if (with_default) {
        s = mark + (*mark == ':' ? 2 : 1);
        s += strspn(s, white);
        p->forwarded = *s == '^';
        if (p->forwarded) s += s[1] == '|' ? 2 : 1;
        const char *end = end_of_default(s);
        if (!end) return mbsri_xacro_refuse(x, "a default of '%.40s' does not end", p->name);
        if (end > s) p->standard = mbsri_xacro_copy(x, s, (size_t)(end - s));
        s = end;
    }
    *text = s + strspn(s, white);
    return p->name != NULL;
}

bool mbsri_macro_define(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope)
{
    const char *name = mbsri_attribute(e, "name"), *text = mbsri_attribute(e, "params");
    if (!name) return mbsri_xacro_refuse(x, "it has no name");
    if (strncmp(name, "xacro:", 6) == 0) name += 6;
    if (strchr(name, '.') || strcmp(name, "call") == 0)
        return mbsri_xacro_refuse(x, "a macro cannot have this name");
    mbsri_macro *macro = mbsri_xacro_take(x, sizeof *macro);
    if (!macro) return false;
    macro->body = e;
    if (text) text += strspn(text, white);
    while (text && *text) {
        mbsri_macro_parameter *p = mbsri_xacro_spend(x, 64)
                                       ? mbsri_list_add(x->s->arena, &macro->parameters, sizeof *p)
                                       : NULL;
        if (!p || !read_parameter(x, &text, p)) return false;
    }
    const int k = mbsri_names_find(&scope->macro_names, name);
    if (k >= 0) {
        ((const mbsri_macro **)scope->macros.items)[k] = macro;
        return true;
    }
    const mbsri_macro **place = mbsri_list_add(x->s->arena, &scope->macros, sizeof *place);
    if (!place) return false;
    *place = macro;
    return mbsri_scope_name(x, &scope->macro_names, name, scope->macros.count - 1);
}

/* ---- calls ---- */

static const mbsri_macro *find_macro(const mbsri_scope *scope, const char *name)
{
    for (; scope; scope = scope->parent) {
        const int k = mbsri_names_find(&scope->macro_names, name);
        if (k >= 0) return ((const mbsri_macro *const *)scope->macros.items)[k];
    }
    return NULL;
}

const mbsri_macro *mbsri_macro_find(mbsri_xacro *x, const char *name, mbsri_scope **scope)
{
    const mbsri_macro *macro = find_macro(*scope, name);
    mbsri_scope *at = *scope;
    const char *rest = name;
    for (const char *dot; !macro && (dot = strchr(rest, '.')); rest = dot + 1) {
        const char *space = mbsri_xacro_copy(x, rest, (size_t)(dot - rest));
        mbsri_value value;
        if (!space || mbsri_scope_find(x, at, space, &value) < 0) return NULL;
        if (!mbsri_scope_has(at, space) || value.kind != MBSRI_NAMESPACE) break;
        at = value.of.scope;
        macro = strchr(dot + 1, '.') ? NULL : find_macro(at, dot + 1);
    }
    if (!macro) mbsri_xacro_refuse(x, "there is no macro '%.60s'", name);
    *scope = at;
    return macro;
}

typedef struct calling {
    mbsri_xacro *x;
    const mbsri_macro *macro;
    mbsri_scope *caller, *scope;
} calling;

static const mbsri_macro_parameter *parameter_of(const mbsri_macro *macro, const char *name)
{
    const mbsri_macro_parameter *p = macro->parameters.items;
    for (int k = 0; k < macro->parameters.count; ++k) {
        if (strcmp(p[k].name, name) == 0) return p + k;
    }
    return NULL;
}

static bool set_attributes(calling *c, const mbsri_element *e, const char *without)
{
    for (const char **a = e->attribute; *a; a += 2) {
        mbsri_value value;
        if (without && strcmp(a[0], without) == 0) continue;
        if (!parameter_of(c->macro, a[0]) || a[0][0] == '*')
            return mbsri_xacro_refuse(c->x, "the macro has no parameter '%.50s'", a[0]);
        if (!mbsri_xacro_value(c->x, c->caller, a[1], &value) ||
            !mbsri_scope_set(c->x, c->scope, a[0], &value, false))
            return false;
    }
    return true;
}

static bool set_blocks(calling *c, const mbsri_element *block)
{
    const mbsri_macro_parameter *p = c->macro->parameters.items;
    for (int k = 0; k < c->macro->parameters.count; ++k) {
        const mbsri_value value = {.kind = MBSRI_BLOCK, .of.block = block};
        if (p[k].name[0] != '*') continue;
        if (!block) return mbsri_xacro_refuse(c->x, "the block '%.50s' is missing", p[k].name);
        if (!mbsri_scope_set(c->x, c->scope, p[k].name, &value, false)) return false;
        block = block->next;
    }
    return !block || mbsri_xacro_refuse(c->x, "the macro takes no block <%.40s>", block->name);
}

static bool set_default(calling *c, const mbsri_macro_parameter *p)
{
    mbsri_value value;
    const int found = p->forwarded ? mbsri_scope_find(c->x, c->caller, p->name, &value) : 0;
    if (found < 0) return false;
    if (!found && !p->standard)
        return mbsri_xacro_refuse(c->x, "the parameter '%.50s' is not given", p->name);
    if (!found && !mbsri_xacro_value(c->x, c->caller, p->standard, &value)) return false;
    return mbsri_scope_set(c->x, c->scope, p->name, &value, false);
}

mbsri_scope *mbsri_macro_open(mbsri_xacro *x, const mbsri_macro *macro, const mbsri_element *e,
                              const char *without, const mbsri_element *blocks, mbsri_scope *scope)
{
    calling c = {x, macro, scope, mbsri_scope_open(x, scope, false)};
    const mbsri_macro_parameter *p = macro->parameters.items;
    if (!c.scope || !set_attributes(&c, e, without) || !set_blocks(&c, blocks->child)) return NULL;
    for (int k = 0; k < macro->parameters.count; ++k) {
        if (p[k].name[0] == '*' || mbsri_names_find(&c.scope->names, p[k].name) >= 0) continue;
        if (!set_default(&c, p + k)) return NULL;
    }
    return c.scope;
}
