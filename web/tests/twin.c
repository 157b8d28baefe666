/* What the package is compared with: the same model, state and run in C.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * twin FILE: reads q, u, u' and tau from standard input and writes, a number a line: status of
 * forward dynamics, u', forces of inverse dynamics, the mass matrix, both energies; steps of a run
 * over 1 s and q at its end. twin FILE COUNT writes instead the time of forward dynamics in ns, the
 * least of COUNT. */
#define _POSIX_C_SOURCE 200809L
#include <mbsrank/files.h>
#include <mbsrank/simulation.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct twin {
    mbsr_file *file;
    mbsr_model *model;
    mbsr_data *data;
    double *q, *u, *udot, *tau, *out;
    int nq, nu;
} twin;

static int stop(const char *text)
{
    fprintf(stderr, "%s\n", text);
    return 1;
}

static int open_file(const char *path, twin *t)
{
    static char text[1 << 20];
    mbsr_file_opt opt = mbsr_default_file_opt();
    mbsr_error error = {.text = ""};
    FILE *from = fopen(path, "rb");
    if (!from) return stop(path);
    const size_t size = fread(text, 1, sizeof text, from);
    fclose(from);
    opt.limits = opt.friction = 1;
    if (mbsr_file_read(text, size, path, &opt, &t->file, &error)) return stop(error.text);
    t->model = mbsr_file_take_model(t->file);
    if (mbsr_model_finish(t->model)) return stop(mbsr_model_error(t->model)->text);
    if (mbsr_data_create(t->model, &t->data, &error)) return stop(error.text);
    t->nq = mbsr_model_nq(t->model);
    t->nu = mbsr_model_nu(t->model);
    const size_t nq = (size_t)t->nq, nu = (size_t)t->nu;
    t->q = calloc(nq + 4 * nu + nu * nu + 1, sizeof *t->q);
    if (!t->q) return stop("no memory");
    t->u = t->q + nq;
    t->udot = t->u + nu;
    t->tau = t->udot + nu;
    t->out = t->tau + nu;
    for (size_t k = 0; k < nq + 3 * nu; ++k) {
        if (scanf("%lf", t->q + k) != 1) return stop("numbers are missing");
    }
    return 0;
}

static void print(int count, const double *x)
{
    for (int k = 0; k < count; ++k) printf("%.17g\n", x[k]);
}

static int evaluate(twin *t)
{
    double energy[2] = {0.0};
    printf("%d\n", mbsr_forward_dynamics(t->model, t->data, 0.0, t->q, t->u, t->tau, t->out));
    print(t->nu, t->out);
    int status = mbsr_inverse_dynamics(t->model, t->data, 0.0, t->q, t->u, t->udot, NULL, t->out);
    print(t->nu, t->out);
    if (!status) status = mbsr_stage_positions(t->model, t->data, 0.0, t->q);
    if (!status) status = mbsr_stage_velocities(t->model, t->data, t->u);
    if (!status) status = mbsr_mass_matrix(t->model, t->data, t->out);
    print(t->nu * t->nu, t->out);
    if (!status) status = mbsr_energy(t->model, t->data, energy, energy + 1);
    print(2, energy);
    return status ? stop(mbsr_data_error(t->data)->text) : 0;
}

static int run(twin *t)
{
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    mbsr_ida_stats cost;
    opt.rtol = opt.atol = 1e-8;
    mbsr_simulation s = mbsr_simulation_of(t->model);
    int status = mbsr_simulation_start(&s, &opt, 0.0, t->file->q0, NULL);
    if (!status) status = mbsr_simulation_to(&s, 1.0);
    mbsr_simulation_get_stats(&s, &cost);
    printf("%ld\n", cost.steps);
    if (!status) print(t->nq, s.q);
    if (status) stop(s.error.text);
    mbsr_simulation_end(&s);
    return status != 0;
}

static int measure(twin *t, int count)
{
    double least = INFINITY;
    for (int k = 0; k < count; ++k) {
        struct timespec from, to;
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &from);
        for (int l = 0; l < 100; ++l)
            mbsr_forward_dynamics(t->model, t->data, 0.0, t->q, t->u, t->tau, t->out);
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &to);
        least = fmin(least, 1e7 * (double)(to.tv_sec - from.tv_sec) +
                                1e-2 * (double)(to.tv_nsec - from.tv_nsec));
    }
    printf("%.6g\n", least);
    return 0;
}

int main(int argc, char **argv)
{
    twin t = {.file = NULL};
    if (argc < 2) return stop("usage: twin FILE [COUNT]");
    int code = open_file(argv[1], &t);
    if (!code && argc > 2) {
        code = measure(&t, atoi(argv[2]));
        mbsr_model_destroy(t.model);
    } else if (!code) {
        code = evaluate(&t);
        mbsr_data_destroy(t.data);
        t.data = NULL;
        if (!code) code = run(&t); /* which takes the model */
    }
    mbsr_data_destroy(t.data);
    mbsr_file_destroy(t.file);
    free(t.q);
    return code;
}
