/* Values of seeds: what a parameter changes where it stands.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Inertias: forces are polynomials of second degree at most in mass, centre and tensor, so that one
 * central difference is their derivative. Laws of elements are differenced, one at a time. Frames
 * of joints: what rides behind the frame is displaced by dr, and in the plane turned by theta,
 * against a frame c, that of the predecessor or of the body itself,
 *
 *   dr = s + theta x (r - pivot)       dv = omega_c x dr + theta x v_rel
 *   da = alpha_c x dr + omega_c x (omega_c x dr) + 2 omega_c x (theta x v_rel) + theta x a_rel
 *
 * with v_rel, a_rel seen in c. The force of the joint on the predecessor moves by dr, and against
 * the joint's axes. */
#include "derivatives/seed_values.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/space3.h"
#include "base/error.h"
#include "joints/planar.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/inertia.h"
#include "sweeps/embed.h"

#include <math.h>
#include <string.h>

/* ---- elements ---- */

/* Numbers of a body: f and tau; of the residual, rate of momentum and momentum behind them. */
static size_t numbers_of_body(const mbsri_seeds *s, const mbsri_body *b)
{
    return (size_t)(b->d + b->n + (s->use == MBSRI_SEED_RESIDUAL ? 2 * b->d : 0));
}

/* What the call of an element, defined as `def`, adds to f and tau of its bodies, `weight` times,
 * into `to`, body after body; copies of f and tau stand in the seeds' work. */
static int sample_element(const mbsri_seeds *s, const mbsr_model *m, mbsr_data *d,
                          const mbsri_force *force, const mbsr_force_def *def, int bodies,
                          double weight, double *to)
{
    double *const work = s->work;
    mbsr_force_args args = mbsri_force_args(d, force, bodies);
    double *at = work, *ground;
    args.force = def;
    for (int j = 0; j < bodies; ++j) {
        mbsr_force_body *body = d->element.bodies + j;
        if (body->id == MBSR_GROUND) continue;
        body->f = at;
        body->tau = at + body->d;
        at += body->d + body->n;
    }
    ground = at;
    mbsri_zero((size_t)(at - work) + (size_t)m->root.d, work);
    for (int j = 0; j < bodies; ++j)
        if (d->element.bodies[j].id == MBSR_GROUND) d->element.bodies[j].f = ground;
    const int status = force->def.table->evaluate(&args);
    if (status) return mbsri_force_failed(m, d, force, status, "evaluate");
    const double *x = work;
    for (int j = 0; j < bodies; ++j) {
        const mbsr_force_body *body = d->element.bodies + j;
        if (body->id == MBSR_GROUND) continue;
        const mbsri_body *b = m->body + mbsri_index(m, body->id);
        for (int k = 0; k < b->d + b->n; ++k) to[k] += weight * *x++;
        to += numbers_of_body(s, b);
    }
    return MBSR_OK;
}

/* The size of changes of a law's parameter. Coordinates of points are without a unit. */
static double span_of_law(const mbsr_model *m, const mbsri_parameter *p, double value)
{
    const bool way = strcmp(p->info.unit, "m") == 0 || strcmp(p->info.unit, "") == 0;
    return value != 0.0 ? fabs(value) : way && m->typical.length > 0.0 ? m->typical.length : 1.0;
}

/* Places and weights of a difference over `at`, in steps: central; or, where the element takes
 * another branch there, on the side on which it does not. */
typedef struct stencil {
    int count;
    double h, place[5], weight[5];
} stencil;

/* Whether the element, defined as `def`, is on the branch `side` where parameter x of it is moved
 * by up to `steps` times h. */
static bool stays_on(mbsr_data *d, const mbsri_force *force, int bodies, mbsr_force_def *def,
                     double *x, double side, double h, int steps)
{
    const double at = *x;
    bool stays = true;
    for (int k = 1; k <= steps && stays; ++k) {
        mbsr_force_args args = mbsri_force_args(d, force, bodies);
        args.force = def;
        *x = at + k * h;
        stays = def->table->side(&args) == side;
    }
    *x = at;
    return stays;
}

