/* As much of JSON as the reference files of robots need.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_JSON_H
#define TEST_JSON_H

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

typedef struct json {
    char *key, *text; /* NULL: none */
    double number;
    bool truth, list;
    struct json *child, *next;
    int count;
} json;

static inline void json_space(char **s)
{
    while (**s && strchr(" \t\r\n,:", **s)) ++*s;
}

/* Cuts the text at *s, which moves behind it. */
static inline char *json_string(char **s)
{
    char *start = ++*s;
    while (**s && **s != '"') *s += **s == '\\' ? 2 : 1;
    if (**s) *(*s)++ = '\0';
    return start;
}

static inline json *json_parse(char **s)
{
    json *j = calloc(1, sizeof *j), **place = &j->child;
    json_space(s);
    if (**s == '{' || **s == '[') {
        const char close = *(*s)++ == '{' ? '}' : ']';
        j->list = true;
        for (json_space(s); **s && **s != close; json_space(s)) {
            char *key = close == '}' ? json_string(s) : NULL;
            *place = json_parse(s);
            (*place)->key = key;
            place = &(*place)->next;
            ++j->count;
        }
        if (**s) ++*s;
    } else if (**s == '"') {
        j->text = json_string(s);
    } else if (**s == 't' || **s == 'f' || **s == 'n') {
        j->truth = **s == 't';
        while (**s >= 'a' && **s <= 'z') ++*s;
    } else {
        char *end;
        j->number = strtod(*s, &end);
        *s = end > *s ? end : *s + 1;
    }
    return j;
}

static inline void json_free(json *j)
{
    while (j) {
        json *next = j->next;
        json_free(j->child);
        free(j);
        j = next;
    }
}

/* NULL: there is none. */
static inline const json *json_get(const json *j, const char *key)
{
    const json *child = j ? j->child : NULL;
    while (child && (!child->key || strcmp(child->key, key) != 0)) child = child->next;
    return child;
}

/* Numbers of a list; how many. */
static inline int json_numbers(const json *j, int most, double *to)
{
    int n = 0;
    for (const json *c = j ? j->child : NULL; c && n < most; c = c->next) to[n++] = c->number;
    return n;
}

#endif
