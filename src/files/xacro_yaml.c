/* YAML as values: see xacro_yaml.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A block is what stands further to the right than the line it belongs to. It is a list if it
 * begins with "- ", a map if its first line has a key, else a scalar or brackets. The items of a
 * list may begin in the column of its key. */
#include "files/xacro_yaml.h"

#include "files/xacro_yaml_scalar.h"

#include <string.h>

typedef struct yaml {
    mbsri_xacro *x;
    mbsri_element at; /* file and line, for messages */
    const char *line; /* where it begins */
    const char *s;
    mbsri_list anchors;
} yaml;

/* A value that is used again by its name. */
typedef struct anchor {
    const char *name;
    mbsri_value value;
} anchor;

static bool read_node(yaml *y, int outer, mbsri_value *value);

static int column(const yaml *y)
{
    return (int)(y->s - y->line);
}

static bool ends_line(char c)
{
    return c == '\0' || c == '\n' || c == '\r';
}

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || ends_line(c);
}

/* To the next that is neither space nor comment; over ends of lines. */
static bool skip(yaml *y)
{
    for (;;) {
        y->s += strspn(y->s, " ");
        if (*y->s == '#') y->s += strcspn(y->s, "\n");
        if (*y->s == '\t') return mbsri_xacro_refuse(y->x, "a tab stands between words of YAML");
        if (*y->s == '\r') ++y->s;
        if (*y->s != '\n') return true;
        y->line = ++y->s;
        ++y->at.line;
    }
}

/* Whether the line has nothing more but a comment. */
static bool at_end_of_line(const yaml *y)
{
    const char *s = y->s + strspn(y->s, " ");
    return ends_line(*s) || (*s == '#' && s > y->line && s[-1] == ' ');
}

/* Refuses what stands here, of which at most 20 characters of this line are shown. */
static bool refuse_rest(yaml *y, const char *why)
{
    const char *s = y->s + strspn(y->s, " ");
    const size_t length = strcspn(s, "\r\n");
    return mbsri_xacro_refuse(y->x, "'%.*s' %s", (int)(length < 20 ? length : 20), s, why);
}

static bool begins_item(const yaml *y)
{
    return y->s[0] == '-' && is_space(y->s[1]);
}

/* ---- anchors ---- */

/* The name behind '&' or '*', and the space there. */
static const char *read_anchor_name(yaml *y)
{
    const size_t length = strcspn(++y->s, " \t\r\n,[]{}");
    const char *name = mbsri_xacro_copy(y->x, y->s, length);
    y->s += length + strspn(y->s + length, " ");
    return name;
}

/* The name that a value gets; *name stays NULL without one. */
static bool begin_anchor(yaml *y, const char **name)
{
    *name = NULL;
    return *y->s != '&' || (*name = read_anchor_name(y)) != NULL;
}

static bool end_anchor(yaml *y, const char *name, const mbsri_value *value)
{
    if (!name) return true;
    anchor *a = mbsri_xacro_spend(y->x, 2 * sizeof *a)
                    ? mbsri_list_add(y->x->s->arena, &y->anchors, sizeof *a)
                    : NULL;
    if (a) *a = (anchor){name, *value};
    return a != NULL;
}

/* What "*name" stands for: the last of this name. */
static bool read_alias(yaml *y, mbsri_value *value)
{
    const char *name = read_anchor_name(y);
    const anchor *a = y->anchors.items;
    int k = y->anchors.count - 1;
    if (!name) return false;
    while (k >= 0 && strcmp(a[k].name, name) != 0) --k;
    if (k < 0) return mbsri_xacro_refuse(y->x, "there is no anchor '&%.40s' before", name);
    *value = a[k].value;
    return mbsri_xacro_spend(y->x, (size_t)(8 * y->anchors.count));
}

/* ---- scalars ---- */

/* Behind the closing quote; NULL: there is none in this line. */
static const char *end_of_quotes(const char *s)
{
    const char mark = *s++;
    for (; !ends_line(*s); ++s) {
        if (mark == '"' && *s == '\\' && !ends_line(s[1]))
            ++s;
        else if (*s == mark && !(mark == '\'' && s[1] == mark))
            return s + 1;
        else if (*s == mark)
            ++s;
    }
    return NULL;
}

/* Behind a word without quotes: at ": ", " #", the end of the line, in brackets also at , [ ] { }.
 */
