/* An expression of xacro as a tree: the expressions of Python but for lambda, comprehensions,
 * dictionaries in braces, operators on bits, and keywords in calls other than dict().
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XACRO_PARSE_H
#define MBSRI_FILES_XACRO_PARSE_H

#include "files/xacro_value.h"

typedef enum mbsri_node_kind {
    MBSRI_NODE_CONSTANT,    /* value */
    MBSRI_NODE_NAME,        /* text */
    MBSRI_NODE_LIST,        /* items from `first` */
    MBSRI_NODE_TUPLE,       /* items from `first` */
    MBSRI_NODE_UNARY,       /* text: "+", "-", "not"; a */
    MBSRI_NODE_BINARY,      /* text; a, b */
    MBSRI_NODE_AND,         /* a, b */
    MBSRI_NODE_OR,          /* a, b */
    MBSRI_NODE_COMPARE,     /* a, then items of operator `text` and operand */
    MBSRI_NODE_CONDITIONAL, /* a if b else c */
    MBSRI_NODE_CALL,        /* a, items with their keyword `text` or NULL */
    MBSRI_NODE_INDEX,       /* a[b] */
    MBSRI_NODE_SLICE,       /* a[b:c], either may be NULL */
    MBSRI_NODE_ATTRIBUTE    /* a.text */
} mbsri_node_kind;

typedef struct mbsri_item {
    const char *text;
    const struct mbsri_expression_node *node;
    struct mbsri_item *next;
} mbsri_item;

typedef struct mbsri_expression_node {
    mbsri_node_kind kind;
    const char *text;
    mbsri_value value;
    const struct mbsri_expression_node *a, *b, *c;
    const mbsri_item *first;
} mbsri_expression_node;

/* NULL: refused. */
const mbsri_expression_node *mbsri_xacro_parse(mbsri_xacro *x, const char *text);

/* Whether a text is a name that is no keyword. */
bool mbsri_is_name(const char *text);

#endif
