/* Forms, starts, reports and the reduced ODE: no number that is not finite with MBSR_OK.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "finite.h"

#include <stdlib.h>
#include "mixed.h"
#include "twins.h"

#include <mbsrank/driver.h>

enum { T = 1u << FINITE_T, Q = 1u << FINITE_Q, U = 1u << FINITE_U, Y = 1u << FINITE_Y };
enum { YP = 1u << FINITE_YP, OTHER = 1u << FINITE_OTHER };
enum { BOTH = FINITE_MODEL | FINITE_DATA, MOST = 96 };

static double time_of(const finite_subject *s)
{
    return s->in[FINITE_T][0];
}

/* ---- forms ---- */

/* The index-1 form gets its reference from a good state. */
static int reference(finite_subject *s)
{
    double y[MOST];
    const int status = mbsr_index1_reset(s->model, s->data);
    if (status || s->form != MBSR_DAE_INDEX1) return status;
    double q[MOST], u[MOST];
    for (int k = 0; k < s->nq; ++k) q[k] = 0.1 + 0.05 * k;
    for (int k = 0; k < s->nu; ++k) u[k] = 0.3 - 0.04 * k;
    return mbsr_dae_pack(s->model, s->data, s->form, 0.2, q, u, y);
}

static int run_id(finite_subject *s)
{
    return mbsr_dae_id(s->model, s->data, s->form, s->out[0]);
}

static int run_pack(finite_subject *s)
{
    return mbsr_dae_pack(s->model, s->data, s->form, time_of(s), s->in[FINITE_Q], s->in[FINITE_U],
                         s->out[0]);
}

static int run_unpack(finite_subject *s)
{
    return mbsr_dae_unpack(s->model, s->data, s->form, time_of(s), s->in[FINITE_Y], s->out[0],
                           s->out[1]);
}

static int run_residual(finite_subject *s)
{
    return mbsr_dae_residual(s->model, s->data, s->form, time_of(s), s->in[FINITE_Y],
                             s->in[FINITE_YP], s->out[0]);
}

static int run_alignment(finite_subject *s)
{
    return mbsr_index1_alignment(s->model, s->data, time_of(s), s->in[FINITE_Y], s->out[0]);
}

/* Copies an input to an output that is changed in place. */
static double *in_place(finite_subject *s, finite_input input, int output)
{
    const size_t size = sizeof(double) * (size_t)s->length[input];
    if (!s->in[input] || !s->out[output]) return NULL;
    return memcpy(s->out[output], s->in[input], size);
}

static int run_renew(finite_subject *s)
{
    double *yp = in_place(s, FINITE_YP, 0);
    return mbsr_index1_renew(s->model, s->data, time_of(s), s->in[FINITE_Y], yp, NULL);
}

static int run_consistent(finite_subject *s)
{
    mbsr_consistent_info info;
    mbsr_consistent_opt opt = mbsr_default_consistent_opt();
    if (s->in[FINITE_OTHER]) opt.tolerance = s->in[FINITE_OTHER][0];
    double *y = in_place(s, FINITE_Y, 0);
    const int status =
        mbsr_dae_consistent(s->model, s->data, s->form, time_of(s), y, s->out[1],
                            s->in[FINITE_OTHER] ? &opt : NULL, s->out[2] ? &info : NULL);
    if (status || !s->out[2]) return status;
    s->out[2][0] = info.position_change;
    s->out[2][1] = info.velocity_change;
    s->out[2][2] = info.force_defect;
    return status;
}

static int run_imbalance(finite_subject *s)
{
    int body;
    double *change = calloc((size_t)(s->nq + s->nu) + 1, sizeof *change), *share = s->out[0];
    const int status = mbsr_dae_imbalance(s->model, s->data, s->form, time_of(s), s->in[FINITE_Y],
                                          share, &body, change, change + s->nq);
    if (share) share[1] = 0.0;
    for (int k = 0; k < s->nq + s->nu && share && !status; ++k) share[1] += fabs(change[k]);
    free(change);
    return status;
}

