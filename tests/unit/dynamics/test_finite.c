/* Stages, dynamics and results: no number that is not finite with MBSR_OK.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "finite.h"
#include "mixed.h"
#include "rigid_tree.h"
#include "twins.h"

#include <mbsrank/driver.h>

enum { Q = 1u << FINITE_Q, U = 1u << FINITE_U, TAU = 1u << FINITE_TAU, UDOT = 1u << FINITE_UDOT };
enum { T = 1u << FINITE_T, OTHER = 1u << FINITE_OTHER, BOTH = FINITE_MODEL | FINITE_DATA };

static double time_of(const finite_subject *s)
{
    return s->in[FINITE_T][0];
}

/* ---- stages before the call ---- */

static int positions(finite_subject *s)
{
    return mbsr_stage_positions(s->model, s->data, time_of(s), s->in[FINITE_Q]);
}

static int velocities(finite_subject *s)
{
    const int status = positions(s);
    return status ? status : mbsr_stage_velocities(s->model, s->data, s->in[FINITE_U]);
}

static int forces(finite_subject *s)
{
    const int status = velocities(s);
    return status ? status : mbsr_stage_forces(s->model, s->data, s->in[FINITE_TAU]);
}

static int backward(finite_subject *s)
{
    const int status = forces(s);
    return status ? status : mbsr_stage_backward(s->model, s->data);
}

static int accelerations(finite_subject *s)
{
    const int status = forces(s);
    return status ? status : mbsr_stage_accelerations(s->model, s->data, s->in[FINITE_UDOT]);
}

/* ---- the calls ---- */

static int run_positions(finite_subject *s)
{
    return mbsr_stage_positions(s->model, s->data, time_of(s), s->in[FINITE_Q]);
}

static int run_velocities(finite_subject *s)
{
    return mbsr_stage_velocities(s->model, s->data, s->in[FINITE_U]);
}

static int run_forces(finite_subject *s)
{
    return mbsr_stage_forces(s->model, s->data, s->in[FINITE_TAU]);
}

static int run_backward(finite_subject *s)
{
    return mbsr_stage_backward(s->model, s->data);
}

static int run_forward(finite_subject *s)
{
    return mbsr_stage_forward(s->model, s->data, s->in[FINITE_UDOT], s->out[0]);
}

static int run_coordinate_rates(finite_subject *s)
{
    return mbsr_coordinate_rates(s->model, s->data, s->out[0]);
}

static int run_normalise(finite_subject *s)
{
    const double *q = s->in[FINITE_Q];
    if (q && s->out[0]) memcpy(s->out[0], q, sizeof *q * (size_t)s->nq);
    return mbsr_normalise(s->model, s->data, q ? s->out[0] : NULL);
}

static int run_recursive_residual(finite_subject *s)
{
    return mbsr_recursive_residual(s->model, s->data, time_of(s), s->in[FINITE_Q], s->in[FINITE_U],
                                   s->in[FINITE_UDOT], s->in[FINITE_TAU], s->out[0]);
}

static int run_inverse_dynamics(finite_subject *s)
{
    return mbsr_inverse_dynamics(s->model, s->data, time_of(s), s->in[FINITE_Q], s->in[FINITE_U],
                                 s->in[FINITE_UDOT], NULL, s->out[0]);
}

static int run_forward_dynamics(finite_subject *s)
{
    return mbsr_forward_dynamics(s->model, s->data, time_of(s), s->in[FINITE_Q], s->in[FINITE_U],
                                 s->in[FINITE_TAU], s->out[0]);
}

static int run_refined(finite_subject *s)
{
    return mbsr_forward_dynamics_refined(s->model, s->data, time_of(s), s->in[FINITE_Q],
                                         s->in[FINITE_U], s->in[FINITE_TAU], s->out[0], s->out[1],
                                         s->out[2]);
}

static int run_bias_forces(finite_subject *s)
{
    return mbsr_bias_forces(s->model, s->data, time_of(s), s->in[FINITE_Q], s->in[FINITE_U],
                            s->out[0]);
}

static int run_mass_matrix(finite_subject *s)
{
    return mbsr_mass_matrix(s->model, s->data, s->out[0]);
}

static int run_momenta(finite_subject *s)
{
    return mbsr_momenta(s->model, s->data, s->out[0]);
}

static int run_energy(finite_subject *s)
{
    return mbsr_energy(s->model, s->data, s->out[0], s->out[1]);
}

static int run_body_energy(finite_subject *s)
{
    return mbsr_body_energy(s->model, s->data, 0, s->out[0]);
}

static int run_dissipation(finite_subject *s)
{
    return mbsr_dissipation(s->model, s->data, s->out[0]);
}

static int run_force_power(finite_subject *s)
{
    return mbsr_force_power(s->model, s->data, 0, s->out[0], s->out[1]);
}