static stencil choose_stencil(mbsr_data *d, const mbsri_force *force, int bodies,
                              mbsr_force_def *def, double *x, double h)
{
    static const stencil one_sided = {
        5, 0.0, {0.0, 1.0, 2.0, 3.0, 4.0}, {-25.0, 48.0, -36.0, 16.0, -3.0}};
    enum { SHORTER = 8 }; /* by this, where there is a border on both sides */
    stencil central = {.count = 4, .h = h};
    for (int l = 0; l < 4; ++l) {
        central.place[l] = mbsri_difference_place(l);
        central.weight[l] = mbsri_difference_weight(l);
    }
    if (!def->table->side) return central;
    const mbsr_force_args args = mbsri_force_args(d, force, bodies);
    const double side = def->table->side(&args);
    for (int again = 0; again < 3; ++again, h /= SHORTER) {
        stencil other = one_sided;
        const bool up = stays_on(d, force, bodies, def, x, side, h, 4),
                   down = stays_on(d, force, bodies, def, x, side, -h, 4);
        if (up && down) break;
        other.h = up ? h : -h;
        if (up || down) return other;
    }
    central.h = h;
    return central;
}

/* One call of element `force`, for body i where it acts on every one. */
static int differentiate_law(const mbsri_seeds *s, const mbsri_parameter *p, const mbsr_model *m,
                             mbsr_data *d, const mbsri_force *force, int i, double *to)
{
    mbsr_force_def other = force->def;
    double *x = other.param + p->place;
    const double at = *x, h = mbsri_difference_step(at, span_of_law(m, p, at));
    const int bodies = mbsri_force_bodies(m, d, force, i);
    const stencil by = choose_stencil(d, force, bodies, &other, x, h);
    int status = MBSR_OK;
    for (int l = 0; l < by.count && !status; ++l) {
        *x = at + by.place[l] * by.h;
        status = sample_element(s, m, d, force, &other, bodies, by.weight[l] / (12.0 * by.h), to);
    }
    return status;
}

/* In the residual, behind each change of forces on a body: the rate of momentum that they make. */
static void flow_of_forces(const mbsri_seeds *s, const mbsri_seeded *p)
{
    const mbsri_seed *mu = NULL;
    int of_body = 0;
    for (size_t j = p->first; j < p->last; ++j) {
        const mbsri_seed *seed = s->seed + j;
        if (seed->place != MBSRI_SEED_ACTION) continue;
        if (of_body == 0) mu = seed;
        for (int k = 0; k < seed->count && of_body == 1; ++k)
            s->value[seed->value + (size_t)k] = -s->value[mu->value + (size_t)k];
        of_body = (of_body + 1) % 3;
    }
}

