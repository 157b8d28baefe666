/* Derivatives of force elements with respect to the pose, V, q and u of their bodies: the element's
 * own, or differences.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Differences (differences.h) are taken of one variable at a time, with copies of the bodies in the
 * work memory. Steps of velocities follow from those of positions by a rate: the table's or the
 * tree's (recursion/spans.h), without gravity with the sizes f_k of the element's forces and s_k of
 * the coordinates they belong to sqrt(f_k s_k / m l^2). The orientation of a SPATIAL body is
 * displaced by R <- exp([h e_k]x) R. */
#include "newton/slopes/force_slopes.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "forces/columns.h"
#include "model/query.h"
#include "recursion/elements.h"
#include "recursion/inertia.h"
#include "recursion/kinematics.h"
#include "recursion/pose.h"
#include "recursion/spans.h"

#include <math.h>

/* ---- sizes and places ---- */

/* Of one call of an element: rows and columns of its matrix; numbers of the copies of its bodies;
 * most_d of any of them. */
typedef struct extent {
    size_t rows, columns, copies, most_d;
} extent;

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

static void add_body(const mbsri_body *b, extent *e)
{
    const size_t d = (size_t)b->d, n = (size_t)b->n, nq = (size_t)b->nq;
    e->copies += (size_t)b->np + d + nq + n + d * d;
    e->most_d = larger(e->most_d, d);
    if (b->parent < 0) return;
    e->rows += d + n;
    e->columns += (size_t)mbsri_pose_size(b) + d + nq + n;
}

/* Matrix and work that one call needs. Of the work: the copies, the forces, and what nobody reads.
 * */
static void raise(const mbsr_model *m, const extent *e, size_t *matrix, size_t *work)
{
    *matrix = larger(*matrix, e->rows * e->columns);
    *work = larger(*work, e->copies + e->rows + larger((size_t)m->root.d, e->most_d));
}

/* One pair: twice the largest body. */
static void raise_pair(const mbsr_model *m, const mbsri_force *force, size_t *matrix, size_t *work)
{
    extent pair = {0, 0, 0, 0};
    for (int l = 0; l < force->def.bodies; ++l) {
        extent one = {0, 0, 0, 0};
        add_body(m->body + m->stored.list_index[force->list + (size_t)l], &one);
        pair.rows = larger(pair.rows, 2 * one.rows);
        pair.columns = larger(pair.columns, 2 * one.columns);
    }
    raise(m, &pair, matrix, work);
}

