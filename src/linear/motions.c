/* Motions as inputs of linear equations.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A motion s(t) of a joint or closure enters F(t, y, y') = 0 by its value, rate and acceleration.
 * Its acceleration is the input, value and rate are states beside x,
 *
 *   s' = v,  v' = w        E x' = A x - F_s s - F_v v - F_w w
 *
 * so that no column stands for the rate of an input. F_s and the others are central differences
 * of one model, in which the motion's function is one that adds to it. */
#include "linear/record.h"

#include "base/error.h"

#include <mbsrank/closure.h>

#include <string.h>

static const char name[] = "mbsr_linear_create";

/* Differences of fourth order: places, and weights over 12; steps of value, rate, acceleration of
 * turns, and of moves over what is far for the model. */
static const double places[] = {1.0, -1.0, 2.0, -2.0}, weights[] = {8.0, -8.0, -1.0, 1.0},
                    steps[] = {0x1p-12, 0x1p-10, 1.0};

/* ---- which motions there are ---- */

static int count_bits(int set)
{
    int count = 0;
    for (; set; set &= set - 1) ++count;
    return count;
}

/* What follows the motion of a stock joint; 0: it has none, or is no stock joint. */
static int driven_of(const mbsr_joint *joint)
{
    const mbsr_joint_table *planar = mbsr_joint_point_free().table;
    mbsr_joint_chain chain;
    int count = 0;
    if (!joint->motion) return 0;
    if (joint->table == planar) return count_bits(joint->option[1]);
    if (mbsr_joint_chain_of(joint, &chain)) return 0;
    for (int k = 0; k < chain.axes; ++k) count += chain.axis[k].driven != 0;
    return count;
}

/* Rows of a stock closure that follow its motion; 0: none, or it is one by functions. */
static int moved_rows(const mbsr_model *m, int closure)
{
    const double one[3] = {1.0, 0.0, 0.0};
    const int body[1] = {0}, coordinate[1] = {0};
    const mbsr_closure_def stock[] = {mbsr_closure_ball(0, NULL, 1, NULL),
                                      mbsr_closure_rows(0, NULL, 1, NULL, 1, one),
                                      mbsr_closure_body_rows(0, NULL, 1, NULL, 1, one),
                                      mbsr_closure_distance(0, NULL, 1, NULL, 1.0),
                                      mbsr_closure_coupling(1, body, coordinate, one, 0.0)};
    mbsr_closure_def def;
    int rows;
    if (mbsr_closure_definition(m, closure, &def) || !def.motion) return 0;
    for (size_t k = 0; k < sizeof stock / sizeof *stock; ++k) {
        if (def.table != stock[k].table) continue;
        return mbsr_closure_indices(m, closure, NULL, &rows, NULL, NULL) ? 0 : rows;
    }
    return 0;
}

int mbsri_motions_of(const mbsr_model *m, mbsr_signal_kind kind, int id)
{
    mbsr_body_def body;
    if (kind == MBSR_SIGNAL_CLOSURE_MOTION)
        return id >= 0 && id < mbsr_model_closures(m) ? moved_rows(m, id) : 0;
    return mbsr_body_definition(m, id, &body) ? 0 : driven_of(&body.joint);
}

/* Whether entry `part` of the motion of a stock joint moves the body, and does not turn it. */
static bool is_move(const mbsr_joint *joint, int part)
{
    mbsr_joint_chain chain;
    if (mbsr_joint_chain_of(joint, &chain) == MBSR_OK) {
        int k = 0;
        for (;; ++k) {
            if (chain.axis[k].driven && part-- == 0) break;
        }
        return chain.axis[k].kind == MBSR_AXIS_TRANSLATION;
    }
    int driven = joint->option[1];
    for (; part > 0; --part) driven &= driven - 1;
    return (driven & -driven) != MBSR_ANGLE;
}

/* What is far for the motion: 1 rad, or the length of the model. Rows of closures have it in sums
 * and products alone, which any step tells. */
static double span_of(const mbsr_model *m, const mbsr_signal *s)
{
    const double length = mbsr_model_length(m);
    mbsr_body_def body;
    const bool moves = s->kind == MBSR_SIGNAL_MOTION && !mbsr_body_definition(m, s->id, &body) &&
                       is_move(&body.joint, s->part);
    return moves && length > 0.0 ? length : 1.0;
}

/* ---- what they do ---- */

/* A motion with numbers added to value, rate and acceleration of one of its entries. */
typedef struct moved_motion {
    mbsr_motion_fn motion;
    void *user;
    int part;
    double added[3];
} moved_motion;

