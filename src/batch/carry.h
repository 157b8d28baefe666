/* Mbar, (L, p) and the bound of rounding errors from a body to its predecessor.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BATCH_CARRY_H
#define MBSRI_BATCH_CARRY_H

#include "batch/state.h"

/* ---- R S R^T, where R turns about z or about x ---- */

MBSRI_INLINE void sym_about_z(const turn *t, sym *S)
{
    const lanes d = S->xx - S->yy, xy = S->xy, xz = S->xz, yz = S->yz, twice = xy + xy,
                move = t->ss * d + t->sc * twice;
    S->xx -= move;
    S->yy += move;
    S->xy = xy + (t->sc * d - t->ss * twice);
    S->xz = t->c * xz - t->s * yz;
    S->yz = t->s * xz + t->c * yz;
}

/* Not by the difference, which would mix what does not belong together where bodies lie in a plane.
 */
MBSRI_INLINE void sym_about_x(const turn *t, sym *S)
{
    const lanes yy = S->yy, zz = S->zz, yz = S->yz, xy = S->xy, xz = S->xz,
                move = t->sc * (yz + yz);
    S->yy = t->cc * yy + (t->ss * zz - move);
    S->zz = t->cc * zz + (t->ss * yy + move);
    S->yz = t->sc * (yy - zz) + (t->cc * yz - t->ss * yz);
    S->xy = t->c * xy - t->s * xz;
    S->xz = t->s * xy + t->c * xz;
}

MBSRI_INLINE void mat_about_z(const turn *t, mat *G)
{
    const mat A = *G;
    const lanes d = A.x.x - A.y.y, sum = A.x.y + A.y.x, move = t->ss * d + t->sc * sum,
                across = t->sc * d - t->ss * sum;
    G->x.x = A.x.x - move;
    G->y.y = A.y.y + move;
    G->x.y = A.x.y + across;
    G->y.x = A.y.x + across;
    G->x.z = t->c * A.x.z - t->s * A.y.z;
    G->y.z = t->s * A.x.z + t->c * A.y.z;
    G->z.x = t->c * A.z.x - t->s * A.z.y;
    G->z.y = t->s * A.z.x + t->c * A.z.y;
}

MBSRI_INLINE void mat_about_x(const turn *t, mat *G)
{
    const mat A = *G;
    const lanes move = t->sc * (A.y.z + A.z.y), across = t->sc * (A.y.y - A.z.z);
    G->y.y = t->cc * A.y.y + (t->ss * A.z.z - move);
    G->z.z = t->cc * A.z.z + (t->ss * A.y.y + move);
    G->y.z = t->cc * A.y.z + (across - t->ss * A.z.y);
    G->z.y = t->cc * A.z.y + (across - t->ss * A.y.z);
    G->y.x = t->c * A.y.x - t->s * A.z.x;
    G->z.x = t->s * A.y.x + t->c * A.z.x;
    G->x.y = t->c * A.x.y - t->s * A.x.z;
    G->x.z = t->s * A.x.y + t->c * A.x.z;
}

MBSRI_INLINE void carry_about_z(const turn *t, carry *c)
{
    sym_about_z(t, &c->I);
    mat_about_z(t, &c->G);
    sym_about_z(t, &c->M);
    c->L = about_z(t, c->L);
    c->p = about_z(t, c->p);
}

MBSRI_INLINE void carry_about_x(const turn *t, carry *c)
{
    sym_about_x(t, &c->I);
    mat_about_x(t, &c->G);
    sym_about_x(t, &c->M);
    c->L = about_x(t, c->L);
    c->p = about_x(t, c->p);
}

/* ---- the same by any rotation, and by its transpose ---- */

MBSRI_INLINE mat transposed(const mat *A)
{
    return (mat){{A->x.x, A->y.x, A->z.x}, {A->x.y, A->y.y, A->z.y}, {A->x.z, A->y.z, A->z.z}};
}

MBSRI_INLINE mat product(const mat *A, const mat *B)
{
    return (mat){times(A, B->x), times(A, B->y), times(A, B->z)};
}

MBSRI_INLINE mat mat_turned(const mat *R, const mat *G)
{
    const mat back = transposed(R), first = product(R, G);
    return product(&first, &back);
}

MBSRI_INLINE sym sym_turned(const mat *R, const sym *S)
{
    const mat full = {{S->xx, S->xy, S->xz}, {S->xy, S->yy, S->yz}, {S->xz, S->yz, S->zz}},
              A = mat_turned(R, &full);
    return (sym){A.x.x, A.y.y, A.z.z, A.y.x, A.z.x, A.z.y};
}

