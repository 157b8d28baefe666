/* The elements of a file of xacro: see xacro_expand.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * What an element becomes is added to the element `to`: elements of the model with the values of
 * their attributes, those of xacro as what they stand for. What the prefix xacro means is not asked
 * from its declaration. */
#include "files/xacro_expand.h"

#include "files/xacro_load.h"
#include "files/xacro_macro.h"
#include "files/xacro_parse.h"

#include <string.h>

static const char prefix[] = "xacro:";

static bool expand(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope, mbsri_element *to);

bool mbsri_xacro_is(const mbsri_element *root)
{
    static const char ending[] = ".xacro";
    const size_t length = strlen(root->file), all = sizeof ending - 1;
    return mbsri_attribute(root, "xmlns:xacro") != NULL ||
           (length > all && strcmp(root->file + length - all, ending) == 0);
}

static bool expand_children(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope,
                            mbsri_element *to)
{
    const mbsri_element *before = x->at;
    for (const mbsri_element *child = e->child; child; child = child->next) {
        x->at = child;
        if (!mbsri_xacro_enter(x) || !expand(x, child, scope, to)) return false;
        mbsri_xacro_leave(x);
    }
    x->at = before;
    return true;
}

/* ---- elements of the model ---- */

/* Whether XML may have these characters, in UTF-8: what YAML and arguments give was not seen by the
 * parser of XML. */
static bool is_text(const char *text)
{
    for (const unsigned char *s = (const unsigned char *)text; *s;) {
        const unsigned lead = *s++;
        const int more = lead < 0x80 ? 0 : lead < 0xc2 ? -1 : lead < 0xe0 ? 1 : lead < 0xf0 ? 2 : 3;
        unsigned code = lead & (more > 0 ? 0x3fu >> more : 0x7fu);
        if (more < 0 || lead > 0xf4) return false;
        for (int k = 0; k < more; ++k, ++s) {
            if ((*s & 0xc0) != 0x80) return false;
            code = code << 6 | (*s & 0x3fu);
        }
        if (code < 0x20 && code != '\t' && code != '\n' && code != '\r') return false;
        if ((more == 2 && code < 0x800) || (more == 3 && code < 0x10000) || code > 0x10ffff)
            return false;
        if ((code >= 0xd800 && code < 0xe000) || code == 0xfffe || code == 0xffff) return false;
    }
    return true;
}

/* With the values of attributes; those of xacro and declarations of its prefix are left out. */
static const char **copy_attributes(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope)
{
    size_t count = 0, kept = 0;
    while (e->attribute[count]) ++count;
    const char **list = mbsri_xacro_take(x, (count + 1) * sizeof *list);
    for (const char **a = e->attribute; list && *a; a += 2) {
        if (strncmp(a[0], prefix, sizeof prefix - 1) == 0 || strcmp(a[0], "xmlns:xacro") == 0)
            continue;
        const char *value = mbsri_xacro_text(x, scope, a[1]);
        if (!value) return NULL;
        if (!is_text(value)) {
            mbsri_xacro_refuse(x, "the value of %.40s has characters that XML has not", a[0]);
            return NULL;
        }
        list[kept++] = a[0];
        list[kept++] = value;
    }
    return list;
}

static mbsri_element *copy_element(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope,
                                   mbsri_element *to)
{
    mbsri_element *copy = mbsri_xacro_take(x, sizeof *copy);
    if (!copy) return NULL;
    *copy = (mbsri_element){.name = e->name, .file = e->file, .line = e->line, .parent = to};
    copy->attribute = copy_attributes(x, e, scope);
    if (!copy->attribute) return NULL;
    if (to && to->last)
        to->last->next = copy;
    else if (to)
        to->child = copy;
    if (to) to->last = copy;
    return expand_children(x, e, scope, copy) ? copy : NULL;
}

/* ---- attributes of what is xacro's ---- */

enum { MOST_ATTRIBUTES = 6 };

/* Those named, a NULL behind them, to `value`, NULL where one is missing; others are findings. */
static void read_attributes(mbsri_xacro *x, const mbsri_element *e, const char *const *names,
                            const char *value[MOST_ATTRIBUTES])
{
    for (int k = 0; names[k]; ++k) value[k] = mbsri_attribute(e, names[k]);
    for (const char **a = e->attribute; *a; a += 2) {
        bool known = strncmp(a[0], "xmlns", 5) == 0;
        for (int k = 0; names[k]; ++k) known = known || strcmp(names[k], a[0]) == 0;
        if (!known) mbsri_file_find(x->s, e, "xacro knows no attribute %.40s: not read", a[0]);
    }
}

static bool refuse_lack(mbsri_xacro *x, const char *name)
{
    return mbsri_xacro_refuse(x, "it has no %s", name);
}