static int law_values(mbsri_seeds *s, const mbsri_seeded *p, const mbsr_model *m, mbsr_data *d)
{
    const mbsri_force *force = mbsri_force_at(m, (size_t)p->index);
    const bool every = (force->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
    double *value = s->value + s->seed[p->first].value;
    int status = MBSR_OK;
    if (mbsri_force_off(m, d, force)) return MBSR_OK;
    for (int i = 1; i <= (every ? m->bodies : 1) && !status; ++i) {
        status = differentiate_law(s, &p->parameter, m, d, force, i, value);
        value += numbers_of_body(s, m->body + i);
    }
    if (s->use == MBSRI_SEED_RESIDUAL) flow_of_forces(s, p);
    return status;
}

/* ---- inertias ---- */

static double size_of_inertia(const mbsr_model *m, const mbsr_inertia *inertia,
                              mbsr_parameter_part part)
{
    const double length = m->typical.length > 0.0 ? m->typical.length : 1.0,
                 typical = m->typical.mass > 0.0 ? m->typical.mass : 1.0,
                 mass = inertia->mass > 0.0 ? inertia->mass : typical;
    if (part == MBSR_PARAMETER_MASS) return mass;
    if (part == MBSR_PARAMETER_COM) return length;
    double moment = fabs(inertia->moment);
    for (int k = 0; k < 6; ++k) moment = fmax(moment, fabs(inertia->tensor[k]));
    return moment > 0.0 ? moment : mass * length * length;
}

static double *number_of_inertia(mbsr_inertia *inertia, const mbsri_parameter *p)
{
    switch (p->info.part) {
    case MBSR_PARAMETER_MASS: return &inertia->mass;
    case MBSR_PARAMETER_COM: return inertia->com + p->place;
    case MBSR_PARAMETER_TENSOR: return inertia->tensor + p->place;
    default: return &inertia->moment;
    }
}

/* f - M A of a body like body i, `weight` times, into `to`, with tau of elements behind it. */
static int sample_inertia(const mbsri_seeds *s, const mbsri_body *like, int i, const mbsr_model *m,
                          mbsr_data *d, double weight, double *to)
{
    const size_t n = (size_t)like->d;
    double *M = s->work + s->longest, *f = M + n * n, *h = f + n;
    const double *p = d->p + like->p, *V = d->V + like->v;
    mbsri_inertia_mass(like, p, M);
    int status = mbsri_inertia_velocity(like, d->t, p, V, M, h);
    mbsri_zero(n, f);
    mbsri_inertia_times(like, p, M, -1.0, d->A + like->v, f);
    for (size_t k = 0; k < n; ++k) to[k] += weight * (f[k] - h[k]);
    for (int k = 0; k < m->elements.anywhere && !status; ++k) {
        const mbsri_force *force = mbsri_force_at(m, (size_t)k);
        if (force->def.table->flags & MBSR_FORCE_NO_MASS || mbsri_force_off(m, d, force)) continue;
        const int bodies = mbsri_force_bodies(m, d, force, i);
        d->element.bodies->M = M;
        d->element.bodies->inertia = &like->inertia;
        status = sample_element(s, m, d, force, &force->def, bodies, weight, to);
    }
    if (s->use != MBSRI_SEED_RESIDUAL || status) return status;
    /* -M V, and of its rate what does not stand in f - M A - h: - M A - M' V */
    double *flow = to + like->d + like->n, *momentum = flow + like->d, *rate = M + n * n + 2 * n;
    mbsri_inertia_mass(like, p, M);
    mbsri_inertia_times(like, p, M, -weight, V, momentum);
    mbsri_inertia_times(like, p, M, -weight, d->A + like->v, flow);
    mbsri_inertia_mass_rate(like, p, V, M, rate);
    mbsri_ax(like->d, like->d, -weight, rate, V, flow);
    return MBSR_OK;
}

static int inertia_values(mbsri_seeds *s, const mbsri_seeded *p, const mbsr_model *m, mbsr_data *d)
{
    mbsri_body like = m->body[p->index];
    double *x = number_of_inertia(&like.inertia, &p->parameter);
    const double at = *x, h = size_of_inertia(m, &like.inertia, p->parameter.info.part);
    double *value = s->value + s->seed[p->first].value;
    int status = MBSR_OK;
    like.inertia.exact = 0;
    for (int side = 1; side >= -1 && !status; side -= 2) {
        *x = at + side * h;
        status = sample_inertia(s, &like, p->index, m, d, side / (2.0 * h), value);
    }
    for (int k = 0; k < like.d && s->use == MBSRI_SEED_RESIDUAL; ++k)
        value[like.d + like.n + k] -= value[k];
    return status;
}

/* ---- frames of joints ---- */

/* Whether j stands on i, as they were added, by welded bodies alone. */
static bool stands_on(const mbsr_model *m, int i, int j)
{
    const mbsri_body_entry *entry = m->entries.data;
    while (j > 0 && j != i) {
        j = mbsri_index(m, entry[m->body[j].id].parent);
        if (j <= m->live) break;
    }
    return j == i;
}

bool mbsri_rides(const mbsr_model *m, int i, int j)
{
    if (i == j) return true;
    return i > m->live && stands_on(m, i, j) && !stands_on(m, i, m->body[j].parent);
}

int mbsri_rate_as_given(const mbsri_body *b, int k)
{
    const double *at = b->lock.given_at;
    int free = 0;
    if (at && !isnan(at[k])) return -1;
    for (int j = 0; j < k; ++j) free += !at || isnan(at[j]);
    return free;
}

/* A body in space, as it is at the state: omega and v, alpha and a. */
typedef struct riding {
    double R[9], r[3], V[6], A[6];
} riding;

static int see_body(const mbsr_model *m, mbsr_data *d, int i, riding *out)
{
    const mbsri_body *b = m->body + i;
    if (i == 0) return mbsri_embedded_root(m, d, out->R, out->r, out->V, out->A);
    const int numbers = b->d < 6 ? b->d : 6;
    mbsri_embedded_pose(b->joint.space, d->p + b->p, out->R, out->r);
    mbsri_lift(numbers, d->V + b->v, out->V);
    mbsri_lift(numbers, d->A + b->v, out->A);
    return MBSR_OK;
}

/* How what rides behind a frame is moved against c. */
typedef struct shift {
    riding c;
    double s[3], theta[3], pivot[3];
    bool behind; /* the axes of the joint: B is moved, and c is the body itself */
} shift;

/* dr, and changes of pose, V and A of body j, angular parts first, as above. */
static void move_riding(const shift *by, const riding *j, double dr[3], double x[18])
{
    const double *omega = by->c.V, *alpha = by->c.A;
    double rho[3], v[3], a[3], w[3], e[3], turn[3], from[3];
    for (int k = 0; k < 3; ++k) {
        rho[k] = j->r[k] - by->c.r[k];
        from[k] = j->r[k] - by->pivot[k];
        w[k] = j->V[k] - omega[k];
        e[k] = j->A[k] - alpha[k];
        v[k] = j->V[3 + k] - by->c.V[3 + k];
        a[k] = j->A[3 + k] - by->c.A[3 + k];
        dr[k] = by->s[k];
    }
    mbsri_add_cross3(by->theta, from, dr);
    double part[3];
    mbsri_cross3(omega, rho, part);
    mbsri_add3(-1.0, part, v);
    mbsri_cross3(omega, part, turn);
    mbsri_add3(-1.0, turn, a);
    mbsri_cross3(alpha, rho, part);
    mbsri_add3(-1.0, part, a);
    mbsri_cross3(omega, v, part);
    mbsri_add3(-2.0, part, a);
    mbsri_cross3(omega, w, part);
    mbsri_add3(-1.0, part, e);
    memset(x, 0, 18 * sizeof *x);
    memcpy(x, by->theta, sizeof by->theta);
    memcpy(x + 3, dr, 3 * sizeof *dr);
    double *dV = x + 6, *dA = x + 12;
    mbsri_cross3(by->theta, w, turn); /* omega_rel turns */
    mbsri_add3(1.0, turn, dV);
    mbsri_add_cross3(omega, turn, dA);
    mbsri_add_cross3(by->theta, e, dA);
    mbsri_cross3(by->theta, v, turn); /* v_rel */
    mbsri_cross3(omega, dr, part);
    mbsri_add3(1.0, part, dV + 3);
    mbsri_add3(1.0, turn, dV + 3);
    mbsri_add_cross3(omega, part, dA + 3);
    mbsri_add_cross3(alpha, dr, dA + 3);
    mbsri_cross3(omega, turn, part);
    mbsri_add3(2.0, part, dA + 3);
    mbsri_add_cross3(by->theta, a, dA + 3);
}

/* What it is, from the place in param. */
static int find_frame_shift(const mbsri_seeded *p, const mbsr_model *m, mbsr_data *d, shift *by)
{
    const mbsri_body_entry *entry =
        (const mbsri_body_entry *)m->entries.data + p->parameter.info.id;
    const double *param = (const double *)m->stored.matrices.data + entry->param;
    int free, place = p->parameter.place;
    const bool flat = mbsri_planar_coordinates(entry->joint.table, entry->joint.option, &free);
    const int B = flat ? 3 : MBSRI_B;
    *by = (shift){.behind = place >= B};
    if (by->behind) place -= B;
    const double sign = by->behind ? -1.0 : 1.0, *origin = by->behind ? param + B : param;
    const int status =
        see_body(m, d, by->behind ? p->index : mbsri_index(m, entry->parent), &by->c);
    if (status) return status;
    const double *R = by->c.R;
    if (flat && place == 2) {
        by->theta[2] = sign;
        for (int k = 0; k < 3; ++k)
            by->pivot[k] = by->c.r[k] + R[k] * origin[0] + R[3 + k] * origin[1];
    } else {
        for (int k = 0; k < 3; ++k) by->s[k] = sign * R[3 * place + k];
    }
    return MBSR_OK;
}

int mbsri_frame_change(const mbsri_seeded *p, const mbsr_model *m, mbsr_data *d, double x[18],
                       bool *behind)
{
    shift by;
    riding at;
    double dr[3];
    int status = find_frame_shift(p, m, d, &by);
    if (!status) status = see_body(m, d, p->index, &at);
    if (status) return status;
    move_riding(&by, &at, dr, x);
    *behind = by.behind;
    return MBSR_OK;
}

/* Six numbers in space as those of a body of d. */
static void lower_six(int d, const double lifted[6], double *x)
{
    mbsri_zero((size_t)d, x);
    mbsri_lower(d < 6 ? d : 6, lifted, x);
}

/* Moments of an action of six numbers, displaced by dr; to the predecessor, into to; and `load`: on
 * the joint, along its axes, which turn by theta, or of the body's own frame stay. */
static void displace_action(const shift *by, bool own, const mbsri_body *b, const double *J,
                            const double *action, const double dr[3], double moment[6],
                            double *load)
{
    const int numbers = b->d < 6 ? b->d : 6;
    double mu[6], axis[6], turned[3];
    mbsri_lift(numbers, action, mu);
    mbsri_cross3(dr, mu + 3, moment);
    for (int k = 0; k < b->n; ++k) {
        mbsri_lift(numbers, J + (size_t)k * (size_t)b->d, axis);
        if (own && by->behind) {
            load[k] += mbsri_dot3(axis, moment);
            continue;
        }
        mbsri_cross3(by->theta, axis, turned);
        load[k] += mbsri_dot3(turned, mu);
        mbsri_cross3(by->theta, axis + 3, turned);
        load[k] += mbsri_dot3(turned, mu + 3);
    }
}

static double *next_value(const mbsri_seeds *s, size_t *seed)
{
    return s->value + s->seed[(*seed)++].value;
}

/* Of the residual, behind those of mu: momentum m and its rate, on the predecessor and the joint,
 *
 *   d(J^T m)    d(J'^T m + J^T sigma)    d(H^T sigma + H'^T m)    d(H^T m)
 */
static size_t ride_with_momentum(mbsri_seeds *s, size_t seed, const shift *by, bool own,
                                 const mbsri_body *b, const mbsr_data *d, const double dr[3],
                                 const double rate[3])
{
    const double *m = d->imp + b->v, *J = d->J + b->dn;
    double spare[6] = {0.0}, of_m[6] = {0.0}, flow[6] = {0.0}, more[6] = {0.0},
           *pulse = b->n > 0 ? next_value(s, &seed) : spare,
           *drift = b->n > 0 ? next_value(s, &seed) : spare;
    displace_action(by, own, b, J, m, dr, of_m, pulse);
    displace_action(by, own, b, J, d->sigma + b->v, dr, flow, drift);
    displace_action(by, own, b, d->Jdot + b->dn, m, dr, more, drift);
    mbsri_zero(6, more);
    mbsri_lift(b->d < 6 ? b->d : 6, m, spare);
    mbsri_cross3(rate, spare + 3, more);
    for (int k = 0; k < b->n && own && by->behind; ++k) {
        double axis[6];
        mbsri_lift(b->d < 6 ? b->d : 6, J + (size_t)k * (size_t)b->d, axis);
        drift[k] += mbsri_dot3(axis, more);
    }
    mbsri_add3(1.0, more, flow);
    if (b->parent == 0) return seed;
    lower_six(b->pred.d, flow, next_value(s, &seed));
    lower_six(b->pred.d, of_m, next_value(s, &seed));
    return seed;
}

/* Seeds of body j; returns where those behind it begin. */
static size_t ride(mbsri_seeds *s, size_t seed, const shift *by, bool own, const mbsri_linear *l,
                   mbsr_data *d, int j)
{
    const mbsri_body *b = l->model->body + j;
    const int e = l->e[j];
    riding at;
    double dr[3], x[18], moment[6] = {0.0}, none[6] = {0.0};
    (void)see_body(l->model, d, j, &at);
    move_riding(by, &at, dr, x);
    double *to = next_value(s, &seed), *load = none;
    mbsri_zero((size_t)(e + 2 * b->d), to);
    lower_six(e < b->d ? e : b->d, x, to);
    lower_six(b->d, x + 6, to + e);
    lower_six(b->d, x + 12, to + e + b->d);
    double *below = b->parent > 0 ? next_value(s, &seed) : NULL;
    if (b->n > 0) load = next_value(s, &seed);
    displace_action(by, own, b, d->J + b->dn, d->mu + b->v, dr, moment, load);
    if (below) lower_six(b->pred.d, moment, below);
    if (s->use != MBSRI_SEED_RESIDUAL) return seed;
    return ride_with_momentum(s, seed, by, own, b, d, dr, x + 9);
}

static int frame_values(mbsri_seeds *s, const mbsri_seeded *p, const mbsri_linear *l, mbsr_data *d)
{
    const mbsr_model *m = l->model;
    shift by;
    const int status = find_frame_shift(p, m, d, &by);
    size_t seed = p->first;
    for (int j = 1; j <= m->bodies && !status; ++j) {
        if (mbsri_rides(m, p->index, j)) seed = ride(s, seed, &by, j == p->index, l, d, j);
    }
    return status;
}

/* ---- all ---- */

/* Of a stiff row with unknown y, stiffness k and damping c in F: lambda = -(y + c y' / k), and y'
 * / k and -y / k in its rows. */
static void rows_of_spring(mbsri_seeds *s, const mbsri_seeded *p, const mbsri_closure *c,
                           const mbsr_data *d)
{
    const int place = p->parameter.place, row = c->row + place;
    const double k = c->def.stiffness[place], rate = s->loops_rate[row];
    size_t seed = p->first;
    double *lambda = next_value(s, &seed);
    if (p->parameter.info.part == MBSR_PARAMETER_DAMPING) {
        *lambda = -rate / k;
        return;
    }
    *lambda = c->def.damping[place] * rate / (k * k);
    *next_value(s, &seed) = -rate / (k * k);
    if (place < c->position_rows && !d->dropped[row])
        *next_value(s, &seed) = s->loops[row] / (k * k);
}

static int spring_values(mbsri_seeds *s, const mbsri_seeded *p, const mbsr_model *m, mbsr_data *d,
                         double *value)
{
    const mbsri_closure *c = mbsri_closure_at(m, (size_t)p->index);
    const int row = p->parameter.place;
    double *rate = s->sum[MBSRI_SEED_SPRING];
    int status = MBSR_OK;
    if (s->use == MBSRI_SEED_RESIDUAL) {
        rows_of_spring(s, p, c, d);
    } else if (p->parameter.info.part == MBSR_PARAMETER_STIFFNESS) {
        status = mbsri_closure_gaps(m, d, rate);
        *value = -rate[c->position_row + row];
    } else {
        status = mbsri_closure_rates(m, d, rate);
        *value = -rate[c->row + row];
    }
    return status;
}

/* A joint's missing force by its own inertia, and in the residual its missing momentum. */
static void armature_values(mbsri_seeds *s, const mbsri_seeded *p, const mbsri_body *b,
                            const mbsr_data *d)
{
    const int k = b->iu + mbsri_rate_as_given(b, p->parameter.place);
    size_t seed = p->first;
    *next_value(s, &seed) = d->udot[k];
    if (seed < p->last) *next_value(s, &seed) = d->u[k];
}

int mbsri_seed_values(mbsri_seeds *s, const mbsri_seeded *p, const mbsri_linear *l, mbsr_data *d)
{
    const mbsr_model *m = l->model;
    double *value = s->value + s->seed[p->first].value;
    for (size_t j = p->first; j < p->last; ++j)
        mbsri_zero((size_t)s->seed[j].count, s->value + s->seed[j].value);
    switch (p->parameter.info.part) {
    case MBSR_PARAMETER_MASS:
    case MBSR_PARAMETER_COM:
    case MBSR_PARAMETER_TENSOR:
    case MBSR_PARAMETER_MOMENT: return inertia_values(s, p, m, d);
    case MBSR_PARAMETER_ARMATURE: armature_values(s, p, m->body + p->index, d); return MBSR_OK;
    case MBSR_PARAMETER_JOINT: return frame_values(s, p, l, d);
    case MBSR_PARAMETER_LAW: return law_values(s, p, m, d);
    case MBSR_PARAMETER_STIFFNESS:
    case MBSR_PARAMETER_DAMPING: return spring_values(s, p, m, d, value);
    case MBSR_PARAMETER_POINT:
    case MBSR_PARAMETER_TABLE_VALUE: break;
    }
    return MBSR_OK;
}