static void measure_room(const mbsr_model *m, mbsri_slopes_room room, size_t *matrix, size_t *work)
{
    const mbsri_force *force = m->forces.data;
    *matrix = *work = 0;
    for (size_t k = 0; k < m->forces.count; ++k, ++force) {
        extent whole = {0, 0, 0, 0};
        if (force->def.table->flags & MBSR_FORCE_BY_PAIRS && room == MBSRI_SLOPES_BY_PAIRS) {
            raise_pair(m, force, matrix, work);
            continue;
        }
        for (int l = 0; l < force->def.bodies; ++l)
            add_body(m->body + m->stored.list_index[force->list + (size_t)l], &whole);
        raise(m, &whole, matrix, work);
        const bool every = (force->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
        for (int i = 1; i <= m->bodies && every; ++i) {
            extent one = {0, 0, 0, 0};
            add_body(m->body + i, &one);
            raise(m, &one, matrix, work);
        }
    }
}

void mbsri_slopes_size(const mbsr_model *m, mbsri_slopes_room room, size_t *doubles, size_t *ints)
{
    size_t work;
    measure_room(m, room, doubles, &work);
    *doubles += work;
    *ints = 2 * (size_t)m->most.element_bodies;
}

void mbsri_slopes_place(const mbsr_model *m, mbsri_slopes_room room, mbsri_slopes *s,
                        double *doubles, int *ints)
{
    size_t matrix, work;
    measure_room(m, room, &matrix, &work);
    s->row = ints;
    s->column = ints + m->most.element_bodies;
    s->matrix = doubles;
    s->work = doubles ? doubles + matrix : NULL; /* NULL: a model without elements */
    s->out = (mbsr_force_derivatives){.matrix = s->matrix, .row = s->row, .column = s->column};
}

/* Rows and columns of the bodies of a call. */
static void place_rows(mbsri_slopes *s, int bodies, const mbsr_force_body *body)
{
    int rows = 0, columns = 0;
    for (int k = 0; k < bodies; ++k) {
        const bool ground = body[k].id == MBSR_GROUND;
        s->row[k] = ground ? -1 : rows;
        s->column[k] = ground ? -1 : columns;
        if (ground) continue;
        rows += body[k].d + body[k].n;
        columns += mbsri_u_column(body + k, 0) + body[k].n;
    }
    s->out.rows = rows;
    s->out.columns = columns;
}

/* And a matrix of zeros. */
static void lay_out(mbsri_slopes *s, int bodies, const mbsr_force_body *body)
{
    place_rows(s, bodies, body);
    mbsri_zero((size_t)s->out.rows * (size_t)s->out.columns, s->matrix);
}

/* ---- differences ---- */

/* One call of an element that is differenced. */
typedef struct differences {
    const mbsr_model *m;
    mbsr_data *d;
    const mbsri_force *force;
    mbsri_slopes *s;
    mbsr_force_args args; /* body: those of the data, turned to the copies */
    double *forces;       /* rows, what evaluate writes */
    double *sink; /* forces on the ground, gyroscopic forces that come with a mass by function */
    mbsri_spans spans;
    double energy; /* of note_energy */
} differences;

/* A copy of count numbers (none for NULL); moves *work on. */
static const double *copy(double **work, int count, const double *from)
{
    double *to = *work;
    if (!from) return NULL;
    mbsri_copy((size_t)count, from, to);
    *work += count;
    return to;
}

/* The bodies of the call turned from the data to copies, and their forces to the work. */
static void detach(differences *w)
{
    mbsr_force_body *body = w->d->element.bodies;
    double *work = w->s->work;
    const bool joint_only = (w->force->def.table->flags & MBSR_FORCE_JOINT_ONLY) != 0;
    for (int k = 0; k < w->args.bodies; ++k) {
        mbsr_force_body *b = body + k;
        b->p = copy(&work, b->np, b->p);
        b->V = copy(&work, b->d, b->V);
        b->M = copy(&work, b->d * b->d, b->M);
        b->q = copy(&work, b->nq, b->q);
        b->u = copy(&work, b->n, b->u);
    }
    w->forces = work;
    w->sink = w->forces + w->s->out.rows;
    for (int k = 0; k < w->args.bodies; ++k) {
        const bool ground = w->s->row[k] < 0;
        if (!joint_only) body[k].f = ground ? w->sink : w->forces + w->s->row[k];
        if (!ground) body[k].tau = w->forces + w->s->row[k] + body[k].d;
    }
}

/* Largest energy of the forces over their spans so far, J. */
static void note_energy(differences *w)
{
    for (int k = 0; k < w->args.bodies; ++k) {
        const mbsr_force_body *body = w->args.body + k;
        const mbsri_body *b = w->m->body + mbsri_index(w->m, body->id);
        if (w->s->row[k] < 0) continue;
        const double *f = w->forces + w->s->row[k], *tau = f + body->d;
        for (int c = 0; c < body->d; ++c)
            w->energy = fmax(w->energy, fabs(f[c]) * mbsri_pose_span(&w->spans, b, c));
        for (int c = 0; c < body->n; ++c)
            w->energy =
                fmax(w->energy, fabs(tau[c]) * mbsri_coordinate_span(&w->spans, w->m, b, true, c));
    }
}

/* column += factor times the forces of the bodies as they are */
static int sample(differences *w, double factor, double *column)
{
    mbsri_zero((size_t)(w->s->out.rows + w->m->root.d), w->forces);
    const int status = w->force->def.table->evaluate(&w->args);
    if (status) return mbsri_force_failed(w->m, w->d, w->force, status, "evaluate");
    for (int k = 0; k < w->s->out.rows; ++k) column[k] += factor * w->forces[k];
    if (!(w->spans.rate > 0.0)) note_energy(w);
    return MBSR_OK;
}

/* Largest rate of the bodies of the call, 1/s. */
static double speed_of(const differences *w)
{
    const bool joint_only = (w->force->def.table->flags & MBSR_FORCE_JOINT_ONLY) != 0;
    double speed = 0.0;
    for (int k = 0; k < w->args.bodies; ++k) {
        const mbsr_force_body *body = w->args.body + k;
        const mbsri_body *b = w->m->body + mbsri_index(w->m, body->id);
        if (!joint_only) speed = fmax(speed, mbsri_twist_rate(&w->spans, b, body->V));
        for (int c = 0; c < body->n; ++c)
            speed =
                fmax(speed, fabs(body->u[c]) / mbsri_coordinate_span(&w->spans, w->m, b, true, c));
    }
    return speed;
}

/* Rate of the coordinates: the table's, or the larger one of that of gravity or of the forces so
 * far and of its geometric mean with the bodies' own. */
static double rate_of(const differences *w)
{
    const double inertia = w->m->typical.mass * w->m->typical.length * w->m->typical.length,
                 known = w->spans.rate;
    if (w->force->def.table->scales.time > 0.0) return known;
    const double slow = known > 0.0     ? known
                        : inertia > 0.0 ? sqrt(w->energy / inertia)
                                        : 0.0,
                 speed = speed_of(w), rate = slow > 0.0 ? fmax(slow, sqrt(slow * speed)) : speed;
    return rate > 0.0 && isfinite(rate) ? rate : 1.0;
}

/* A column of the matrix: derivative with respect to *x, a number of the copies. */
static int plain_column(differences *w, double *x, double span, double *column)
{
    const double at = *x, h = mbsri_difference_step(at, span);
    int status = MBSR_OK;
    for (int l = 0; l < 4 && !status; ++l) {
        *x = at + mbsri_difference_place(l) * h;
        status = sample(w, mbsri_difference_weight(l) / (12.0 * h), column);
    }
    *x = at;
    return status;
}

/* R <- exp([angle e_k]x) R */
static void turn(int k, double angle, double R[9])
{
    const double c = cos(angle), s = sin(angle);
    const int a = (k + 1) % 3, b = (k + 2) % 3;
    for (int j = 0; j < 9; j += 3) {
        const double x = R[j + a], y = R[j + b];
        R[j + a] = c * x - s * y;
        R[j + b] = s * x + c * y;
    }
}

/* M of body i, of its pose. */
static int renew_mass(const differences *w, int i, const mbsr_force_body *body, double *M)
{
    const mbsri_body *b = w->m->body + i;
    if (b->inertia.kind != MBSR_INERTIA_FUNCTION) {
        mbsri_inertia_mass(b, body->p, M);
        return MBSR_OK;
    }
    const int status = mbsri_inertia_velocity(b, w->d->t, body->p, body->V, M, w->sink);
    return status ? mbsri_joint_failed(w->m, w->d, i, status, "the inertia's function") : MBSR_OK;
}

/* Column c of body i's pose. The copies p and M are left as they were. */
static int pose_column(differences *w, int i, const mbsr_force_body *body, int c, double *p,
                       double *M, double *column)
{
    const mbsri_body *b = w->m->body + i;
    const double *at = w->d->p + b->p;
    const bool spatial = mbsri_turns(body->space), turned = spatial && c < 3;
    const int entry = spatial ? MBSR_POSE_X + c - 3 : c;
    const double h =
        mbsri_difference_step(turned ? 0.0 : at[entry], mbsri_pose_span(&w->spans, b, c));
    int status = MBSR_OK;
    for (int l = 0; l < 4 && !status; ++l) {
        mbsri_copy((size_t)body->np, at, p);
        if (turned)
            turn(c, mbsri_difference_place(l) * h, p + MBSR_POSE_R);
        else
            p[entry] += mbsri_difference_place(l) * h;
        if (M) status = renew_mass(w, i, body, M);
        if (!status) status = sample(w, mbsri_difference_weight(l) / (12.0 * h), column);
    }
    mbsri_copy((size_t)body->np, at, p);
    if (M) mbsri_copy((size_t)(b->d * b->d), w->d->M + b->dd, M);
    return status;
}

/* The columns of body k of the call. */
static int body_columns(differences *w, int k)
{
    const mbsr_force_body *body = w->args.body + k;
    const unsigned flags = w->force->def.table->flags;
    const int i = mbsri_index(w->m, body->id), rows = w->s->out.rows,
              pose = mbsri_V_column(body, 0);
    const mbsri_body *b = w->m->body + i;
    const mbsri_spans *spans = &w->spans;
    const bool joint_only = (flags & MBSR_FORCE_JOINT_ONLY) != 0;
    double *column = w->s->matrix + (size_t)w->s->column[k] * (size_t)rows;
    /* the copies again, to be written to: they are this file's own */
    double *p = (double *)body->p, *V = (double *)body->V, *M = (double *)body->M,
           *q = (double *)body->q, *u = (double *)body->u;
    if (flags & MBSR_FORCE_NO_MASS) M = NULL;
    int status = MBSR_OK;
    for (int c = 0; c < pose; ++c, column += rows) {
        if (!joint_only && !status) status = pose_column(w, i, body, c, p, M, column);
    }
    for (int c = 0; c < body->d; ++c, column += rows) {
        if (!joint_only && !status)
            status = plain_column(w, V + c, rate_of(w) * mbsri_pose_span(spans, b, c), column);
    }
    for (int c = 0; c < body->nq && !status; ++c, column += rows)
        status = plain_column(w, q + c, mbsri_coordinate_span(spans, w->m, b, false, c), column);
    for (int c = 0; c < body->n && !status; ++c, column += rows)
        status = plain_column(w, u + c, rate_of(w) * mbsri_coordinate_span(spans, w->m, b, true, c),
                              column);
    return status;
}

/* A call of an element whose bodies are copies. */
static differences prepare(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int body,
                           mbsri_slopes *s)
{
    differences w = {.m = m, .d = d, .force = force, .s = s};
    w.args = mbsri_force_args(d, force, mbsri_force_bodies(m, d, force, body));
    lay_out(s, w.args.bodies, w.args.body);
    detach(&w);
    w.spans = mbsri_spans_of(m, &force->def.table->scales);
    return w;
}

int mbsri_force_values(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int body,
                       mbsri_slopes *s, double *forces)
{
    differences w = prepare(m, d, force, body, s);
    mbsri_zero((size_t)s->out.rows, forces);
    return sample(&w, 1.0, forces);
}

int mbsri_force_differences(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int body,
                            mbsri_slopes *s)
{
    differences w = prepare(m, d, force, body, s);
    int status = MBSR_OK;
    for (int k = 0; k < w.args.bodies && !status; ++k) {
        if (s->row[k] >= 0) status = body_columns(&w, k);
    }
    return status;
}

/* ---- the element's own ---- */

/* Whether an element has its own. How a mass by function depends on the pose no element knows. */
static bool has_own(const mbsr_force_table *table, int bodies, const mbsr_force_body *body)
{
    if (!table->derivatives) return false;
    if (table->flags & (MBSR_FORCE_NO_MASS | MBSR_FORCE_JOINT_ONLY)) return true;
    for (int k = 0; k < bodies; ++k) {
        if (body[k].inertia && body[k].inertia->kind == MBSR_INERTIA_FUNCTION) return false;
    }
    return true;
}

/* The derivatives that the element adds to s->out. */
static int add_own(const mbsr_model *m, mbsr_data *d, const mbsri_force *force,
                   const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const int status = force->def.table->derivatives(args, out);
    return status ? mbsri_force_failed(m, d, force, status, "derivatives") : MBSR_OK;
}

/* Pair by pair. */
static int add_pairs(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, mbsri_slopes *s)
{
    int count;
    int status = mbsri_force_pairs(m, d, force, &count);
    for (int k = 0; k < count && !status; ++k) {
        const int *pair = d->element.pairs[k];
        const int row[2] = {s->row[pair[0]], s->row[pair[1]]},
                  column[2] = {s->column[pair[0]], s->column[pair[1]]};
        mbsr_force_derivatives out = s->out;
        const mbsr_force_body body[2] = {d->element.bodies[pair[0]], d->element.bodies[pair[1]]};
        mbsr_force_args args = mbsri_force_args(d, force, 2);
        out.row = row, out.column = column;
        args.body = body, args.pair = pair;
        status = add_own(m, d, force, &args, &out);
    }
    return status;
}

static int own_slopes(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int bodies,
                      mbsri_slopes *s)
{
    lay_out(s, bodies, d->element.bodies);
    if (force->def.table->flags & MBSR_FORCE_BY_PAIRS) return add_pairs(m, d, force, s);
    const mbsr_force_args args = mbsri_force_args(d, force, bodies);
    return add_own(m, d, force, &args, &s->out);
}

static int check_slopes(mbsr_data *d, const mbsr_model *m, const mbsri_force *force, int columns,
                        const double *matrix, const mbsri_slopes *s)
{
    if (mbsri_finite((size_t)s->out.rows * (size_t)columns, matrix)) return MBSR_OK;
    char label[MBSRI_LABEL];
    return mbsri_fail(
        &d->error, MBSR_NOT_FINITE, MBSR_NONE, force->id,
        "%s (%s): its derivatives are not finite at t = %g",
        mbsri_label(label, "force", force->id, (const char *)m->stored.names.data + force->name),
        force->def.table->name, d->t);
}

int mbsri_pair_slopes(const mbsr_model *m, mbsr_data *d, const mbsri_force *force,
                      const int pair[2], mbsri_slopes *s)
{
    const mbsr_force_body *body = d->element.bodies;
    double *motion[2];
    int count[2];
    mbsri_pair_bodies(m, d, force, pair);
    place_rows(s, 2, body);
    for (int k = 0; k < 2; ++k) {
        const bool ground = s->column[k] < 0;
        count[k] = ground ? 0 : mbsri_q_column(body + k, 0);
        motion[k] = s->matrix + (ground ? 0 : (size_t)s->column[k] * (size_t)s->out.rows);
        mbsri_zero((size_t)count[k] * (size_t)s->out.rows, motion[k]);
    }
    mbsr_force_args args = mbsri_force_args(d, force, 2);
    args.pair = pair;
    int status = add_own(m, d, force, &args, &s->out);
    for (int k = 0; k < 2 && !status; ++k)
        status = check_slopes(d, m, force, count[k], motion[k], s);
    return status;
}

/* Of an element that is on. */
static int find_slopes(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int body,
                       int bodies, mbsri_slopes *s)
{
    const int status = has_own(force->def.table, bodies, d->element.bodies)
                           ? own_slopes(m, d, force, bodies, s)
                           : mbsri_force_differences(m, d, force, body, s);
    return status ? status : check_slopes(d, m, force, s->out.columns, s->matrix, s);
}

int mbsri_force_slopes(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int body,
                       mbsri_slopes *s)
{
    const int bodies = mbsri_force_bodies(m, d, force, body);
    if (mbsri_force_off(m, d, force)) {
        lay_out(s, bodies, d->element.bodies);
        return MBSR_OK;
    }
    return find_slopes(m, d, force, body, bodies, s);
}