static int run_report(finite_subject *s)
{
    mbsr_index_report *report;
    const int status = mbsr_index_report_create(s->model, s->data, time_of(s), s->in[FINITE_Q],
                                                s->in[FINITE_U], s->out[0] ? &report : NULL);
    if (status || !s->out[0]) return status;
    s->out[0][0] = report->conditioning;
    s->out[0][1] = 0.0;
    for (int k = 0; k < report->directions; ++k) {
        const mbsr_direction *direction = report->direction + k;
        for (int l = 0; l < direction->terms; ++l) s->out[0][1] += direction->term[l].weight;
    }
    mbsr_index_report_destroy(s->model, report);
    return status;
}

/* ---- the reduced ODE; every call has its own ---- */

static int run_ode_create(finite_subject *s)
{
    mbsr_ode *ode;
    const int status =
        mbsr_ode_create(s->model, s->data, time_of(s), s->in[FINITE_Q], s->in[FINITE_U], &ode);
    mbsr_ode_destroy(ode);
    return status;
}

static int run_ode_pack(finite_subject *s)
{
    return mbsr_ode_pack(s->object, time_of(s), s->in[FINITE_Q], s->in[FINITE_U], s->out[0]);
}

static int run_ode_velocities(finite_subject *s)
{
    double *u = in_place(s, FINITE_U, 0);
    return mbsr_ode_velocities(s->object, time_of(s), s->in[FINITE_R], u);
}

/* Newton's iteration begins at the same velocities. */
static int start_ode(finite_subject *s)
{
    double u[MOST], x[2 * MOST];
    for (int k = 0; k < s->nu; ++k) u[k] = 0.1;
    for (int k = 0; k < s->nq + s->nu; ++k) x[k] = 0.2 + 0.1 * k;
    return mbsr_ode_velocities(s->object, 0.2, x, u);
}

static int run_ode_rhs(finite_subject *s)
{
    return mbsr_ode_rhs(s->object, time_of(s), s->in[FINITE_R], s->out[0]);
}

/* ---- lengths ---- */

static int size_of(const finite_subject *s)
{
    return mbsr_dae_size(s->model, s->form);
}

static int of_y(const finite_subject *s, int o)
{
    return o == 0 ? size_of(s) : 0;
}

static int of_state(const finite_subject *s, int o)
{
    return o == 0 ? s->nq : o == 1 ? s->nu : 0;
}

static int of_start(const finite_subject *s, int o)
{
    return o < 2 ? size_of(s) : 3;
}

static int of_one(const finite_subject *s, int o)
{
    (void)s;
    return o == 0;
}

static int of_two(const finite_subject *s, int o)
{
    (void)s;
    return o == 0 ? 2 : 0;
}

static int of_x(const finite_subject *s, int o)
{
    return o == 0 ? s->nq + s->nu : 0;
}

static int of_u(const finite_subject *s, int o)
{
    return o == 0 ? s->nu : 0;
}

