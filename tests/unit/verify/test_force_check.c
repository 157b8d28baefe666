/* mbsr_force_verify: what it says of right and of wrong derivatives, and what it refuses.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "expect.h"
#include "space.h"

#include <mbsrank/verify.h>

/* An element on two bodies in space: force -(7 + |r|^2) r with r the displacement between their
 * origins, moments 2 (omega_b - omega_a), and a joint force sin(q_0) u_1 on a. */
typedef struct coupling {
    int wrong;        /* derivative that is off, 0: none */
    double constant;  /* a force that is there always */
    int status;       /* what derivatives returns */
    int not_a_number; /* evaluate writes NaN */
} coupling;

static int evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *a = args->body, *b = args->body + 1;
    const coupling *c = args->force->user;
    double r[3], square = 0.0;
    for (int k = 0; k < 3; ++k) {
        r[k] = a->p[MBSR_POSE_X + k] - b->p[MBSR_POSE_X + k];
        square += r[k] * r[k];
    }
    for (int k = 0; k < 3; ++k) {
        const double force = (7.0 + square) * r[k], moment = 2.0 * (b->V[k] - a->V[k]);
        a->f[3 + k] -= force;
        b->f[3 + k] += force;
        a->f[k] += moment;
        b->f[k] -= moment;
    }
    a->f[5] += c->not_a_number ? NAN : c->constant;
    a->tau[0] += sin(a->q[0]) * a->u[1];
    return 0;
}

static int derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const mbsr_force_body *a = args->body, *b = args->body + 1;
    const coupling *c = args->force->user;
    double r[3], square = 0.0;
    for (int k = 0; k < 3; ++k) {
        r[k] = a->p[MBSR_POSE_X + k] - b->p[MBSR_POSE_X + k];
        square += r[k] * r[k];
    }
    for (int l = 0; l < 4; ++l) {
        const int on = l / 2, by = l % 2;
        const double sign = on == by ? -1.0 : 1.0;
        for (int j = 0; j < 3; ++j) {
            const int pose = out->column[by] + 3 + j, spin = out->column[by] + 6 + j;
            out->matrix[spin * out->rows + out->row[on] + j] +=
                sign * (c->wrong == 1 && on == 1 && by == 0 ? 2.002 : 2.0);
            for (int k = 0; k < 3; ++k) {
                out->matrix[pose * out->rows + out->row[on] + 3 + k] +=
                    sign * ((j == k ? 7.0 + square : 0.0) +
                            (c->wrong == 2 && j != k ? 0.0 : 2.0) * r[j] * r[k]);
            }
        }
    }
    const int tau = out->row[0] + a->d, q = out->column[0] + 6 + a->d, u = q + a->nq;
    out->matrix[q * out->rows + tau] += (c->wrong == 3 ? -1.0 : 1.0) * cos(a->q[0]) * a->u[1];
    out->matrix[(u + (c->wrong == 4 ? 0 : 1)) * out->rows + tau] += sin(a->q[0]);
    if (c->wrong == 5) out->matrix[q * out->rows + out->row[0] + 2] += 1e-3;
    (void)b;
    return c->status;
}

static const mbsr_force_table own = {.version = MBSR_FORCE_TABLE_VERSION,
                                     .flags = MBSR_FORCE_NO_MASS,
                                     .name = "coupling",
                                     .evaluate = evaluate,
                                     .derivatives = derivatives};
static const mbsr_force_table none = {.version = MBSR_FORCE_TABLE_VERSION,
                                      .flags = MBSR_FORCE_NO_MASS,
                                      .name = "bare",
                                      .evaluate = evaluate};

/* Gravity that forgets that masses turn. */
static int straight(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    (void)args;
    (void)out;
    return 0;
}

enum { COUPLING, BARE, GRAVITY, STRAIGHT, FORCES };

typedef struct fixture {
    coupling c;
    mbsr_force_table turned;
    test_counting counting;
    mbsr_model *model;
    mbsr_data *data;
    double q[14], u[12];
} fixture;

static void set_up(fixture *s)
{
    static const int ids[2] = {1, 0};
    static const double com[3] = {0.2, -0.3, 0.1}, tensor[6] = {1.0, 1.1, 1.2, 0.1, 0.2, -0.1};
    test_rng rng = test_seed(1);
    memset(s, 0, sizeof *s);
    mbsr_model_def def = mbsr_default_model_def();
    def.allocator = test_counting_allocator(&s->counting);
    assert_ok(mbsr_model_create(&def, &s->model, NULL), NULL);
    for (int id = 0; id < 2; ++id) {
        const mbsr_frame A = test_frame(&rng, 0.5), B = test_frame(&rng, 0.5);
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = mbsr_joint_free(&A, &B);
        /* the weight of the first does not depend on its pose */
        body.inertia = id ? mbsr_inertia_rigid(1.5, com, tensor) : mbsr_inertia_particle(1.5);
        assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
    }
    mbsr_force_def force[FORCES] = {
        mbsr_force_custom(&own, 2, ids, &s->c), mbsr_force_custom(&none, 2, ids, &s->c),
        mbsr_force_gravity(1.0, 2.0, -5.0), mbsr_force_gravity(1.0, 2.0, -5.0)};
    s->turned = *force[STRAIGHT].table;
    s->turned.derivatives = straight;
    force[STRAIGHT].table = &s->turned;
    for (int k = 0; k < FORCES; ++k)
        assert_ok(mbsr_model_add_force(s->model, force + k, NULL), mbsr_model_error(s->model));
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_ok(mbsr_data_create(s->model, &s->data, NULL), NULL);
    test_fill(&rng, 14, s->q);
    test_fill(&rng, 12, s->u);
    assert_ok(mbsr_stage_positions(s->model, s->data, 0.0, s->q), mbsr_data_error(s->data));
    assert_ok(mbsr_stage_velocities(s->model, s->data, s->u), mbsr_data_error(s->data));
}

