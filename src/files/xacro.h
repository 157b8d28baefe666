/* One expansion of a file of xacro: what its parts share, and what limits it.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * From the ground: values (xacro_value.h), expressions as trees (xacro_parse.h), their evaluation
 * (xacro_evaluate.h), YAML (xacro_yaml.h), scopes with properties and texts (xacro_scope.h), macros
 * (xacro_macro.h), other files (xacro_load.h) and the elements (xacro_expand.h). */
#ifndef MBSRI_FILES_XACRO_H
#define MBSRI_FILES_XACRO_H

#include "files/scene.h"

/* What limits an expansion: none in use comes near. Elements, macros, properties and expressions in
 * each other; work, roughly the bytes that it takes; bytes of one text that an expression makes;
 * other files. */
enum {
    MBSRI_XACRO_DEPTH = 1000,
    MBSRI_XACRO_WORK = 1 << 27,
    MBSRI_XACRO_TEXT = 1 << 20,
    MBSRI_XACRO_FILES = 256
};

struct mbsri_value;
struct mbsri_scope;

typedef struct mbsri_xacro {
    mbsri_scene *s;          /* takes refusals and findings */
    const mbsri_element *at; /* that is expanded, for messages */
    const char *home;        /* folder of the model, with its slash */
    const char *folder;      /* of the file that is expanded */
    size_t work;
    int depth;
    mbsri_list arguments; /* mbsr_xacro_argument: $(arg) */
    mbsri_list files;     /* those loaded */
    /* What expressions reach above them. Scopes: 1 found, 0 not there, -1 refused. */
    int (*look_up)(struct mbsri_xacro *x, struct mbsri_scope *scope, const char *name,
                   struct mbsri_value *value);
    bool (*load_yaml)(struct mbsri_xacro *x, const char *path, struct mbsri_value *value);
} mbsri_xacro;

/* Always false. */
#define mbsri_xacro_refuse(x, ...) mbsri_file_refuse((x)->s, (x)->at, __VA_ARGS__)

/* Counts work and the depth; false: refused. What was entered is left by mbsri_xacro_leave. */
bool mbsri_xacro_spend(mbsri_xacro *x, size_t work);
bool mbsri_xacro_enter(mbsri_xacro *x);
void mbsri_xacro_leave(mbsri_xacro *x);

/* The value of an argument; NULL: it has none. */
const char *mbsri_xacro_argument(const mbsri_xacro *x, const char *name);

/* A path from the folder of the file that is expanded; NULL: refused. */
const char *mbsri_xacro_beside(mbsri_xacro *x, const char *path);

/* Memory that counts as work; NULL: refused, or there is none. */
void *mbsri_xacro_take(mbsri_xacro *x, size_t size);
char *mbsri_xacro_copy(mbsri_xacro *x, const char *text, size_t length);

#endif
