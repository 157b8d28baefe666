/* What differs between versions 6 and 7 of SUNDIALS: the context, the way of messages, a code.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_COMPAT_H
#define MBSRI_IDA_COMPAT_H

#include <ida/ida.h>
#include <sundials/sundials_config.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_types.h>

#include <stdbool.h>

#if !defined(SUNDIALS_DOUBLE_PRECISION)
#error "SUNDIALS must be built with double precision"
#endif

/* Receives every message of SUNDIALS; `code` is an IDA flag, negative for errors. */
typedef void (*mbsri_ida_message_fn)(void *user, int code, const char *message);

/* Where the messages go; has to stay in place as long as the context and IDA's memory. */
typedef struct mbsri_ida_messages {
    mbsri_ida_message_fn receive;
    void *user;
} mbsri_ida_messages;

#if SUNDIALS_VERSION_MAJOR >= 7

/* What a linear solver returns that failed for good. */
#define MBSRI_IDA_PACKAGE_FAILED SUN_ERR_EXT_FAIL

static inline void mbsri_ida_handler(int line, const char *function, const char *file,
                                     const char *message, SUNErrCode code, void *user,
                                     SUNContext context)
{
    (void)line;
    (void)function;
    (void)file;
    (void)context;
    const mbsri_ida_messages *messages = user;
    messages->receive(messages->user, (int)code, message ? message : "");
}

/* A context whose messages go to `messages` only; false if there is no memory for it. */
static inline bool mbsri_ida_context(SUNContext *context, mbsri_ida_messages *messages)
{
    if (SUNContext_Create(SUN_COMM_NULL, context) != SUN_SUCCESS) return false;
    return SUNContext_ClearErrHandlers(*context) == SUN_SUCCESS &&
           SUNContext_PushErrHandler(*context, mbsri_ida_handler, messages) == SUN_SUCCESS;
}

/* The same for IDA's memory; an IDA flag. The context has taken care of it. */
static inline int mbsri_ida_redirect(void *ida, mbsri_ida_messages *messages)
{
    (void)ida;
    (void)messages;
    return IDA_SUCCESS;
}

#else

#define MBSRI_IDA_PACKAGE_FAILED SUNLS_PACKAGE_FAIL_UNREC

static inline void mbsri_ida_handler(int code, const char *module, const char *function,
                                     char *message, void *user)
{
    (void)module;
    (void)function;
    const mbsri_ida_messages *messages = user;
    messages->receive(messages->user, code, message ? message : "");
}

static inline bool mbsri_ida_context(SUNContext *context, mbsri_ida_messages *messages)
{
    (void)messages;
    return SUNContext_Create(NULL, context) == 0;
}

static inline int mbsri_ida_redirect(void *ida, mbsri_ida_messages *messages)
{
    return IDASetErrHandlerFn(ida, mbsri_ida_handler, messages);
}

#endif

#endif
