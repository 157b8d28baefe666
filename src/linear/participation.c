/* Where the energy of a mode is.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Of a shape x and an element whose generalised forces are Q(q, u): x^T (-dQ/dq) x is twice the
 * potential energy that it takes up, x^T (-dQ/du) x what it dissipates at rates x. Both are
 * differences of Q^T x = sum f . V + tau . u with V and u of the rates x, once for the real and
 * once for the imaginary part. */
#include "files/arena.h"

#include "base/error.h"
#include "linear/spans.h"

#include <mbsrank/linear.h>

#include <math.h>
#include <string.h>

static const char name[] = "mbsr_mode_participation";

typedef struct shares {
    const mbsr_model *model;
    mbsr_data *data;
    double t;
    const double *q;
    int nq, nu, bodies, forces, widest; /* widest: numbers of a velocity */
    double *place, *rates, *before;     /* nq, nu, nq */
    double *V, *V0;                     /* bodies x widest: of rates x, less those of zero */
    double *ground, *load;              /* widest each */
    double *kinetic, *potential, *dissipated;
} shares;

static int velocities_at(const shares *w, const double *x, double factor)
{
    for (int k = 0; k < w->nu; ++k) w->rates[k] = x ? factor * x[k] : 0.0;
    return mbsr_stage_velocities(w->model, w->data, w->rates);
}

/* The places h x away from q. */
static int displace(const shares *w, const double *x, double h)
{
    int status = mbsr_stage_positions(w->model, w->data, w->t, w->q);
    if (!status) status = velocities_at(w, x, h);
    if (!status) status = mbsr_coordinate_rates(w->model, w->data, w->place);
    if (!status) status = velocities_at(w, x, -h);
    if (!status) status = mbsr_coordinate_rates(w->model, w->data, w->before);
    for (int k = 0; k < w->nq; ++k) w->place[k] = w->q[k] + 0.5 * (w->place[k] - w->before[k]);
    if (!status) status = mbsr_normalise(w->model, w->data, w->place);
    return status ? status : mbsr_stage_positions(w->model, w->data, w->t, w->place);
}

/* V of rates x where the model stands, without what drives add. */
static int find_velocities(const shares *w, const double *x)
{
    int status = MBSR_OK;
    for (int pass = 0; pass < 2 && !status; ++pass) {
        double *V = pass ? w->V : w->V0;
        status = velocities_at(w, pass ? x : NULL, 1.0);
        for (int i = 0; i < w->bodies && !status; ++i)
            status = mbsr_body_twist(w->model, w->data, i, V + (size_t)i * (size_t)w->widest);
    }
    for (size_t k = 0; k < (size_t)w->bodies * (size_t)w->widest; ++k) w->V[k] -= w->V0[k];
    return status;
}