static int run_tree_momentum(finite_subject *s)
{
    return mbsr_tree_momentum(s->model, s->data, s->in[FINITE_OTHER], s->out[0], s->out[1],
                              s->out[2]);
}

static int run_accelerations(finite_subject *s)
{
    return mbsr_stage_accelerations(s->model, s->data, s->in[FINITE_UDOT]);
}

static int run_body_pose(finite_subject *s)
{
    return mbsr_body_pose(s->model, s->data, s->id, s->out[0]);
}

static int run_body_twist(finite_subject *s)
{
    return mbsr_body_twist(s->model, s->data, s->id, s->out[0]);
}

static int run_body_acceleration(finite_subject *s)
{
    return mbsr_body_acceleration(s->model, s->data, s->id, s->out[0]);
}

static int run_joint_reaction(finite_subject *s)
{
    return mbsr_joint_reaction(s->model, s->data, s->id, s->out[0]);
}

static int run_body_jacobian(finite_subject *s)
{
    return mbsr_body_jacobian(s->model, s->data, s->id, s->out[0]);
}

static int run_body_rank(finite_subject *s)
{
    mbsr_rank_info info;
    const int status = mbsr_body_rank(s->model, s->data, s->id, s->out[0] ? &info : NULL);
    if (status || !s->out[0]) return status;
    s->out[0][0] = info.tolerance;
    s->out[0][1] = info.scale;
    s->out[0][2] = info.smallest_kept;
    s->out[0][3] = info.largest_dropped;
    return status;
}

/* ---- lengths of results ---- */

static int of_q(const finite_subject *s, int o)
{
    return o == 0 ? s->nq : 0;
}

static int of_u(const finite_subject *s, int o)
{
    return o == 0 ? s->nu : 0;
}

static int of_refined(const finite_subject *s, int o)
{
    return o < 2 ? s->nu : 1;
}

static int of_matrix(const finite_subject *s, int o)
{
    return o == 0 ? s->nu * s->nu : 0;
}

static int of_jacobian(const finite_subject *s, int o)
{
    return o == 0 ? s->nu * mbsr_body_dimension(s->model, s->id) : 0;
}

static int of_body(const finite_subject *s, int o)
{
    return o == 0 ? mbsr_body_dimension(s->model, s->id) : 0;
}

static int of_pose(const finite_subject *s, int o)
{
    return o == 0 ? mbsr_body_pose_size(s->model, s->id) : 0;
}

static int of_totals(const finite_subject *s, int o)
{
    (void)s;
    return o == 0 ? 1 : 3 * o;
}

static int of_one(const finite_subject *s, int o)
{
    (void)s;
    return o == 0;
}

static int of_two(const finite_subject *s, int o)
{
    (void)s;
    return o < 2;
}

static int of_four(const finite_subject *s, int o)
{
    (void)s;
    return o == 0 ? 4 : 0;
}