/* A truth value in a text; NULL: `standard`. False: refused. */
static bool read_condition(mbsri_xacro *x, mbsri_scope *scope, const char *text, bool standard,
                           bool *result)
{
    mbsri_value value;
    *result = standard;
    if (!text) return true;
    return mbsri_xacro_value(x, scope, text, &value) &&
           (mbsri_value_condition(&value, result) ||
            mbsri_xacro_refuse(x, "'%.50s' is no truth value", text));
}

/* ---- properties ---- */

/* The scope that a property with scope="..." goes to; NULL: refused. */
static mbsri_scope *find_target(mbsri_xacro *x, mbsri_scope *scope, const char *where)
{
    mbsri_scope *target = scope;
    if (where && strcmp(where, "global") == 0) {
        while (target->parent) target = target->parent;
    } else if (where && strcmp(where, "parent") == 0) {
        target = scope->parent;
        while (!scope->is_namespace && target && target->is_namespace) target = target->parent;
        if (!target) mbsri_xacro_refuse(x, "there is no scope around this one");
    } else if (where && strcmp(where, "local") != 0) {
        mbsri_xacro_refuse(x, "there is no scope '%.40s'", where);
        return NULL;
    }
    return target;
}

/* Its elements, under "**name". */
static bool set_block(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *target, const char *name)
{
    const mbsri_value value = {.kind = MBSRI_BLOCK, .of.block = e};
    char *key = mbsri_xacro_take(x, strlen(name) + 3);
    if (!key) return false;
    memcpy(key, "**", 2);
    memcpy(key + 2, name, strlen(name));
    return mbsri_scope_set(x, target, key, &value, false);
}

static bool expand_property(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope,
                            mbsri_element *to)
{
    static const char *const names[] = {"name",  "value",     "default", "remove",
                                        "scope", "lazy_eval", NULL};
    const char *given[MOST_ATTRIBUTES];
    bool remove, lazy;
    mbsri_value value;
    (void)to;
    read_attributes(x, e, names, given);
    const char *name = given[0] ? mbsri_xacro_text(x, scope, given[0]) : NULL, *text = given[1];
    if (!given[0]) return refuse_lack(x, "name");
    if (!name || !read_condition(x, scope, given[3], false, &remove) ||
        !read_condition(x, scope, given[5], true, &lazy))
        return false;
    if (!mbsri_is_name(name) || strncmp(name, "__", 2) == 0)
        return mbsri_xacro_refuse(x, "a property cannot be called '%.50s'", name);
    if ((text != NULL) + (given[2] != NULL) + remove > 1)
        return mbsri_xacro_refuse(x, "value, default and remove exclude each other");
    if (remove) {
        mbsri_scope_remove(scope, name);
        return true;
    }
    if (given[2] && mbsri_scope_has(scope, name)) return true;
    if (given[2]) text = given[2];
    mbsri_scope *target = find_target(x, scope, given[4]);
    if (!target) return false;
    if (!text) return set_block(x, e, target, name);
    lazy = lazy && target == scope;
    value = mbsri_value_string(text);
    if (!lazy && !mbsri_xacro_value(x, scope, text, &value)) return false;
    return mbsri_scope_set(x, target, name, &value, lazy);
}

/* The value that an argument has where the caller gives none. */
static bool expand_arg(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope,
                       mbsri_element *to)
{
    static const char *const names[] = {"name", "default", NULL};
    const char *given[MOST_ATTRIBUTES];
    (void)to;
    read_attributes(x, e, names, given);
    if (!given[0]) return refuse_lack(x, "name");
    if (mbsri_xacro_argument(x, given[0])) return true;
    if (!given[1]) return mbsri_xacro_refuse(x, "the argument has neither a value nor a default");
    const mbsr_xacro_argument argument = {given[0], mbsri_xacro_text(x, scope, given[1])};
    mbsr_xacro_argument *place = argument.value && mbsri_xacro_spend(x, 64)
                                     ? mbsri_list_add(x->s->arena, &x->arguments, sizeof *place)
                                     : NULL;
    if (place) *place = argument;
    return place != NULL;
}

/* ---- what stands in the place of others ---- */

static bool expand_condition(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope,
                             mbsri_element *to)
{
    static const char *const names[] = {"value", NULL};
    const char *given[MOST_ATTRIBUTES];
    bool holds;
    read_attributes(x, e, names, given);
    if (!given[0]) return refuse_lack(x, "value");
    if (!read_condition(x, scope, given[0], false, &holds)) return false;
    return holds == (strcmp(e->name, "xacro:unless") == 0) || expand_children(x, e, scope, to);
}

