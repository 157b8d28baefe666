/* The motion of a mode as a run: see mode_motion.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/mode_motion.h"

#include "program/output.h"

#include <math.h>
#include <stdlib.h>

/* How far the largest turn and way of a shape are to go: 0.2 rad, a tenth of the model. */
static double amplitude_of(const program_model *p, const double *re, const double *im)
{
    const mbsr_model *m = p->model;
    double length = 0.0, most = 0.0;
    for (int i = 0; i < mbsr_model_bodies(m); ++i) {
        double x[3];
        if (mbsr_body_point(m, p->data, i, NULL, x, NULL, NULL)) continue;
        length = fmax(length, sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]));
    }
    if (!(length > 0.0)) length = 1.0;
    for (int i = 0; i < mbsr_model_bodies(m); ++i) {
        mbsr_coordinate_kind kind[MBSR_MAX_D];
        int u, n;
        mbsr_body_coordinates(m, i, NULL, NULL, &u, &n);
        mbsr_body_coordinate_kinds(m, i, NULL, kind);
        for (int k = 0; k < n; ++k) {
            const double whole = kind[k] == MBSR_COORDINATE_TRANSLATION ? 0.1 * length : 0.2;
            most = fmax(most, hypot(re[u + k], im[u + k]) / whole);
        }
    }
    return most > 0.0 ? 1.0 / most : 1.0;
}

int mode_motion_write(const program_model *p, const double *rest, const mbsr_mode *mode,
                      const double *re, const double *im, const char *path)
{
    enum { STEPS = 60 };
    const mbsr_model *m = p->model;
    const int nq = mbsr_model_nq(m), nu = mbsr_model_nu(m);
    const bool swings = mode->imaginary > 0.0;
    const double size = hypot(mode->real, mode->imaginary), last = size > 0.0 ? 3.0 / size : 1.0,
                 end = swings ? 1.0 / mode->frequency : last;
    columns c = {.list = NULL};
    output to = {.path = NULL};
    double *x = calloc((size_t)(2 * nq + 2 * nu) + 1, sizeof *x), *u = x ? x + nu : NULL,
           *q = x ? u + nu : NULL, *dq = x ? q + nq : NULL;
    int code = x ? columns_make(p, NULL, &c) : complain(FAILED, "no memory");
    if (!code) code = output_open(path, &c, STEPS + 1.0, &to);
    int status = code ? MBSR_OK : mbsr_stage_positions(m, p->data, 0.0, rest);
    const double scale = code || status ? 0.0 : amplitude_of(p, re, im);
    for (int k = 0; k <= STEPS && !code && !status; ++k) {
        const double t = end * k / STEPS, decay = swings ? 1.0 : exp(-size * t),
                     a = scale * decay * cos(mode->imaginary * t),
                     b = scale * decay * sin(mode->imaginary * t);
        for (int j = 0; j < nu; ++j) x[j] = a * re[j] - b * im[j];
        status = mbsr_stage_positions(m, p->data, 0.0, rest);
        if (!status) status = mbsr_stage_velocities(m, p->data, x);
        if (!status) status = mbsr_coordinate_rates(m, p->data, dq);
        for (int j = 0; j < nq; ++j) q[j] = rest[j] + dq[j];
        if (!status) status = mbsr_normalise(m, p->data, q);
        if (!status) status = mbsr_stage_positions(m, p->data, 0.0, q);
        if (!status) status = mbsr_stage_velocities(m, p->data, u);
        if (!status) code = output_state(&to, m, p->data, t, q, u);
    }
    if (status) code = complain(FAILED, "%s", mbsr_data_error(p->data)->text);
    if (to.row) {
        const int closing = output_close(&to);
        if (!code) code = closing;
    }
    free(c.list);
    free(x);
    return code;
}
