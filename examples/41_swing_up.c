/* Swing-up of an arm with an elastic gear by direct collocation: derivatives here and differences.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A motor at the shoulder turns an arm without mass by a gear that gives; at its end a forearm
 * hangs on a free hinge. The motor cannot hold the arm out, so it has to swing it up:
 *
 *   ground -- rotor (0.05 kg m^2, torque tau) -- gear (100 N m/rad) -- arm (0 kg, 0.5 m)
 *          -- forearm (1 kg, 0.6 m)
 *
 * Unknowns are x = (q, u) and tau at 81 times h apart. Between neighbours x follows the trapezoidal
 * rule, |tau| <= 8 N m, it hangs at first and stands in the end, at rest. Least is the sum of
 * tau^2. That is a sparse problem of optimisation in 567 numbers for IPOPT
 * (coinor-libipopt-dev of Debian), which asks for the derivatives of u'(q, u, tau) at all times at
 * once: from mbsr_derivatives_batch_matrices, and for comparison from differences of
 * mbsr_batch_forward_dynamics. Writes swing_up.csv for swing_up.gp. */
#include "build.h"

#include <coin/IpStdCInterface.h>

#include <math.h>
#include <string.h>
#include <time.h>

enum {
    N = 80,
    RATES = 3,
    STATE = 2 * RATES,
    NODE = STATE + 1, /* q, u, tau */
    UNKNOWNS = NODE * (N + 1),
    ROWS = STATE * N,
    ENTRIES = ROWS * 2 * NODE,
    COLUMNS = NODE + 1 /* of differences */
};

static const double duration = 2.5, most = 8.0, pi = 3.14159265358979323846;

/* The arm, and what is counted. */
typedef struct arm {
    mbsr_batch *batch;
    mbsr_derivatives_batch *derivatives;
    int by_differences, evaluations, linearised, iterations;
    double seconds; /* in linearise */
    double q[RATES * (N + 1) * COLUMNS], u[RATES * (N + 1) * COLUMNS],
        tau[RATES * (N + 1) * COLUMNS], udot[RATES * (N + 1) * COLUMNS];
    double by_q[RATES * RATES * (N + 1)], by_u[RATES * RATES * (N + 1)],
        by_tau[RATES * RATES * (N + 1)];
} arm;

