/* Joint coordinates and rates that a start is given.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/given.h"

#include "ida/error.h"

#include <math.h>
#include <stdlib.h>

int mbsri_given_add(mbsri_given **list, mbsri_given given)
{
    for (mbsri_given *g = *list; g; g = g->next) {
        if (g->rate != given.rate || g->body != given.body || g->coordinate != given.coordinate)
            continue;
        g->value = given.value;
        return MBSR_OK;
    }
    mbsri_given *made = malloc(sizeof *made);
    if (!made) return MBSR_ERR_NO_MEMORY;
    *made = given;
    made->next = *list;
    *list = made;
    return MBSR_OK;
}

static int check_given(const mbsri_given *g, const mbsr_model *model, int numbers,
                       mbsr_error *error)
{
    const char *function = g->rate ? "mbsr_simulation_set_rate" : "mbsr_simulation_set_position";
    if (g->coordinate < 0 || g->coordinate >= numbers)
        return mbsri_ida_fail(error, MBSR_ERR_VALUE, g->body, MBSR_NONE,
                              "%s: coordinate is %d, but the joint of body %d '%.40s' has %d",
                              function, g->coordinate, g->body, mbsr_body_name(model, g->body),
                              numbers);
    if (!isfinite(g->value))
        return mbsri_ida_fail(error, MBSR_ERR_VALUE, g->body, MBSR_NONE,
                              "%s: the value of coordinate %d of body %d '%.40s' is %g", function,
                              g->coordinate, g->body, mbsr_body_name(model, g->body), g->value);
    return MBSR_OK;
}

/* Of a quaternion, which begins the q of joints with one number more, all three turns stay. */
static void apply_position(const mbsri_given *g, int more, double *q, int *keep)
{
    q[g->coordinate] = g->value;
    if (more > 0 && g->coordinate < 4)
        keep[0] = keep[1] = keep[2] = 1;
    else
        keep[g->coordinate - more] = 1;
}

int mbsri_given_apply(const mbsri_given *list, const mbsr_model *model, double *q, double *u,
                      int *keep_position, int *keep_rate, mbsr_error *error)
{
    for (const mbsri_given *g = list; g; g = g->next) {
        int from_q, nq, from_u, n;
        int status = mbsr_body_coordinates(model, g->body, &from_q, &nq, &from_u, &n);
        if (status)
            return mbsri_ida_fail(
                error, status, g->body, MBSR_NONE, "%s: there is no body %d",
                g->rate ? "mbsr_simulation_set_rate" : "mbsr_simulation_set_position", g->body);
        status = check_given(g, model, g->rate ? n : nq, error);
        if (status) return status;
        if (g->rate) {
            u[from_u + g->coordinate] = g->value;
            keep_rate[from_u + g->coordinate] = 1;
        } else {
            apply_position(g, nq - n, q + from_q, keep_position + from_u);
        }
    }
    return MBSR_OK;
}

void mbsri_given_free(mbsri_given *list)
{
    while (list) {
        mbsri_given *next = list->next;
        free(list);
        list = next;
    }
}

void mbsri_given_nothing(const mbsr_model *m, double *q)
{
    for (int k = 0; k < mbsr_model_nq(m); ++k) q[k] = 0.0;
    for (int i = 0; i < mbsr_model_bodies(m); ++i) {
        int at, nq, n;
        mbsr_body_coordinates(m, i, &at, &nq, NULL, &n);
        if (nq == n + 1) q[at] = 1.0;
    }
}
