/* The problems of the paper.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "paper.h"

const paper_parameters paper_standard = {.mi = 0.0,
                                         .mj = 1.5,
                                         .cix = 40.0,
                                         .dix = 3.0,
                                         .ciy = 30.0,
                                         .diy = 5.0,
                                         .cjx = 20.0,
                                         .djx = 0.8,
                                         .l = 0.4};

const oscillator_parameters oscillator_standard = {
    .m1 = 0.0, .m2 = 1.0, .c1 = 1.0, .c2 = 1.0, .d1 = 1e-5, .d2 = 1e-5, .F = 1.0};

static mbsr_model *create(void)
{
    mbsr_model *m;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
    return m;
}

static void add_point(mbsr_model *m, int parent, mbsr_joint joint, double mass)
{
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = parent;
    body.joint = joint;
    body.inertia = mbsr_inertia_particle(mass);
    assert_int_equal(mbsr_model_add_body(m, &body, NULL), MBSR_OK);
}

static void add_spring(mbsr_model *m, int a, int b, int axis, double c, double d)
{
    const mbsr_force_def spring = mbsr_force_axis_spring(a, b, axis, c, d, 0.0);
    assert_int_equal(mbsr_model_add_force(m, &spring, NULL), MBSR_OK);
}

static mbsr_model *finish(mbsr_model *m)
{
    assert_int_equal(mbsr_model_finish(m), MBSR_OK);
    return m;
}

mbsr_model *paper_upper(const paper_parameters *p)
{
    mbsr_model *m = create();
    add_point(m, MBSR_GROUND, mbsr_joint_point_free(), p->mi);
    add_point(m, 0, mbsr_joint_point_free(), p->mj);
    add_spring(m, 0, MBSR_GROUND, 0, p->cix, p->dix);
    add_spring(m, 0, MBSR_GROUND, 1, p->ciy, p->diy);
    add_spring(m, 1, 0, 0, p->cjx, p->djx);
    return finish(m);
}

mbsr_model *paper_lower(const paper_parameters *p)
{
    mbsr_model *m = create();
    add_point(m, MBSR_GROUND, mbsr_joint_point_free(), p->mi);
    add_point(m, 0, mbsr_joint_point((mbsr_planar_frame){p->l, 0.0, 0.0}, MBSR_Y, 0, NULL, NULL),
              p->mj);
    add_spring(m, 0, MBSR_GROUND, 0, p->cix, p->dix);
    add_spring(m, 0, MBSR_GROUND, 1, p->ciy, p->diy);
    return finish(m);
}

static int constant_force(void *user, double t, int n, double *value)
{
    (void)t, (void)n;
    value[0] = *(const double *)user;
    return MBSR_OK;
}

/* p must outlive the model: its F is read during the motion. */
mbsr_model *paper_oscillators(const oscillator_parameters *p, int relative)
{
    mbsr_model *m = create();
    const mbsr_joint line = mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL);
    add_point(m, MBSR_GROUND, line, p->m1);
    add_point(m, relative ? 0 : MBSR_GROUND, line, p->m2);
    add_spring(m, 0, MBSR_GROUND, 0, p->c1, p->d1);
    add_spring(m, 1, 0, 0, p->c2, p->d2);
    const mbsr_force_def force = mbsr_force_applied(0, constant_force, (void *)&p->F);
    assert_int_equal(mbsr_model_add_force(m, &force, NULL), MBSR_OK);
    return finish(m);
}

enum { PIX, PIY, PJX, PJY, VJX, VJY, VIX, VIY };

/* mi pix'' = -dix pix' - cix pix + djx (pjx' - pix') + cjx (pjx - pix), mi piy'' = -diy piy' - ciy
 * piy, mj pjx'' = -djx (pjx' - pix') - cjx (pjx - pix), mj pjy'' = 0   (33) */
