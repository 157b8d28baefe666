/* Status codes, error texts, version and export macro of libmbsrank.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_BASE_H
#define MBSRANK_BASE_H

#include <stddef.h>

#define MBSR_VERSION_MAJOR 0
#define MBSR_VERSION_MINOR 1
#define MBSR_VERSION_PATCH 0

#if defined(MBSR_API)
/* chosen by the build */
#elif defined(_WIN32)
#if defined(MBSR_STATIC)
#define MBSR_API
#elif defined(MBSR_BUILDING)
#define MBSR_API __declspec(dllexport)
#else
#define MBSR_API __declspec(dllimport)
#endif
#elif defined(__GNUC__)
#define MBSR_API __attribute__((visibility("default")))
#else
#define MBSR_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Every function that can fail returns an int with the sign rule of SUNDIALS IDA: 0 success, > 0
 * recoverable (a solver may retry with a smaller step), < 0 fatal. The library's own codes have an
 * absolute value above 1000; any other non-zero value is what a callback of the caller returned,
 * handed through unchanged.
 *
 * X(name, value, text) */
#define MBSR_STATUS_MAP(X)                                                                         \
    X(MBSR_OK, 0, "success")                                                                       \
    /* recoverable: depends on the state, not on the model */                                      \
    X(MBSR_SINGULAR_K, 1001, "the Jacobian K of a joint is singular")                              \
    X(MBSR_RANK_DEFICIENT_J, 1002, "the Jacobian J of a joint does not have full column rank")     \
    X(MBSR_NOT_FINITE, 1003, "a NaN or infinite value appeared")                                   \
    X(MBSR_INDEFINITE_MASS, 1004, "a mass matrix is not positive semi-definite")                   \
    X(MBSR_EIGEN_FAILED, 1005, "an eigenvalue iteration did not converge")                         \
    X(MBSR_DEGENERATE_FORCE, 1006, "a force element has no direction in this state")               \
    X(MBSR_UNDETERMINED, 1007, "an acceleration or velocity is not determined by the equations")   \
    X(MBSR_NO_CONVERGENCE, 1008, "an iteration did not converge")                                  \
    X(MBSR_EVENT, 1009, "an event function changed sign")                                          \
    X(MBSR_RANK_CHANGED, 1010, "the rank of a joint block changed")                                \
    X(MBSR_FRAME_TURNED, 1011, "massless directions turned too far from their reference")          \
    X(MBSR_ZERO_QUATERNION, 1012, "a quaternion has length zero")                                  \
    X(MBSR_SINGULAR_BLOCK, 1013, "the Newton equations of a joint are singular")                   \
    X(MBSR_LOOP_SINGULAR, 1014, "the rows of a closure have become dependent")                     \
    X(MBSR_LOOP_OPEN, 1015, "a loop does not close")                                               \
    /* fatal: wrong use */                                                                         \
    X(MBSR_ERR_NULL, -1001, "a required pointer is NULL")                                          \
    X(MBSR_ERR_NO_DEFAULT, -1002, "a definition was not made by its default function")             \
    X(MBSR_ERR_VALUE, -1003, "a value is out of range")                                            \
    X(MBSR_ERR_ID, -1004, "no such body or force")                                                 \
    X(MBSR_ERR_CYCLE, -1005, "the predecessors form a cycle")                                      \
    X(MBSR_ERR_SPACE, -1006, "coordinates of these kinds cannot be combined")                      \
    X(MBSR_ERR_FINISHED, -1007, "the model is finished and cannot be changed")                     \
    X(MBSR_ERR_UNFINISHED, -1008, "the model is not finished")                                     \
    X(MBSR_ERR_NO_MEMORY, -1009, "an allocation failed")                                           \
    X(MBSR_ERR_MEMORY_SIZE, -1010, "the given memory is too small")                                \
    X(MBSR_ERR_MEMORY_ALIGNMENT, -1011, "the given memory is not aligned")                         \
    X(MBSR_ERR_MISMATCH, -1012, "the data belongs to another model")                               \
    X(MBSR_ERR_SEQUENCE, -1013, "an earlier stage of the evaluation is missing")                   \
    X(MBSR_ERR_SOLVER, -1014, "the integrator failed")                                             \
    X(MBSR_ERR_LEAN, -1015, "the data is lean and does not hold what this needs")                  \
    X(MBSR_ERR_CLOSURES, -1016, "the model has closures, which this does not serve")               \
    X(MBSR_ERR_FILE, -1017, "a file cannot be read")                                               \
    X(MBSR_ERR_UNAVAILABLE, -1018, "the library was built without this")                           \
    X(MBSR_ERR_NUMERICS, -1019, "an iteration over the data of a definition did not converge")

enum mbsr_status {
#define MBSR_STATUS_ENUM(name, value, text) name = value,
    MBSR_STATUS_MAP(MBSR_STATUS_ENUM)
#undef MBSR_STATUS_ENUM
        MBSR_STATUS_END = 0x7fff
};

/* "MBSR_ERR_CYCLE" and the like; "callback status" for a code that is not the library's. Never
 * NULL. */
MBSR_API const char *mbsr_status_name(int status);

/* One line of English for a status; never NULL. */
MBSR_API const char *mbsr_status_text(int status);

/* "0.1.0": the version of the library at run time. */
MBSR_API const char *mbsr_version(void);

/* Body ids: the root of every tree, and "no body". */
#define MBSR_GROUND (-1)
#define MBSR_NONE (-2)

#define MBSR_TEXT_SIZE 256

/* What went wrong last: status, culprit and a text that names body, joint, field and value. */
typedef struct mbsr_error {
    int status;                /* MBSR_OK when nothing has failed */
    int body;                  /* id of the body concerned, or MBSR_NONE */
    int force;                 /* id of the force element concerned, or MBSR_NONE */
    char text[MBSR_TEXT_SIZE]; /* NUL-terminated, possibly cut short; "" when nothing has failed */
} mbsr_error;

/* Memory functions for models and for mbsr_data_create. `allocate` returns memory aligned for any
 * object, or NULL; `release` takes what `allocate` returned, never NULL. */
typedef struct mbsr_allocator {
    void *(*allocate)(void *user, size_t size);
    void (*release)(void *user, void *memory);
    void *user;
} mbsr_allocator;

#ifdef __cplusplus
}
#endif

#endif
