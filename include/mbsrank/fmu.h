/* Functional Mock-up Units: a model inside other people's simulators (component fmu).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * An FMU is a ZIP archive with a shared object that steps the model, the model, and a description
 * of its variables, by the standard FMI 2.0 or 3.0. The shared object is the same for every model
 * and is built with the library: nothing is compiled where an FMU is made or runs.
 *
 *   mbsr_fmu *fmu;
 *   mbsr_fmu_opt opt = mbsr_default_fmu_opt();
 *   opt.name = "rover", opt.q0 = q;
 *   if (!mbsr_fmu_export(model, &opt, &fmu, &error)) ...
 *       write fmu->size bytes of fmu->data to rover.fmu
 *   mbsr_fmu_destroy(fmu);
 *
 * Of a model go into an FMU all parts of the library and of files, with tables, modal data and
 * shapes that touch; of functions of the caller's own only those that hold numbers, which become
 * inputs: mbsr_stored_force and mbsr_fmu_stored_motion. docs/fmu.md has the variables. */
#ifndef MBSRANK_FMU_H
#define MBSRANK_FMU_H

#include <mbsrank/files.h>
#include <mbsrank/model.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What an FMU offers; 0 as a choice: co-simulation, and model exchange where the model allows it.
 */
enum {
    MBSR_FMU_CO_SIMULATION = 1, /* it steps by itself */
    MBSR_FMU_MODEL_EXCHANGE =
        2 /* it gives derivatives (ode.h): trees whose massless directions are damped */
};

/* Groups of outputs. Joint coordinates, rates and accelerations are always there. */
enum mbsr_fmu_outputs {
    MBSR_FMU_SITES = 1,     /* positions and quaternions of sites */
    MBSR_FMU_FORCES = 2,    /* what force elements exert on their first body, contacts on each */
    MBSR_FMU_REACTIONS = 4, /* of joints, and loop forces of closures */
    MBSR_FMU_ENERGY = 8,    /* kinetic and potential */
    MBSR_FMU_ALL = 15
};

typedef struct mbsr_fmu_opt {
    int cookie;            /* set by mbsr_default_fmu_opt */
    int version;           /* of the standard: 2 or 3 (default) */
    int kinds;             /* MBSR_FMU_CO_SIMULATION, _MODEL_EXCHANGE, both, or 0 (default) */
    const char *name;      /* of the model; NULL (default): that of the file, else "model" */
    const mbsr_file *file; /* what the model was read from: names of joints, sites, actuators; NULL
                              (default): none. */
    int sites; /* points with axes whose pose is an output; -1 (default): those of the file, or the
                * frames of all bodies where it has none */
    const mbsr_file_site *site; /* these */
    const double *q0, *u0;      /* start, nq and nu numbers; NULL (default): zero, quaternions 1 */
    double rtol, atol;          /* of co-simulation, as in mbsr_ida_opt; default 1e-6 */
    int sources;       /* 1: C11 sources too, for systems without a shared object here; default 0 */
    double fixed_step; /* s; > 0: steps of mbsr_stepper, at most this long; 0 (default): by the
                          error, sources by one step against two halves */
    int order;         /* of these, 1 or 2 (default) */
    int outputs;       /* sum of mbsr_fmu_outputs, default MBSR_FMU_ALL */
    double stop_time;  /* s, of the default experiment; default 1 */
    double step_size;  /* s, likewise; default 1e-3 */
    mbsr_allocator allocator; /* of what is made; default: malloc and free (both functions NULL) */
} mbsr_fmu_opt;

MBSR_API mbsr_fmu_opt mbsr_default_fmu_opt(void);

/* An archive, which belongs to this object. */
typedef struct mbsr_fmu {
    const unsigned char *data;
    size_t size; /* bytes */
    int kinds;   /* what it offers */
    const char
        *text; /* why it does not offer model exchange; "" where it does or was not asked to */
} mbsr_fmu;

/* Makes an FMU of a finished model; opt == NULL: mbsr_default_fmu_opt(). On failure *fmu is NULL
 * and the text of *error (may be NULL) names the part. MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT,
 * MBSR_ERR_UNFINISHED, MBSR_ERR_MISMATCH (`file` is another one), MBSR_ERR_VALUE (of opt; a joint,
 * force, closure, inertia or root by a function of the caller's own; a closure with compliance
 * matrices; model exchange of a model that does not allow it), MBSR_ERR_UNAVAILABLE (the library
 * was built without the shared object), MBSR_ERR_NO_MEMORY, statuses of mbsr_index_report_create.
 */
MBSR_API int mbsr_fmu_export(const mbsr_model *model, const mbsr_fmu_opt *opt, mbsr_fmu **fmu,
                             mbsr_error *error);
MBSR_API void mbsr_fmu_destroy(mbsr_fmu *fmu); /* NULL is allowed */

/* ---- motions as inputs ---- */

#define MBSR_FMU_MOTION_MOST 12

/* `count` prescribed coordinates: value, first and second derivative of each. */
typedef struct mbsr_fmu_motion {
    int count; /* 1 .. MBSR_FMU_MOTION_MOST */
    double value[3 * MBSR_FMU_MOTION_MOST];
} mbsr_fmu_motion;

/* As mbsr_motion_fn (joint.h), with an mbsr_fmu_motion as `user`: gives its numbers whatever the
 * time. In an FMU they are inputs, and between two settings the motion goes on by their parabola.
 * MBSR_ERR_NULL, MBSR_ERR_VALUE (count). */
MBSR_API int mbsr_fmu_stored_motion(void *motion, double t, double *s, double *sdot, double *sddot);

#ifdef __cplusplus
}
#endif

#endif