expm_system paper_upper_system(const paper_parameters *p)
{
    expm_system s = {.n = p->mi > 0.0 ? 8 : 6};
    const double force_x[8] = {
        [PIX] = -p->cix - p->cjx, [PJX] = p->cjx, [VJX] = p->djx, [VIX] = -p->dix - p->djx};
    const double force_y[8] = {[PIY] = -p->ciy, [VIY] = -p->diy};
    s.A[PJX][VJX] = s.A[PJY][VJY] = 1.0;
    s.A[VJX][PIX] = p->cjx / p->mj, s.A[VJX][PJX] = -p->cjx / p->mj,
    s.A[VJX][VJX] = -p->djx / p->mj;
    if (p->mi > 0.0) {
        s.A[PIX][VIX] = s.A[PIY][VIY] = 1.0;
        for (int k = 0; k < 8; ++k)
            s.A[VIX][k] = force_x[k] / p->mi, s.A[VIY][k] = force_y[k] / p->mi;
        s.A[VJX][VIX] = p->djx / p->mj;
    } else { /* (34) solved for the velocities of i */
        for (int k = 0; k < 6; ++k) {
            s.A[PIX][k] = -force_x[k] / force_x[VIX], s.A[PIY][k] = -force_y[k] / force_y[VIY];
            s.A[VJX][k] += p->djx / p->mj * s.A[PIX][k];
        }
    }
    return s;
}

void paper_upper_state(const double *q, const double *u, double *x)
{
    x[PIX] = q[0], x[PIY] = q[1], x[PJX] = q[0] + q[2], x[PJY] = q[1] + q[3];
    x[VJX] = u[0] + u[2], x[VJY] = u[1] + u[3], x[VIX] = u[0], x[VIY] = u[1];
}

void paper_upper_positions(const double *x, double *q)
{
    q[0] = x[PIX], q[1] = x[PIY], q[2] = x[PJX] - x[PIX], q[3] = x[PJY] - x[PIY];
}

/* (mi + mj) pix'' = -dix pix' - cix pix, mi piy'' = -diy piy' - ciy piy, mj pjy'' = 0: states pix
 * piy pjy vix vjy (viy) */
expm_system paper_lower_system(const paper_parameters *p)
{
    expm_system s = {.n = p->mi > 0.0 ? 6 : 5};
    s.A[0][3] = s.A[2][4] = 1.0;
    s.A[3][0] = -p->cix / (p->mi + p->mj), s.A[3][3] = -p->dix / (p->mi + p->mj);
    if (p->mi > 0.0) {
        s.A[1][5] = 1.0;
        s.A[5][1] = -p->ciy / p->mi, s.A[5][5] = -p->diy / p->mi;
    } else {
        s.A[1][1] = -p->ciy / p->diy;
    }
    return s;
}

void paper_lower_state(const double *q, const double *u, double *x)
{
    x[0] = q[0], x[1] = q[1], x[2] = q[1] + q[2], x[3] = u[0], x[4] = u[1] + u[2], x[5] = u[1];
}

void paper_lower_positions(const double *x, double *q)
{
    q[0] = x[0], q[1] = x[1], q[2] = x[2] - x[1];
}

/* (5), and for m1 = 0 (6): states p1 p2 v2 (v1) */
expm_system paper_oscillator_system(const oscillator_parameters *p)
{
    expm_system s = {.n = p->m1 > 0.0 ? 4 : 3};
    const double force[4] = {-p->c1 - p->c2, p->c2, p->d2, -p->d1 - p->d2};
    s.A[1][2] = 1.0;
    s.A[2][0] = p->c2 / p->m2, s.A[2][1] = -p->c2 / p->m2, s.A[2][2] = -p->d2 / p->m2;
    if (p->m1 > 0.0) {
        s.A[0][3] = 1.0;
        s.A[2][3] = p->d2 / p->m2;
        for (int k = 0; k < 4; ++k) s.A[3][k] = force[k] / p->m1;
        s.b[3] = p->F / p->m1;
    } else {
        for (int k = 0; k < 3; ++k) s.A[0][k] = -force[k] / force[3];
        s.b[0] = -p->F / force[3];
        for (int k = 0; k < 3; ++k) s.A[2][k] += p->d2 / p->m2 * s.A[0][k];
        s.b[2] = p->d2 / p->m2 * s.b[0];
    }
    return s;
}