static bool expand_include(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope,
                           mbsri_element *to)
{
    static const char *const names[] = {"filename", "ns", "optional", NULL};
    const char *given[MOST_ATTRIBUTES], *before = x->folder;
    const mbsri_element *root;
    bool optional;
    read_attributes(x, e, names, given);
    if (!given[0]) return refuse_lack(x, "filename");
    const char *path = mbsri_xacro_text(x, scope, given[0]);
    if (!path || !read_condition(x, scope, given[2], false, &optional)) return false;
    if (strpbrk(path, "*?["))
        return mbsri_xacro_refuse(x, "several files at once ('%.50s') are not read", path);
    if (given[1]) {
        const char *name = mbsri_xacro_text(x, scope, given[1]);
        mbsri_scope *inner = name ? mbsri_scope_open(x, scope, true) : NULL;
        const mbsri_value value = {.kind = MBSRI_NAMESPACE, .of.scope = inner};
        if (!inner || !mbsri_scope_set(x, scope, name, &value, false)) return false;
        scope = inner;
    }
    if (!mbsri_xacro_include(x, path, optional, &root)) return false;
    if (!root) return true;
    x->folder = mbsri_arena_folder(x->s->arena, root->file);
    const bool good = x->folder && expand_children(x, root, scope, to);
    x->folder = before;
    return good;
}

static bool expand_block(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope,
                         mbsri_element *to)
{
    static const char *const names[] = {"name", NULL};
    const char *given[MOST_ATTRIBUTES];
    mbsri_value value;
    read_attributes(x, e, names, given);
    if (!given[0]) return refuse_lack(x, "name");
    char *key = mbsri_xacro_take(x, strlen(given[0]) + 3);
    if (!key) return false;
    memcpy(key, "**", 2);
    memcpy(key + 2, given[0], strlen(given[0]));
    if (mbsri_scope_find(x, scope, key, &value) > 0)
        return expand_children(x, value.of.block, scope, to);
    if (mbsri_scope_find(x, scope, key + 1, &value) <= 0)
        return mbsri_xacro_refuse(x, "there is no such block");
    x->at = value.of.block;
    return expand(x, value.of.block, scope, to);
}

/* ---- macros ---- */

static bool expand_macro(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope,
                         mbsri_element *to)
{
    (void)to;
    return mbsri_macro_define(x, e, scope);
}

/* What the call has in it is expanded where it stands, then goes to the macro's blocks. */
static bool call(mbsri_xacro *x, const mbsri_element *e, const char *name, const char *without,
                 mbsri_scope *scope, mbsri_element *to)
{
    mbsri_element *blocks = mbsri_xacro_take(x, sizeof *blocks);
    const mbsri_macro *macro = blocks ? mbsri_macro_find(x, name, &scope) : NULL;
    if (!macro) return false;
    if (!expand_children(x, e, scope, blocks)) return false;
    mbsri_scope *inner = mbsri_macro_open(x, macro, e, without, blocks, scope);
    return inner && expand_children(x, macro->body, inner, to);
}

static bool expand_call(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope,
                        mbsri_element *to)
{
    const char *text = mbsri_attribute(e, "macro");
    if (!text) return refuse_lack(x, "macro");
    const char *name = mbsri_xacro_text(x, scope, text);
    return name && call(x, e, name, "macro", scope, to);
}

static bool refuse_element(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope,
                           mbsri_element *to)
{
    (void)scope, (void)to;
    return mbsri_xacro_refuse(x, "<%.40s> is not read", e->name);
}

static bool expand(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope, mbsri_element *to)
{
    static const struct {
        const char *name;
        bool (*expand)(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope,
                       mbsri_element *to);
    } kinds[] = {{"property", expand_property},  {"macro", expand_macro},
                 {"if", expand_condition},       {"unless", expand_condition},
                 {"include", expand_include},    {"arg", expand_arg},
                 {"insert_block", expand_block}, {"call", expand_call},
                 {"element", refuse_element},    {"attribute", refuse_element}};
    const size_t skipped = sizeof prefix - 1;
    if (strncmp(e->name, prefix, skipped) != 0) return copy_element(x, e, scope, to) != NULL;
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; ++k) {
        if (strcmp(e->name + skipped, kinds[k].name) == 0) return kinds[k].expand(x, e, scope, to);
    }
    return call(x, e, e->name + skipped, NULL, scope, to);
}

/* ---- the file ---- */

mbsri_element *mbsri_xacro_expand(mbsri_scene *s, const mbsri_element *root)
{
    mbsri_xacro x = {.s = s, .at = root, .look_up = mbsri_scope_find};
    x.load_yaml = mbsri_xacro_load_yaml;
    x.home = x.folder = mbsri_arena_folder(x.s->arena, root->file);
    for (int k = 0; k < s->opt->xacro.arguments; ++k) {
        mbsr_xacro_argument *place = mbsri_list_add(s->arena, &x.arguments, sizeof *place);
        if (!place) return NULL;
        *place = s->opt->xacro.argument[k];
    }
    mbsri_scope *scope = mbsri_scope_open(&x, NULL, false);
    return x.home && scope ? copy_element(&x, root, scope, NULL) : NULL;
}