static const char *end_of_plain(const char *s, bool brackets)
{
    const char *end = s;
    for (; !ends_line(*s); ++s) {
        if (*s == ':' && (is_space(s[1]) || (brackets && strchr(",[]{}", s[1])))) break;
        if (*s == '#' && s > end && s[-1] == ' ') break;
        if (brackets && strchr(",[]{}", *s)) break;
        if (!is_space(*s)) end = s + 1;
    }
    return end;
}

/* One scalar, or what a tag makes of one. */
static bool read_scalar(yaml *y, bool brackets, mbsri_value *value)
{
    const char *tag = y->s;
    size_t tagged = 0;
    if (*tag == '*') return read_alias(y, value);
    if (*tag == '!') {
        tagged = strcspn(tag, " \r\n");
        y->s += tagged + strspn(y->s + tagged, " ");
    }
    if (*y->s == '\t') return mbsri_xacro_refuse(y->x, "a tab stands between words of YAML");
    if (*y->s && strchr("&|>%@`!?", *y->s) && (*y->s != '?' || is_space(y->s[1])))
        return mbsri_xacro_refuse(y->x, "YAML with '%c' is not read", *y->s);
    const bool quoted = *y->s == '\'' || *y->s == '"';
    const char *end = quoted ? end_of_quotes(y->s) : end_of_plain(y->s, brackets);
    if (!end) return mbsri_xacro_refuse(y->x, "a text does not end in its line");
    const char *text = quoted ? mbsri_yaml_unquote(y->x, y->s, end)
                              : mbsri_xacro_copy(y->x, y->s, (size_t)(end - y->s));
    y->s = end;
    if (!text) return false;
    if (tagged > 0) return mbsri_yaml_unit(y->x, tag, tagged, text, value);
    *value = mbsri_value_string(text);
    return quoted || mbsri_yaml_resolve(y->x, text, value);
}

/* The place of the value of a key, which is added unless it is there: then the last value counts.
 * NULL: refused. */
static mbsri_value *value_place(yaml *y, mbsri_value *map, const mbsri_value *key)
{
    const mbsri_value none = {.kind = MBSRI_NOTHING};
    mbsri_list *list = map->of.list;
    mbsri_value *known;
    if (!mbsri_value_find(y->x, map, key, &known)) return NULL;
    if (known) {
        mbsri_file_find(y->x->s, &y->at, "a key is there twice: the last counts");
        return known;
    }
    if (!mbsri_value_add(y->x, list, key) || !mbsri_value_add(y->x, list, &none)) return NULL;
    return (mbsri_value *)list->items + list->count - 1;
}

/* ---- brackets ---- */

static bool read_flow(yaml *y, mbsri_value *value);

static bool expect_colon(yaml *y)
{
    if (!skip(y)) return false;
    if (*y->s != ':') return mbsri_xacro_refuse(y->x, "a key in braces has no ':'");
    ++y->s;
    return skip(y);
}

/* An item of a list, or a key and its value. */
static bool read_entry(yaml *y, mbsri_value *all)
{
    mbsri_value key, item;
    if (all->kind == MBSRI_LIST)
        return read_flow(y, &item) && mbsri_value_add(y->x, all->of.list, &item);
    if (!read_scalar(y, true, &key) || !expect_colon(y) || !read_flow(y, &item)) return false;
    mbsri_value *place = value_place(y, all, &key);
    if (place) *place = item;
    return place != NULL;
}

static bool read_brackets(yaml *y, mbsri_value *value)
{
    const bool map = *y->s == '{';
    const char closing = map ? '}' : ']';
    ++y->s;
    if (!mbsri_value_begin(y->x, map ? MBSRI_DICTIONARY : MBSRI_LIST, value) || !skip(y))
        return false;
    while (*y->s != closing) {
        if (!read_entry(y, value) || !skip(y)) return false;
        if (*y->s == closing) break;
        if (*y->s != ',')
            return mbsri_xacro_refuse(y->x, "brackets of YAML do not end, or lack ','");
        ++y->s;
        if (!skip(y)) return false;
    }
    ++y->s;
    return true;
}

static bool read_flow(yaml *y, mbsri_value *value)
{
    const char *name;
    if (!begin_anchor(y, &name)) return false;
    if (*y->s == '[' || *y->s == '{') {
        if (!mbsri_xacro_enter(y->x) || !read_brackets(y, value)) return false;
        mbsri_xacro_leave(y->x);
    } else if (!read_scalar(y, true, value)) {
        return false;
    }
    return end_anchor(y, name, value);
}

/* ---- blocks ---- */

/* Whether a key stands here. */
static bool begins_pair(const yaml *y)
{
    if (strchr("[{!&*|>%@`", *y->s)) return false;
    const bool quoted = *y->s == '\'' || *y->s == '"';
    const char *end = quoted ? end_of_quotes(y->s) : end_of_plain(y->s, false);
    if (!end) return false;
    end += strspn(end, " ");
    return *end == ':' && is_space(end[1]);
}

