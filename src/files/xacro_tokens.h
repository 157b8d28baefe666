/* Tokens of an expression of xacro.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XACRO_TOKENS_H
#define MBSRI_FILES_XACRO_TOKENS_H

#include "files/xacro_value.h"

typedef enum mbsri_token_kind {
    MBSRI_TOKEN_END,
    MBSRI_TOKEN_VALUE, /* a number or string */
    MBSRI_TOKEN_NAME,  /* keywords too */
    MBSRI_TOKEN_MARK   /* an operator, a bracket */
} mbsri_token_kind;

typedef struct mbsri_token {
    mbsri_token_kind kind;
    const char *text;  /* of a name or mark */
    mbsri_value value; /* of a number or string */
} mbsri_token;

/* The token at *text, which moves behind it; false: refused. */
bool mbsri_token_next(mbsri_xacro *x, const char **text, mbsri_token *token);

#endif
