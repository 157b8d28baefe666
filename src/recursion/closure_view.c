/* The bodies of a closure as its functions see them.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/closure_view.h"

#include "base/expect.h"

#include <math.h>

void mbsri_expect_closure(const mbsr_model *m, const mbsri_closure *c)
{
    enum { CLOSURES = 4, BODIES = 2 };
    if (m->bodies <= MBSRI_LARGE) return;
    const mbsri_closure *end = (const mbsri_closure *)m->closures.data + m->closures.count;
    if (end - c > CLOSURES) mbsri_expect(c + CLOSURES, c + CLOSURES + 1);
    if (end - c <= BODIES) return;
    c += BODIES;
    for (int k = 0; k < c->bodies; ++k) {
        const mbsri_body *b = m->body + c->body[k];
        mbsri_expect(b, &b->dd);
        mbsri_expect(&b->joint.space, &b->joint.space + 1);
    }
}

void mbsri_view_closure(const mbsr_model *m, const mbsr_data *d, const mbsri_closure *c,
                        bool velocities, mbsri_closure_view *view)
{
    for (int k = 0; k < c->bodies; ++k) {
        const int i = c->body[k];
        const mbsri_body *b = m->body + i;
        view->body[k] = (mbsr_force_body){.id = b->id,
                                          .space = b->joint.space,
                                          .d = b->d,
                                          .np = b->np,
                                          .n = b->n,
                                          .nq = b->nq,
                                          .locked_at = b->lock.given_at,
                                          .p = d->p + b->p,
                                          .q = i > 0 ? d->q + b->iq : NULL};
    }
    if (velocities) mbsri_view_velocities(m, d, c, view);
    view->q = d->closure_q;
    view->args =
        (mbsr_closure_args){.closure = &c->def, .t = d->t, .bodies = c->bodies, .body = view->body};
}

void mbsri_view_velocities(const mbsr_model *m, const mbsr_data *d, const mbsri_closure *c,
                           mbsri_closure_view *view)
{
    for (int k = 0; k < c->bodies; ++k) {
        const mbsri_body *b = m->body + c->body[k];
        view->body[k].V = d->V + b->v;
        view->body[k].u = c->body[k] > 0 ? d->u + b->iu : NULL;
    }
}

const char *mbsri_closure_row_name(const mbsr_model *m, const mbsri_closure *c, int k)
{
    mbsr_force_body body[MBSR_CLOSURE_BODIES + 1];
    if (!c->def.table->row) return "";
    for (int l = 0; l < c->bodies; ++l) {
        const mbsri_body *b = m->body + c->body[l];
        body[l] = (mbsr_force_body){
            .id = b->id, .space = b->joint.space, .d = b->d, .np = b->np, .n = b->n, .nq = b->nq};
    }
    const mbsr_closure_args args = {.closure = &c->def, .bodies = c->bodies, .body = body};
    if (!c->mix || k >= c->position_rows) return c->def.table->row(&args, k);
    int most = 0; /* of the rows that it combines, the one with the largest part */
    for (int l = 1; l < c->position_rows; ++l) {
        if (fabs(c->mix[k * c->position_rows + l]) > fabs(c->mix[k * c->position_rows + most]))
            most = l;
    }
    return c->def.table->row(&args, most);
}