static const finite_row rows[] = {
    {"mbsr_stage_positions", run_positions, NULL, 0, T | Q, BOTH, NULL},
    {"mbsr_stage_velocities", run_velocities, positions, T | Q, U, BOTH, NULL},
    {"mbsr_stage_forces", run_forces, velocities, T | Q | U, TAU, BOTH, NULL},
    {"mbsr_stage_backward", run_backward, forces, T | Q | U | TAU, 0, BOTH, NULL},
    {"mbsr_stage_forward", run_forward, backward, T | Q | U | TAU, UDOT, BOTH, of_u},
    {"mbsr_coordinate_rates", run_coordinate_rates, velocities, T | Q | U, 0, BOTH, of_q},
    {"mbsr_normalise", run_normalise, NULL, 0, Q, BOTH, of_q},
    {"mbsr_recursive_residual", run_recursive_residual, NULL, 0, T | Q | U | UDOT | TAU, BOTH,
     of_u},
    {"mbsr_inverse_dynamics", run_inverse_dynamics, NULL, 0, T | Q | U | UDOT, BOTH, of_u},
    {"mbsr_forward_dynamics", run_forward_dynamics, NULL, 0, T | Q | U | TAU, BOTH, of_u},
    {"mbsr_forward_dynamics_refined", run_refined, NULL, 0, T | Q | U | TAU, BOTH, of_refined},
    {"mbsr_bias_forces", run_bias_forces, NULL, 0, T | Q | U, BOTH, of_u},
    {"mbsr_mass_matrix", run_mass_matrix, velocities, T | Q | U, 0, BOTH, of_matrix},
    {"mbsr_momenta", run_momenta, velocities, T | Q | U, 0, BOTH, of_u},
    {"mbsr_energy", run_energy, velocities, T | Q | U, 0, BOTH, of_two},
    {"mbsr_body_energy", run_body_energy, velocities, T | Q | U, 0, BOTH, of_one},
    {"mbsr_dissipation", run_dissipation, velocities, T | Q | U, 0, BOTH, of_one},
    {"mbsr_force_power", run_force_power, velocities, T | Q | U, 0, BOTH, of_two},
    {"mbsr_force_load", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_contact_at", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_force_inspect", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_force_switch", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_tree_momentum", run_tree_momentum, velocities, T | Q | U, OTHER, BOTH, of_totals},
    {"mbsr_stage_accelerations", run_accelerations, forces, T | Q | U | TAU, UDOT, BOTH, NULL},
    {"mbsr_body_pose", run_body_pose, positions, T | Q, 0, BOTH, of_pose},
    {"mbsr_body_twist", run_body_twist, velocities, T | Q | U, 0, BOTH, of_body},
    {"mbsr_body_acceleration", run_body_acceleration, accelerations, T | Q | U | TAU | UDOT, 0,
     BOTH, of_body},
    {"mbsr_joint_reaction", run_joint_reaction, accelerations, T | Q | U | TAU | UDOT, 0, BOTH,
     of_body},
    {"mbsr_body_point", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_body_jacobian", run_body_jacobian, positions, T | Q, 0, BOTH, of_jacobian},
    {"mbsr_body_rank", run_body_rank, backward, T | Q | U | TAU, 0, BOTH, of_four},
    {"mbsr_rank_watch", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_rank_watch_exchange", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_total_rank", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_data_size", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_data_init", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_data_create", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_data_size_lean", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_data_init_lean", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_data_create_lean", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_data_destroy", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_data_error", NULL, NULL, 0, 0, 0, NULL},
};
enum { ROWS = sizeof rows / sizeof rows[0] };

/* How many models each function served. */
static int served[ROWS];

/* A random state; q: one to begin with, or NULL. */
static void try_all(const char *name, mbsr_model *model, mbsr_data *data, const double *q)
{
    finite_subject s = {.name = name, .model = model, .data = data};
    s.nq = mbsr_model_nq(model);
    s.nu = mbsr_model_nu(model);
    s.id = mbsr_model_bodies(model) - 1;
    double x[64];
    assert_true(s.nq <= 64);
    test_rng rng = test_seed(71);
    finite_give(&s, FINITE_T, 1, (double[]){0.3});
    test_fill(&rng, s.nq, x);
    finite_give(&s, FINITE_Q, s.nq, q ? q : x);
    for (int k = FINITE_U; k <= FINITE_UDOT; ++k) {
        test_fill(&rng, s.nu, x);
        finite_give(&s, (finite_input)k, s.nu, x);
    }
    finite_give(&s, FINITE_OTHER, 3, (double[]){0.1, -0.2, 0.3});
    for (int k = 0; k < ROWS; ++k) served[k] += finite_try(&s, rows + k);
    finite_free(&s);
}

static void mixed_trees(void **unused)
{
    (void)unused;
    static const char *const names[] = {"in space", "in the plane", "an arm", "in space, general",
                                        "in the plane, general"};
    for (int k = 0; k < MIXED_ALL; ++k) {
        mixed s;
        mixed_make(&s, (mixed_scene)k);
        try_all(names[k], s.model, s.data, NULL);
        mixed_free(&s);
    }
}

static void trees_of_rigid_bodies(void **unused)
{
    (void)unused;
    for (int k = 0; k < 4; ++k) {
        const test_rigid_choice choice = {.seed = 11 + (uint64_t)k,
                                          .bodies = 4 + k,
                                          .massless = k < 2 ? 0.0 : 0.3,
                                          .points = 0.2,
                                          .many = 0.3,
                                          .branching = 0.5,
                                          .length = 1.0,
                                          .forces = k % 2,
                                          .moving = k == 3,
                                          .shuffle = k % 2};
        test_rigid_tree tree;
        test_rigid_tree_make(&tree, choice);
        try_all("a tree of rigid bodies", tree.model, tree.data, tree.q);
        mbsr_data *lean;
        if (mbsr_data_size_lean(tree.model) > 0) {
            assert_ok(mbsr_data_create_lean(tree.model, &lean, NULL), NULL);
            try_all("the same with lean data", tree.model, lean, tree.q);
            mbsr_data_destroy(lean);
        }
        test_rigid_tree_free(&tree);
    }
}

static void a_massless_bead(void **unused)
{
    (void)unused;
    twins s;
    twins_make(&s, 1.0);
    try_all("two pendulums on a bead", s.model, s.data, NULL);
    twins_free(&s);
}

static void each_function_served(void **unused)
{
    (void)unused;
    for (int k = 0; k < ROWS; ++k) {
        if (rows[k].run && served[k] == 0) fail_msg("%s was never MBSR_OK", rows[k].function);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mixed_trees),
        cmocka_unit_test(trees_of_rigid_bodies),
        cmocka_unit_test(a_massless_bead),
        cmocka_unit_test(each_function_served),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
