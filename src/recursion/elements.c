/* Applied forces f and joint forces tau: gyroscopic terms and all force elements.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/elements.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "forces/gravity.h"
#include "model/locked.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/not_finite.h"

/* Body i as force elements see it. The root drops what is added to it. */
static mbsr_force_body view(const mbsr_model *m, mbsr_data *d, int i, mbsri_question ask)
{
    const mbsri_body *b = m->body + i;
    mbsr_force_body body = {.id = b->id,
                            .space = b->joint.space,
                            .d = b->d,
                            .np = b->np,
                            .n = b->n,
                            .nq = b->nq,
                            .locked_at = b->lock.given_at,
                            .p = d->p + b->p,
                            .V = ask != MBSRI_ENERGY ? d->V + b->v : NULL,
                            .f = ask == MBSRI_FORCES ? d->f + b->v : NULL};
    if (i > 0) {
        body.M = d->M + b->dd;
        body.inertia = &b->inertia;
        body.q = d->q + b->iq;
        body.u = ask != MBSRI_ENERGY ? d->u + b->iu : NULL;
        body.tau = ask == MBSRI_FORCES ? d->tau + b->iu : NULL;
    }
    return body;
}

/* The same of a body whose joint alone counts, with q and u in the order of the sweeps. */
static mbsr_force_body view_joint(const mbsr_model *m, mbsr_data *d, int i, mbsri_question ask,
                                  const double *q, const double *u)
{
    mbsr_force_body body = view(m, d, i, ask);
    body.p = body.V = body.M = NULL;
    body.f = NULL;
    if (i == 0) return body;
    body.q = q + m->body[i].iq;
    body.u = u + m->body[i].iu;
    return body;
}

int mbsri_force_failed(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int status,
                       const char *function)
{
    char label[MBSRI_LABEL];
    d->element.text[MBSR_TEXT_SIZE - 1] = '\0';
    mbsri_label(label, "force", force->id, (const char *)m->stored.names.data + force->name);
    if (d->element.text[0])
        return mbsri_fail(&d->error, status, MBSR_NONE, force->id, "%s (%s): %.150s at t = %g",
                          label, force->def.table->name, d->element.text, d->t);
    return mbsri_fail(&d->error, status, MBSR_NONE, force->id, "%s (%s): %s returned %d at t = %g",
                      label, force->def.table->name, function, status, d->t);
}

bool mbsri_force_off(const mbsr_model *m, const mbsr_data *d, const mbsri_force *force)
{
    return d->element.off[force - (const mbsri_force *)m->forces.data];
}

mbsr_force_args mbsri_force_args(mbsr_data *d, const mbsri_force *force, int bodies)
{
    d->element.text[0] = '\0';
    return (mbsr_force_args){.force = &force->def,
                             .t = d->t,
                             .bodies = bodies,
                             .body = d->element.bodies,
                             .text = d->element.text,
                             .memory = d->element.memory + force->memory};
}

/* One call of an element; its energy or dissipation is added to *sum. */
static int call_element(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int bodies,
                        mbsri_question ask, double *sum)
{
    static const char *const names[] = {"evaluate", "energy", "dissipation"};
    const mbsr_force_table *table = force->def.table;
    const mbsr_force_args args = mbsri_force_args(d, force, bodies);
    double one = 0.0;
    int status = MBSR_OK;
    if (mbsri_force_off(m, d, force)) return MBSR_OK;
    if (ask == MBSRI_FORCES)
        status = table->evaluate(&args);
    else if (ask == MBSRI_ENERGY && table->energy)
        status = table->energy(&args, &one);
    else if (ask == MBSRI_DISSIPATION && table->dissipation)
        status = table->dissipation(&args, &one);
    if (sum) *sum += one;
    return status ? mbsri_force_failed(m, d, force, status, names[ask]) : MBSR_OK;
}

/* The bodies of one call of an element: those of its list, or the one of an element that acts on
 * every body; with q, joints alone. Returns how many. */
