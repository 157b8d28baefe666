/* Functions of tables that give numbers which are not finite: see spoil.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "spoil.h"

#include <stdbool.h>
#include <string.h>

test_spoil_counts test_spoil_of;

enum { MOST = 128 };

typedef struct slot {
    union {
        const mbsr_joint_table *joint;
        const mbsr_force_table *force;
        const mbsr_closure_table *closure;
    } of;
    union {
        mbsr_joint_table joint;
        mbsr_force_table force;
        mbsr_closure_table closure;
    } own;
    void *user; /* of a joint */
} slot;

static slot slots[MOST];
static int count;

/* One of the n numbers, where it is the turn of this call and there are any. */
static void give(double *x, int n)
{
    const test_spoil_counts *c = &test_spoil_of;
    if (c->asked == c->at && x && n > 0) x[c->at % n] = c->with;
}

/* One of two or more results, by the number of the call. */
static bool turn_of(int result, int results)
{
    return test_spoil_of.at % results == result;
}

/* ---- joints ---- */

/* The slot and what the table's own functions read. */
static const mbsr_joint_table *joint_of(const mbsr_joint_args *args, mbsr_joint_args *inner)
{
    const slot *s = args->user;
    *inner = *args;
    inner->user = s->user;
    ++test_spoil_of.asked;
    return s->of.joint;
}

static int joint_position(const mbsr_joint_args *args, double *p)
{
    mbsr_joint_args a;
    const int status = joint_of(args, &a)->position(&a, p);
    give(p, a.np);
    return status;
}

static int joint_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    mbsr_joint_args a;
    const int status = joint_of(args, &a)->jacobians(&a, K, H, J, kI);
    if (turn_of(0, 4)) give(K, a.d * a.d);
    if (turn_of(1, 4)) give(H, a.d * a.pred_d);
    if (turn_of(2, 4)) give(J, a.d * a.n);
    if (turn_of(3, 4)) give(kI, a.d);
    return status;
}

static int joint_bias(const mbsr_joint_args *args, double *kII)
{
    mbsr_joint_args a;
    const int status = joint_of(args, &a)->bias(&a, kII);
    give(kII, a.d);
    return status;
}

static int joint_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    mbsr_joint_args a;
    const int status = joint_of(args, &a)->rates(&a, Kdot, Hdot, Jdot);
    if (turn_of(0, 2)) give(Hdot, a.d * a.pred_d);
    if (turn_of(1, 2)) give(Jdot, a.d * a.n);
    return status;
}

static int joint_coordinate_rates(const mbsr_joint_args *args, double *qdot)
{
    mbsr_joint_args a;
    const int status = joint_of(args, &a)->coordinate_rates(&a, qdot);
    give(qdot, a.nq);
    return status;
}

static int joint_normalise(const mbsr_joint_args *args, double *q)
{
    mbsr_joint_args a;
    const int status = joint_of(args, &a)->normalise(&a, q);
    give(q, a.nq);
    return status;
}

static int joint_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                         double *dK, double *dH, double *dJ, double *dkI)
{
    mbsr_joint_args a;
    const int status = joint_of(args, &a)->tangent(&a, by, dp, dK, dH, dJ, dkI);
    if (turn_of(0, 3)) give(dp, a.np);
    if (turn_of(1, 3)) give(dH, a.d * a.pred_d);
    if (turn_of(2, 3)) give(dJ, a.d * a.n);
    return status;
}

static int joint_rate_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by,
                              double *dkII, double *dKdot, double *dHdot, double *dJdot,
                              double *dqdot)
{
    mbsr_joint_args a;
    const int status = joint_of(args, &a)->rate_tangent(&a, by, dkII, dKdot, dHdot, dJdot, dqdot);
    if (turn_of(0, 2)) give(dkII, a.d);
    if (turn_of(1, 2)) give(dJdot, a.d * a.n);
    return status;
}

static void spoil_joint(mbsr_joint *joint)
{
    const mbsr_joint_table *of = joint->table;
    slot *s = slots + count++;
    mbsr_joint_table *own = &s->own.joint;
    s->of.joint = of, s->user = joint->user;
    *own = *of;
    own->position = joint_position;
    own->jacobians = joint_jacobians;
    own->bias = joint_bias;
    own->rates = of->rates ? joint_rates : NULL;
    own->coordinate_rates = of->coordinate_rates ? joint_coordinate_rates : NULL;
    own->normalise = of->normalise ? joint_normalise : NULL;
    own->tangent = of->tangent ? joint_tangent : NULL;
    own->rate_tangent = of->rate_tangent ? joint_rate_tangent : NULL;
    joint->table = own, joint->user = s;
}

/* ---- force elements ---- */

static const mbsr_force_table *force_of(const mbsr_force_args *args)
{
    for (int k = 0; k < count; ++k)
        if (args->force->table == &slots[k].own.force) {
            ++test_spoil_of.asked;
            return slots[k].of.force;
        }
    return NULL;
}