static const finite_row rows[] = {
    {"mbsr_dae_size", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_dae_id", run_id, reference, 0, 0, BOTH, of_y},
    {"mbsr_dae_pack", run_pack, reference, 0, T | Q | U, BOTH, of_y},
    {"mbsr_dae_unpack", run_unpack, reference, 0, T | Y, BOTH, of_state},
    {"mbsr_dae_residual", run_residual, reference, 0, T | Y | YP, BOTH, of_y},
    {"mbsr_index1_alignment", run_alignment, reference, 0, T | Y, BOTH, of_one},
    {"mbsr_index1_renew", run_renew, reference, 0, T | Y | YP, BOTH, of_y},
    {"mbsr_index1_reset", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_momentum_scales", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_default_consistent_opt", NULL, NULL, 0, 0, 0, NULL},
};
enum { ROWS = sizeof rows / sizeof rows[0] };

/* Slow ones, for small models. */
static const finite_row slow[] = {
    {"mbsr_dae_consistent", run_consistent, reference, 0, T | Y | OTHER, BOTH, of_start},
    {"mbsr_dae_imbalance", run_imbalance, reference, 0, T | Y, BOTH, of_two},
    {"mbsr_index_report_create", run_report, NULL, 0, T | Q | U, BOTH, of_two},
    {"mbsr_index_report_destroy", NULL, NULL, 0, 0, 0, NULL},
};
enum { SLOW = sizeof slow / sizeof slow[0] };

static const finite_row ode_rows[] = {
    {"mbsr_ode_create", run_ode_create, NULL, 0, T | Q | U, BOTH, NULL},
    {"mbsr_ode_destroy", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_ode_size", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_ode_stats", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_ode_pack", run_ode_pack, NULL, 0, T | Q | U, FINITE_OBJECT, of_x},
    {"mbsr_ode_velocities", run_ode_velocities, NULL, 0, T | U | 1u << FINITE_R, FINITE_OBJECT,
     of_u},
    {"mbsr_ode_rhs", run_ode_rhs, start_ode, 0, T | 1u << FINITE_R, FINITE_OBJECT, of_x},
};
enum { ODE_ROWS = sizeof ode_rows / sizeof ode_rows[0] };

static int served[ROWS], slow_served[SLOW], ode_served[ODE_ROWS];

static finite_subject subject(const char *name, mbsr_model *model, mbsr_data *data,
                              mbsr_dae_form form)
{
    finite_subject s = {.name = name, .model = model, .data = data, .form = form};
    double x[MOST];
    s.nq = mbsr_model_nq(model);
    s.nu = mbsr_model_nu(model);
    test_rng rng = test_seed(72);
    const int size = mbsr_dae_size(model, form);
    const struct {
        finite_input input;
        int n;
    } given[] = {{FINITE_Q, s.nq},
                 {FINITE_U, s.nu},
                 {FINITE_Y, size},
                 {FINITE_YP, size},
                 {FINITE_R, s.nq + s.nu}};
    assert_true(size <= MOST);
    finite_give(&s, FINITE_T, 1, (double[]){0.3});
    for (size_t k = 0; k < sizeof given / sizeof given[0]; ++k) {
        test_fill(&rng, given[k].n, x);
        finite_give(&s, given[k].input, given[k].n, x);
    }
    finite_give(&s, FINITE_OTHER, 1, (double[]){1e-12});
    return s;
}

static void forms_of(const char *name, mbsr_model *model, mbsr_data *data, bool small)
{
    for (int form = 0; form < 4; ++form) {
        finite_subject s = subject(name, model, data, (mbsr_dae_form)form);
        for (int k = 0; k < ROWS; ++k) served[k] += finite_try(&s, rows + k);
        for (int k = 0; k < SLOW && small; ++k) slow_served[k] += finite_try(&s, slow + k);
        finite_free(&s);
    }
}

static void mixed_trees(void **unused)
{
    (void)unused;
    for (int k = 0; k < MIXED_ALL; ++k) {
        mixed s;
        mixed_make(&s, (mixed_scene)k);
        forms_of("mixed", s.model, s.data, false);
        mixed_free(&s);
    }
}

static void a_massless_bead(void **unused)
{
    (void)unused;
    twins s;
    twins_make(&s, 1.0);
    forms_of("two pendulums on a bead", s.model, s.data, true);
    finite_subject o = subject("the ODE of two pendulums on a bead", s.model, s.data, 0);
    mbsr_ode *ode;
    assert_ok(mbsr_ode_create(s.model, s.data, 0.3, o.in[FINITE_Q], o.in[FINITE_U], &ode),
              mbsr_data_error(s.data));
    o.object = ode;
    for (int k = 0; k < ODE_ROWS; ++k) ode_served[k] += finite_try(&o, ode_rows + k);
    mbsr_ode_destroy(ode);
    finite_free(&o);
    twins_free(&s);
}

static void each_function_served(void **unused)
{
    (void)unused;
    for (int k = 0; k < ROWS; ++k) {
        if (rows[k].run && served[k] == 0) fail_msg("%s was never MBSR_OK", rows[k].function);
    }
    for (int k = 0; k < SLOW; ++k) {
        if (slow[k].run && slow_served[k] == 0) fail_msg("%s was never MBSR_OK", slow[k].function);
    }
    for (int k = 0; k < ODE_ROWS; ++k) {
        if (ode_rows[k].run && ode_served[k] == 0)
            fail_msg("%s was never MBSR_OK", ode_rows[k].function);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mixed_trees),
        cmocka_unit_test(a_massless_bead),
        cmocka_unit_test(each_function_served),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