MBSRI_INLINE void turn_carry(const mat *R, carry *c)
{
    c->I = sym_turned(R, &c->I);
    c->G = mat_turned(R, &c->G);
    c->M = sym_turned(R, &c->M);
    c->L = times(R, c->L);
    c->p = times(R, c->p);
}

MBSRI_INLINE void turn_carry_back(const mat *R, carry *c)
{
    const mat back = transposed(R);
    turn_carry(&back, c);
}

/* ---- to another point ---- */

/* From a body's origin to its predecessor's, which is r before it: with r for [r]x
 *   G' = G - M r,  I + r G' + (r G)^T,  L + r p */
MBSRI_INLINE void translate(vec r, carry *c)
{
    const sym *M = &c->M;
    const mat G = c->G, N = {{G.x.x - M->xy * r.z + M->xz * r.y, G.x.y - M->yy * r.z + M->yz * r.y,
                              G.x.z - M->yz * r.z + M->zz * r.y},
                             {G.y.x - M->xz * r.x + M->xx * r.z, G.y.y - M->yz * r.x + M->xy * r.z,
                              G.y.z - M->zz * r.x + M->xz * r.z},
                             {G.z.x - M->xx * r.y + M->xy * r.x, G.z.y - M->xy * r.y + M->yy * r.x,
                              G.z.z - M->xz * r.y + M->yz * r.x}};
    c->I.xx = c->I.xx + r.y * (N.x.z + G.x.z) - r.z * (N.x.y + G.x.y);
    c->I.yy = c->I.yy + r.z * (N.y.x + G.y.x) - r.x * (N.y.z + G.y.z);
    c->I.zz = c->I.zz + r.x * (N.z.y + G.z.y) - r.y * (N.z.x + G.z.x);
    c->I.xy = c->I.xy + r.z * (N.x.x - G.y.y) + r.y * G.y.z - r.x * N.x.z;
    c->I.xz = c->I.xz + r.y * (G.z.z - N.x.x) + r.x * N.x.y - r.z * G.z.y;
    c->I.yz = c->I.yz + r.x * (N.y.y - G.z.z) + r.z * G.z.x - r.y * N.y.x;
    c->G = N;
    c->L = add(c->L, cross(r, c->p));
}

/* ---- sums ---- */

MBSRI_INLINE lanes larger(lanes a, lanes b)
{
    const lane_bits first = a > b;
    return (lanes)((first & (lane_bits)a) | (~first & (lane_bits)b));
}

/* Behind a leaf. Number by number, and so is what goes to the stack: copied as one piece, it would
 * not stay in registers. */
MBSRI_INLINE carry no_carry(void)
{
    const lanes zero = splat(0.0);
    const sym none = {zero, zero, zero, zero, zero, zero};
    return (carry){none, none, {no_vec(), no_vec(), no_vec()}, no_vec(), no_vec(), zero, zero};
}

MBSRI_INLINE void keep_carry(const carry *c, carry *to)
{
    const vec *from[5] = {&c->G.x, &c->G.y, &c->G.z, &c->L, &c->p};
    vec *const at[5] = {&to->G.x, &to->G.y, &to->G.z, &to->L, &to->p};
    to->I = c->I;
    to->M = c->M;
    for (int k = 0; k < 5; ++k) *at[k] = *from[k];
    to->kappa = c->kappa;
    to->spread = c->spread;
}

/* c += what other successors left. */
MBSRI_INLINE void add_carry(const carry *m, carry *c)
{
    add_to(&c->I, &m->I);
    add_to(&c->M, &m->M);
    c->G = (mat){add(c->G.x, m->G.x), add(c->G.y, m->G.y), add(c->G.z, m->G.z)};
    c->L = add(c->L, m->L);
    c->p = add(c->p, m->p);
    c->kappa = larger(m->kappa, c->kappa);
    c->spread += m->spread;
}

/* Own inertia, and the gyroscopic force. */
MBSRI_INLINE void add_own(const mbsri_batch_body *b, const body_state *s, carry *c)
{
    const sym I = {splat(b->I[0]), splat(b->I[1]), splat(b->I[2]),
                   splat(b->I[3]), splat(b->I[4]), splat(b->I[5])};
    const vec h = vec_of(b->c);
    const lanes mass = splat(b->mass);
    add_to(&c->I, &I);
    /* G = -[h]x */
    c->G.x.y -= h.z, c->G.x.z += h.y;
    c->G.y.x += h.z, c->G.y.z -= h.x;
    c->G.z.x -= h.y, c->G.z.y += h.x;
    c->M.xx += mass, c->M.yy += mass, c->M.zz += mass;
    c->L = add(c->L, s->column.g_L);
    c->p = add(c->p, s->column.g_p);
}

#endif
