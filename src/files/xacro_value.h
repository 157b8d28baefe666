/* Values of expressions of xacro, as those of Python.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XACRO_VALUE_H
#define MBSRI_FILES_XACRO_VALUE_H

#include "files/xacro.h"

#include <stdint.h>

typedef enum mbsri_value_kind {
    MBSRI_NOTHING, /* None */
    MBSRI_TRUTH,
    MBSRI_WHOLE,
    MBSRI_REAL,
    MBSRI_STRING,
    MBSRI_LIST,
    MBSRI_TUPLE,
    MBSRI_DICTIONARY,
    MBSRI_FUNCTION,  /* one of those that xacro offers, or a method of `self` */
    MBSRI_MODULE,    /* math, python, xacro */
    MBSRI_NAMESPACE, /* of an include */
    MBSRI_BLOCK      /* elements */
} mbsri_value_kind;

typedef struct mbsri_value {
    mbsri_value_kind kind;
    union {
        bool truth;
        int64_t whole;
        double real;
        const char *string;
        mbsri_list *list; /* of values; of a dictionary: key and value in turn */
        const struct mbsri_function *function;
        int module; /* an mbsri_module */
        struct mbsri_scope *scope;
        const mbsri_element *block;
    } of;
    const struct mbsri_value *self; /* of a method */
} mbsri_value;

static inline mbsri_value mbsri_value_truth(bool truth)
{
    return (mbsri_value){.kind = MBSRI_TRUTH, .of.truth = truth};
}

static inline mbsri_value mbsri_value_whole(int64_t whole)
{
    return (mbsri_value){.kind = MBSRI_WHOLE, .of.whole = whole};
}

static inline mbsri_value mbsri_value_real(double real)
{
    return (mbsri_value){.kind = MBSRI_REAL, .of.real = real};
}

static inline mbsri_value mbsri_value_string(const char *string)
{
    return (mbsri_value){.kind = MBSRI_STRING, .of.string = string};
}

static inline const mbsri_value *mbsri_items(const mbsri_value *v)
{
    return v->of.list->items;
}

static inline bool mbsri_is_sequence(const mbsri_value *v)
{
    return v->kind == MBSRI_LIST || v->kind == MBSRI_TUPLE;
}

/* Truth values count as 0 and 1. */
bool mbsri_is_whole(const mbsri_value *v, int64_t *whole);
bool mbsri_is_number(const mbsri_value *v, double *number);

/* An empty list, tuple or dictionary to be filled by mbsri_value_add; NULL: refused. */
mbsri_list *mbsri_value_begin(mbsri_xacro *x, mbsri_value_kind kind, mbsri_value *value);
bool mbsri_value_add(mbsri_xacro *x, mbsri_list *list, const mbsri_value *item);

/* What a dictionary has under a key; *found is NULL: nothing. False: refused. */
bool mbsri_value_find(mbsri_xacro *x, const mbsri_value *dictionary, const mbsri_value *key,
                      mbsri_value **found);

/* "a list" and the like, for messages. */
const char *mbsri_kind_name(const mbsri_value *v);

/* What Python's bool() says. */
bool mbsri_value_true(const mbsri_value *v);

/* a == b; and a < b -1, a == b 0, a > b 1. False: refused. */
bool mbsri_value_equal(mbsri_xacro *x, const mbsri_value *a, const mbsri_value *b, bool *equal);
bool mbsri_value_compare(mbsri_xacro *x, const mbsri_value *a, const mbsri_value *b, int *order);

/* What Python's str() writes; NULL: refused. */
const char *mbsri_value_text(mbsri_xacro *x, const mbsri_value *v);

/* What int() and float() read. */
bool mbsri_text_whole(const char *text, int64_t *whole);
bool mbsri_text_real(const char *text, double *real);

/* What a property or parameter with this text is: without quotes around it, a number, a truth
 * value, or the text. Other values stay as they are. */
mbsri_value mbsri_value_literal(mbsri_xacro *x, const mbsri_value *v);

/* Whether an element stays: numbers, "true", "False" and the like. False: it is no truth value. */
bool mbsri_value_condition(const mbsri_value *v, bool *keep);

#endif