/* A scalar or brackets that end their line. */
static bool read_line(yaml *y, mbsri_value *value)
{
    if (!(*y->s == '[' || *y->s == '{' ? read_flow(y, value) : read_scalar(y, false, value)))
        return false;
    return at_end_of_line(y) || refuse_rest(y, "stands behind a value");
}

static bool read_list(yaml *y, int at, mbsri_value *value)
{
    mbsri_list *list = mbsri_value_begin(y->x, MBSRI_LIST, value);
    while (list && *y->s && column(y) == at && begins_item(y)) {
        mbsri_value item;
        ++y->s;
        if (!skip(y) || !read_node(y, at, &item) || !mbsri_value_add(y->x, list, &item) || !skip(y))
            return false;
    }
    return list != NULL;
}

/* What stands behind a key in the column `at`. */
static bool read_under_key(yaml *y, int at, mbsri_value *value)
{
    const char *name;
    bool good;
    y->s += strspn(y->s, " ");
    if (!begin_anchor(y, &name)) return false;
    if (!at_end_of_line(y)) {
        if (begins_item(y) || begins_pair(y))
            return mbsri_xacro_refuse(y->x, "a list or a map begins behind a key in its line");
        good = read_line(y, value);
    } else {
        good = skip(y) && (*y->s && column(y) == at && begins_item(y) ? read_list(y, at, value)
                                                                      : read_node(y, at, value));
    }
    return good && end_anchor(y, name, value);
}

static bool read_map(yaml *y, int at, mbsri_value *value)
{
    mbsri_list *list = mbsri_value_begin(y->x, MBSRI_DICTIONARY, value);
    while (list && *y->s && column(y) == at) {
        mbsri_value key, item;
        if (!begins_pair(y)) return refuse_rest(y, "is no key of YAML");
        if (!read_scalar(y, false, &key)) return false;
        if (key.kind == MBSRI_STRING && strcmp(key.of.string, "<<") == 0)
            return mbsri_xacro_refuse(y->x, "YAML with '<<' is not read");
        y->s += strspn(y->s, " ") + 1;
        mbsri_value *place = value_place(y, value, &key);
        if (!place || !read_under_key(y, at, &item)) return false;
        *place = item;
        if (!skip(y)) return false;
    }
    return list != NULL;
}

static bool read_block(yaml *y, mbsri_value *value)
{
    const int at = column(y);
    bool good;
    if (begins_item(y))
        good = read_list(y, at, value);
    else if (begins_pair(y))
        good = read_map(y, at, value);
    else
        good = read_line(y, value) && skip(y);
    return good;
}

/* What stands further to the right than `outer`; None: nothing. */
static bool read_node(yaml *y, int outer, mbsri_value *value)
{
    const char *name;
    *value = (mbsri_value){.kind = MBSRI_NOTHING};
    if (!*y->s || column(y) <= outer) return true;
    if (!begin_anchor(y, &name) || (name && !skip(y))) return false;
    if (!mbsri_xacro_enter(y->x) || !read_block(y, value) || !end_anchor(y, name, value))
        return false;
    mbsri_xacro_leave(y->x);
    if (!*y->s || column(y) <= outer) return true;
    return refuse_rest(y, "does not belong to what is above it");
}

static bool read_document(yaml *y, mbsri_value *value)
{
    if (!skip(y)) return false;
    if (strncmp(y->s, "---", 3) == 0 && is_space(y->s[3])) {
        y->s += 3;
        if (!at_end_of_line(y)) return mbsri_xacro_refuse(y->x, "YAML has more behind '---'");
        if (!skip(y)) return false;
    }
    if (!read_node(y, -1, value)) return false;
    return !*y->s || refuse_rest(y, "is not read here");
}

bool mbsri_yaml_read(mbsri_xacro *x, const char *text, size_t size, const char *name,
                     mbsri_value *value)
{
    const char *nothing[] = {NULL};
    const mbsri_element *before = x->at;
    const char *copy = mbsri_xacro_copy(x, text, size);
    yaml y = {.x = x, .at = {.name = "yaml", .file = name, .line = 1, .attribute = nothing}};
    if (!copy) return false;
    y.s = y.line = copy;
    x->at = &y.at;
    bool good = strlen(copy) == size || mbsri_xacro_refuse(x, "the file has NUL bytes");
    good = good && read_document(&y, value);
    x->at = before;
    return good;
}