/* Adds factor Q^T x of all elements at the velocities that the data has. */
static int add_power(const shares *w, const double *x, double factor, double *power)
{
    for (int k = 0; k < w->forces; ++k) {
        mbsr_force_def def;
        int status = mbsr_force_definition(w->model, k, &def);
        if (status) return status;
        const bool every = (def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
        const int places = every ? w->bodies : def.bodies,
                  *list = def.body_list ? def.body_list : def.body;
        for (int place = 0; place < places; ++place) {
            const int i = every ? place : list[place];
            int ui, n;
            if (i == MBSR_GROUND) continue;
            mbsr_body_coordinates(w->model, i, NULL, NULL, &ui, &n);
            double *tau = w->load + w->widest;
            status = mbsr_force_load(w->model, w->data, k, place, w->load, tau);
            if (status) return status;
            const double *V = w->V + (size_t)i * (size_t)w->widest;
            double sum = 0.0;
            for (int j = 0; j < mbsr_body_dimension(w->model, i); ++j) sum += w->load[j] * V[j];
            for (int j = 0; j < n; ++j) sum += tau[j] * x[ui + j];
            power[k] += factor * sum;
        }
    }
    return MBSR_OK;
}

/* Adds what the part x of the shape has; h: of places, in units of x; speed: of rates. */
static int add_energies(const shares *w, const double *x, double h, double speed)
{
    int status = MBSR_OK;
    for (int side = -1; side <= 1 && !status && w->potential; side += 2) {
        status = displace(w, x, side * h);
        if (!status) status = find_velocities(w, x);
        if (!status) status = velocities_at(w, NULL, 0.0);
        if (!status) status = add_power(w, x, -0.5 * side / h, w->potential);
    }
    if (!status) status = mbsr_stage_positions(w->model, w->data, w->t, w->q);
    if (!status) status = find_velocities(w, x);
    for (int side = -1; side <= 1 && !status && w->dissipated && speed > 0.0; side += 2) {
        status = velocities_at(w, x, side * h * speed);
        if (!status) status = add_power(w, x, -0.5 * side / (h * speed), w->dissipated);
    }
    /* the even part, less that of drives */
    for (int side = -1; side <= 1 && !status && w->kinetic; ++side) {
        status = velocities_at(w, x, side);
        for (int i = 0; i < w->bodies && !status; ++i) {
            double energy;
            status = mbsr_body_energy(w->model, w->data, i, &energy);
            if (!status) w->kinetic[i] += side ? 0.5 * energy : -energy;
        }
    }
    return status;
}

static bool is_zero_shape(int n, const double *x)
{
    for (int k = 0; k < n; ++k) {
        if (x[k] != 0.0) return false;
    }
    return true;
}

/* Shares of the sum of sizes. */
static void make_shares(int n, double *x)
{
    double sum = 0.0;
    for (int k = 0; k < n && x; ++k) sum += fabs(x[k]);
    for (int k = 0; k < n && x && sum > 0.0; ++k) x[k] /= sum;
}

/* A small step along the shape: some 1e-5 rad, or of the length of the model. */
static double small_step(const shares *w, const double *re, const double *im)
{
    const double length = mbsri_linear_length(w->model, w->data);
    double most = 0.0;
    for (int i = 0; i < w->bodies; ++i) {
        int n, ui;
        double span[MBSRI_LINEAR_SPANS];
        mbsr_body_coordinates(w->model, i, NULL, NULL, &ui, &n);
        mbsri_linear_spans(w->model, i, true, length, span);
        for (int k = 0; k < n; ++k) {
            const double size = hypot(re[ui + k], im ? im[ui + k] : 0.0);
            most = fmax(most, size / (span[k] > 0.0 ? span[k] : 1.0));
        }
    }
    return most > 0.0 ? 1e-5 / most : 0.0;
}

static bool open_shares(shares *w, mbsri_arena *arena)
{
    int most_n = 1;
    w->widest = 6;
    for (int i = 0; i < w->bodies; ++i) {
        int n;
        const int d = mbsr_body_dimension(w->model, i);
        mbsr_body_coordinates(w->model, i, NULL, NULL, NULL, &n);
        if (d > w->widest) w->widest = d;
        if (n > most_n) most_n = n;
    }
    const size_t all = (size_t)w->bodies * (size_t)w->widest,
                 count = 2 * all + (size_t)(2 * w->nq + w->nu + w->widest + most_n);
    w->V = mbsri_arena_take(arena, (count + 1) * sizeof *w->V);
    if (!w->V) return false;
    w->V0 = w->V + all;
    w->place = w->V0 + all;
    w->before = w->place + w->nq;
    w->rates = w->before + w->nq;
    w->load = w->rates + w->nu;
    return true;
}

int mbsr_mode_participation(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                            const mbsr_mode *mode, const double *re, const double *im,
                            double *kinetic, double *potential, double *dissipated,
                            mbsr_error *error)
{
    mbsr_model_def def;
    if (!model || !data || !q || !mode || !re)
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: %s is NULL", name,
                          !model  ? "model"
                          : !data ? "data"
                          : !q    ? "q"
                          : !mode ? "mode"
                                  : "re");
    if (mbsr_model_definition(model, &def))
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "%s: the model is not finished", name);
    shares w = {.model = model,
                .data = data,
                .t = t,
                .q = q,
                .nq = mbsr_model_nq(model),
                .nu = mbsr_model_nu(model),
                .bodies = mbsr_model_bodies(model),
                .forces = mbsr_model_forces(model),
                .kinetic = kinetic,
                .potential = potential,
                .dissipated = dissipated};
    mbsri_arena arena;
    mbsri_arena_open(&arena, &def.allocator);
    int status = MBSR_OK;
    if (kinetic) memset(kinetic, 0, (size_t)w.bodies * sizeof *kinetic);
    if (potential) memset(potential, 0, (size_t)w.forces * sizeof *potential);
    if (dissipated) memset(dissipated, 0, (size_t)w.forces * sizeof *dissipated);
    if (!open_shares(&w, &arena)) {
        status = mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                            "%s: no memory for %d bodies", name, w.bodies);
    } else {
        status = mbsr_stage_positions(model, data, t, q);
        const double h = status ? 0.0 : small_step(&w, re, im);
        for (int part = 0; part < 2 && !status && h > 0.0; ++part) {
            const double *x = part ? im : re;
            if (x && !is_zero_shape(w.nu, x))
                status = add_energies(&w, x, h, hypot(mode->real, mode->imaginary));
        }
        if (status) {
            const mbsr_error *why = mbsr_data_error(data);
            mbsri_fail(error, status, why->body, why->force, "%s: %s", name, why->text);
        }
    }
    make_shares(w.bodies, kinetic);
    make_shares(w.forces, potential);
    make_shares(w.forces, dissipated);
    mbsri_arena_close(&arena);
    return status;
}