static int force_evaluate(const mbsr_force_args *args)
{
    const int status = force_of(args)->evaluate(args);
    const mbsr_force_body *body = args->body + test_spoil_of.at % args->bodies;
    if (body->f)
        give(body->f, body->d);
    else
        give(body->tau, body->n);
    return status;
}

static int force_energy(const mbsr_force_args *args, double *energy)
{
    const int status = force_of(args)->energy(args, energy);
    give(energy, 1);
    return status;
}

static int force_dissipation(const mbsr_force_args *args, double *power)
{
    const int status = force_of(args)->dissipation(args, power);
    give(power, 1);
    return status;
}

static int force_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const int status = force_of(args)->derivatives(args, out);
    give(out->matrix, out->rows * out->columns);
    return status;
}

static void spoil_force(mbsr_force_def *def)
{
    const mbsr_force_table *of = def->table;
    slot *s = slots + count++;
    mbsr_force_table *own = &s->own.force;
    s->of.force = of;
    *own = *of;
    own->evaluate = force_evaluate;
    own->energy = of->energy ? force_energy : NULL;
    own->dissipation = of->dissipation ? force_dissipation : NULL;
    own->derivatives = of->derivatives ? force_derivatives : NULL;
    def->table = own;
}

/* ---- closures ---- */

static const mbsr_closure_table *closure_of(const mbsr_closure_args *args)
{
    for (int k = 0; k < count; ++k)
        if (args->closure->table == &slots[k].own.closure) {
            ++test_spoil_of.asked;
            return slots[k].of.closure;
        }
    return NULL;
}

static int closure_position(const mbsr_closure_args *args, double *g)
{
    const int status = closure_of(args)->position(args, g);
    give(g, 1);
    return status;
}

static int closure_jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    const int status = closure_of(args)->jacobian(args, out);
    give(out->matrix, out->rows * out->columns);
    return status;
}

static int closure_drift(const mbsr_closure_args *args, double *gt)
{
    const int status = closure_of(args)->drift(args, gt);
    give(gt, 1);
    return status;
}

static int closure_bias(const mbsr_closure_args *args, double *bias)
{
    const int status = closure_of(args)->bias(args, bias);
    give(bias, 1);
    return status;
}

static int closure_tangent(const mbsr_closure_args *args, const double *lambda,
                           const mbsr_closure_tangent *out)
{
    const int status = closure_of(args)->tangent(args, lambda, out);
    if (turn_of(0, 2)) give(out->force, out->columns * out->columns);
    if (turn_of(1, 2)) give(out->rate, out->rows * out->columns);
    return status;
}

static void spoil_closure(mbsr_closure_def *def)
{
    const mbsr_closure_table *of = def->table;
    slot *s = slots + count++;
    mbsr_closure_table *own = &s->own.closure;
    s->of.closure = of;
    *own = *of;
    own->position = of->position ? closure_position : NULL;
    own->jacobian = of->jacobian ? closure_jacobian : NULL;
    own->drift = of->drift ? closure_drift : NULL;
    own->bias = of->bias ? closure_bias : NULL;
    own->tangent = of->tangent ? closure_tangent : NULL;
    def->table = own;
}

/* ---- models ---- */

/* Without those that springs have become, which stand behind them. */
static int own_closures(const mbsr_model *model)
{
    int closures = mbsr_model_closures(model);
    for (int k = 0; k < mbsr_model_forces(model); ++k)
        if (mbsr_force_closure(model, k) != MBSR_NONE) --closures;
    return closures;
}

static int add_all(const mbsr_model *from, mbsr_model *to)
{
    const int bodies = mbsr_model_bodies(from), forces = mbsr_model_forces(from),
              closures = own_closures(from);
    int status = count + bodies + forces + closures > MOST ? MBSR_ERR_VALUE : MBSR_OK;
    for (int k = 0; k < bodies && !status; ++k) {
        mbsr_body_def def;
        status = mbsr_body_definition(from, k, &def);
        if (!status) spoil_joint(&def.joint);
        if (!status) status = mbsr_model_add_body(to, &def, NULL);
    }
    for (int k = 0; k < forces && !status; ++k) {
        mbsr_force_def def;
        status = mbsr_force_definition(from, k, &def);
        def.as_closure = 0; /* for the library's own tables alone */
        if (!status) spoil_force(&def);
        if (!status) status = mbsr_model_add_force(to, &def, NULL);
    }
    for (int k = 0; k < closures && !status; ++k) {
        mbsr_closure_def def;
        status = mbsr_closure_definition(from, k, &def);
        if (!status) spoil_closure(&def);
        if (!status) status = mbsr_model_add_closure(to, &def, NULL);
    }
    return status;
}

mbsr_model *test_spoil_copy(const mbsr_model *model)
{
    mbsr_model *made = NULL;
    mbsr_model_def def;
    int status = mbsr_model_definition(model, &def);
    if (!status) status = mbsr_model_create(&def, &made, NULL);
    if (!status) status = add_all(model, made);
    if (!status) return made;
    mbsr_model_destroy(made);
    return NULL;
}

void test_spoil_end(void)
{
    memset(slots, 0, sizeof slots);
    count = 0;
}