static void tear_down(fixture *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
    assert_int_equal(s->counting.live, 0);
}

static mbsr_force_errors verified(fixture *s, int force)
{
    mbsr_force_errors errors;
    const long live = s->counting.live;
    assert_ok(mbsr_force_verify(s->model, s->data, force, &errors), mbsr_data_error(s->data));
    assert_int_equal(s->counting.live, live);
    return errors;
}

static void right_derivatives_pass(void **state)
{
    (void)state;
    fixture s;
    set_up(&s);
    assert_less(verified(&s, COUPLING).largest, 1e-9);
    assert_less(verified(&s, GRAVITY).largest, 1e-9);
    /* a large force that does not change is no error */
    s.c.constant = 1e8;
    assert_less(verified(&s, COUPLING).largest, 1e-9);
    tear_down(&s);
}

static void wrong_entries_are_named(void **state)
{
    (void)state;
    fixture s;
    set_up(&s);
    /* bodies 1 and 0 are the first and the second of the element */
    static const struct {
        double low, high;
        const char *words;
    } list[] = {{0.9e-3, 1.1e-3, "df(|dV(|bodies 0 and 1 is 2.002, by differences 2"},
                {1e-3, 1.0, "df(|dpose(|by differences"},
                {1.9, 2.1, "dtau(0) / dq(0) of bodies 1 and 1 is"},
                {0.9, 1.1, "dtau(0) / du(|of bodies 1 and 1 is"},
                {0.9, 1.1, "df(2) / dq(0) of bodies 1 and 1 is 0.001, by differences "}};
    for (int k = 0; k < 5; ++k) {
        s.c.wrong = k + 1;
        const mbsr_force_errors errors = verified(&s, COUPLING);
        assert_less(list[k].low, errors.largest);
        assert_less(errors.largest, list[k].high);
        assert_contains(errors.text, list[k].words);
    }
    const mbsr_force_errors errors = verified(&s, STRAIGHT);
    assert_close(errors.largest, 1.0, 1e-6);
    assert_contains(errors.text, "df(|dpose(| is 0, by differences ");
    tear_down(&s);
}

static void what_cannot_be_tested_is_refused(void **state)
{
    (void)state;
    fixture s;
    mbsr_force_errors errors;
    set_up(&s);
    const mbsr_error *error = mbsr_data_error(s.data);
    assert_refused(mbsr_force_verify(s.model, s.data, COUPLING, NULL), error, MBSR_ERR_NULL,
                   MBSR_NONE, MBSR_NONE, "mbsr_force_verify");
    assert_int_equal(mbsr_force_verify(NULL, s.data, COUPLING, &errors), MBSR_ERR_NULL);
    assert_int_equal(mbsr_force_verify(s.model, NULL, COUPLING, &errors), MBSR_ERR_NULL);
    assert_refused(mbsr_force_verify(s.model, s.data, FORCES, &errors), error, MBSR_ERR_ID,
                   MBSR_NONE, MBSR_NONE, "mbsr_force_verify: there is no force 4");
    assert_refused(mbsr_force_verify(s.model, s.data, BARE, &errors), error, MBSR_ERR_VALUE,
                   MBSR_NONE, BARE, "force 1 (bare) has no derivatives");
    s.c.status = 23;
    assert_refused(mbsr_force_verify(s.model, s.data, COUPLING, &errors), error, 23, MBSR_NONE,
                   COUPLING, "derivatives returned 23");
    s.c.status = 0;
    s.c.not_a_number = 1;
    assert_refused(mbsr_force_verify(s.model, s.data, COUPLING, &errors), error, MBSR_NOT_FINITE,
                   MBSR_NONE, COUPLING, "not finite");
    s.counting.fail_at = s.counting.calls + 1;
    assert_refused(mbsr_force_verify(s.model, s.data, COUPLING, &errors), error, MBSR_ERR_NO_MEMORY,
                   MBSR_NONE, COUPLING, "no memory");
    assert_ok(mbsr_stage_positions(s.model, s.data, 0.0, s.q), error);
    assert_refused(mbsr_force_verify(s.model, s.data, COUPLING, &errors), error, MBSR_ERR_SEQUENCE,
                   MBSR_NONE, MBSR_NONE, "mbsr_force_verify");
    tear_down(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(right_derivatives_pass),
        cmocka_unit_test(wrong_entries_are_named),
        cmocka_unit_test(what_cannot_be_tested_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