static int move_motion(void *user, double t, double *s, double *sdot, double *sddot)
{
    const moved_motion *m = user;
    const int status = m->motion(m->user, t, s, sdot, sddot);
    s[m->part] += m->added[0];
    sdot[m->part] += m->added[1];
    sddot[m->part] += m->added[2];
    return status;
}

/* A model that follows *moved instead, and data of it. */
static int make_moved(const mbsr_model *model, const mbsr_signal *s, moved_motion *moved,
                      mbsr_model **made, mbsr_data **data, mbsr_error *error)
{
    mbsr_body_def body;
    mbsr_closure_def closure;
    const bool of_closure = s->kind == MBSR_SIGNAL_CLOSURE_MOTION;
    int status = of_closure ? mbsr_closure_definition(model, s->id, &closure)
                            : mbsr_body_definition(model, s->id, &body);
    if (!status) status = mbsr_model_copy(model, made, error);
    if (status) return status;
    moved->motion = of_closure ? closure.motion : body.joint.motion;
    moved->user = of_closure ? closure.user : body.joint.user;
    status = of_closure ? mbsr_model_drive_closure(*made, s->id, move_motion, moved)
                        : mbsr_model_drive(*made, s->id, move_motion, moved);
    if (!status) status = mbsr_model_finish(*made);
    if (!status) status = mbsr_data_create(*made, data, error);
    if (status == MBSR_OK) return MBSR_OK;
    if (mbsr_model_error(*made)->status && error) *error = *mbsr_model_error(*made);
    mbsr_model_destroy(*made);
    return status;
}

/* Adds weight times the residual to r (size, with as many behind it), and times outputs to the
 * column `seen` of theirs. */
static int add_sample(const mbsr_linear *l, const mbsri_coordinates *c, const mbsr_model *m,
                      mbsr_data *d, const double *y, const double *yp, const mbsr_linear_opt *opt,
                      double weight, double *r, double *seen)
{
    double *F = r + c->size;
    int status = mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, c->t, y, yp, F);
    for (int i = 0; i < c->size && !status; ++i) r[i] += weight * F[i];
    if (!status) status = mbsr_stage_positions(m, d, c->t, y);
    if (!status) status = mbsr_stage_velocities(m, d, y + c->nq + c->nu);
    for (int i = 0; i < l->outputs && !status; ++i) {
        const mbsr_signal *s = opt->output + i;
        double value[3] = {0.0};
        if (s->kind == MBSR_SIGNAL_POINT)
            status = mbsr_body_point(m, d, s->id, s->point, value, NULL, NULL);
        else if (s->kind == MBSR_SIGNAL_FORCE)
            status = mbsri_sample_force(m, d, s, &value[s->part % 3]);
        else
            continue;
        seen[i] += weight * value[s->part % 3];
    }
    return status;
}

int mbsri_motion_enter(mbsr_linear *l, const mbsri_coordinates *c, const double *y,
                       const double *yp, const mbsr_linear_opt *opt, int j, int at, double *r,
                       mbsr_error *error)
{
    const size_t size = (size_t)l->info.size, outputs = (size_t)l->outputs;
    const mbsr_signal *s = opt->input + j;
    double *A = l->part[MBSR_LINEAR_A], *B = l->part[MBSR_LINEAR_B] + (size_t)j * size,
           *const column[] = {A + (size_t)at * size, A + (size_t)(at + 1) * size, B},
           *const seen[] = {l->output + (size_t)at * outputs,
                            l->output + (size_t)(at + 1) * outputs,
                            l->direct + (size_t)j * outputs};
    moved_motion moved = {.part = s->part};
    mbsr_model *m;
    mbsr_data *d;
    int status = make_moved(c->model, s, &moved, &m, &d, error);
    if (status) return status;
    const double span = span_of(m, s);
    for (int order = 0; order < 3 && !status; ++order) {
        memset(r, 0, 2 * (size_t)c->size * sizeof *r);
        const double step = span * steps[order];
        for (int k = 0; k < 4 && !status; ++k) {
            moved.added[order] = places[k] * step;
            status = add_sample(l, c, m, d, y, yp, opt, weights[k] / (12.0 * step), r, seen[order]);
        }
        moved.added[order] = 0.0;
        mbsri_pencil_rows(c, r, -1.0, column[order]);
    }
    if (status) {
        const mbsr_error *why = mbsr_data_error(d);
        (void)mbsri_fail(error, status, why->body, why->force, "%s: along input %d: %s", name, j,
                         why->text);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    double *E = l->part[MBSR_LINEAR_E];
    E[(size_t)at * (size + 1)] = E[(size_t)(at + 1) * (size + 1)] = 1.0;
    column[1][at] = 1.0; /* s' = v */
    B[at + 1] = 1.0;     /* v' = w */
    return status;
}