static mbsr_model *make(void)
{
    const double z[3] = {0, 0, 1}, middle[3] = {0.3, 0, 0};
    const mbsr_frame elbow = mbsr_frame_at(0.5, 0, 0);
    const double tensor[6] = {0, 0.03, 0.03, 0, 0, 0}, disc[6] = {0.025, 0.025, 0.05, 0, 0, 0};
    mbsr_model *m = new_model();
    const int rotor = add_body(m, "rotor", MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, z),
                               mbsr_inertia_rigid(1.0, (const double[3]){0, 0, 0}, disc));
    const int upper =
        add_body(m, "arm", rotor, mbsr_joint_revolute(NULL, NULL, z), mbsr_inertia_zero());
    add_body(m, "forearm", upper, mbsr_joint_revolute(&elbow, NULL, z),
             mbsr_inertia_rigid(1.0, middle, tensor));
    add_force(m, mbsr_force_joint_spring(upper, 0, 100.0, 4.0, 0.0));
    add_force(m, mbsr_force_gravity(-9.81, 0, 0)); /* up is x: it stands at q = 0 */
    check(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* ---- the equations at all nodes ---- */

/* Nodes into columns `from` and on, one number of each moved. */
static void spread(arm *a, const double *x, int from, int moved, double by)
{
    for (int k = 0; k <= N; ++k) {
        const int at = RATES * (from + k);
        double node[NODE];
        memcpy(node, x + NODE * k, sizeof node);
        if (moved >= 0) node[moved] += by;
        memcpy(a->q + at, node, RATES * sizeof *node);
        memcpy(a->u + at, node + RATES, RATES * sizeof *node);
        memset(a->tau + at, 0, RATES * sizeof *node);
        a->tau[at] = node[STATE];
    }
}

static int evaluate(arm *a, const mbsr_model *m, const double *x)
{
    spread(a, x, 0, -1, 0.0);
    a->evaluations += N + 1;
    return mbsr_batch_forward_dynamics(m, a->batch, 0.0, N + 1, a->q, a->u, a->tau, a->udot, NULL);
}

/* by_q, by_u, by_tau at all nodes. */
static int linearise(arm *a, const mbsr_model *m, const double *x)
{
    const double step = 1e-7;
    if (!a->by_differences) {
        spread(a, x, 0, -1, 0.0);
        a->linearised += N + 1;
        return mbsr_derivatives_batch_matrices(a->derivatives, 0.0, N + 1, a->q, a->u, a->tau, NULL,
                                               a->by_q, a->by_u, a->by_tau, NULL);
    }
    for (int j = 0; j < COLUMNS; ++j) spread(a, x, j * (N + 1), j - 1, step);
    a->evaluations += COLUMNS * (N + 1);
    const int status = mbsr_batch_forward_dynamics(m, a->batch, 0.0, COLUMNS * (N + 1), a->q, a->u,
                                                   a->tau, a->udot, NULL);
    for (int k = 0; k <= N; ++k) {
        for (int j = 0; j < NODE; ++j) {
            double *to = j < RATES   ? a->by_q + RATES * (RATES * k + j)
                         : j < STATE ? a->by_u + RATES * (RATES * k + j - RATES)
                                     : a->by_tau + RATES * RATES * k;
            for (int i = 0; i < RATES; ++i)
                to[i] =
                    (a->udot[RATES * ((j + 1) * (N + 1) + k) + i] - a->udot[RATES * k + i]) / step;
        }
    }
    return status;
}

/* ---- what IPOPT asks for ---- */

typedef struct problem {
    arm *a;
    const mbsr_model *m;
} problem;

static Bool objective(Index n, Number *x, Bool is_new, Number *value, UserDataPtr user)
{
    (void)n, (void)is_new, (void)user;
    *value = 0.0;
    for (int k = 0; k <= N; ++k) *value += duration / N * x[NODE * k + STATE] * x[NODE * k + STATE];
    return TRUE;
}

static Bool gradient(Index n, Number *x, Bool is_new, Number *to, UserDataPtr user)
{
    (void)is_new, (void)user;
    memset(to, 0, (size_t)n * sizeof *to);
    for (int k = 0; k <= N; ++k) to[NODE * k + STATE] = 2.0 * duration / N * x[NODE * k + STATE];
    return TRUE;
}

/* x_k+1 - x_k - h/2 (x'_k + x'_k+1) */
static Bool defects(Index n, Number *x, Bool is_new, Index rows, Number *to, UserDataPtr user)
{
    (void)n, (void)is_new, (void)rows;
    problem *p = user;
    const double h = 0.5 * duration / N;
    if (evaluate(p->a, p->m, x)) return FALSE;
    for (int k = 0; k < N; ++k) {
        const double *at = x + NODE * k, *next = at + NODE, *f = p->a->udot + RATES * k;
        for (int i = 0; i < RATES; ++i) {
            to[STATE * k + i] = next[i] - at[i] - h * (at[RATES + i] + next[RATES + i]);
            to[STATE * k + RATES + i] = next[RATES + i] - at[RATES + i] - h * (f[i] + f[RATES + i]);
        }
    }
    return TRUE;
}

/* Of row i of a defect by number j of a node, which is the later one or not. */
static double entry(const arm *a, int k, int i, int j, int later)
{
    const double h = 0.5 * duration / N;
    const double own = i == j ? (later ? 1.0 : -1.0) : 0.0;
    const int node = k + later;
    if (i < RATES) return own - (j == i + RATES ? h : 0.0);
    const int row = i - RATES;
    const double slope = j < RATES   ? a->by_q[RATES * (RATES * node + j) + row]
                         : j < STATE ? a->by_u[RATES * (RATES * node + j - RATES) + row]
                                     : a->by_tau[RATES * RATES * node + row];
    return own - h * slope;
}

static Bool jacobian(Index n, Number *x, Bool is_new, Index rows, Index count, Index *row,
                     Index *column, Number *value, UserDataPtr user)
{
    (void)n, (void)is_new, (void)rows, (void)count;
    problem *p = user;
    const clock_t begin = clock();
    if (value && linearise(p->a, p->m, x)) return FALSE;
    p->a->seconds += (double)(clock() - begin) / CLOCKS_PER_SEC;
    for (int k = 0, at = 0; k < N; ++k) {
        for (int i = 0; i < STATE; ++i) {
            for (int j = 0; j < 2 * NODE; ++j, ++at) {
                if (value) {
                    value[at] = entry(p->a, k, i, j % NODE, j >= NODE);
                } else {
                    row[at] = STATE * k + i;
                    column[at] = NODE * k + j;
                }
            }
        }
    }
    return TRUE;
}

static Bool no_hessian(Index n, Number *x, Bool is_new, Number factor, Index rows, Number *lambda,
                       Bool new_lambda, Index count, Index *row, Index *column, Number *value,
                       UserDataPtr user)
{
    (void)n, (void)x, (void)is_new, (void)factor, (void)rows, (void)lambda, (void)new_lambda;
    (void)count, (void)row, (void)column, (void)value, (void)user;
    return FALSE;
}

static Bool count_iteration(Index mode, Index iteration, Number value, Number primal, Number dual,
                            Number mu, Number step, Number regularisation, Number alpha_dual,
                            Number alpha_primal, Index trials, UserDataPtr user)
{
    (void)mode, (void)value, (void)primal, (void)dual, (void)mu, (void)step;
    (void)regularisation, (void)alpha_dual, (void)alpha_primal, (void)trials;
    ((problem *)user)->a->iterations = iteration;
    return TRUE;
}

/* ---- */

/* IPOPT's status; x is the guess, then the solution. */
static int solve(problem *p, double *x, double *cost)
{
    static double low[UNKNOWNS], high[UNKNOWNS], zero[ROWS];
    for (int k = 0; k <= N; ++k) {
        for (int i = 0; i < NODE; ++i) {
            const double bound = i == STATE ? most : 1e3, fixed = k == 0 && i == 0 ? pi : 0.0;
            const int is_fixed = (k == 0 || k == N) && i < STATE;
            low[NODE * k + i] = is_fixed ? fixed : -bound;
            high[NODE * k + i] = is_fixed ? fixed : bound;
            x[NODE * k + i] = i == 0 ? pi * (N - k) / N : 0.0;
        }
    }
    IpoptProblem ipopt = CreateIpoptProblem(UNKNOWNS, low, high, ROWS, zero, zero, ENTRIES, 0, 0,
                                            objective, defects, gradient, jacobian, no_hessian);
    AddIpoptStrOption(ipopt, "hessian_approximation", "limited-memory");
    AddIpoptIntOption(ipopt, "print_level", 0);
    AddIpoptStrOption(ipopt, "sb", "yes");
    AddIpoptIntOption(ipopt, "max_iter", 1000);
    AddIpoptNumOption(ipopt, "tol", 1e-8);
    SetIntermediateCallback(ipopt, count_iteration);
    const int status = (int)IpoptSolve(ipopt, x, NULL, cost, NULL, NULL, NULL, p);
    FreeIpoptProblem(ipopt);
    return status;
}

/* ---- whether it is a motion ---- */

/* By the rule of Runge and Kutta over a short step, at all times at once; x becomes what follows
 * from it, in as many steps to the next node, tau from node to node on a line. */
static void follow(arm *a, const mbsr_model *m, double *x, int steps)
{
    static double stage[UNKNOWNS], start[UNKNOWNS], sum[UNKNOWNS];
    const double h = duration / N / steps, part[] = {0.0, 0.5, 0.5, 1.0}, weight[] = {1, 2, 2, 1};
    double slope[N + 1];
    for (int k = 0; k < N; ++k)
        slope[k] = (x[NODE * (k + 1) + STATE] - x[NODE * k + STATE]) / steps;
    for (int step = 0; step < steps; ++step) {
        memcpy(start, x, sizeof start);
        memset(sum, 0, sizeof sum);
        for (int s = 0; s < 4; ++s) {
            for (int i = 0; i < NODE * N; ++i) {
                const int k = i / NODE, j = i % NODE;
                const double rate = s == 0       ? 0.0
                                    : j < RATES  ? a->u[RATES * k + j]
                                    : j == STATE ? slope[k] / h
                                                 : a->udot[RATES * k + j - RATES];
                stage[i] = start[i] + part[s] * h * rate;
            }
            check(evaluate(a, m, stage), mbsr_batch_error(a->batch));
            for (int i = 0; i < NODE * N; ++i) {
                const int k = i / NODE, j = i % NODE;
                sum[i] += weight[s] * h / 6.0 *
                          (j < RATES    ? a->u[RATES * k + j]
                           : j == STATE ? slope[k] / h
                                        : a->udot[RATES * k + j - RATES]);
            }
        }
        for (int i = 0; i < NODE * N; ++i) x[i] = start[i] + sum[i];
    }
}

/* The largest angle by which the nodes miss each other. */
static double largest_gap(arm *a, const mbsr_model *m, const double *x)
{
    static double end[UNKNOWNS];
    double gap = 0.0;
    memcpy(end, x, sizeof end);
    follow(a, m, end, 20);
    for (int k = 0; k < N; ++k) {
        for (int i = 0; i < RATES; ++i)
            gap = fmax(gap, fabs(end[NODE * k + i] - x[NODE * (k + 1) + i]));
    }
    return gap;
}

int main(void)
{
    static arm a;
    static double x[2][UNKNOWNS];
    double cost[2], seconds[2];
    int status[2];
    mbsr_error error;
    mbsr_model *m = make();
    check(mbsr_batch_create(m, &a.batch, &error), &error);
    check(mbsr_derivatives_batch_create(m, NULL, &a.derivatives, &error), &error);
    problem p = {&a, m};
    printf("derivatives     iterations  cost N^2m^2s  dynamics  linearised  seconds, of these in "
           "derivatives\n");
    for (int k = 0; k < 2; ++k) {
        a.by_differences = k;
        a.evaluations = a.linearised = 0;
        a.seconds = 0.0;
        const clock_t begin = clock();
        status[k] = solve(&p, x[k], cost + k);
        seconds[k] = (double)(clock() - begin) / CLOCKS_PER_SEC;
        printf("%-15s %10d %13.6f %9d %11d %8.3f %9.4f%s\n",
               k ? "by differences" : "of the library", a.iterations, cost[k], a.evaluations,
               a.linearised, seconds[k], a.seconds, status[k] == 0 ? "" : " (not converged)");
    }
    double apart = 0.0;
    for (int k = 0; k < UNKNOWNS; ++k) apart = fmax(apart, fabs(x[0][k] - x[1][k]));
    const double gap = largest_gap(&a, m, x[0]);
    printf("the two differ by %.1e; fine steps from node to node miss by %.1e rad\n", apart, gap);
    FILE *file = csv("swing_up.csv");
    for (int k = 0; k <= N; ++k) {
        const double *node = x[0] + NODE * k, shoulder = node[0] + node[1];
        fprintf(file, "%g", duration * k / N);
        for (int i = 0; i < NODE; ++i) fprintf(file, ",%.8g", node[i]);
        const double elbow[2] = {-0.5 * sin(shoulder), 0.5 * cos(shoulder)};
        fprintf(file, ",%.8g,%.8g,%.8g,%.8g\n", elbow[0], elbow[1],
                elbow[0] - 0.6 * sin(shoulder + node[2]), elbow[1] + 0.6 * cos(shoulder + node[2]));
    }
    fclose(file);
    mbsr_derivatives_batch_destroy(a.derivatives);
    mbsr_batch_destroy(a.batch);
    mbsr_model_destroy(m);
    return status[0] == 0 && gap < 0.05 ? 0 : 1;
}
