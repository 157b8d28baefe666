/* Closures whose forces turn with one of their bodies: see follower.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/carried/follower.h"

#include "algebra/dense.h"
#include "newton/carried/carried.h"

bool mbsri_follower_open(mbsr_newton *w, const mbsr_data *d, int k, double c)
{
    mbsri_carried *v = &w->carried;
    const mbsri_closure *closure = (const mbsri_closure *)w->model->closures.data + k;
    const mbsri_loop *loop = v->loop + k;
    const mbsri_closure_turn turn = mbsri_turn_of(v, closure, loop);
    double *S = v->store + loop->S;
    const double *C = d->closure_C + closure->at;
    if (!mbsri_closure_may_turn(closure)) return false;
    for (int l = 0; l < closure->rows; ++l) {
        if (d->dropped[closure->row + l]) return false;
    }
    if (!mbsri_closure_turns(closure, C, S, &turn)) return false;
    mbsri_closure_turn_over(closure, c, C, &turn, S, v->store + loop->slope);
    return true;
}

void mbsri_follower_load(mbsr_newton *w)
{
    const mbsri_carried *v = &w->carried;
    const mbsri_closure *all = w->model->closures.data;
    for (int k = v->first_follower; k >= 0; k = v->loop[k].next_follower) {
        const mbsri_closure *c = all + k;
        const mbsri_closure_turn turn = mbsri_turn_of(v, c, v->loop + k);
        const mbsri_multiplier *eta = v->multiplier + mbsri_name_eta(w->model, c, 0);
        double r[MBSR_CLOSURE_ROWS];
        for (int l = 0; l < c->rows; ++l) r[l] = v->store[eta[l].right];
        for (int j = c->column[1]; j < c->columns; ++j)
            turn.load[j] = mbsri_dot(c->rows, turn.Y + j * c->rows, r);
    }
}

void mbsri_follower_finish(mbsr_newton *w)
{
    const mbsri_carried *v = &w->carried;
    const mbsri_closure *all = w->model->closures.data;
    for (int k = v->first_follower; k >= 0; k = v->loop[k].next_follower) {
        const mbsri_closure_turn turn = mbsri_turn_of(v, all + k, v->loop + k);
        for (int l = 0; l < all[k].rows; ++l)
            v->value[mbsri_name_lambda(all + k, l)] -= turn.shift[l];
    }
}

void mbsri_follower_load_transposed(mbsr_newton *w)
{
    const mbsri_carried *v = &w->carried;
    const mbsri_closure *all = w->model->closures.data;
    for (int k = v->first_follower; k >= 0; k = v->loop[k].next_follower) {
        const mbsri_closure *c = all + k;
        const mbsri_closure_turn turn = mbsri_turn_of(v, c, v->loop + k);
        const mbsri_multiplier *eta = v->multiplier + mbsri_name_eta(w->model, c, 0);
        for (int l = 0; l < c->rows; ++l) {
            double *right = v->store + eta[l].right;
            for (int j = c->column[1]; j < c->columns; ++j)
                *right += turn.Y[j * c->rows + l] * turn.load[j];
        }
    }
}

void mbsri_follower_finish_transposed(mbsr_newton *w)
{
    const mbsri_carried *v = &w->carried;
    const mbsri_closure *all = w->model->closures.data;
    for (int k = v->first_follower; k >= 0; k = v->loop[k].next_follower) {
        const mbsri_closure_turn turn = mbsri_turn_of(v, all + k, v->loop + k);
        for (int l = 0; l < all[k].rows; ++l)
            turn.shift[l] = -v->value[mbsri_name_lambda(all + k, l)];
    }
}