static int view_all(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int body,
                    mbsri_question ask, const double *q, const double *u)
{
    const bool every = (force->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
    const int bodies = every ? 1 : force->def.bodies;
    for (int k = 0; k < bodies; ++k) {
        const int i = every ? body : m->stored.list_index[force->list + (size_t)k];
        d->element.bodies[k] = q ? view_joint(m, d, i, ask, q, u) : view(m, d, i, ask);
    }
    return bodies;
}

/* All calls of an element. */
static int visit(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, mbsri_question ask,
                 const double *q, const double *u, double *sum)
{
    const int calls = force->def.table->flags & MBSR_FORCE_EVERY_BODY ? m->bodies : 1;
    int status = MBSR_OK;
    for (int i = 1; i <= calls && !status; ++i)
        status = call_element(m, d, force, view_all(m, d, force, i, ask, q, u), ask, sum);
    return status;
}

/* The same of all elements. */
static int visit_all(const mbsr_model *m, mbsr_data *d, mbsri_question ask, double *sum)
{
    const mbsri_force *force = m->forces.data;
    int status = MBSR_OK;
    for (size_t k = 0; k < m->forces.count && !status; ++k)
        status = visit(m, d, force + k, ask, NULL, NULL, sum);
    return status;
}

static int add_loop_forces(const mbsr_model *m, mbsr_data *d, const double *lambda)
{
    const int status = lambda ? MBSR_OK : mbsri_closure_springs(m, d);
    if (status) return status;
    if (lambda && lambda != d->loop_lambda) mbsri_copy((size_t)m->rows, lambda, d->loop_lambda);
    d->lambda_known = lambda != NULL;
    mbsri_closure_load(m, d, d->loop_lambda, d->f, d->tau);
    return MBSR_OK;
}

int mbsri_forces(const mbsr_model *m, mbsr_data *d, const double *tau, const double *lambda)
{
    d->stage = MBSRI_STAGE_VELOCITIES;
    d->accelerated = false;
    d->pending = MBSRI_PENDING_NONE;

    mbsri_zero((size_t)m->nu, d->tau);
    int status =
        tau ? mbsri_check_input(d, (size_t)m->nu, tau, "mbsr_stage_forces", "tau") : MBSR_OK;
    if (status) return status;
    if (tau) mbsri_gather(m, tau, d->tau);
    /* f_i = -h_i */
    mbsri_zero((size_t)m->root.d, d->f);
    for (size_t k = (size_t)m->root.d; k < m->size.v; ++k) d->f[k] = -d->h[k];
    /* + force elements */
    status = visit_all(m, d, MBSRI_FORCES, NULL);
    /* + closures */
    if (!status && m->rows > 0) status = add_loop_forces(m, d, lambda);
    if (status) return status;
    d->stage = MBSRI_STAGE_FORCES;
    return MBSR_OK;
}

int mbsri_joint_elements(const mbsr_model *m, mbsr_data *d, const double *q, const double *u)
{
    const mbsri_force *force = m->forces.data;
    const size_t others = mbsri_other_forces(m);
    int status = MBSR_OK;
    for (size_t k = 0; k < others && !status; ++k, ++force) {
        if (force->def.table->flags & MBSR_FORCE_JOINT_ONLY)
            status = visit(m, d, force, MBSRI_FORCES, q, u, NULL);
    }
    mbsri_coordinate_forces(&m->elements.along, d->element.off + others, q, u, d->tau);
    return status;
}

int mbsri_force_bodies(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int body)
{
    const bool joints = (force->def.table->flags & MBSR_FORCE_JOINT_ONLY) != 0;
    return view_all(m, d, force, body, MBSRI_DERIVATIVES, joints ? d->q : NULL, d->u);
}

int mbsri_force_pairs(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int *count)
{
    *count = 0;
    if (mbsri_force_off(m, d, force)) return MBSR_OK;
    const mbsr_force_args args =
        mbsri_force_args(d, force, view_all(m, d, force, 0, MBSRI_DERIVATIVES, NULL, NULL));
    int status = force->def.table->pairs(&args, d->element.pairs, count);
    bool good = *count >= 0 && *count <= force->needs.pairs;
    for (int k = 0; k < *count && good && !status; ++k) {
        const int *pair = d->element.pairs[k];
        good = pair[0] >= 0 && pair[1] >= 0 && pair[0] < args.bodies && pair[1] < args.bodies &&
               pair[0] != pair[1];
    }
    if (!status && !good) status = MBSR_ERR_VALUE;
    if (status) *count = 0;
    return status ? mbsri_force_failed(m, d, force, status, "pairs") : MBSR_OK;
}

void mbsri_pair_bodies(const mbsr_model *m, mbsr_data *d, const mbsri_force *force,
                       const int pair[2])
{
    for (int k = 0; k < 2; ++k) {
        const int i = m->stored.list_index[force->list + (size_t)pair[k]];
        d->element.bodies[k] = view(m, d, i, MBSRI_DERIVATIVES);
    }
}

int mbsri_weigh(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_force *force = m->forces.data;
    int status = MBSR_OK;
    for (int k = 0; k < m->elements.anywhere && !status; ++k, ++force) {
        if (!mbsri_is_gravity(&force->def)) continue;
        const int bodies = view_all(m, d, force, i, MBSRI_FORCES, NULL, NULL);
        status = call_element(m, d, force, bodies, MBSRI_FORCES, NULL);
    }
    return status;
}

int mbsri_body_elements(const mbsr_model *m, mbsr_data *d)
{
    const mbsri_force *force = m->forces.data;
    const size_t others = mbsri_other_forces(m);
    int status = MBSR_OK;
    for (size_t k = 0; k < others && !status; ++k, ++force) {
        if (mbsri_is_gravity(&force->def) || force->def.table->flags & MBSR_FORCE_JOINT_ONLY)
            continue;
        status = visit(m, d, force, MBSRI_FORCES, NULL, NULL, NULL);
    }
    return status;
}

int mbsri_add_element(const mbsr_model *m, mbsr_data *d, const mbsri_force *force)
{
    return visit(m, d, force, MBSRI_FORCES, NULL, NULL, NULL);
}

/* The energy of a resting element is added to *sum. */
static int add_resting(const mbsr_model *m, mbsr_data *d, const mbsri_force *force,
                       mbsri_question ask, double *sum)
{
    double energy = 0.0;
    if (ask != MBSRI_ENERGY || mbsri_force_off(m, d, force)) return MBSR_OK;
    const int status = mbsri_resting_energy(m, force, &energy);
    *sum += energy;
    return status ? mbsri_force_failed(m, d, force, status, "energy") : MBSR_OK;
}

int mbsri_element_sum(const mbsr_model *m, mbsr_data *d, const mbsri_force *force,
                      mbsri_question ask, double *sum)
{
    const mbsri_force *behind = (const mbsri_force *)m->forces.data + m->forces.count;
    *sum = 0.0;
    if (force && force->resting) return add_resting(m, d, force, ask, sum);
    if (force) return visit(m, d, force, ask, NULL, NULL, sum);
    int status = visit_all(m, d, ask, sum);
    for (size_t k = 0; k < m->elements.idle && !status; ++k) {
        if (behind[k].resting) status = add_resting(m, d, behind + k, ask, sum);
    }
    return status;
}

int mbsri_force_on(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int place,
                   double *f, double *tau)
{
    const bool every = (force->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
    if (force->resting) return MBSR_OK;
    const int bodies = view_all(m, d, force, every ? place : 0, MBSRI_FORCES, NULL, NULL);
    for (int k = 0; k < bodies; ++k) {
        const bool asked = every || k == place;
        mbsr_force_body *body = d->element.bodies + k;
        double *const elsewhere = d->scratch;
        if (!asked) mbsri_zero((size_t)(m->most.d + m->most.n), elsewhere);
        body->f = asked ? f : elsewhere;
        if (body->tau) body->tau = asked ? tau : elsewhere + m->most.d;
    }
    return call_element(m, d, force, bodies, MBSRI_FORCES, NULL);
}

const mbsri_force *mbsri_find_force(const mbsr_model *m, mbsr_data *d, int id, const char *function)
{
    const mbsri_force *force = m->forces.data;
    for (size_t k = 0; k < m->forces.count + m->elements.idle; ++k) {
        if (force[k].id == id) return force + k;
    }
    (void)mbsri_fail(&d->error, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE, "%s: there is no force %d",
                     function, id);
    return NULL;
}
